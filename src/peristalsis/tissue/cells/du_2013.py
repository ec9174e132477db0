"""Interstitial cell of Cajal of the stomach by Du and others, as a description of a cell for `general`: a pacemaker.

Source: P. Du, J. Gao, G. O'Grady, L. K. Cheng, Proc. 35th IEEE EMBC (2013) 1547-1550, a simplified cell for the
entrainment of slow waves. Its clock is that of M. S. Imtiaz, D. W. Smith, D. F. van Helden, Biophys. J. 83 (2002)
1877-1890: IP3, made at depolarised potentials too, releases calcium from a store; calcium opens an inward current.
Constants as in the curated file of the model of 2021, with which it reproduces the paper's slow waves.

Currents of the source belong to a cell of 27 pF; here they are per area at 1 uF/cm^2: nS / 27 pF = mS/uF. Units: mV,
ms, mM, mS/cm^2, uA/cm^2. The source calls its concentrations mM; by size they are uM, and only their ratios matter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import compiled, inlined

KIND, NAME, TITLE = "cell", "du_2013", "gastric interstitial cell of Cajal, a pacemaker (Du and others 2013)"
SOURCE = "Du, Gao, O'Grady, Cheng 2013, Proc. IEEE EMBC 35:1547"
CURATED = "curated CellML file of Du 2013 (2021)"

STATES = (
    ("sodium_activation", 0.0, 1.0),
    ("sodium_inactivation", 0.0, 1.0),
    ("calcium", 0.0, 100.0),
    ("stored_calcium", 0.0, 100.0),
    ("ip3", 0.0, 100.0),
)
"""The first two are gates; then calcium in the cytosol, calcium in the store and inositol trisphosphate [mM]."""
CALCIUM_STATE = ("calcium", "uM")
"""Which state is calcium, and its unit: what the source calls mM has the size of uM."""
GATES = 2
CALCIUM, STORE, IP3 = 2, 3, 4
CHANNELS = ("sodium", "calcium", "calcium_potassium", "ip3_voltage_production")
INSTANT = 1
LOWEST, HIGHEST = -150.0, 100.0
START = (-70.0328, 0.0, 0.9998, 0.38498, 2.46238, 0.4778)
"""Potential [mV] and states at which the source begins."""

PARAMETERS = (
    number("sodium_reversal", 80.0, "mV", "reversal of the sodium current", tag="sourced", source=SOURCE),
    number("calcium_reversal", -20.0, "mV", "reversal of the calcium-activated current", tag="sourced", source=SOURCE),
    number("potassium_reversal", -72.0, "mV", "reversal of the potassium current", tag="sourced", source=SOURCE),
    number("sodium_activation_time", 10.0, "ms", "opening of sodium channels",
           tag="sourced", source=SOURCE, lowest=1e-3),
    number("sodium_inactivation_time", 110.0, "ms", "their inactivation", tag="sourced", source=SOURCE, lowest=1e-3),
    number("calcium_half", 1.4, "mM", "calcium that half opens the inward current",
           tag="sourced", source=SOURCE, lowest=1e-9 ),
    number("influx", 0.00022, "mM/ms", "calcium influx at rest", tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_influx", 0.0002266, "1/ms", "calcium influx by IP3", tag="sourced", source=CURATED, lowest=0.0),
    number("uptake", 0.00334, "mM/ms", "most that the store takes up", tag="sourced", source=CURATED, lowest=0.0),
    number("uptake_half", 1.0, "mM", "calcium of half uptake", tag="sourced", source=CURATED, lowest=1e-9),
    number("uptake_power", 1.8, "1", "power of calcium in the uptake", tag="sourced", source=CURATED, lowest=1.0),
    number("release", 0.44, "mM/ms", "most that the store releases", tag="sourced", source=CURATED, lowest=0.0),
    number("release_calcium_half", 1.0, "mM", "calcium of half release", tag="sourced", source=CURATED, lowest=1e-9),
    number("release_store_half", 2.0, "mM", "stored calcium of half release",
           tag="sourced", source=CURATED, lowest=1e-9),
    number("release_ip3_half", 0.65, "mM", "IP3 of half release", tag="sourced", source=CURATED, lowest=1e-9),
    number("leak_rate", 0.00006, "1/ms", "leak of the store", tag="sourced", source=CURATED, lowest=0.0),
    number("extrusion_rate", 0.00066, "1/ms", "removal of calcium", tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_production", 0.000062, "mM/ms", "IP3 made at any potential",
           tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_potential", 60.0, "mV", "size of the potential of half of it",
           tag="sourced", source=CURATED, lowest=1.0),
    number("ip3_decay_rate", 0.02021, "1/ms", "decay of IP3", tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_degradation", 0.00016, "mM/ms", "saturable decay of IP3", tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_degradation_half", 0.5, "mM", "IP3 of half of it", tag="sourced", source=CURATED, lowest=1e-9),
    number("capacitance", 1.0, "uF/cm^2", "capacitance of the membrane", tag="chosen", lowest=1e-3, highest=1e3),
    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", tag="chosen", lowest=1e-3, highest=1e3),
)  # fmt: skip

CONDUCTANCES = (
    number("sodium", 8.0 / 27.0, "mS/cm^2", "sodium: 8 nS", tag="sourced", source=CURATED, lowest=0.0),
    number("calcium", 4.0 / 27.0, "mS/cm^2", "calcium-activated inward: 4 nS",
           tag="sourced", source=CURATED, lowest=0.0),
    number("calcium_potassium", 1.2 / 27.0, "mS/cm^2", "calcium-activated potassium: 1.2 nS",
           tag="sourced", source=CURATED, lowest=0.0),
    number("ip3_voltage_production", 0.032, "mM/ms", "most IP3 made where depolarised; sets the period",
           tag="sourced", source=CURATED, lowest=0.0),
)  # fmt: skip
"""Besides the conductances the one number that sets the period: regions may make a part of a network faster."""
INHIBITION = "potassium_reversal"
"""The constant towards which inhibiting nerves pull the potential."""


class CellConstants(NamedTuple):
    """The values of PARAMETERS, in their order."""

    sodium_reversal: float
    calcium_reversal: float
    potassium_reversal: float
    sodium_activation_time: float
    sodium_inactivation_time: float
    calcium_half: float
    influx: float
    ip3_influx: float
    uptake: float
    uptake_half: float
    uptake_power: float
    release: float
    release_calcium_half: float
    release_store_half: float
    release_ip3_half: float
    leak_rate: float
    extrusion_rate: float
    ip3_production: float
    ip3_potential: float
    ip3_decay_rate: float
    ip3_degradation: float
    ip3_degradation_half: float
    capacitance: float
    kinetics_rate: float


SHIPPED = CellConstants(*(one.value for one in PARAMETERS))


@inlined
def _fourth(x: float) -> float:
    """x to the power of four."""
    return x * x * x * x


@inlined
def _bound(x: float, half: float) -> float:
    """Share bound with four sites."""
    power = _fourth(x)
    return power / (_fourth(half) + power)


@compiled
def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady value and rate [1/ms] of both gates of the sodium current."""
    row[0], row[1] = 1.0 / (1.0 + math.exp(-(v + 7.0) / 5.0)), 1.0 / constants.sodium_activation_time
    row[2], row[3] = 1.0 / (1.0 + math.exp((v + 37.4) / 4.0)), 1.0 / constants.sodium_inactivation_time


