"""The line search of Newton's method: how far the merit may rise, how an update is shortened, states to go back to."""

from __future__ import annotations

import numpy as np

from ..numerics.compiled import compiled
from .problem import CHANGE_Q, CHANGE_R, CHANGE_Z, KEPT_Q, KEPT_R, KEPT_Z, Unknowns

SHORTER = 0.25
SMALLEST_STEP = 1.0 / 16.0
"""Lengths of the line search: 1, 1/4, 1/16. Where a kink spoils the whole update, one half as long does no better."""
MEMORY = 2
KINK_ALLOWANCE = 2.0
"""The line search asks for less than this times the largest of so many last merits: an update may pass a kink."""
FIRST_ALLOWANCE = 2.0
"""The first updates may raise the merit: they leave the kinks of the extrapolated guess."""


@compiled
def passes(merit: float, merits: np.ndarray) -> bool:
    """Whether a merit is low enough beside the last ones, (MEMORY,)."""
    highest = 0.0
    for m in merits:
        highest = max(highest, m)
    return merit <= KINK_ALLOWANCE * highest


@compiled
def keep(unknowns: Unknowns, first: int, last: int, row: int, work: np.ndarray) -> None:
    """Nodes and densities first...last into the rows of `work` from `row` on."""
    rho, zeta, density = unknowns.rho, unknowns.zeta, unknowns.density
    for i in range(first, last + 1):
        work[row, i], work[row + 1, i], work[row + 2, i] = rho[i], zeta[i], density[i]


@compiled
def go(unknowns: Unknowns, d_scalars: np.ndarray, work: np.ndarray) -> None:
    """Make the whole update that `work` and d_scalars hold."""
    rho, zeta, density, scalars = unknowns.rho, unknowns.zeta, unknowns.density, unknowns.scalars
    n = rho.size
    for i in range(min(1, n), n - 1):
        rho[i] += work[CHANGE_R, i]
        zeta[i] += work[CHANGE_Z, i]
        density[i] += work[CHANGE_Q, i]
    for k in range(3):
        scalars[k] += d_scalars[k]


@compiled
def go_part(
    unknowns: Unknowns, old_scalars: np.ndarray, d_scalars: np.ndarray, length: float, work: np.ndarray
) -> None:
    """Make so much of the update from the kept state instead."""
    rho, zeta, density, scalars = unknowns.rho, unknowns.zeta, unknowns.density, unknowns.scalars
    n = rho.size
    for i in range(min(1, n), n - 1):
        rho[i] = work[KEPT_R, i] + length * work[CHANGE_R, i]
        zeta[i] = work[KEPT_Z, i] + length * work[CHANGE_Z, i]
        density[i] = work[KEPT_Q, i] + length * work[CHANGE_Q, i]
    for k in range(3):
        scalars[k] = old_scalars[k] + length * d_scalars[k]
