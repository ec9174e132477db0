"""Work done and lost in a step by a wall on the whole surface, term by term; see `balance` for one column, Eq. (29)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import surface_volume, to_frames
from ..numerics.compiled import compiled
from ..wall.constants import SurfaceConstants, WallConstants
from ..wall.membrane import PARTS
from .state import WallState
from .surface_fields import corner_of_surface, padded_frames, regulariser_forces, surface_stretches

Floats = NDArray[np.float64]


def surface_wall_work(old: WallState, new: WallState, c: WallConstants, s: SurfaceConstants) -> tuple[float, ...]:
    """(stored, active, lost) in the wall over a step between two states [mN cm]; active work is done on the wall."""
    before, after = surface_stretches(old.position, c), surface_stretches(new.position, c)
    parts = np.zeros(4)
    _corner_work(
        before.axial,
        before.hoop,
        old.stretch_rate,
        old.hoop_rate,
        old.drive,
        after.axial,
        after.hoop,
        new.stretch_rate,
        new.hoop_rate,
        new.drive,
        c,
        parts,
    )
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
def _corner_work(
    stretch_0: np.ndarray,
    hoop_0: np.ndarray,
    stretch_rate_0: np.ndarray,
    hoop_rate_0: np.ndarray,
    drive_0: np.ndarray,
    stretch_1: np.ndarray,
    hoop_1: np.ndarray,
    stretch_rate_1: np.ndarray,
    hoop_rate_1: np.ndarray,
    drive_1: np.ndarray,
    c: WallConstants,
    out: np.ndarray,
) -> None:
    """Trapezoidal work on the wall by part into `out`: passive, active, viscous, and what the floor adds."""
    old = np.empty(PARTS)
    new = np.empty(PARTS)
    m = stretch_0.shape[1]
    out[:] = 0.0
    for e in range(stretch_0.shape[0]):
        for end in range(2):
            i = e + end
            for j in range(m):
                for k in (j - 1 if j > 0 else m - 1, j):
                    l_0 = stretch_0[e, j]
                    l_1 = stretch_1[e, j]
                    c_0 = hoop_0[i, k]
                    c_1 = hoop_1[i, k]
                    corner_of_surface(stretch_0, hoop_0, stretch_rate_0, hoop_rate_0, drive_0, e, end, j, k, c, old)
                    corner_of_surface(stretch_1, hoop_1, stretch_rate_1, hoop_rate_1, drive_1, e, end, j, k, c, new)
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
