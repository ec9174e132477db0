"""FitzHugh and Nagumo's oscillator on a scale of millivolts, as a description of a cell for `general`, for teaching.

Source: R. FitzHugh, Biophys. J. 1 (1961) 445-466; J. Nagumo, S. Arimoto, S. Yoshizawa, Proc. IRE 50 (1962) 2061-2070.
Their variable u is here (V - middle) / scale; u' = strength (u - u^3/3 - w), w' = rate (u + a - b w), per ms. The
recovery variable w is no gate: it has no bounds of its own. The one "channel" is the strength [mS/cm^2].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...numerics.compiled import compiled

STATES = (("w", -10.0, 10.0),)
GATES = 0
CHANNELS = ("excitability",)
INSTANT = 0
LOWEST, HIGHEST = -200.0, 150.0


class CellConstants(NamedTuple):
    """Middle and scale of the potential [mV], a, b, rate of recovery [1/ms]; the last two are those of the tissue."""

    middle: float
    scale: float
    a: float
    b: float
    recovery_rate: float
    capacitance: float
    kinetics_rate: float


SHIPPED = CellConstants(-25.0, 32.0, 0.7, 0.8, 0.08, 1.0, 1.0)
CONDUCTANCES = (1.0,)
"""a, b and the rate are FitzHugh's; middle and scale put rest near -63 mV and the peak near 30 mV."""


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
