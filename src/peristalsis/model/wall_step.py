"""An implicit step of the axisymmetric wall in one compiled call: its start, the solver, what its answer means."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from ..pellet.body import unpack_pellet
from ..pellet.constants import PELLET_DRY, PELLET_SLIDING, PELLET_VISCOUS, PelletConstants
from ..pellet.contact import axial_force
from ..pellet.friction import (
    FrictionLaw,
    Nodes,
    Shares,
    Start,
    falling_velocity,
    friction_of_step,
    held_by_ends,
    pressed_on_end,
)
from ..pellet.load import pull_of_load
from ..wall.assembly import HISTORY_HOOP, HISTORY_R, HISTORY_STRETCH, HISTORY_Z, set_drives
from ..wall.constants import WallConstants
from ..wall.membrane import element_stretch
from ..wall.unpacking import unpack_wall
from .arrays import NewWall, WallArrays
from .constants import Step, unpack_lumen
from .equilibrium import solve
from .predictor import Stretches, fit_lengths
from .problem import KNOWN, TANGENT, VELOCITY_R, WEIGHT, Limits, Problem, Unknowns, Workspace, posed
from .verdicts import CONVERGED, OUT_OF_RANGE, ROUNDED

PRESSURE, CENTRE, VELOCITY, FORCE, DRY, VISCOUS, SLIDING = range(7)
"""Entries of the numbers that a step starts from and ends with: mN/cm^2, cm, cm/s, mN, mN, mN s/cm, 0 or 1."""


class Request(NamedTuple):
    """What a step is to be: lengths [s] of it and of the one before, formula of the rates (32), friction, solver."""

    dt: float
    step_before: float
    older: float
    inverse: float
    second_order: bool
    inertia: bool
    tolerance: float
    gap_tolerance: float
    max_newton: int
    friction: FrictionLaw


@compiled
def step_wall(
    before: WallArrays,
    drive: np.ndarray,
    numbers: np.ndarray,
    request: Request,
    wall_numbers: np.ndarray,
    pellet_numbers: np.ndarray,
    lumen_numbers: np.ndarray,
    work: np.ndarray,
    system: np.ndarray,
    after: NewWall,
) -> tuple[int, int, int]:
    """One implicit step from `before` under the new drive into `after`: (code, iterations, assemblies).

    numbers (7,): PRESSURE...FORCE before and after the step; DRY, VISCOUS: friction in the step before, then in this
    one; SLIDING: whether the pellet slid when that step began.
    Constants by `constants.packed`; work, system: `equilibrium.workspace`. Unless the code is CONVERGED, numbers and
    `after` must not be used.
    """
    r = request
    n = before.position.shape[0]
    pellet = unpack_pellet(pellet_numbers)
    wall = unpack_wall(wall_numbers)
    # Friction over the step, from the contact at its start, Eqs. (27), (50), (51).
    shares = Shares(np.empty((n, 1)), np.empty((n, 1)))
    held = pressed_on_end(numbers[CENTRE], numbers[VELOCITY], numbers[FORCE], pellet.lowest, pellet.highest)
    net = 0.0 if held else numbers[FORCE] - pull_of_load(numbers[CENTRE], pellet)[0]
    slides = numbers[SLIDING] != 0.0
    stuck = (
        falling_velocity(net, numbers[VISCOUS], numbers[DRY], pellet.fast_share, pellet.fall_speed, slides)[0] == 0.0
    )
    friction = friction_of_step(
        Nodes(before.contact, before.position, 2.0 * np.pi * wall.radius * wall.element_size),
        Start(numbers[CENTRE], net, stuck),
        pellet.shape,
        pellet.viscous,
        pellet.dry,
        r.friction,
        shares,
    )
    own_numbers = pellet_numbers.copy()
    own_numbers[PELLET_VISCOUS] = friction.viscous
    own_numbers[PELLET_DRY] = friction.dry
    own_numbers[PELLET_SLIDING] = 0.0 if stuck else 1.0
    own = unpack_pellet(own_numbers)

    second = r.second_order and r.step_before > 0.0
    pellet_weight = 0.5 * r.dt if second else r.dt
    pellet_history = numbers[CENTRE] + (0.5 * r.dt * numbers[VELOCITY] if second else 0.0)
    step = Step(r.inverse, r.inertia, pellet_history, pellet_weight)
    scalars = np.array([numbers[PRESSURE], numbers[CENTRE] + r.dt * numbers[VELOCITY], numbers[FORCE]])
    unknowns, known = Unknowns(np.empty(n), np.empty(n), np.empty(n), scalars), np.zeros((KNOWN, n))
    if not prepare_step(before, drive, r, shares, wall, own, unknowns, known):
        return OUT_OF_RANGE, 0, 0
    limits = Limits(r.tolerance, r.gap_tolerance, r.max_newton)
    problem = posed(unknowns, known, wall, own, unpack_lumen(lumen_numbers), step, limits)
    code, iterations, assemblies, _ = solve(unknowns, problem, Workspace(work, system))
    if code == ROUNDED:  # no step of any length does better
        code = CONVERGED
    if code != CONVERGED:
        return code, iterations, assemblies
    numbers[PRESSURE], numbers[CENTRE] = scalars[0], scalars[1]
    numbers[DRY], numbers[VISCOUS], numbers[SLIDING] = friction.dry, friction.viscous, own_numbers[PELLET_SLIDING]
    finish_step(unknowns, problem, before.position, numbers, after)
    return code, iterations, assemblies


@compiled
def prepare_step(
    before: WallArrays,
    drive: np.ndarray,
    request: Request,
    shares: Shares,
    wall: WallConstants,
    pellet: PelletConstants,
    guess: Unknowns,
    known: np.ndarray,
) -> bool:
    """What `solve` needs for a step from a wall of one column: the guess and `known` (KNOWN, n), which are written.

    The scalars of the guess are there already. False if the state is out of range.
    """
    rho, zeta, density = guess.rho, guess.zeta, guess.density
    position, position_before = before.position, before.position_before
    velocity, velocity_before = before.velocity, before.velocity_before
    dt, older, step_before = request.dt, request.older, request.step_before
    n = position.shape[0]
    m = n - 1
    now, past = np.empty((2, n)), np.empty((2, n))
    trend = 1.0 + 0.5 * dt / step_before if step_before > 0.0 else 1.0
    for k in range(2):
        place = rho if k == 0 else zeta
        for i in range(n):
            x, x_before = position[i, 0, 2 * k], position_before[i, 0, 2 * k]
            v, v_before = velocity[i, 0, 2 * k], velocity_before[i, 0, 2 * k]
            now[k, i] = x
            past[k, i] = x_before
            known[HISTORY_R + k, i] = x - older * (x - x_before)
            known[VELOCITY_R + k, i] = v - older * (v - v_before)
            place[i] = x + dt * (trend * v - (trend - 1.0) * v_before)
        place[0], place[m] = now[k, 0], now[k, m]  # the clamped ends, to the last bit
    stretch, stretch_before = np.empty(m), np.empty(m)
    if not element_stretch(now[0], now[1], wall.element_size, stretch):
        return False
    if not element_stretch(past[0], past[1], wall.element_size, stretch_before):
        return False
    for e in range(m):
        known[HISTORY_STRETCH, e] = stretch[e] - older * (stretch[e] - stretch_before[e])
    hoop = np.empty(n)
    for i in range(n):
        hoop[i] = now[0, i] / wall.radius
        known[HISTORY_HOOP, i] = known[HISTORY_R, i] / wall.radius
        density[i] = before.contact[i, 0]
        known[WEIGHT, i] = shares.weight[i, 0]
        known[TANGENT, i] = shares.tangent[i, 0]
    set_drives(drive[0, :, 0].copy(), drive[1, :, 0].copy(), known)
    if step_before > 0.0:
        fit_lengths(guess, before, Stretches(stretch, hoop), known, request.inverse, wall, pellet)
    return True


@compiled
def finish_step(found: Unknowns, problem: Problem, position: np.ndarray, numbers: np.ndarray, after: NewWall) -> None:
    """The new `WallState` and pellet from a solution.

    position: before the step, for the angles. numbers (7,): pressure and centre by the solver; the centre and what
    is left follow here, the velocity from the stored contact by the friction law, Eqs. (13), (34).
    """
    rho, zeta, density = found.rho, found.zeta, found.density
    known, wall, pellet, step = problem.known, problem.wall, problem.pellet, problem.step
    inverse = step.slope
    n = rho.size
    m = n - 1
    for i in range(n):
        after.position[i, 0, 0] = rho[i]
        after.position[i, 0, 1] = position[i, 0, 1]
        after.position[i, 0, 2] = zeta[i]
        inner = inverse if 0 < i < m else 0.0
        after.velocity[i, 0, 0] = (rho[i] - known[HISTORY_R, i]) * inner
        after.velocity[i, 0, 1] = 0.0
        after.velocity[i, 0, 2] = (zeta[i] - known[HISTORY_Z, i]) * inner
        after.contact[i, 0] = density[i]
        after.hoop_rate[i, 0] = (rho[i] / wall.radius - known[HISTORY_HOOP, i]) * inverse
    stretch = np.empty(m)
    element_stretch(rho, zeta, wall.element_size, stretch)
    for e in range(m):
        after.stretch_rate[e, 0] = (stretch[e] - known[HISTORY_STRETCH, e]) * inverse
    numbers[VELOCITY] = 0.0
    numbers[FORCE] = 0.0
    if not pellet.present:
        return
    area = 2.0 * np.pi * wall.radius * wall.element_size
    numbers[FORCE] = axial_force(rho, zeta, density, numbers[CENTRE], pellet.shape, area)
    net = numbers[FORCE] - pull_of_load(numbers[CENTRE], pellet)[0]
    sliding, _ = falling_velocity(net, pellet.viscous, pellet.dry, pellet.fast_share, pellet.fall_speed, pellet.sliding)
    carried = 0.0
    for i in range(n):
        carried += known[WEIGHT, i] * after.velocity[i, 0, 2]
    numbers[VELOCITY] = sliding + pellet.frame * carried
    numbers[CENTRE] = step.pellet_history + step.pellet_weight * numbers[VELOCITY]
    if held_by_ends(numbers[CENTRE], pellet.lowest, pellet.highest):
        numbers[CENTRE] = min(max(numbers[CENTRE], pellet.lowest), pellet.highest)
        numbers[VELOCITY] = 0.0
