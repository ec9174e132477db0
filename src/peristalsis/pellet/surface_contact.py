"""Contact of the wall on the whole surface with the pellet, Eqs. (12) and (28), in the frames of the columns."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .contact import AUGMENTATION


@compiled
def measure_contact(
    places: np.ndarray,
    density: np.ndarray,
    x: float,
    y: float,
    z: float,
    radius: float,
    gap: np.ndarray,
    normal: np.ndarray,
    touching: np.ndarray,
    rows: np.ndarray,
) -> None:
    """Gap [cm] (n, m), normal from pellet to wall (n, 3, m) and touching nodes for a sphere centred at (x, y, z).

    places: nodes (n, 3, m); x, y: in the frame of column 0. `rows` (n,) tells where any node touches: no end row does.
    """
    n = places.shape[0]
    m = places.shape[2]
    rows[:] = False
    touching[0] = False
    touching[n - 1] = False
    for i in range(1, n - 1):
        for j in range(m):
            c = math.cos(2.0 * math.pi * j / m) if x != 0.0 or y != 0.0 else 1.0
            s = math.sin(2.0 * math.pi * j / m) if x != 0.0 or y != 0.0 else 0.0
            dx = places[i, 0, j] - (c * x + s * y)
            dy = places[i, 1, j] - (c * y - s * x)
            dz = places[i, 2, j] - z
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            gap[i, j] = distance - radius
            normal[i, 0, j] = dx / distance
            normal[i, 1, j] = dy / distance
            normal[i, 2, j] = dz / distance
            touching[i, j] = density[i, j] - AUGMENTATION * gap[i, j] > 0.0
            if touching[i, j]:
                rows[i] = True


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
