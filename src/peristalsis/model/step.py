"""One coupled step: drives, sheets, wall with lumen and pellet, then what the nerves saw. `advance` is pure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.pulses import add_pulses, covered
from ..control.reflex import observe_stretch
from ..control.sequence import observe_activation, observe_tension, trigger_current
from ..errors import DivergenceError
from ..numerics.rates import rate_formula
from ..numerics.transfer import average
from ..pellet.contact import axial_force
from ..pellet.friction import sliding_velocity
from ..tissue.cells.plant import CellConstants
from ..tissue.sheet import advance_sheet
from .equilibrium import CONVERGED, REASONS, Step, solve_equilibrium
from .fields import axial_tension_of_elements, column, stretch_of_elements
from .model import ACTIVATION_LEVEL, Layer, Model, explicit_stages
from .state import PelletState, SheetState, State, WallState

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StepReport:
    """What a step cost: Newton iterations, assemblies of the wall, wall solves (more than one after halving)."""

    newton_iterations: int
    assemblies: int
    wall_solves: int


def advance(model: Model, state: State) -> tuple[State, StepReport]:
    """The state one wall step later, and what it took. Raises DivergenceError naming field, place and time."""
    start = state.step * model.dt_wall
    stop = (state.step + 1) * model.dt_wall
    stretch = _stretch_ahead(model, state.wall)
    longitudinal_drive, circular_drive, pacemaker_drive = _drives(model, state, start, stop)
    shunt = np.zeros_like(circular_drive)
    add_pulses(state.reflex.inhibition, model.grid.cells, model.grid.cell_size, start, stop, shunt)
    longitudinal = _advance_layer(
        model, model.longitudinal, state.longitudinal, stretch, longitudinal_drive, None, start, "longitudinal"
    )
    circular = _advance_layer(model, model.circular, state.circular, stretch, circular_drive, shunt, start, "circular")
    pacemaker = _advance_pacemaker(model, state.pacemaker, pacemaker_drive, start)
    drive = np.stack(
        [muscle_drive(model, model.longitudinal, longitudinal), muscle_drive(model, model.circular, circular)]
    )
    solved = _solve_wall(
        model, state.wall, state.pellet, state.pressure, drive, model.dt_wall, model.max_halvings, stop
    )
    after = replace(
        state,
        step=state.step + 1,
        longitudinal=longitudinal,
        circular=circular,
        pacemaker=pacemaker,
        wall=solved.wall,
        pellet=solved.pellet,
        pressure=solved.pressure,
    )
    return _listen(model, after, stop), StepReport(solved.iterations, solved.assemblies, solved.solves)


def muscle_drive(model: Model, layer: Layer, sheet: SheetState) -> Floats:
    """Force factor times phi+ [mV] of the half elements, Eqs. (19) and (33): one for each corner."""
    source = layer.force_factor * np.maximum(sheet.potential - layer.threshold, 0.0)
    target = np.empty((2 * model.grid.n_z_wall, model.grid.n_theta))
    average(model.grid.cells_to_half_elements, source, target)
    return target


def _stretch_ahead(model: Model, wall: WallState) -> Floats:
    """Longitudinal stretch of the elements extrapolated to the middle of the coming step."""
    now = stretch_of_elements(wall.position, model.wall.element_size)
    if wall.step_before == 0.0:
        return now
    before = stretch_of_elements(wall.position_before, model.wall.element_size)
    return np.maximum(now + 0.5 * model.dt_wall / wall.step_before * (now - before), 0.5 * now)


def _drives(model: Model, state: State, start: float, stop: float) -> tuple[Floats, Floats, Floats]:
    """Mean stimulus currents over the step: longitudinal, circular (n_z, n_theta), pacemaker cell (1, 1)."""
    grid = model.grid
    shape = (grid.n_z, grid.n_theta)
    longitudinal, circular, own = np.zeros(shape), np.zeros(shape), np.zeros((1, 1))
    for trains, drive in ((model.longitudinal_trains, longitudinal), (model.circular_trains, circular)):
        for train in trains:
            add_pulses(train.between(start, stop), grid.cells, grid.cell_size, start, stop, drive)
    add_pulses(state.reflex.excitation, grid.cells, grid.cell_size, start, stop, circular)
    circular += trigger_current(model.trigger, state.trigger, start, stop)
    if model.pacemaker_cell is not None:
        cell = model.pacemaker_cell
        edge = 0.5 * grid.cell_size
        where = covered(grid.cells - edge, grid.cells + edge, 0.0, cell.width)[:, None]
        difference = state.pacemaker.potential[0, 0] - state.longitudinal.potential
        longitudinal += cell.coupling * where * difference
        own[0, 0] = -cell.coupling * float((where * difference).sum() / (where.sum() * grid.n_theta))
    return longitudinal, circular, own


def _advance_layer(
    model: Model,
    layer: Layer,
    sheet: SheetState,
    stretch: Floats,
    drive: Floats,
    shunt: Floats | None,
    start: float,
    name: str,
) -> SheetState:
    grid = model.grid
    if layer.conducts:
        faces = np.empty((grid.n_z - 1, grid.n_theta))
        average(grid.elements_to_faces, stretch, faces)
        coefficient = (layer.diffusivity * 1e-3 / (24.0 * grid.cell_size) ** 2) / faces
    else:
        coefficient = np.empty((0, grid.n_theta))
    opened = 0.0 if shunt is None else float(shunt.max())
    tissue = _Tissue(layer.conductances, coefficient, model.stages(layer, stretch, opened), model.tables, model.cell)
    return _advance_sheet(model, sheet, tissue, drive, shunt, start, f"{name} potential")


def _advance_pacemaker(model: Model, sheet: SheetState, drive: Floats, start: float) -> SheetState:
    cell = model.pacemaker_cell
    if cell is None:
        return sheet
    rate = cell.constants.kinetics_rate * float(cell.conductances.sum()) / cell.constants.capacitance
    stages = explicit_stages(rate, model.dt_cell)
    tissue = _Tissue(cell.conductances, np.empty((0, 1)), stages, model.pacemaker_tables, cell.constants)
    return _advance_sheet(model, sheet, tissue, drive, None, start, "pacemaker potential")


class _Tissue(NamedTuple):
    conductances: Floats
    coefficient: Floats
    stages: Floats
    tables: tuple[Floats, Floats]
    constants: CellConstants


def _advance_sheet(
    model: Model, sheet: SheetState, tissue: _Tissue, drive: Floats, shunt: Floats | None, start: float, field: str
) -> SheetState:
    shape = sheet.potential.shape
    potential = sheet.potential.ravel().copy()
    gates = sheet.gates.reshape(4, -1).copy()
    first, last = sheet.first_activation.ravel().copy(), sheet.last_activation.ravel().copy()
    bad = advance_sheet(
        potential,
        gates,
        first,
        last,
        tissue.conductances,
        tissue.coefficient.ravel(),
        drive.ravel(),
        np.zeros(drive.size) if shunt is None else shunt.ravel(),
        shape[1],
        start * 1e3,
        model.dt_cell,
        model.substeps,
        tissue.stages,
        tissue.tables[0],
        tissue.tables[1],
        model.exact_kinetics,
        ACTIVATION_LEVEL,
        tissue.constants,
    )
    if bad >= 0:
        place = f"z = {model.grid.cells[bad // shape[1]]:.3g} cm" if shape[0] > 1 else "the oral end"
        raise DivergenceError(
            f"{field} left -200...150 mV at {place}, t = {start:.6g} s: the conduction step of "
            f"{model.dt_cell:g} ms or a stimulus is too large; lower step.conduction or the intensity"
        )
    return SheetState(potential.reshape(shape), gates.reshape(4, *shape), first.reshape(shape), last.reshape(shape))


@dataclass(frozen=True)
class _Solved:
    wall: WallState
    pellet: PelletState
    pressure: float
    iterations: int
    assemblies: int
    solves: int


def _solve_wall(
    model: Model,
    wall: WallState,
    pellet: PelletState,
    pressure: float,
    drive: Floats,
    dt: float,
    halvings: int,
    time: float,
) -> _Solved:
    """Equilibrium after `dt`, in two half steps where one does not converge; the drive is linear in between."""
    code, solved = _try_wall(model, wall, pellet, pressure, drive, dt)
    if solved is not None:
        return solved
    if halvings == 0:
        where = int(np.argmin(wall.position[:, 0, 0]))
        raise DivergenceError(
            f"wall position: no equilibrium at t = {time:.6g} s even with a step of {dt:.2g} s ({REASONS[code]}); the "
            f"wall is narrowest at z = {model.grid.nodes[where]:.3g} cm, radius {wall.position[where, 0, 0]:.3g} cm. "
            "Lower step.wall, or raise wall.bending_stiffness or grid.n_z_wall"
        )
    middle = 0.5 * (wall.drive + drive)
    half = _solve_wall(model, wall, pellet, pressure, middle, 0.5 * dt, halvings - 1, time - 0.5 * dt)
    full = _solve_wall(model, half.wall, half.pellet, half.pressure, drive, 0.5 * dt, halvings - 1, time)
    return replace(
        full,
        iterations=half.iterations + full.iterations,
        assemblies=half.assemblies + full.assemblies,
        solves=half.solves + full.solves,
    )


def _try_wall(
    model: Model, wall: WallState, pellet: PelletState, pressure: float, drive: Floats, dt: float
) -> tuple[int, _Solved | None]:
    """One implicit step of the axisymmetric wall; None with the reason's code when it does not converge."""
    formula = rate_formula(dt, wall.step_before, model.second_order)
    position, before = wall.position[:, 0, :], wall.position_before[:, 0, :]
    history = np.ascontiguousarray((formula.keep * position + formula.older * before)[:, [0, 2]].T)
    velocity_history = np.ascontiguousarray(
        (formula.keep * wall.velocity[:, 0, :] + formula.older * wall.velocity_before[:, 0, :])[:, [0, 2]].T
    )
    stretch = stretch_of_elements(wall.position, model.wall.element_size)[:, 0]
    stretch_before = stretch_of_elements(wall.position_before, model.wall.element_size)[:, 0]
    stretch_history = formula.keep * stretch + formula.older * stretch_before
    hoop_history = history[0] / model.wall.radius
    trend = 1.0 + 0.5 * dt / wall.step_before if wall.step_before > 0.0 else 1.0
    guess = position + dt * (trend * wall.velocity[:, 0, :] - (trend - 1.0) * wall.velocity_before[:, 0, :])
    rho, zeta = np.ascontiguousarray(guess[:, 0]), np.ascontiguousarray(guess[:, 2])
    density = wall.contact[:, 0].copy()
    weight = density / density.sum() if density.sum() > 0.0 else np.zeros_like(density)
    second = model.second_order and wall.step_before > 0.0
    pellet_history = pellet.position + (0.5 * dt * pellet.velocity if second else 0.0)
    pellet_weight = 0.5 * dt if second else dt
    scalars = np.array([pressure, pellet.position + dt * pellet.velocity, pellet.axial_force])
    code, iterations, assemblies = solve_equilibrium(
        rho,
        zeta,
        density,
        scalars,
        history,
        velocity_history,
        stretch_history,
        hoop_history,
        np.ascontiguousarray(drive[0, :, 0]),
        np.ascontiguousarray(drive[1, :, 0]),
        weight,
        Step(formula.inverse, model.inertia, pellet_history, pellet_weight),
        model.wall,
        model.pellet,
        model.lumen,
        model.tolerance,
        model.gap_tolerance,
        model.max_newton,
    )
    if code != CONVERGED:
        return code, None
    new = np.empty_like(wall.position)
    new[:, 0, 0], new[:, 0, 1], new[:, 0, 2] = rho, wall.position[:, 0, 1], zeta
    velocity = (new - formula.keep * wall.position - formula.older * wall.position_before) * formula.inverse
    velocity[:, :, 1] = 0.0
    new_stretch = stretch_of_elements(new, model.wall.element_size)[:, 0]
    after = WallState(
        position=new,
        position_before=wall.position,
        velocity=velocity,
        velocity_before=wall.velocity,
        contact=density[:, None],
        stretch_rate=((new_stretch - stretch_history) * formula.inverse)[:, None],
        hoop_rate=((rho / model.wall.radius - hoop_history) * formula.inverse)[:, None],
        drive=drive,
        step_before=dt,
    )
    moved = _move_pellet(model, after, weight, float(scalars[1]), pellet_history, pellet_weight)
    return code, _Solved(after, moved, float(scalars[0]), iterations, assemblies, 1)


