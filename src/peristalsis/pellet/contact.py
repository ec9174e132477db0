"""Unilateral contact of wall nodes with the pellet, Eqs. (12) and (28).

The unknown is the contact force density Q per undeformed area [mN/cm^2]; the contact pressure on the deformed wall
is Q / (lambda_l lambda_c). A semismooth Newton method finds the set of touching nodes: where Q - AUGMENTATION*gap
is positive the gap is closed, elsewhere Q vanishes.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .shapes.sphere import ShapeConstants, gap_and_normal, reach

AUGMENTATION = 1.0e5
"""Weight of the gap against Q in the choice of touching nodes [mN/cm^3]; does not enter the solution."""


@compiled
def axial_force(
    rho: np.ndarray, zeta: np.ndarray, density: np.ndarray, centre: float, shape: ShapeConstants, area: float
) -> float:
    """Axial force of the wall on the pellet [mN]: minus the sum of Q n_zeta over nodes of `area` [cm^2]."""
    total = 0.0
    for i in range(rho.size):
        if density[i] != 0.0:
            _, _, nz, _, _ = gap_and_normal(rho[i], zeta[i] - centre, shape)
            total -= area * density[i] * nz
    return total


@compiled
def smallest_gap(rho: np.ndarray, zeta: np.ndarray, centre: float, shape: ShapeConstants) -> float:
    """Smallest gap between the free nodes and the pellet [cm]; negative means penetration."""
    least = math.inf
    for i in range(1, rho.size - 1):
        gap, _, _, _, _ = gap_and_normal(rho[i], zeta[i] - centre, shape)
        least = min(least, gap)
    return least


@compiled
def room(rho: np.ndarray, zeta: np.ndarray, centre: float, shape: ShapeConstants) -> float:
    """Girth radius [cm] of the largest similar body that fits within the nodes, Eq. (72)."""
    least = math.inf
    for i in range(rho.size):
        least = min(least, reach(rho[i], zeta[i] - centre, shape))
    return least


@compiled
def normal_slope(position: np.ndarray, weight: np.ndarray, centre: float, shape: ShapeConstants) -> np.ndarray:
    """n_zeta / n_rho of the normal at nodes (n, m, 3) that have a weight (n, m), zero at the others."""
    slopes = np.zeros_like(weight)
    for i in range(weight.shape[0]):
        for j in range(weight.shape[1]):
            if weight[i, j] != 0.0:
                _, nr, nz, _, _ = gap_and_normal(position[i, j, 0], position[i, j, 2] - centre, shape)
                slopes[i, j] = nz / nr
    return slopes
