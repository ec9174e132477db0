"""Smooth muscle of the stomach by Corrias and Buist, as a description of a cell for `general`.

Source: A. Corrias, M. L. Buist, Ann. Biomed. Eng. 35 (2007) 1595-1607; a cell of 77 pF and 3500 um^3. It rests near
-70 mV and follows the slow waves of its interstitial cells of Cajal: the current from them is a stimulus from outside
(about 1 uA/cm^2 over the first tenth of a second, then a plateau), and no part of the cell.

Currents and conductances of the source belong to one cell (pA, nS); here they are per area, at 1 uF/cm^2: nS / 77 pF =
mS/uF. Units: mV, ms, mM, mS/cm^2, uA/cm^2. Temperature lengthens all time constants by Q10^((T - T_data) / 10), as the
published file of the model has it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import compiled, inlined

KIND, NAME, TITLE = "cell", "corrias_buist_2007", "gastric smooth muscle (Corrias & Buist 2007)"
SOURCE = "Corrias & Buist 2007, Ann. Biomed. Eng. 35:1595"

STATES = (
    ("calcium_l_activation", 0.0, 1.0),
    ("calcium_l_inactivation", 0.0, 1.0),
    ("calcium_t_activation", 0.0, 1.0),
    ("calcium_t_inactivation", 0.0, 1.0),
    ("delayed_activation", 0.0, 1.0),
    ("delayed_inactivation", 0.0, 1.0),
    ("sodium_activation", 0.0, 1.0),
    ("sodium_inactivation", 0.0, 1.0),
    ("a_type_activation", 0.0, 1.0),
    ("a_type_inactivation", 0.0, 1.0),
    ("nonselective_activation", 0.0, 1.0),
    ("calcium_block", 0.0, 1.0),
    ("calcium", 0.0, 1.0),
)
"""The first eleven are gates; the block of L-type channels depends on calcium [mM], which is the last state."""
CALCIUM_STATE = ("calcium", "mM")
"""Which state is calcium, and its unit."""
GATES = 11
CALCIUM_BLOCK, CALCIUM = 11, 12
CHANNELS = (
    "calcium_l",
    "calcium_t",
    "delayed_potassium",
    "a_type_potassium",
    "calcium_potassium",
    "background_potassium",
    "sodium",
    "nonselective",
)
INSTANT = 1
LOWEST, HIGHEST = -150.0, 100.0
START = (-69.75, 0.0, 0.95, 0.02, 0.99, 0.0, 0.82, 0.005, 0.05787, 0.00414, 0.72, 0.0, 1.0, 0.00008)
"""Potential [mV] and states at which the source begins."""

PARAMETERS = (
    number("temperature", 310.0, "K", "temperature", tag="sourced", source=SOURCE, lowest=273.0, highest=320.0),
    number("data_temperature", 297.0, "K", "temperature of the data", tag="sourced", source=SOURCE, lowest=273.0),
    number("calcium_q10", 2.1, "1", "Q10 of calcium channels", tag="sourced", source=SOURCE, lowest=0.1),
    number("potassium_q10", 1.365, "1", "Q10 of potassium channels", tag="sourced", source=SOURCE, lowest=0.1),
    number("sodium_q10", 2.45, "1", "Q10 of sodium channels", tag="sourced", source=SOURCE, lowest=0.1),
    number("calcium_potassium_warmth", 1.1 / 45.7, "1/K", "rise of calcium_potassium by 1.1 of 45.7 nS a kelvin",
           tag="sourced", source=SOURCE),
    number("calcium_outside", 2.5, "mM", "calcium outside", tag="sourced", source=SOURCE, lowest=1e-9),
    number("potassium_reversal", -88.819584, "mV", "reversal of potassium: RT/F ln(5.9/164) at 310 K",
           tag="sourced", source=SOURCE, lowest=-200.0, highest=200.0),
    number("sodium_reversal", 69.919403, "mV", "reversal of sodium: RT/F ln(137/10) at 310 K",
           tag="sourced", source=SOURCE, lowest=-200.0, highest=200.0),
    number("nonselective_reversal", -28.0, "mV", "reversal, nonselective", tag="sourced", source=SOURCE),
    number("acetylcholine", 1e-5, "mM", "acetylcholine at the muscle", tag="sourced", source=SOURCE, lowest=0.0),
    number("acetylcholine_half", 0.01, "mM", "half effect of acetylcholine",
           tag="sourced", source=SOURCE, lowest=1e-9),
    number("cell_area", 7700.0, "um^2", "membrane of one cell, 77 pF at 1 uF/cm^2",
           tag="sourced", source=SOURCE, lowest=0.0),
    number("cell_volume", 3500.0, "um^3", "volume of one cell", tag="sourced", source=SOURCE, lowest=1.0),
    number("extrusion", 0.31705, "mM/ms", "removal of calcium at 1 mM", tag="sourced", source=SOURCE, lowest=0.0),
    number("extrusion_power", 1.34, "1", "power of calcium in its removal", tag="sourced", source=SOURCE, lowest=1.0),
    number("capacitance", 1.0, "uF/cm^2", "capacitance of the membrane", tag="chosen", lowest=1e-3, highest=1e3),
    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", tag="chosen", lowest=1e-3, highest=1e3),
)  # fmt: skip

CONDUCTANCES = (
    number("calcium_l", 65.0 / 77.0, "mS/cm^2", "L-type calcium: 65 nS", tag="sourced", source=SOURCE, lowest=0.0),
    number("calcium_t", 0.18 / 77.0, "mS/cm^2", "low-voltage calcium: 0.18 nS",
           tag="sourced", source=SOURCE, lowest=0.0),
    number("delayed_potassium", 35.0 / 77.0, "mS/cm^2", "delayed K: 35 nS", tag="sourced", source=SOURCE, lowest=0.0),
    number("a_type_potassium", 9.0 / 77.0, "mS/cm^2", "A-type K: 9 nS", tag="sourced", source=SOURCE, lowest=0.0),
    number("calcium_potassium", 45.7 / 77.0, "mS/cm^2", "calcium-activated K at the temperature of the data: 45.7 nS",
           tag="sourced", source=SOURCE, lowest=0.0),
    number("background_potassium", 0.0144 / 77.0, "mS/cm^2", "background K: 0.0144 nS",
           tag="sourced", source=SOURCE, lowest=0.0),
    number("sodium", 3.0 / 77.0, "mS/cm^2", "sodium: 3 nS", tag="sourced", source=SOURCE, lowest=0.0),
    number("nonselective", 50.0 / 77.0, "mS/cm^2", "nonselective: 50 nS", tag="sourced", source=SOURCE, lowest=0.0),
)  # fmt: skip
INHIBITION = "potassium_reversal"
"""The constant towards which inhibiting nerves pull the potential."""


class CellConstants(NamedTuple):
    """The values of PARAMETERS, in their order."""

    temperature: float
    data_temperature: float
    calcium_q10: float
    potassium_q10: float
    sodium_q10: float
    calcium_potassium_warmth: float
    calcium_outside: float
    potassium_reversal: float
    sodium_reversal: float
    nonselective_reversal: float
    acetylcholine: float
    acetylcholine_half: float
    cell_area: float
    cell_volume: float
    extrusion: float
    extrusion_power: float
    capacitance: float
    kinetics_rate: float


SHIPPED = CellConstants(*(one.value for one in PARAMETERS))

GAS, FARADAY = 8314.4, 96486.0
"""Constants of physics as the source has them: mJ/(mol K), C/mol; their ratio times K is in mV."""
SHORTEST = 0.02
"""Least time constant [ms]: straight lines of the source cross zero at potentials that its cell never reaches."""


@inlined
def _thermal(constants: CellConstants) -> float:
    """RT/F [mV]."""
    return GAS * constants.temperature / FARADAY


@inlined
def _slowing(q10: float, constants: CellConstants) -> float:
    """What the time constants of the data are multiplied with."""
    return math.pow(q10, 0.1 * (constants.temperature - constants.data_temperature))


@inlined
def _open(v: float, half: float, slope: float) -> float:
    """Boltzmann's curve, rising with v for a positive slope [mV]."""
    return 1.0 / (1.0 + math.exp((half - v) / slope))


