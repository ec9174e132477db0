"""Unilateral contact of wall nodes with the pellet, Eqs. (12) and (28).

The unknown is the contact force density Q per undeformed area [mN/cm^2]; the contact pressure on the deformed wall
is Q / (lambda_l lambda_c). A semismooth Newton method finds the set of touching nodes: where Q - AUGMENTATION*gap
is positive the gap is closed, elsewhere Q vanishes.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .sphere import gap_and_normal

AUGMENTATION = 1.0e5
"""Weight of the gap against Q in the choice of touching nodes [mN/cm^3]; does not enter the solution."""


@compiled
def axial_force(
    rho: np.ndarray, zeta: np.ndarray, density: np.ndarray, centre: float, radius: float, area: float
) -> float:
    """Axial force of the wall on the pellet [mN]: minus the sum of Q n_zeta over nodes of `area` [cm^2]."""
    total = 0.0
    for i in range(rho.size):
        if density[i] != 0.0:
            _, _, nz, _ = gap_and_normal(rho[i], zeta[i] - centre, radius)
            total -= area * density[i] * nz
    return total


@compiled
def smallest_gap(rho: np.ndarray, zeta: np.ndarray, centre: float, radius: float) -> float:
    """Smallest gap between the free nodes and the pellet [cm]; negative means penetration."""
    least = math.inf
    for i in range(1, rho.size - 1):
        gap, _, _, _ = gap_and_normal(rho[i], zeta[i] - centre, radius)
        least = min(least, gap)
    return least
