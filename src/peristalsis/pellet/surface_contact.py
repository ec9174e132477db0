"""Contact of the wall on the whole surface with the pellet, Eqs. (12) and (28), in the frames of the columns.

The pellet's axis stays parallel to the tube's, wherever its centre is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .contact import AUGMENTATION
from .shapes import sphere as body
from .shapes.sphere import ShapeConstants, gap_and_normal


class SurfaceContact(NamedTuple):
    """What `measure_contact` finds at the nodes.

    gap [cm] (n, m); normal from pellet to wall (n, 3, m); meridian: the tangent along the meridian (n, 3, m); bend,
    hoop: radii of curvature along it and around [cm] (n, m), Eq. (71); touching (n, m); rows (n,): where any node
    touches. No end row does.
    """

    gap: np.ndarray
    normal: np.ndarray
    meridian: np.ndarray
    bend: np.ndarray
    hoop: np.ndarray
    touching: np.ndarray
    rows: np.ndarray


def no_contact(n: int, m: int) -> SurfaceContact:
    """Arrays for `measure_contact` on n rings of m columns: no contact anywhere."""
    return SurfaceContact(
        np.zeros((n, m)),
        np.zeros((n, 3, m)),
        np.zeros((n, 3, m)),
        np.ones((n, m)),
        np.ones((n, m)),
        np.zeros((n, m), np.bool_),
        np.zeros(n, np.bool_),
    )


if hasattr(body, "gap_in_space"):
    gap_in_space = body.gap_in_space
else:

    @compiled
    def gap_in_space(
        x: float, y: float, z: float, shape: ShapeConstants
    ) -> tuple[float, float, float, float, float, float]:
        """(gap, n_x, n_y, n_z, bend, hoop) at a point from the centre, by the meridian plane through it."""
        rho = math.sqrt(x * x + y * y)
        gap, nr, nz, bend, hoop = gap_and_normal(rho, z, shape)
        along, across = (x / rho, y / rho) if rho > 0.0 else (1.0, 0.0)
        return gap, nr * along, nr * across, nz, bend, hoop


@compiled
def measure_contact(
    places: np.ndarray,
    density: np.ndarray,
    x: float,
    y: float,
    z: float,
    shape: ShapeConstants,
    found: SurfaceContact,
) -> None:
    """Contact of nodes at `places` (n, 3, m) with a pellet centred at (x, y, z), written into `found`.

    x, y: in the frame of column 0.
    """
    n = places.shape[0]
    m = places.shape[2]
    found.rows[:] = False
    found.touching[0] = False
    found.touching[n - 1] = False
    for i in range(1, n - 1):
        for j in range(m):
            c = math.cos(2.0 * math.pi * j / m) if x != 0.0 or y != 0.0 else 1.0
            s = math.sin(2.0 * math.pi * j / m) if x != 0.0 or y != 0.0 else 0.0
            dx = places[i, 0, j] - (c * x + s * y)
            dy = places[i, 1, j] - (c * y - s * x)
            gap, nx, ny, nz, bend, hoop = gap_in_space(dx, dy, places[i, 2, j] - z, shape)
            found.gap[i, j] = gap
            found.normal[i, 0, j] = nx
            found.normal[i, 1, j] = ny
            found.normal[i, 2, j] = nz
            rho = math.sqrt(dx * dx + dy * dy)
            found.meridian[i, 0, j] = -nz * dx / rho if rho > 0.0 else -nz
            found.meridian[i, 1, j] = -nz * dy / rho if rho > 0.0 else 0.0
            found.meridian[i, 2, j] = math.sqrt(nx * nx + ny * ny)
            found.bend[i, j] = bend
            found.hoop[i, j] = hoop
            found.touching[i, j] = density[i, j] - AUGMENTATION * gap > 0.0
            if found.touching[i, j]:
                found.rows[i] = True


@compiled
def force_on_pellet(density: np.ndarray, normal: np.ndarray, area: float) -> tuple[float, float, float]:
    """Force of the wall on the pellet [mN]: across the axis in the frame of column 0, and along it.

    density [mN/cm^2] (n, m) per undeformed area; area [cm^2] of a node.
    """
    fx = 0.0
    fy = 0.0
    fz = 0.0
    m = density.shape[1]
    for i in range(density.shape[0]):
        for j in range(m):
            q = density[i, j]
            if q != 0.0:
                c = math.cos(2.0 * math.pi * j / m)
                s = math.sin(2.0 * math.pi * j / m)
                fx -= area * q * (c * normal[i, 0, j] - s * normal[i, 1, j])
                fy -= area * q * (s * normal[i, 0, j] + c * normal[i, 1, j])
                fz -= area * q * normal[i, 2, j]
    return fx, fy, fz
