"""Morris and Lecar's barnacle muscle fibre, as a description of a cell for `general`: two states, for teaching.

Source: C. Morris, H. Lecar, Biophys. J. 35 (1981) 193-213; constants of the Hopf regime as in J. Rinzel, B. Ermentrout,
in Methods in Neuronal Modeling, MIT Press 1998, table 7.1. Units: mV, ms, mS/cm^2, uA/cm^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import compiled

KIND = "cell"
NAME = "morris_lecar"
TITLE = "barnacle muscle fibre of Morris and Lecar (1981), for teaching"

STATES = (("w", 0.0, 1.0),)
GATES = 1
CHANNELS = ("calcium", "potassium", "leak")
INSTANT = 1
LOWEST, HIGHEST = -150.0, 150.0


class CellConstants(NamedTuple):
    """Reversal and half-activation potentials, slopes [mV], rate of w [1/ms], capacitance, rate factor."""

    calcium_reversal: float
    potassium_reversal: float
    leak_reversal: float
    calcium_half: float
    calcium_slope: float
    potassium_half: float
    potassium_slope: float
    potassium_rate: float
    capacitance: float
    kinetics_rate: float


PARAMETERS = (
    number("calcium_reversal", 120.0, "mV", "reversal potential of calcium", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=-300.0, highest=300.0),
    number("potassium_reversal", -84.0, "mV", "reversal potential of potassium", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=-300.0, highest=300.0),
    number("leak_reversal", -60.0, "mV", "reversal potential of the leak", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=-300.0, highest=300.0),
    number("calcium_half", -1.2, "mV", "potential at which half of the calcium channels are open", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=-200.0, highest=200.0),
    number("calcium_slope", 18.0, "mV", "width of the opening of calcium channels", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=0.1, highest=200.0),
    number("potassium_half", 2.0, "mV", "potential at which half of the potassium channels are open", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=-200.0, highest=200.0),
    number("potassium_slope", 30.0, "mV", "width of the opening of potassium channels", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=0.1, highest=200.0),
    number("potassium_rate", 0.04, "1/ms", "least rate of the potassium channels", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=1e-6, highest=100.0),
    number("capacitance", 20.0, "uF/cm^2", "capacitance of the membrane", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=1e-3, highest=1e3),
    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", lowest=1e-3, highest=1e3),
)  # fmt: skip
SHIPPED = CellConstants(*(one.value for one in PARAMETERS))
CONDUCTANCES = (
    number("calcium", 4.4, "mS/cm^2", "conductance of the calcium channel", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=0.0, highest=1e4),
    number("potassium", 8.0, "mS/cm^2", "conductance of the potassium channel", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=0.0, highest=1e4),
    number("leak", 2.0, "mS/cm^2", "conductance of the leak", tag="sourced",
           source="Rinzel and Ermentrout 1998, table 7.1", lowest=0.0, highest=1e4),
)  # fmt: skip
INHIBITION = "potassium_reversal"


@compiled
def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady value and rate [1/ms] of w, open potassium channels."""
    reduced = (v - constants.potassium_half) / constants.potassium_slope
    row[0] = 0.5 * (1.0 + math.tanh(reduced))
    row[1] = constants.potassium_rate * math.cosh(0.5 * reduced)


@compiled
def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Open calcium channels, which follow the potential at once."""
    row[0] = 0.5 * (1.0 + math.tanh((v - constants.calcium_half) / constants.calcium_slope))


@compiled
def others(
    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants, row: np.ndarray
) -> None:
    """There are no other states."""


@compiled
def current(
    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: int, constants: CellConstants
) -> float:
    """Ionic current [uA/cm^2], outward positive, at the potential v."""
    return (
        channels[0, node] * instants[0, node] * (v - constants.calcium_reversal)
        + channels[1, node] * states[0, node] * (v - constants.potassium_reversal)
        + channels[2, node] * (v - constants.leak_reversal)
    )
