"""The activation that a layer is bound to, for all of its cells: drive from potential, calcium and states of its own.

The slot is `tissue.activations.depolarisation`: `bind({"tissue.activations.depolarisation": file})` puts another one
there, one file with `ActivationConstants` and `drive`, and, if it has states of its own, `STATES`, `steady` and
`advance`; see docs/activation.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declared import Declared
from ..numerics.compiled import compiled, inlined
from .activations import depolarisation

_activation: Any = depolarisation

ActivationConstants = depolarisation.ActivationConstants
drive = depolarisation.drive
PARAMETERS: tuple[Declared, ...] = getattr(_activation, "PARAMETERS", ())
STATES: tuple[tuple[str, float, float], ...] = getattr(_activation, "STATES", ())
"""Name, least and largest value of each state that it has in every cell."""
READS_CALCIUM: bool = getattr(_activation, "READS_CALCIUM", False)


def _unbounded(highest: float, c: ActivationConstants) -> float:
    return float("inf")


@inlined
def _nothing_to_set(calcium: float, states: np.ndarray, k: int, c: ActivationConstants) -> None:
    pass


@inlined
def _nothing_to_do(calcium: float, states: np.ndarray, k: int, dt: float, c: ActivationConstants) -> None:
    pass


largest_drive = getattr(_activation, "largest_drive", _unbounded)
steady = getattr(_activation, "steady", _nothing_to_set)
advance = getattr(_activation, "advance", _nothing_to_do)


@compiled
def drive_of_cells(
    potential: np.ndarray,
    calcium: np.ndarray,
    scale: float,
    states: np.ndarray,
    constants: ActivationConstants,
    out: np.ndarray,
) -> None:
    """Drive of every cell [mV] into `out`; potential [mV], calcium, out: (n,), states: (states, n).

    scale: of the cell's calcium to uM.
    """
    for k in range(out.shape[0]):
        out[k] = drive(potential[k], scale * calcium[k], states, k, constants)


@compiled
def set_steady(calcium: np.ndarray, scale: float, constants: ActivationConstants, states: np.ndarray) -> None:
    """Put every cell's states, (states, n), where they stay at its calcium, (n,)."""
    for k in range(states.shape[1]):
        steady(scale * calcium[k], states, k, constants)


@compiled
def advance_states(
    before: np.ndarray, after: np.ndarray, scale: float, dt: float, constants: ActivationConstants, states: np.ndarray
) -> None:
    """Advance every cell's states, (states, n), in place by dt [s], at the mean of its calcium before and after."""
    for k in range(states.shape[1]):
        advance(0.5 * scale * (before[k] + after[k]), states, k, dt, constants)
