"""How small the forces on the nodes can become in double precision, Eq. (58), and whether a state is there.

A place is kept to one part in 2^53, and the wall's stiffness turns that into a force: of an element ~ N_ll/h, of the
bending regulariser ~ 16 B/h^3. On fine grids and on wall stretched far into its exponential that exceeds a small
`solver.residual_tolerance`, and no iteration can get below it.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import INDEX, compiled
from ..wall.assembly import FORCE_R, FORCE_Z, LEFT, RIGHT_CORNER, STRETCH, VOLUME_R, VOLUME_Z
from ..wall.constants import WallConstants

UNIT_ROUNDOFF = 2.0**-53
ALLOWANCE = 2.0
"""Residuals up to this times the estimate count as rounding: once for the places, once for the sums of the forces."""


@compiled
def force_rounding(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    pressure: float,
    slope: float,
    wall: WallConstants,
    i: int,
    work: np.ndarray,
) -> float:
    """Estimate of what rounding leaves of the forces on an inner node [mN/cm], Eq. (58), after `wall_forces`."""
    h = wall.element_size
    place = UNIT_ROUNDOFF * (max(abs(zeta[i - 1]), abs(zeta[i + 1])) + max(rho[i - 1], rho[i], rho[i + 1]))
    stiff = sums = 0.0
    hoop = rho[i] / wall.radius
    for side in range(2):
        e = i - 1 + side
        near = RIGHT_CORNER if side == 0 else LEFT  # the corner at this node
        along = max(abs(work[LEFT, e]), abs(work[RIGHT_CORNER, e]))
        stiff += (max(abs(work[LEFT + 2, e]), abs(work[RIGHT_CORNER + 2, e])) + along / work[STRETCH, e]) / h
        around = abs(work[near + 1, e]) + hoop * abs(work[near + 5, e]) + work[STRETCH, e] * abs(work[near + 4, e])
        sums += along + hoop * abs(work[near + 3, e]) + 0.5 * h / wall.radius * around
    bending = (wall.bending_stiffness + wall.bending_viscosity * slope) / (h * h * h)
    sums += abs(pressure) * (abs(work[VOLUME_R, i]) + abs(work[VOLUME_Z, i])) + h * density[i]
    return place * (2.0 * stiff + 16.0 * bending) + 4.0 * UNIT_ROUNDOFF * sums


@compiled
def at_rounding(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    pressure: float,
    slope: float,
    wall: WallConstants,
    tolerance: float,
    work: np.ndarray,
) -> bool:
    """Whether the residual forces of all inner nodes are below `tolerance` [mN/cm] or no more than rounding."""
    good = True
    for o in range(rho.size - 2):
        i = (o + 1) & INDEX
        force = max(abs(work[FORCE_R, i]), abs(work[FORCE_Z, i]))
        if force > tolerance:
            allowed = ALLOWANCE * force_rounding(rho, zeta, density, pressure, slope, wall, i, work)
            good = good and force <= allowed
    return good and math.isfinite(pressure)