@compiled
def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Opening exp(-V/17 mV) of calcium-activated potassium channels."""
    row[0] = math.exp(-v / 17.0)


@compiled
def others(
    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants, row: np.ndarray
) -> None:
    """Source and decay [1/ms] of calcium, stored calcium and IP3."""
    calcium, store, ip3 = states[CALCIUM, node], states[STORE, node], states[IP3, node]
    # Uptake and release per calcium that they take, so that they are decays of it and no concentration falls below 0.
    power = math.pow(calcium, constants.uptake_power - 1.0)
    uptake = constants.uptake * power / (math.pow(constants.uptake_half, constants.uptake_power) + calcium * power)
    opened = _bound(calcium, constants.release_calcium_half) * _bound(ip3, constants.release_ip3_half)
    cube = store * store * store
    release = constants.release * opened * cube / (_fourth(constants.release_store_half) + cube * store)
    row[0] = constants.influx + constants.ip3_influx * ip3 + (release + constants.leak_rate) * store
    row[1] = uptake + constants.extrusion_rate
    row[2] = uptake * calcium
    row[3] = release + constants.leak_rate
    depolarised = 1.0 / (1.0 + _fourth(v * v / (constants.ip3_potential * constants.ip3_potential)))
    row[4] = constants.ip3_production + channels[3, node] * depolarised
    cubed = ip3 * ip3 * ip3
    row[5] = constants.ip3_decay_rate + constants.ip3_degradation * cubed / (
        _fourth(constants.ip3_degradation_half) + cubed * ip3
    )


@compiled
def current(
    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: int, constants: CellConstants
) -> float:
    """Ionic current [uA/cm^2], outward positive, at the potential v."""
    calcium = states[CALCIUM, node]
    reduced = (calcium / 0.001) * (calcium / 0.001)
    return (
        channels[0, node] * states[0, node] * states[1, node] * (v - constants.sodium_reversal)
        + channels[1, node] * _bound(calcium, constants.calcium_half) * (v - constants.calcium_reversal)
        + channels[2, node] * reduced / (reduced + instants[0, node]) * (v - constants.potassium_reversal)
    )