def _move_pellet(
    model: Model, wall: WallState, weight: Floats, centre: float, history: float, step: float
) -> PelletState:
    """Velocity from the stored contact by the friction law, and the position that goes with it, Eqs. (13), (34)."""
    if not model.pellet.present:
        return PelletState(centre, 0.0, 0.0)
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    rho, zeta, contact = column(wall.position, 0, 0), column(wall.position, 0, 2), column(wall.contact, 0)
    force = axial_force(rho, zeta, contact, centre, model.pellet.radius, area)
    sliding, _ = sliding_velocity(force, model.pellet.viscous, model.pellet.dry)
    velocity = sliding + model.pellet.frame * float(weight @ wall.velocity[:, 0, 2])
    return PelletState(history + step * velocity, velocity, force)


def _listen(model: Model, state: State, time: float) -> State:
    """What trigger and mechanoreceptors make of the new state."""
    grid = model.grid
    trigger = state.trigger
    if model.trigger.rule in ("active", "total"):
        trigger = observe_tension(model.trigger, trigger, _sensed_tension(model, state), time)
    elif model.trigger.rule == "delay":
        trigger = observe_activation(model.trigger, trigger, state.longitudinal.last_activation * 1e-3)
    reflex = state.reflex
    if model.reflex.enabled and model.pellet.present:
        girth = state.wall.position[:, 0, 0] / model.free_radius
        touching = state.wall.contact[:, 0] > 0.0
        reflex = observe_stretch(model.reflex, reflex, grid.nodes, girth, touching, time)
    return replace(state, trigger=trigger, reflex=reflex)


def _sensed_tension(model: Model, state: State) -> Floats:
    """Longitudinal tension that the trigger reads at the conduction cells [mN/cm], Eq. (25)."""
    grid = model.grid
    cells = np.empty((grid.n_z, grid.n_theta))
    if model.trigger.rule == "total":
        average(grid.elements_to_cells, axial_tension_of_elements(state.wall, model.wall), cells)
        return cells
    average(grid.elements_to_cells, stretch_of_elements(state.wall.position, model.wall.element_size), cells)
    muscle = model.wall.longitudinal
    force = np.maximum((muscle.c7 * cells + muscle.c8) * cells + muscle.c9, 0.0)
    return np.asarray(np.maximum(state.longitudinal.potential - model.longitudinal.threshold, 0.0) * force)
