"""An implicit step of the axisymmetric wall in one compiled call: its start, the solver, what its answer means."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from ..pellet.body import unpack_pellet
from ..pellet.constants import PELLET_DRY
from ..pellet.contact import axial_force
from ..pellet.friction import FrictionLaw, friction_of_step, held_by_ends, pressed_on_end, sliding_velocity
from ..wall.assembly import HISTORY_HOOP, HISTORY_R, HISTORY_STRETCH, HISTORY_Z, set_drives
from ..wall.membrane import element_stretch
from ..wall.unpacking import unpack_wall
from .arrays import NewWall, WallArrays
from .equilibrium import CONVERGED, KNOWN, OUT_OF_RANGE, ROUNDED, TANGENT, VELOCITY_R, WEIGHT, solve_packed
from .predictor import fit_lengths

PRESSURE, CENTRE, VELOCITY, FORCE, DRY = range(5)
"""Entries of the numbers that a step starts from and ends with: mN/cm^2, cm, cm/s, mN, mN."""


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

    numbers (5,): PRESSURE...FORCE before and after the step; DRY: dry friction in the step before, then in this one.
    Constants by `constants.packed`; work, system: `equilibrium.workspace`. Unless the code is CONVERGED, numbers and
    `after` must not be used.
    """
    r = request
    n = before.position.shape[0]
    pellet = unpack_pellet(pellet_numbers)
    wall = unpack_wall(wall_numbers)
    # Friction over the step, from the contact at its start, Eqs. (27), (50), (51).
    weight, tangent = np.empty((n, 1)), np.empty((n, 1))
    held = pressed_on_end(numbers[CENTRE], numbers[VELOCITY], numbers[FORCE], pellet.lowest, pellet.highest)
    dry = friction_of_step(
        before.contact,
        before.position,
        numbers[CENTRE],
        pellet.shape,
        0.0 if held else numbers[FORCE],
        pellet.viscous,
        numbers[DRY],
        pellet.dry,
        r.friction,
        2.0 * np.pi * wall.radius * wall.element_size,
        weight,
        tangent,
    )
    own_numbers = pellet_numbers.copy()
    own_numbers[PELLET_DRY] = dry

    rho, zeta, density, known = np.empty(n), np.empty(n), np.empty(n), np.zeros((KNOWN, n))
    second = r.second_order and r.step_before > 0.0
    pellet_weight = 0.5 * r.dt if second else r.dt
    pellet_history = numbers[CENTRE] + (0.5 * r.dt * numbers[VELOCITY] if second else 0.0)
    centre = numbers[CENTRE] + r.dt * numbers[VELOCITY]
    if not prepare_step(
        before.position,
        before.position_before,
        before.velocity,
        before.velocity_before,
        before.contact,
        before.stretch_rate,
        before.hoop_rate,
        before.drive,
        drive,
        r.step_before,
        r.dt,
        r.older,
        r.inverse,
        centre,
        weight,
        tangent,
        wall_numbers,
        own_numbers,
        rho,
        zeta,
        density,
        known,
    ):
        return OUT_OF_RANGE, 0, 0
    scalars = np.array([numbers[PRESSURE], centre, numbers[FORCE]])
    settings = np.empty(7)
    settings[0], settings[1] = r.inverse, 1.0 if r.inertia else 0.0
    settings[2], settings[3] = pellet_history, pellet_weight
    settings[4], settings[5], settings[6] = r.tolerance, r.gap_tolerance, r.max_newton
    code, iterations, assemblies = solve_packed(
        rho, zeta, density, scalars, known, wall_numbers, own_numbers, lumen_numbers, settings, work, system
    )
    if code == ROUNDED:  # no step of any length does better
        code = CONVERGED
    if code != CONVERGED:
        return code, iterations, assemblies
    numbers[PRESSURE], numbers[CENTRE], numbers[DRY] = scalars[0], scalars[1], dry
    finish_step(
        rho,
        zeta,
        density,
        known,
        before.position,
        r.inverse,
        pellet_history,
        pellet_weight,
        wall_numbers,
        own_numbers,
        numbers,
        after.position,
        after.velocity,
        after.contact,
        after.stretch_rate,
        after.hoop_rate,
    )
    return code, iterations, assemblies


