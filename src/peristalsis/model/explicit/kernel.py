"""The explicit scheme's loop over time, compiled as one: sheets, shell and pellet by turns, Eqs. (53)-(56).

The shape is that of the paper's Fig. 2: EXCLONG and EXCCIRC (`excite`), BIOSHELL and TRSOLID (`load`), step after step;
OUTPRN is what watches the run around it. A conduction step holds many micro-steps of the wall.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.tube import lumen_volume
from ...numerics.compiled import compiled
from ...numerics.transfer import Overlap, average
from ...pellet.friction import FrictionLaw, dry_friction, held_by_ends, pressed_part, sliding_velocity
from ...pellet.penalty import penalty_contact
from ...tissue.cells import plant as cell
from ...tissue.cells.plant import CellConstants
from ...tissue.explicit_sheet import Excitable, excite
from ...wall.constants import WallConstants
from ...wall.explicit import INSIDE, add_bending_forces, add_pressure_forces, add_tension_forces
from ..constants import LumenConstants, PelletConstants

DONE, LONGITUDINAL, CIRCULAR, STRETCH, VOLUME = range(5)
"""How `march` ends: well, or at what went out of range."""


class Shell(NamedTuple):
    """Wall and pellet in motion, all advanced in place; n nodes.

    place, rate, acceleration: (2, n) of rho and zeta: now [cm], half a micro-step ago [cm/s], now [cm/s^2].
    density, stretch_rate, hoop_rate, drive: as in WallState, of one column. pellet: centre, velocity, axial force,
    dry friction, sliding velocity. pressure: (1,).
    """

    place: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    density: np.ndarray
    stretch_rate: np.ndarray
    hoop_rate: np.ndarray
    drive: np.ndarray
    pellet: np.ndarray
    pressure: np.ndarray


class Laws(NamedTuple):
    """What moves the shell: constants of wall, pellet, lumen, friction; contact stiffness k_c [mN/cm^3]."""

    wall: WallConstants
    pellet: PelletConstants
    lumen: LumenConstants
    friction: FrictionLaw
    contact_stiffness: float


class Kinetics(NamedTuple):
    """What moves the sheets: constants of the cells, tables for a whole and a half step, level of activation [mV]."""

    cell: CellConstants
    table: np.ndarray
    half_table: np.ndarray
    exact: bool
    level: float


class Transfers(NamedTuple):
    """Transfers between the grids, Eq. (33)."""

    elements_to_faces: Overlap
    cells_to_half_elements: Overlap


class Plan(NamedTuple):
    """Steps of a call: `substeps` conduction steps from `time` [s], each of `micro` wall steps of `dt` [s].

    first_kick: time over which the first acceleration acts on the rates [s]. settle: the accelerations now are not
    known yet. predicted: dashpots see the rates of now, carried on by half a step, and not those of half a step ago.
    """

    time: float
    dt: float
    micro: int
    substeps: int
    first_kick: float
    settle: bool
    predicted: bool


@compiled
def load(
    shell: Shell, laws: Laws, drive: np.ndarray, centre: float, seen: np.ndarray, force: np.ndarray, normal: np.ndarray
) -> int:
    """Forces on the wall now, as accelerations, and on the pellet: its force, friction and sliding velocity.

    drive: (2, 2n - 2) [mV]. centre: of the pellet, predicted [cm]. seen: the rates that the dashpots see [cm/s],
    (2, n). Returns DONE, STRETCH or VOLUME; shell.pellet[1] becomes the pellet's velocity now.
    """
    rho = shell.place[0]
    zeta = shell.place[1]
    wall = laws.wall
    pellet = laws.pellet
    n = rho.size
    force[:, :] = 0.0
    bad = add_tension_forces(
        rho, zeta, seen[0], seen[1], drive[0], drive[1], wall, force[0], force[1], shell.stretch_rate
    )
    if bad != INSIDE:
        return STRETCH
    add_bending_forces(rho, zeta, seen[0], seen[1], wall, force[0], force[1])
    volume = lumen_volume(rho, zeta) - (pellet.volume if pellet.present else 0.0)
    if not volume > 0.0:
        return VOLUME
    lumen = laws.lumen
    shell.pressure[0] = lumen.pressure * (lumen.reference_volume / volume) ** lumen.exponent
    add_pressure_forces(rho, zeta, shell.pressure[0], wall, force[0], force[1])
    h = wall.element_size
    if pellet.present:
        penalty_contact(rho, zeta, centre, pellet, laws.contact_stiffness, shell.density, normal)
        circumference = 2.0 * math.pi * wall.radius
        axial = 0.0
        pressing = 0.0
        pushing = 0.0
        velocity_pressed = 0.0
        wall_velocity = 0.0
        for i in range(1, n - 1):
            q = shell.density[i]
            if q > 0.0:
                nr = normal[0, i]
                nz = normal[1, i]
                force[0, i] += h * q * nr
                force[1, i] += h * q * nz
                axial -= circumference * h * q * nz
                pressing += circumference * h * q * nr
                pushing += q
                wall_velocity += q * seen[1, i]
                velocity_pressed += q * nr * seen[1, i]
        if pushing > 0.0:
            wall_velocity /= pushing
        dry = dry_friction(pellet.dry, laws.friction, pressing, shell.pellet[4] == 0.0)
        part = 0.0  # of the friction, in proportion to pressing
        if laws.friction.coefficient > 0.0 and pressing > 0.0:
            part = pressed_part(pellet.dry, laws.friction, pressing, axial, dry)
            velocity_pressed *= circumference * h / pressing
            wall_velocity = (1.0 - part) * wall_velocity + part * velocity_pressed
        sliding = sliding_velocity(axial, pellet.viscous, dry)[0]
        if pellet.frame != 0.0 and pushing > 0.0:
            for i in range(1, n - 1):
                q = shell.density[i]
                if q > 0.0:
                    reaction = pellet.frame * q / pushing * axial / circumference
                    if part > 0.0:
                        pressed = pellet.frame * part * h * q * axial / pressing
                        force[0, i] -= pressed * normal[1, i]
                        reaction = (1.0 - part) * reaction + pressed * normal[0, i]
                    force[1, i] += reaction
        shell.pellet[1] = pellet.frame * wall_velocity + sliding
        shell.pellet[2] = axial
        shell.pellet[3] = dry
        shell.pellet[4] = sliding
    per_mass = 1.0 / (wall.surface_density * h)
    for i in range(1, n - 1):
        shell.acceleration[0, i] = per_mass * force[0, i]
        shell.acceleration[1, i] = per_mass * force[1, i]
    return DONE


@compiled
def _ahead(shell: Shell, wall: WallConstants, time: float, stretch: np.ndarray) -> None:
    """Longitudinal stretch of the elements `time` [s] ahead, (n - 1, 1), by their rates."""
    for e in range(stretch.shape[0]):
        dr = shell.place[0, e + 1] - shell.place[0, e]
        dz = shell.place[1, e + 1] - shell.place[1, e]
        now = math.sqrt(dr * dr + dz * dz) / wall.element_size
        stretch[e, 0] = max(now + time * shell.stretch_rate[e], 0.5 * now)


@compiled
def _muscle(sheet: Excitable, transfers: Transfers, source: np.ndarray, halves: np.ndarray, drive: np.ndarray) -> None:
    """Force factor times phi+ of the half elements [mV], Eqs. (19), (33), into `drive`."""
    for k in range(source.shape[0]):
        source[k, 0] = sheet.force_factor[k] * max(sheet.potential[k] - sheet.threshold, 0.0)
    average(transfers.cells_to_half_elements, source, halves)
    drive[:] = halves[:, 0]


@compiled
def _relax(sheet: Excitable, kinetics: Kinetics, table: np.ndarray, span: float, instant: np.ndarray) -> None:
    """Gates of a sheet over a span [ms] at its held potential, and what of its cells follows the potential at once."""
    cell.relax_gates(
        sheet.potential, sheet.gates, table, kinetics.exact, span, kinetics.cell, instant, sheet.conductances
    )


@compiled
def march(
    longitudinal: Excitable,
    circular: Excitable,
    shell: Shell,
    laws: Laws,
    kinetics: Kinetics,
    transfers: Transfers,
    plan: Plan,
) -> tuple[int, int, int]:
    """Advance sheets, wall and pellet over one wall step, in place.

    Returns (code, cell or 0, micro-steps made); after any code but DONE the arrays must not be used.
    """
    n = shell.place.shape[1]
    cells = longitudinal.potential.size
    dt = plan.dt
    dt_cell = plan.micro * dt
    instant = np.empty((2, cell.INSTANT, cells))
    work = np.empty((3 + cell.HELD, cells))
    stretch = np.empty((n - 1, 1))
    faces = np.empty((cells - 1, 1))
    source = np.empty((cells, 1))
    halves = np.empty((2 * n - 2, 1))
    before = np.empty((2, 2 * n - 2))
    after = np.empty((2, 2 * n - 2))
    drive = np.empty((2, 2 * n - 2))
    force = np.empty((2, n))
    normal = np.empty((2, n))
    seen = np.zeros((2, n))
    place = shell.place
    rate = shell.rate
    acceleration = shell.acceleration
    pellet = shell.pellet
    made = 0
    after[:, :] = shell.drive
    if plan.settle:
        seen[:, :] = rate
        code = load(shell, laws, after, pellet[0], seen, force, normal)
        if code != DONE:
            return code, 0, made
    bad = cell.out_of_range(longitudinal.potential)
    if bad >= 0:
        return LONGITUDINAL, bad, made
    bad = cell.out_of_range(circular.potential)
    if bad >= 0:
        return CIRCULAR, bad, made
    half = 500.0 * dt_cell  # half a conduction step in ms, for the kernels of cells
    constants, table, half_table = kinetics.cell, kinetics.table, kinetics.half_table
    exact = kinetics.exact
    _relax(longitudinal, kinetics, half_table, half, instant[0])
    _relax(circular, kinetics, half_table, half, instant[1])
    kick = plan.first_kick
    for substep in range(plan.substeps):
        now = 1e3 * (plan.time + substep * dt_cell)
        _ahead(shell, laws.wall, 0.5 * dt_cell, stretch)
        average(transfers.elements_to_faces, stretch, faces)
        # EXCLONG
        bad = excite(
            longitudinal,
            faces[:, 0],
            now,
            2.0 * half,
            constants,
            table,
            kinetics.exact,
            kinetics.level,
            instant[0],
            work,
        )
        if bad >= 0:
            return LONGITUDINAL, bad, made
        # EXCCIRC
        bad = excite(circular, faces[:, 0], now, 2.0 * half, constants, table, exact, kinetics.level, instant[1], work)
        if bad >= 0:
            return CIRCULAR, bad, made
        before[:, :] = after
        _muscle(longitudinal, transfers, source, halves, after[0])
        _muscle(circular, transfers, source, halves, after[1])
        for micro in range(plan.micro):
            share = (micro + 1) / plan.micro
            for i in range(1, n - 1):
                for k in range(2):
                    rate[k, i] += kick * acceleration[k, i]
                    place[k, i] += dt * rate[k, i]
                    seen[k, i] = rate[k, i]
                    if plan.predicted:
                        seen[k, i] += 0.5 * dt * acceleration[k, i]
            kick = dt
            for k in range(2 * n - 2):
                drive[0, k] = before[0, k] + share * (after[0, k] - before[0, k])
                drive[1, k] = before[1, k] + share * (after[1, k] - before[1, k])
            # BIOSHELL and TRSOLID: the pellet moves on as it did, then by the mean of its old and new velocity.
            velocity = pellet[1]
            code = load(shell, laws, drive, pellet[0] + dt * velocity, seen, force, normal)
            if code != DONE:
                return code, 0, made
            pellet[0] += 0.5 * dt * (velocity + pellet[1])
            if held_by_ends(pellet[0], laws.pellet.lowest, laws.pellet.highest):
                pellet[0] = min(max(pellet[0], laws.pellet.lowest), laws.pellet.highest)
                pellet[1] = 0.0
                pellet[4] = 0.0
            made += 1
        if substep < plan.substeps - 1:
            _relax(longitudinal, kinetics, table, 2.0 * half, instant[0])
            _relax(circular, kinetics, table, 2.0 * half, instant[1])
    _relax(longitudinal, kinetics, half_table, half, instant[0])
    _relax(circular, kinetics, half_table, half, instant[1])
    shell.drive[:, :] = after
    for i in range(n):
        shell.hoop_rate[i] = seen[0, i] / laws.wall.radius
    return DONE, 0, made
