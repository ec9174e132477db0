"""FitzHugh and Nagumo's oscillator on a scale of millivolts, as a description of a cell for `general`, for teaching.

Source: R. FitzHugh, Biophys. J. 1 (1961) 445-466; J. Nagumo, S. Arimoto, S. Yoshizawa, Proc. IRE 50 (1962) 2061-2070.
Their variable u is here (V - middle) / scale; u' = strength (u - u^3/3 - w), w' = rate (u + a - b w), per ms. The
recovery variable w is no gate: it has no bounds of its own. The one "channel" is the strength [mS/cm^2].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import compiled

KIND = "cell"
NAME = "fitzhugh_nagumo"
TITLE = "oscillator of FitzHugh and Nagumo (1961), for teaching"

STATES = (("w", -10.0, 10.0),)
GATES = 0
CHANNELS = ("excitability",)
INSTANT = 0
LOWEST, HIGHEST = -200.0, 150.0


class CellConstants(NamedTuple):
    """Middle and scale of the potential [mV], a, b, rate of recovery [1/ms], capacitance, rate factor."""

    middle: float
    scale: float
    a: float
    b: float
    recovery_rate: float
    inhibition_reversal: float
    capacitance: float
    kinetics_rate: float


PARAMETERS = (
    number("middle", -25.0, "mV", "potential at u = 0, chosen so that the cell rests near -63 mV",
           lowest=-100.0, highest=100.0),
    number("scale", 32.0, "mV", "potential by which u rises by 1, chosen so that the peak is near 30 mV",
           lowest=1.0, highest=100.0),
    number("a", 0.7, "1", "offset of the recovery", tag="sourced",
           source="R. FitzHugh, Biophys. J. 1 (1961) 447", lowest=-10.0, highest=10.0),
    number("b", 0.8, "1", "weight of the recovery variable in its own rate", tag="sourced",
           source="R. FitzHugh, Biophys. J. 1 (1961) 447", lowest=0.0, highest=10.0),
    number("recovery_rate", 0.08, "1/ms", "rate of the recovery, FitzHugh's phi (1/c^2) for a unit of time of 1 ms",
           lowest=1e-6, highest=10.0),
    number("inhibition_reversal", -70.0, "mV", "potential towards which inhibiting nerves pull the cell",
           lowest=-200.0, highest=100.0),
    number("capacitance", 1.0, "uF/cm^2", "capacitance of the membrane", lowest=1e-3, highest=1e3),
    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", lowest=1e-3, highest=1e3),
)  # fmt: skip
SHIPPED = CellConstants(*(one.value for one in PARAMETERS))
CONDUCTANCES = (
    number("excitability", 1.0, "mS/cm^2", "strength of the current", lowest=0.0, highest=100.0),
)  # fmt: skip
INHIBITION = "inhibition_reversal"


@compiled
def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """There are no gates."""


@compiled
def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """There are no functions of the potential alone."""


@compiled
def others(
    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants, row: np.ndarray
) -> None:
    """Source and decay [1/ms] of the recovery variable."""
    row[0] = constants.recovery_rate * ((v - constants.middle) / constants.scale + constants.a)
    row[1] = constants.recovery_rate * constants.b


@compiled
def current(
    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: int, constants: CellConstants
) -> float:
    """Ionic current [uA/cm^2], outward positive, at the potential v."""
    u = (v - constants.middle) / constants.scale
    return -constants.scale * channels[0, node] * (u - u * u * u / 3.0 - states[0, node])