@compiled
def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady value and rate [1/ms] of every gate in turn, at the potential v."""
    calcium = _slowing(constants.calcium_q10, constants)
    potassium = _slowing(constants.potassium_q10, constants)
    sodium = _slowing(constants.sodium_q10, constants)
    row[0], row[1] = _open(v, -17.0, 4.3), 1.0 / (calcium * 0.47)
    row[2], row[3] = _open(v, -43.0, -8.9), 1.0 / (calcium * 86.0)
    row[4], row[5] = _open(v, -27.5, 10.9), 1.0 / (calcium * 3.0)
    row[6], row[7] = _open(v, -15.8, -7.0), 1.0 / (calcium * 7.58 * math.exp(0.00817 * v))
    row[8], row[9] = _open(v, -27.0, 5.0), 1.0 / (potassium * 80.0)
    row[10] = 0.2 + 0.8 * _open(v, -58.0, -10.0)
    row[11] = 1.0 / (potassium * max(-707.0 + 1481.0 * math.exp((v + 36.0) / 95.0), SHORTEST))
    row[12], row[13] = _open(v, -47.0, 4.8), 1.0 / (sodium * max(0.44 - 0.017 * v, SHORTEST))
    row[14], row[15] = _open(v, -78.0, -3.0), 1.0 / (sodium * max(5.5 - 0.25 * v, SHORTEST))
    reduced = (v + 44.4) / 22.3
    row[16], row[17] = _open(v, -26.5, 7.9), 1.0 / (potassium * (31.8 + 175.0 * math.exp(-0.5 * reduced * reduced)))
    row[18], row[19] = 0.1 + 0.9 * _open(v, -65.0, -6.2), 1.0 / (potassium * 90.0)
    row[20], row[21] = _open(v, -25.0, 20.0), 1.0 / (150.0 * _open(v, -66.0, 26.0))


@compiled
def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """exp(-V/17 mV), on which the opening of calcium-activated potassium channels depends."""
    row[0] = math.exp(-v / 17.0)


@inlined
def _calcium_currents(v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants) -> float:
    """Current through both kinds of calcium channels [uA/cm^2]."""
    reversal = 0.5 * _thermal(constants) * math.log(constants.calcium_outside / states[CALCIUM, node])
    long = channels[0, node] * states[0, node] * states[1, node] * states[CALCIUM_BLOCK, node]
    low = channels[1, node] * states[2, node] * states[3, node]
    return (long + low) * (v - reversal)


@compiled
def others(
    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants, row: np.ndarray
) -> None:
    """Source and decay [1/ms] of the block by calcium and of calcium [mM]."""
    calcium = states[CALCIUM, node]
    rate = 1.0 / (_slowing(constants.calcium_q10, constants) * 2.0)
    row[0] = rate * (1.0 - 1.0 / (1.0 + math.exp((calcium - 0.00030399) / -0.0000131)))
    row[1] = rate
    # uA/cm^2 times um^2 is 0.01 pA; pA / (C/mol * um^3) is 1e6 mM/s.
    charge = 2.0 * FARADAY * constants.cell_volume
    row[2] = -10.0 * constants.cell_area * _calcium_currents(v, states, channels, node, constants) / charge
    row[3] = constants.extrusion * math.pow(calcium, constants.extrusion_power - 1.0)


@compiled
def current(
    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: int, constants: CellConstants
) -> float:
    """Ionic current [uA/cm^2], outward positive, at the potential v."""
    calcium = states[CALCIUM, node]
    warmth = 1.0 + constants.calcium_potassium_warmth * (constants.temperature - constants.data_temperature)
    reduced = (calcium / 0.001) * (calcium / 0.001)
    bound = calcium / 0.0002
    fourth = bound * bound * bound * bound
    excited = constants.acetylcholine / (constants.acetylcholine + constants.acetylcholine_half)
    potassium = (
        channels[2, node] * states[4, node] * states[5, node]
        + channels[3, node] * states[8, node] * states[9, node]
        + channels[4, node] * warmth * reduced / (reduced + instants[0, node])
        + channels[5, node]
    )
    return (
        _calcium_currents(v, states, channels, node, constants)
        + potassium * (v - constants.potassium_reversal)
        + channels[6, node] * states[6, node] * states[7, node] * (v - constants.sodium_reversal)
        + channels[7, node]
        * states[10, node]
        * fourth
        / (1.0 + fourth)
        * excited
        * (v - constants.nonselective_reversal)
    )
