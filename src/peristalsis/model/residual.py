"""Residuals of the equilibrium: forces on the nodes, gaps, and the three scalars, Eqs. (1), (17), (27), (28), (34)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.tube import lumen_volume
from ..numerics.compiled import INDEX, compiled
from ..numerics.reductions import squares_and_largest
from ..pellet.contact import AUGMENTATION
from ..pellet.friction import falling_velocity, held_by_ends
from ..pellet.load import pull_of_load
from ..pellet.shapes.sphere import gap_and_normal
from ..wall.assembly import FORCE_R, FORCE_Z, HISTORY_R, HISTORY_Z, VOLUME_R, VOLUME_Z, wall_forces
from .problem import (
    BEND,
    GAP,
    NORMAL_R,
    NORMAL_Z,
    TANGENT,
    TOUCHES,
    VELOCITY_R,
    VELOCITY_Z,
    WEIGHT,
    Problem,
    Unknowns,
)
from .verdicts import GAP_SCALE, TENSION_SCALE


class Balance(NamedTuple):
    """How far a state is from equilibrium.

    within: whether the state is in range. merit: root of the sum of squares of all scaled residuals; worst: the
    largest of them. pressure [mN/cm^2], centre [cm], force [mN]: residuals of the scalars. law: what the gas law gives
    for the pressure at the lumen's `volume` [cm^3]. speed_slope: derivative of the pellet's velocity by its force;
    pull_slope: of the load's pull by the place.
    """

    within: bool
    merit: float
    worst: float
    pressure: float
    centre: float
    force: float
    law: float
    volume: float
    speed_slope: float
    pull_slope: float


@compiled
def forces(unknowns: Unknowns, problem: Problem, first: int, last: int, work: np.ndarray) -> bool:
    """Residual forces on the nodes first...last, and where they touch the pellet; False out of range."""
    rho, zeta, density, scalars = unknowns.rho, unknowns.zeta, unknowns.density, unknowns.scalars
    known, wall, pellet, step = problem.known, problem.wall, problem.pellet, problem.step
    if not wall_forces(rho, zeta, known, step.slope, wall, first, last, work):
        return False
    first, high = first & INDEX, (last + 1) & INDEX
    for i in range(first, high):
        work[FORCE_R, i] -= scalars[0] * work[VOLUME_R, i]
        work[FORCE_Z, i] -= scalars[0] * work[VOLUME_Z, i]
    h = wall.element_size
    if step.inertia:
        mass = wall.surface_density * h * step.slope
        for i in range(first, high):
            work[FORCE_R, i] += mass * ((rho[i] - known[HISTORY_R, i]) * step.slope - known[VELOCITY_R, i])
            work[FORCE_Z, i] += mass * ((zeta[i] - known[HISTORY_Z, i]) * step.slope - known[VELOCITY_Z, i])
    if pellet.present:
        reaction = pellet.frame * scalars[2] / problem.circumference
        for i in range(first, high):
            axial = zeta[i] - scalars[1]
            work[TOUCHES, i] = 0.0
            work[FORCE_Z, i] -= reaction * known[WEIGHT, i]
            rubbed = pellet.tangential and known[TANGENT, i] != 0.0
            if density[i] == 0.0 and not rubbed and (axial < -pellet.oral or axial > pellet.anal):
                continue
            gap, normal_r, normal_z, bend, _ = gap_and_normal(rho[i], axial, pellet.shape)
            work[GAP, i] = gap
            work[NORMAL_R, i] = normal_r
            work[NORMAL_Z, i] = normal_z
            work[BEND, i] = bend
            if rubbed:
                work[FORCE_R, i] += reaction * known[TANGENT, i] * normal_z / normal_r
            if density[i] - AUGMENTATION * gap > 0.0:
                work[TOUCHES, i] = 1.0
            q = h * density[i]
            work[FORCE_R, i] -= q * normal_r
            work[FORCE_Z, i] -= q * normal_z
    return True


@compiled
def measure(density: np.ndarray, problem: Problem, first: int, last: int, work: np.ndarray) -> tuple[float, float]:
    """(sum of squares, largest) of the scaled residuals at the nodes first...last, as acceptance sees the largest."""
    first, high = first & INDEX, (last + 1) & INDEX
    open_unit = problem.wall.radius / TENSION_SCALE
    gap_unit = GAP_SCALE / TENSION_SCALE
    gap_weight = problem.limits.tolerance / problem.limits.gap_tolerance
    squares_r, loudest_r = squares_and_largest(work[FORCE_R], first, high)
    squares_z, loudest_z = squares_and_largest(work[FORCE_Z], first, high)
    total = (squares_r + squares_z) / (problem.unit * problem.unit)
    worst = max(loudest_r, loudest_z) / problem.unit
    for i in range(first, high):
        if work[TOUCHES, i] != 0.0:
            error = gap_unit * abs(work[GAP, i])
            worst = max(worst, abs(work[GAP, i]) * gap_weight)
        elif density[i] != 0.0:
            error = open_unit * abs(density[i])
            worst = max(worst, error)
        else:
            continue
        total += error * error
    return total, worst


@compiled
def _pellet_balance(unknowns: Unknowns, problem: Problem, work: np.ndarray) -> tuple[float, float, float, float]:
    """Residuals of the pellet's centre [cm] and force [mN], Eqs. (27), (34), (60); slopes of its velocity and load.

    Those are of the velocity by the force, and of the load's pull by the place.
    """
    zeta, density, scalars = unknowns.zeta, unknowns.density, unknowns.scalars
    known, pellet, step = problem.known, problem.pellet, problem.step
    h, circumference = problem.wall.element_size, problem.circumference
    pull, pull_slope = pull_of_load(scalars[1], pellet)
    speed, speed_slope = falling_velocity(
        scalars[2] - pull, pellet.viscous, pellet.dry, pellet.fast_share, pellet.fall_speed, pellet.sliding
    )
    axial = 0.0
    wall_velocity = 0.0
    for i in range(1, zeta.size - 1):
        if density[i] != 0.0:
            axial -= circumference * h * density[i] * work[NORMAL_Z, i]
            wall_velocity += known[WEIGHT, i] * (zeta[i] - known[HISTORY_Z, i]) * step.slope
        elif known[WEIGHT, i] != 0.0:
            wall_velocity += known[WEIGHT, i] * (zeta[i] - known[HISTORY_Z, i]) * step.slope
    force = scalars[2] - axial
    centre = scalars[1] - step.pellet_history - step.pellet_weight * (pellet.frame * wall_velocity + speed)
    if held_by_ends(scalars[1] - centre, pellet.lowest, pellet.highest):
        centre = scalars[1] - min(max(scalars[1] - centre, pellet.lowest), pellet.highest)
        speed_slope = 0.0
    return centre, force, speed_slope, pull_slope


@compiled
def balance(unknowns: Unknowns, problem: Problem, within: bool, work: np.ndarray) -> Balance:
    """The balance of a state after `forces` on all inner nodes, which told whether it is `within` range."""
    wall, pellet, lumen = problem.wall, problem.pellet, problem.lumen
    volume = 0.0
    if within:
        volume = lumen_volume(unknowns.rho, unknowns.zeta) - (pellet.volume if pellet.present else 0.0)
        within = volume > 0.0
    if not within:
        return Balance(False, math.inf, math.inf, 0.0, 0.0, 0.0, 0.0, volume, 0.0, 0.0)
    n = unknowns.rho.size
    law = lumen.pressure * (lumen.reference_volume / volume) ** lumen.exponent
    total, worst = measure(unknowns.density, problem, min(1, n), n - 2, work)
    pressure = unknowns.scalars[0] - law
    centre = force = speed_slope = pull_slope = 0.0
    if pellet.present:
        centre, force, speed_slope, pull_slope = _pellet_balance(unknowns, problem, work)
    for error in (
        abs(pressure) * wall.radius / TENSION_SCALE,
        abs(force) / (problem.circumference * TENSION_SCALE),
        abs(centre) * GAP_SCALE / TENSION_SCALE,
    ):
        total += error * error
        worst = max(worst, error)
    within = math.isfinite(total)
    merit = math.sqrt(total) if within else math.inf
    return Balance(within, merit, worst, pressure, centre, force, law, volume, speed_slope, pull_slope)
