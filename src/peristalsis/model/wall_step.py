"""Before and after the solver of an implicit step of the axisymmetric wall: its start, and what its answer means."""

from __future__ import annotations

import numpy as np

from ..numerics.compiled import compiled
from ..pellet.contact import axial_force
from ..pellet.friction import sliding_velocity
from ..wall.assembly import HISTORY_HOOP, HISTORY_R, HISTORY_STRETCH, HISTORY_Z, set_drives
from ..wall.membrane import element_stretch
from .constants import unpack_pellet, unpack_wall
from .equilibrium import VELOCITY_R, WEIGHT
from .predictor import fit_lengths

PRESSURE, CENTRE, VELOCITY, FORCE = range(4)
"""Entries of the numbers that a step starts from and ends with: mN/cm^2, cm, cm/s, mN."""


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
    wall_numbers: np.ndarray,
    pellet_numbers: np.ndarray,
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    known: np.ndarray,
) -> bool:
    """What `solve_packed` needs for a step dt [s] from a `WallState` of one column: guess, densities, `known`.

    Shapes are those of `WallState`; rho, zeta, density (n,) and known (KNOWN, n) are written. older, inverse: of the
    `RateFormula`. centre: of the pellet at the end of the step [cm], extrapolated. weight: shares of the nodes in the
    friction, (n, 1). False if the state is out of range.
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
    set_drives(drive[0, :, 0].copy(), drive[1, :, 0].copy(), known)
    if step_before > 0.0:
        radius = pellet.radius if pellet.present else 0.0
        fit_lengths(
            rho, zeta, density, centre, radius, stretch, stretch_rate, hoop, hoop_rate, old_drive, known, inverse, wall
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

    position: before the step, for the angles. numbers (4,): pressure and centre by the solver; the centre and what
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
    numbers[FORCE] = axial_force(rho, zeta, density, numbers[CENTRE], pellet.radius, area)
    sliding, _ = sliding_velocity(numbers[FORCE], pellet.viscous, pellet.dry)
    carried = 0.0
    for i in range(n):
        carried += known[WEIGHT, i] * new_velocity[i, 0, 2]
    numbers[VELOCITY] = sliding + pellet.frame * carried
    numbers[CENTRE] = pellet_history + pellet_weight * numbers[VELOCITY]
