"""Contact of wall nodes with the pellet by a stiff spring, for the explicit scheme, Eq. (55)."""

from __future__ import annotations

import numpy as np

from ..numerics.compiled import compiled
from .constants import PelletConstants
from .shapes.sphere import gap_and_normal


@compiled
def penalty_contact(
    rho: np.ndarray,
    zeta: np.ndarray,
    centre: float,
    pellet: PelletConstants,
    stiffness: float,
    density: np.ndarray,
    normal: np.ndarray,
) -> None:
    """Contact density Q = stiffness * penetration [mN/cm^2] of the inner nodes, and the normals of touching ones.

    stiffness: k_c [mN/cm^3], of undeformed area. density: (n,), normal: (2, n), both written.
    """
    for i in range(1, rho.size - 1):
        axial = zeta[i] - centre
        density[i] = 0.0
        if rho[i] < pellet.shape.radius and -pellet.oral < axial < pellet.anal:
            gap, nr, nz, _, _ = gap_and_normal(rho[i], axial, pellet.shape)
            if gap < 0.0:
                density[i] = -stiffness * gap
                normal[0, i] = nr
                normal[1, i] = nz
