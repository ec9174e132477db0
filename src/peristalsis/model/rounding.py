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
from .problem import GAP, TOUCHES, Problem, Unknowns
from .residual import Balance
from .verdicts import GAP_SCALE, ROUNDOFF, TENSION_SCALE

UNIT_ROUNDOFF = 2.0**-53
ALLOWANCE = 2.0
"""Residuals up to this times the estimate count as rounding: once for the places, once for the sums of the forces."""
SCALAR_ROUNDING = 1e-13
"""Share of pressure and axial force that the rounding of the sums they follow from may take."""
LARGEST_ROUNDING = 1e-3
"""Rounding of the forces above this residual is no state of rest: of tensions beyond 1e9 mN/cm or so."""


@compiled
def force_rounding(unknowns: Unknowns, slope: float, wall: WallConstants, i: int, work: np.ndarray) -> float:
    """Estimate of what rounding leaves of the forces on an inner node [mN/cm], Eq. (58), after `wall_forces`."""
    rho, zeta, density, pressure = unknowns.rho, unknowns.zeta, unknowns.density, unknowns.scalars[0]
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
def _rest_is_closed(unknowns: Unknowns, problem: Problem, now: Balance, work: np.ndarray) -> bool:
    """Whether scalars, gaps and densities are within tolerance or rounding, so that forces alone are left over."""
    density, scalars = unknowns.density, unknowns.scalars
    tolerance, radius = problem.limits.tolerance, problem.wall.radius
    n = density.size
    apart = abs(now.pressure) > max(tolerance * TENSION_SCALE / radius, SCALAR_ROUNDING * abs(now.law))
    force_unit = problem.circumference * TENSION_SCALE
    apart = apart or abs(now.force) > max(tolerance * force_unit, SCALAR_ROUNDING * abs(scalars[2]))
    centre_rounding = ROUNDOFF * max(abs(scalars[1]), unknowns.zeta[n - 1])
    apart = apart or abs(now.centre) > max(tolerance * TENSION_SCALE / GAP_SCALE, centre_rounding)
    for i in range(min(1, n), n - 1):
        if work[TOUCHES, i] != 0.0:
            apart = apart or abs(work[GAP, i]) > max(problem.limits.gap_tolerance, centre_rounding)
        else:
            apart = apart or abs(density[i]) * radius > tolerance * TENSION_SCALE
    return not apart


@compiled
def at_rounding(unknowns: Unknowns, problem: Problem, now: Balance, work: np.ndarray) -> bool:
    """Whether what is left of all residuals is below the tolerance or no more than rounding."""
    if now.worst >= LARGEST_ROUNDING or not _rest_is_closed(unknowns, problem, now, work):
        return False
    tolerance = problem.limits.tolerance * problem.unit
    good = True
    for o in range(unknowns.rho.size - 2):
        i = (o + 1) & INDEX
        force = max(abs(work[FORCE_R, i]), abs(work[FORCE_Z, i]))
        if force > tolerance:
            allowed = ALLOWANCE * force_rounding(unknowns, problem.step.slope, problem.wall, i, work)
            good = good and force <= allowed
    return good and math.isfinite(unknowns.scalars[0])
