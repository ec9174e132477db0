"""The sphere as a shape: gap and normal, Eq. (12). A new shape is a new file with the same function."""

from __future__ import annotations

import math

from ..numerics.compiled import compiled


@compiled
def gap_and_normal(rho: float, axial: float, radius: float) -> tuple[float, float, float, float]:
    """(gap, n_rho, n_zeta, curvature) at a point `rho` off the axis and `axial` from the centre [cm].

    The normal points from the pellet to the wall; curvature [1/cm] is that of the distance function there.
    """
    distance = math.sqrt(rho * rho + axial * axial)
    return distance - radius, rho / distance, axial / distance, 1.0 / distance


def volume(radius: float) -> float:
    """Volume of the sphere [cm^3]."""
    return 4.0 / 3.0 * math.pi * radius**3
