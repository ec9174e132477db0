"""Work done and lost in a step by a wall on the whole surface, term by term; see `balance` for one column, Eq. (29)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import surface_volume, to_frames
from ..numerics.compiled import compiled
from ..wall.constants import SurfaceConstants, WallConstants
from ..wall.membrane import PARTS
from .arrays import StrainedSurface
from .state import WallState
from .surface_fields import corner_of_surface, padded_frames, regulariser_forces, strained_surface

Floats = NDArray[np.float64]


def surface_wall_work(old: WallState, new: WallState, c: WallConstants, s: SurfaceConstants) -> tuple[float, ...]:
    """(stored, active, lost) in the wall over a step between two states [mN cm]; active work is done on the wall."""
    parts = np.zeros(4)
    _corner_work(strained_surface(old, c), strained_surface(new, c), c, parts)
    moved = to_frames(new.position) - to_frames(old.position)
    elastic_0, viscous_0 = regulariser_forces(old, c, s)
    elastic_1, viscous_1 = regulariser_forces(new, c, s)
    stored = parts[0] + 0.5 * float(((elastic_0 + elastic_1) * moved).sum())
    lost = parts[2] + parts[3] + 0.5 * float(((viscous_0 + viscous_1) * moved).sum())
    return stored, float(parts[1]), lost


def volume_of(wall: WallState) -> float:
    """Volume inside the wall [cm^3], the pellet's included, Eq. (18)."""
    return float(surface_volume(padded_frames(wall.position)))


@compiled
def _corner_work(before: StrainedSurface, after: StrainedSurface, c: WallConstants, out: np.ndarray) -> None:
    """Trapezoidal work on the wall by part into `out`: passive, active, viscous, and what the floor adds."""
    old = np.empty(PARTS)
    new = np.empty(PARTS)
    m = before.axial.shape[1]
    out[:] = 0.0
    for e in range(before.axial.shape[0]):
        for end in range(2):
            i = e + end
            for j in range(m):
                for k in (j - 1 if j > 0 else m - 1, j):
                    l_0 = before.axial[e, j]
                    l_1 = after.axial[e, j]
                    c_0 = before.hoop[i, k]
                    c_1 = after.hoop[i, k]
                    corner_of_surface(before, e, end, j, k, c, old)
                    corner_of_surface(after, e, end, j, k, c, new)
                    for layer in range(2):
                        across_0 = (l_0 if layer else c_0) if c.published else 1.0
                        across_1 = (l_1 if layer else c_1) if c.published else 1.0
                        change = (c_1 - c_0) if layer else (l_1 - l_0)
                        total = 0.0
                        for part in range(4):
                            mean = 0.5 * (old[4 * layer + part] * across_0 + new[4 * layer + part] * across_1)
                            if part < 3:
                                out[part] += mean * change
                                total += mean * change
                            else:
                                out[3] += mean * change - total
    weight = 0.25 * c.element_size * 2.0 * math.pi * c.radius / m
    for part in range(4):
        out[part] *= weight
