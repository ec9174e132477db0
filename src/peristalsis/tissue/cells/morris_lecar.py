"""Morris and Lecar's barnacle muscle fibre, as a description of a cell for `general`: two states, for teaching.

Source: C. Morris, H. Lecar, Biophys. J. 35 (1981) 193-213; constants of the Hopf regime as in J. Rinzel, B. Ermentrout,
in Methods in Neuronal Modeling, MIT Press 1998, table 7.1. Units: mV, ms, mS/cm^2, uA/cm^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...numerics.compiled import compiled

STATES = (("w", 0.0, 1.0),)
GATES = 1
CHANNELS = ("calcium", "potassium", "leak")
INSTANT = 1
LOWEST, HIGHEST = -150.0, 150.0


class CellConstants(NamedTuple):
    """Reversal and half-activation potentials, slopes [mV], rate of w [1/ms]; the last two are those of the tissue."""

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


SHIPPED = CellConstants(120.0, -84.0, -60.0, -1.2, 18.0, 2.0, 30.0, 0.04, 20.0, 1.0)
CONDUCTANCES = (4.4, 8.0, 2.0)
"""Constants and conductances [mS/cm^2] of the source."""


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