@compiled
def prepare_step(
    position: np.ndarray,
    position_before: np.ndarray,
    velocity: np.ndarray,
    velocity_before: np.ndarray,
    contact: np.ndarray,
    stretch_rate: np.ndarray,
    hoop_rate: np.ndarray,
    old_drive: np.ndarray,
    drive: np.ndarray,
    step_before: float,
    dt: float,
    older: float,
    inverse: float,
    centre: float,
    weight: np.ndarray,
    tangent: np.ndarray,
    wall_numbers: np.ndarray,
    pellet_numbers: np.ndarray,
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    known: np.ndarray,
) -> bool:
    """What `solve_packed` needs for a step dt [s] from a `WallState` of one column: guess, densities, `known`.

    Shapes are those of `WallState`; rho, zeta, density (n,) and known (KNOWN, n) are written. older, inverse: of the
    `RateFormula`. centre: of the pellet at the end of the step [cm], extrapolated. weight, tangent: shares of the
    nodes in the friction, (n, 1), and what of them lies along the meridian. False if the state is out of range.
    """
    wall, pellet = unpack_wall(wall_numbers), unpack_pellet(pellet_numbers)
    n = position.shape[0]
    m = n - 1
    now, past = np.empty((2, n)), np.empty((2, n))
    trend = 1.0 + 0.5 * dt / step_before if step_before > 0.0 else 1.0
    for k in range(2):
        guess = rho if k == 0 else zeta
        for i in range(n):
            x, x_before = position[i, 0, 2 * k], position_before[i, 0, 2 * k]
            v, v_before = velocity[i, 0, 2 * k], velocity_before[i, 0, 2 * k]
            now[k, i] = x
            past[k, i] = x_before
            known[HISTORY_R + k, i] = x - older * (x - x_before)
            known[VELOCITY_R + k, i] = v - older * (v - v_before)
            guess[i] = x + dt * (trend * v - (trend - 1.0) * v_before)
        guess[0], guess[m] = now[k, 0], now[k, m]  # the clamped ends, to the last bit
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
        density[i] = contact[i, 0]
        known[WEIGHT, i] = weight[i, 0]
        known[TANGENT, i] = tangent[i, 0]
    set_drives(drive[0, :, 0].copy(), drive[1, :, 0].copy(), known)
    if step_before > 0.0:
        fit_lengths(
            rho, zeta, density, centre, pellet, stretch, stretch_rate, hoop, hoop_rate, old_drive, known, inverse, wall
        )
    return True


@compiled
def finish_step(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    known: np.ndarray,
    position: np.ndarray,
    inverse: float,
    pellet_history: float,
    pellet_weight: float,
    wall_numbers: np.ndarray,
    pellet_numbers: np.ndarray,
    numbers: np.ndarray,
    new_position: np.ndarray,
    new_velocity: np.ndarray,
    new_contact: np.ndarray,
    new_stretch_rate: np.ndarray,
    new_hoop_rate: np.ndarray,
) -> None:
    """The new `WallState` and pellet from a solution.

    position: before the step, for the angles. numbers (5,): pressure and centre by the solver; the centre and what
    is left follow here, the velocity from the stored contact by the friction law, Eqs. (13), (34).
    """
    wall, pellet = unpack_wall(wall_numbers), unpack_pellet(pellet_numbers)
    n = rho.size
    m = n - 1
    for i in range(n):
        new_position[i, 0, 0] = rho[i]
        new_position[i, 0, 1] = position[i, 0, 1]
        new_position[i, 0, 2] = zeta[i]
        inner = inverse if 0 < i < m else 0.0
        new_velocity[i, 0, 0] = (rho[i] - known[HISTORY_R, i]) * inner
        new_velocity[i, 0, 1] = 0.0
        new_velocity[i, 0, 2] = (zeta[i] - known[HISTORY_Z, i]) * inner
        new_contact[i, 0] = density[i]
        new_hoop_rate[i, 0] = (rho[i] / wall.radius - known[HISTORY_HOOP, i]) * inverse
    stretch = np.empty(m)
    element_stretch(rho, zeta, wall.element_size, stretch)
    for e in range(m):
        new_stretch_rate[e, 0] = (stretch[e] - known[HISTORY_STRETCH, e]) * inverse
    numbers[VELOCITY] = 0.0
    numbers[FORCE] = 0.0
    if not pellet.present:
        return
    area = 2.0 * np.pi * wall.radius * wall.element_size
    numbers[FORCE] = axial_force(rho, zeta, density, numbers[CENTRE], pellet.shape, area)
    sliding, _ = sliding_velocity(numbers[FORCE], pellet.viscous, pellet.dry)
    carried = 0.0
    for i in range(n):
        carried += known[WEIGHT, i] * new_velocity[i, 0, 2]
    numbers[VELOCITY] = sliding + pellet.frame * carried
    numbers[CENTRE] = pellet_history + pellet_weight * numbers[VELOCITY]
    if held_by_ends(numbers[CENTRE], pellet.lowest, pellet.highest):
        numbers[CENTRE] = min(max(numbers[CENTRE], pellet.lowest), pellet.highest)
        numbers[VELOCITY] = 0.0
