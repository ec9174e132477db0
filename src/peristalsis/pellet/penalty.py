"""Contact of wall nodes with the pellet by a stiff spring, for the explicit scheme, Eq. (55)."""

from __future__ import annotations

import numpy as np

from ..numerics.compiled import compiled
from .sphere import gap_and_normal


@compiled
def penalty_contact(
    rho: np.ndarray,
    zeta: np.ndarray,
    centre: float,
    radius: float,
    stiffness: float,
    density: np.ndarray,
    normal: np.ndarray,
) -> None:
    """Contact density Q = stiffness * penetration [mN/cm^2] of the inner nodes, and the normals of touching ones.

    stiffness: k_c [mN/cm^3], of undeformed area. density: (n,), normal: (2, n), both written.
    """
    reach = radius * radius
    for i in range(1, rho.size - 1):
        axial = zeta[i] - centre
        density[i] = 0.0
        if rho[i] * rho[i] + axial * axial < reach:
            gap, nr, nz, _ = gap_and_normal(rho[i], axial, radius)
            density[i] = -stiffness * gap
            normal[0, i] = nr
            normal[1, i] = nz
