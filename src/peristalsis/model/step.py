"""One coupled step: drives, sheets, wall with lumen and pellet, then what the nerves saw. `advance` is pure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.pulses import add_pulses, covered, covered_around
from ..control.reflex import observe_stretch
from ..control.sequence import observe_activation, observe_tension, trigger_current
from ..errors import DivergenceError
from ..numerics.rates import rate_formula
from ..numerics.transfer import average
from ..pellet.contact import axial_force
from ..pellet.friction import sliding_velocity
from ..tissue.bidomain import EllipticError, surface_operator
from ..tissue.cells.plant import CellConstants
from ..tissue.sheet import advance_sheet
from ..tissue.surface import SurfaceOperator, SurfaceSizes
from ..tissue.surface_sheet import advance_surface_sheet
from .equilibrium import CONVERGED, REASONS, Step, solve_equilibrium
from .explicit_step import march_explicitly
from .fields import axial_tension_of_elements, column, stretch_of_elements
from .friction import friction_ahead
from .model import ACTIVATION_LEVEL, Layer, Model, explicit_stages
from .state import PelletState, SheetState, State, WallState
from .surface_fields import Stretches, surface_stretches
from .surface_step import try_surface_wall

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StepReport:
    """What a step cost: Newton iterations, assemblies of the wall, wall solves (more than one after halving).

    krylov_iterations: of the linear solver on the whole surface.
    halved: why the whole step was made in parts, empty if it was not.
    """

    newton_iterations: int
    assemblies: int
    wall_solves: int
    krylov_iterations: int = 0
    halved: str = ""


def advance(model: Model, state: State) -> tuple[State, StepReport]:
    """The state one wall step later, and what it took. Raises DivergenceError naming field, place and time."""
    start = state.step * model.dt_wall
    stop = (state.step + 1) * model.dt_wall
    stretch = _stretches_ahead(model, state.wall)
    stimuli = _stimuli(model, state, start, stop)
    if model.explicit is not None:
        pacemaker = _advance_pacemaker(model, state.pacemaker, stimuli.pacemaker, start)
        marched, micro_steps = march_explicitly(model, state, stimuli.longitudinal, stimuli.circular)
        return _listen(model, replace(marched, pacemaker=pacemaker), stop), StepReport(0, micro_steps, 1)
    longitudinal = _advance_layer(model, "longitudinal", state.longitudinal, stretch, stimuli.longitudinal, start)
    circular = _advance_layer(model, "circular", state.circular, stretch, stimuli.circular, start)
    pacemaker = _advance_pacemaker(model, state.pacemaker, stimuli.pacemaker, start)
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
    return _listen(model, after, stop), StepReport(solved.iterations, solved.assemblies, solved.solves, solved.krylov)


def muscle_drive(model: Model, layer: Layer, sheet: SheetState) -> Floats:
    """Force factor times phi+ [mV] of the half elements, Eqs. (19) and (33): one for each corner."""
    source = layer.force_factor * np.maximum(sheet.potential - layer.threshold, 0.0)
    if model.grid.is_surface:
        return model.grid.half_elements_of_cells(source)
    target = np.empty((2 * model.grid.n_z_wall, model.grid.n_theta))
    average(model.grid.cells_to_half_elements, source, target)
    return target


def _stretches(model: Model, position: Floats) -> Stretches:
    """Stretches of a wall: of its edges on the whole surface, of elements and nodes on one column."""
    if model.grid.is_surface:
        return surface_stretches(position, model.wall)
    return Stretches(stretch_of_elements(position, model.wall.element_size), position[:, :, 0] / model.wall.radius)


def _stretches_ahead(model: Model, wall: WallState) -> Stretches:
    """Stretches extrapolated to the middle of the coming step."""
    now = _stretches(model, wall.position)
    if wall.step_before == 0.0:
        return now
    share = 0.5 * model.dt_wall / wall.step_before
    before = _stretches(model, wall.position_before)
    return Stretches(*(np.maximum(new + share * (new - old), 0.5 * new) for new, old in zip(now, before, strict=True)))


class _Stimulus(NamedTuple):
    """Current at 0 mV [uA/cm^2], inward positive, and conductance [mS/cm^2] added to every cell over a step."""

    current: Floats
    conductance: Floats

    def open(self, conductance: Floats, reversal: Floats | float) -> None:
        """Add a conductance [mS/cm^2] towards a reversal potential [mV]."""
        np.add(self.conductance, conductance, out=self.conductance)
        np.add(self.current, conductance * reversal, out=self.current)


class _Stimuli(NamedTuple):
    longitudinal: _Stimulus
    circular: _Stimulus
    pacemaker: _Stimulus


def _stimuli(model: Model, state: State, start: float, stop: float) -> _Stimuli:
    """Mean stimuli over the step, Eqs. (24)-(26); the layers' have shape (n_z, n_theta), the pacemaker's (1, 1)."""
    grid = model.grid
    shape = (grid.n_z, grid.n_theta_conduction)
    stimuli = _Stimuli(*(_Stimulus(np.zeros(size), np.zeros(size)) for size in (shape, shape, (1, 1))))
    for trains, layer, stimulus in (
        (model.longitudinal_trains, model.longitudinal, stimuli.longitudinal),
        (model.circular_trains, model.circular, stimuli.circular),
    ):
        for train in trains:
            pulses = train.between(start, stop)
            add_pulses(pulses, grid.cells, grid.cell_size, start, stop, stimulus.current, layer.response.pacemaker)
    current, response = stimuli.circular.current, model.circular.response
    add_pulses(state.reflex.excitation, grid.cells, grid.cell_size, start, stop, current, response.excitation)
    current += trigger_current(model.trigger, state.trigger, start, stop) * response.trigger
    inhibition = np.zeros(shape)
    add_pulses(state.reflex.inhibition, grid.cells, grid.cell_size, start, stop, inhibition, response.inhibition)
    stimuli.circular.open(inhibition, model.cell.potassium_reversal)
    if model.pacemaker_cell is not None:
        # Each side sees the other's potential of the step before and its own of now: stable at any coupling.
        cell = model.pacemaker_cell
        edge = 0.5 * grid.cell_size
        along = covered(grid.cells - edge, grid.cells + edge, cell.place, cell.place + cell.width)
        around = covered_around(grid.n_theta_conduction, cell.angle, cell.sector)
        where = along[:, None] * around * model.longitudinal.response.pacemaker
        reached = float(where.sum())
        if reached > 0.0:  # a region may cut the cell off from all of the tissue
            stimuli.longitudinal.open(cell.coupling * where, float(state.pacemaker.potential[0, 0]))
            mean = float((where * state.longitudinal.potential).sum() / reached)
            stimuli.pacemaker.open(np.full((1, 1), cell.coupling), mean)
    return stimuli


def _advance_layer(
    model: Model, name: str, sheet: SheetState, stretch: Stretches, stimulus: _Stimulus, start: float
) -> SheetState:
    grid = model.grid
    layer = model.longitudinal if name == "longitudinal" else model.circular
    opened = float(stimulus.conductance.max())
    if grid.is_surface:
        operator = _surface_operator(model, layer, stretch) if layer.conducts else None
        stages = model.stages(layer, stretch.axial, opened, 0.0 if operator is None else operator.ring_rate)
        tissue = _Tissue(layer.conductances, operator, stages, model.tables, model.cell)
    else:
        coefficient = np.empty((0, 1))
        if layer.conducts:
            faces = np.empty((grid.n_z - 1, 1))
            average(grid.elements_to_faces, stretch.axial, faces)
            coefficient = (layer.diffusivity * 1e-3 / (24.0 * grid.cell_size) ** 2) / faces * layer.conductivity
        stages = model.stages(layer, stretch.axial, opened)
        tissue = _Tissue(layer.conductances, coefficient, stages, model.tables, model.cell)
    return _advance_sheet(model, sheet, tissue, stimulus, start, f"{name} potential")


def _surface_operator(model: Model, layer: Layer, stretch: Stretches) -> SurfaceOperator:
    """Conduction of a layer on the wall of the middle of the step; what varies from place to place divides stretch."""
    grid = model.grid
    return surface_operator(
        layer.diffusivity,
        layer.conductivities,
        SurfaceSizes(grid.cell_size, grid.column_width(model.wall.radius)),
        grid.elements_at_faces(stretch.axial) / layer.conductivity,
        grid.nodes_at_ring_faces(stretch.hoop) / layer.conductivity_around,
    )


def _advance_pacemaker(model: Model, sheet: SheetState, stimulus: _Stimulus, start: float) -> SheetState:
    cell = model.pacemaker_cell
    if cell is None:
        return sheet
    rate = cell.constants.kinetics_rate * float(cell.conductances.sum()) + cell.coupling
    stages = explicit_stages(rate / cell.constants.capacitance, model.dt_cell)
    tissue = _Tissue(cell.conductances, np.empty((0, 1)), stages, model.pacemaker_tables, cell.constants)
    return _advance_sheet(model, sheet, tissue, stimulus, start, "pacemaker potential")


class _Tissue(NamedTuple):
    conductances: Floats
    conduction: Floats | SurfaceOperator | None
    stages: Floats
    tables: tuple[Floats, Floats]
    constants: CellConstants


def _advance_sheet(
    model: Model, sheet: SheetState, tissue: _Tissue, stimulus: _Stimulus, start: float, field: str
) -> SheetState:
    shape = sheet.potential.shape
    potential = sheet.potential.ravel().copy()
    gates = sheet.gates.reshape(4, -1).copy()
    first, last = sheet.first_activation.ravel().copy(), sheet.last_activation.ravel().copy()
    if isinstance(tissue.conduction, np.ndarray):
        bad = advance_sheet(
            potential,
            gates,
            first,
            last,
            tissue.conductances,
            tissue.conduction.ravel(),
            stimulus.current.ravel(),
            stimulus.conductance.ravel(),
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
    else:
        try:
            bad = advance_surface_sheet(
                potential,
                gates,
                first,
                last,
                tissue.conductances,
                tissue.conduction,
                stimulus.current.ravel(),
                stimulus.conductance.ravel(),
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
        except EllipticError as error:
            raise DivergenceError(f"{field} at t = {start:.6g} s: {error}") from None
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
    krylov: int = 0


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
        krylov=half.krylov + full.krylov,
    )


def _try_wall(
    model: Model, wall: WallState, pellet: PelletState, pressure: float, drive: Floats, dt: float
) -> tuple[int, _Solved | None]:
    """One implicit step of the wall; None with the reason's code when it does not converge."""
    if model.grid.is_surface:
        code, found = try_surface_wall(model, wall, pellet, pressure, drive, dt, model.surface, model.sideways_friction)
        if found is None:
            return code, None
        counts = (found.iterations, found.assemblies, found.solves, found.krylov)
        return code, _Solved(found.wall, found.pellet, found.pressure, *counts)
    formula = rate_formula(dt, wall.step_before, model.second_order)
    position, before = wall.position[:, 0, :], wall.position_before[:, 0, :]
    history = np.ascontiguousarray(formula.history(position, before)[:, [0, 2]].T)
    velocity_history = np.ascontiguousarray(
        formula.history(wall.velocity[:, 0, :], wall.velocity_before[:, 0, :])[:, [0, 2]].T
    )
    stretch = stretch_of_elements(wall.position, model.wall.element_size)[:, 0]
    stretch_before = stretch_of_elements(wall.position_before, model.wall.element_size)[:, 0]
    stretch_history = formula.history(stretch, stretch_before)
    hoop_history = history[0] / model.wall.radius
    trend = 1.0 + 0.5 * dt / wall.step_before if wall.step_before > 0.0 else 1.0
    guess = position + dt * (trend * wall.velocity[:, 0, :] - (trend - 1.0) * wall.velocity_before[:, 0, :])
    guess[[0, -1]] = position[[0, -1]]  # the clamped ends, to the last bit
    rho, zeta = np.ascontiguousarray(guess[:, 0]), np.ascontiguousarray(guess[:, 2])
    density = wall.contact[:, 0].copy()
    dry, weights = friction_ahead(model, wall, pellet)
    weight = np.ascontiguousarray(weights[:, 0])
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
        model.pellet._replace(dry=dry),
        model.lumen,
        model.tolerance,
        model.gap_tolerance,
        model.max_newton,
    )
    if code != CONVERGED:
        return code, None
    new = np.empty_like(wall.position)
    new[:, 0, 0], new[:, 0, 1], new[:, 0, 2] = rho, wall.position[:, 0, 1], zeta
    velocity = (new - formula.history(wall.position, wall.position_before)) * formula.inverse
    velocity[:, :, 1] = 0.0
    velocity[[0, -1]] = 0.0
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
    moved = _move_pellet(model, after, weight, dry, float(scalars[1]), pellet_history, pellet_weight)
    return code, _Solved(after, moved, float(scalars[0]), iterations, assemblies, 1)


def _move_pellet(
    model: Model, wall: WallState, weight: Floats, dry: float, centre: float, history: float, step: float
) -> PelletState:
    """Velocity from the stored contact by the friction law, and the position that goes with it, Eqs. (13), (34)."""
    if not model.pellet.present:
        return PelletState(centre, 0.0, 0.0)
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    rho, zeta, contact = column(wall.position, 0, 0), column(wall.position, 0, 2), column(wall.contact, 0)
    force = axial_force(rho, zeta, contact, centre, model.pellet.radius, area)
    sliding, _ = sliding_velocity(force, model.pellet.viscous, dry)
    velocity = sliding + model.pellet.frame * float(weight @ wall.velocity[:, 0, 2])
    return PelletState(history + step * velocity, velocity, force, dry)


def _listen(model: Model, state: State, time: float) -> State:
    """What trigger and mechanoreceptors make of the new state."""
    grid = model.grid
    trigger = state.trigger
    if model.trigger.rule in ("active", "total"):
        trigger = observe_tension(model.trigger, trigger, _sensed_tension(model, state), time)
    elif model.trigger.rule == "delay":
        trigger = observe_activation(model.trigger, trigger, state.longitudinal.last_activation * 1e-3, time)
    reflex = state.reflex
    if model.reflex.enabled and model.pellet.present:
        if grid.is_surface:
            girth = surface_stretches(state.wall.position, model.wall).hoop.mean(axis=1)
            girth *= model.wall.radius / model.free_radius
        else:
            girth = state.wall.position[:, 0, 0] / model.free_radius
        touching = np.any(state.wall.contact > 0.0, axis=1)
        reflex = observe_stretch(model.reflex, reflex, grid.nodes, girth, touching, time)
    return replace(state, trigger=trigger, reflex=reflex)


def _sensed_tension(model: Model, state: State) -> Floats:
    """Longitudinal tension that the trigger reads at the conduction cells [mN/cm], Eq. (25)."""
    if model.trigger.rule == "total":
        return _at_cells(model, axial_tension_of_elements(state.wall, model.wall))
    cells = _at_cells(model, _stretches(model, state.wall.position).axial)
    muscle = model.wall.longitudinal
    force = np.maximum((muscle.c7 * cells + muscle.c8) * cells + muscle.c9, 0.0)
    return np.asarray(np.maximum(state.longitudinal.potential - model.longitudinal.threshold, 0.0) * force)


def _at_cells(model: Model, elements: Floats) -> Floats:
    """A field of wall elements at the conduction cells."""
    grid = model.grid
    if grid.is_surface:
        return grid.elements_at_cells(elements)
    cells = np.empty((grid.n_z, 1))
    average(grid.elements_to_cells, elements, cells)
    return cells
