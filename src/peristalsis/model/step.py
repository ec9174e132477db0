"""One coupled step: drives, sheets, wall with lumen and pellet, then what the nerves saw. `advance` is pure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import follow
from ..control.pulses import add_pulses, covered, covered_around
from ..control.reflex import ReflexState, forget, observe_stretch, refractory
from ..control.sequence import TriggerState, add_trigger_current, observe_activation, observe_tension
from ..errors import DivergenceError
from ..numerics.rates import rate_formula
from ..numerics.transfer import average
from ..pellet.body import require_shape
from ..tissue.bidomain import EllipticError, surface_operator
from ..tissue.cell import SHIPPED_CELL, Cell
from ..tissue.surface import SurfaceOperator, SurfaceSizes
from .arrays import NewWall
from .constants import packed
from .equilibrium import CONVERGED, REASONS, workspace
from .exchange import (
    active_force,
    active_force_at,
    conduction_coefficient,
    drive_of_layer,
    stretch_ahead,
    stretches_receptors,
)
from .explicit_step import march_explicitly
from .fields import axial_tension_of_elements
from .friction import dry_friction_now
from .model import ACTIVATION_LEVEL, Layer, Model, Network, explicit_stages
from .muscle import advance_muscle, drive_of_cells
from .state import PelletState, SheetState, State, WallState
from .surface_fields import Stretches, surface_stretches
from .surface_step import try_surface_wall
from .wall_step import Request, step_wall

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
    require_shape(model.pellet)
    start = state.step * model.dt_wall
    stop = (state.step + 1) * model.dt_wall
    state = replace(state, sources=follow(model.sources, state.sources, start, stop))
    stimuli = _stimuli(model, state, start, stop)
    if model.explicit is not None:
        pacemaker = _advance_pacemaker(model, state.pacemaker, stimuli.pacemaker, start)
        marched, micro_steps = march_explicitly(model, state, stimuli.longitudinal, stimuli.circular)
        trigger = _listen_to_muscle(model, state.trigger, marched.longitudinal, marched.wall, stop)
        reflex = _listen_to_stretch(model, state.reflex, marched.wall, stop)
        return replace(marched, pacemaker=pacemaker, trigger=trigger, reflex=reflex), StepReport(0, micro_steps, 1)
    longitudinal, circular, network, drive = _advance_tissue(model, state, stimuli, start)
    pacemaker = _advance_pacemaker(model, state.pacemaker, stimuli.pacemaker, start)
    solved = _solve_wall(
        model, state.wall, state.pellet, state.pressure, drive, model.dt_wall, model.max_halvings, stop
    )
    trigger = _listen_to_muscle(model, state.trigger, longitudinal, solved.wall, stop)
    reflex = _listen_to_stretch(model, state.reflex, solved.wall, stop)
    after = State(
        state.step + 1,
        longitudinal,
        circular,
        pacemaker,
        solved.wall,
        solved.pellet,
        solved.pressure,
        trigger,
        reflex,
        state.sources,
        network,
    )
    return after, StepReport(solved.iterations, solved.assemblies, solved.solves, solved.krylov)


def advance_tissue(model: Model, state: State) -> None:
    """Take both layers through a step, for the kernels that it compiles; the outcome is dropped."""
    start, stop = state.step * model.dt_wall, (state.step + 1) * model.dt_wall
    state = replace(state, sources=follow(model.sources, state.sources, start, stop))
    _advance_tissue(model, state, _stimuli(model, state, start, stop), start)


def _advance_tissue(
    model: Model, state: State, stimuli: _Stimuli, start: float
) -> tuple[SheetState, SheetState, SheetState | None, Floats]:
    """Both layers and the network after a step, and the drive of the wall."""
    stretch = _stretches_ahead(model, state.wall)
    longitudinal, circular = (
        advance_muscle(layer, sheet, _advance_layer(model, name, layer, sheet, stretch, stimulus, start), model.dt_wall)
        for name, layer, sheet, stimulus in (
            ("longitudinal", model.longitudinal, state.longitudinal, stimuli.longitudinal),
            ("circular", model.circular, state.circular, stimuli.circular),
        )
    )
    network = _advance_network(model, state, stretch, stimuli.network, start)
    drive = np.empty_like(state.wall.drive)
    drive[0] = muscle_drive(model, model.longitudinal, longitudinal)
    drive[1] = muscle_drive(model, model.circular, circular)
    return longitudinal, circular, network, drive


def muscle_drive(model: Model, layer: Layer, sheet: SheetState) -> Floats:
    """Force factor times drive [mV] of the half elements, Eqs. (19) and (33): one for each corner."""
    driven = drive_of_cells(layer, sheet)
    if model.grid.is_surface:
        return model.grid.half_elements_of_cells(layer.force_factor * driven)
    out = np.empty((2 * model.grid.n_z_wall, model.grid.n_theta))
    drive_of_layer(*model.grid.cells_to_half_elements, driven, layer.force_of_cells, out)
    return out


class _Ahead(NamedTuple):
    """Stretch extrapolated to the middle of the coming step: along z, (n_z_wall, n_theta), and its smallest value.

    hoop: around the ring, on the whole surface.
    """

    axial: Floats
    least: float
    hoop: Floats | None = None


def _stretches_ahead(model: Model, wall: WallState) -> _Ahead:
    share = 0.5 * model.dt_wall / wall.step_before if wall.step_before > 0.0 else 0.0
    if not model.grid.is_surface:
        stretch = np.empty_like(wall.stretch_rate)
        least = stretch_ahead(wall.position, wall.position_before, model.wall.element_size, share, stretch)
        return _Ahead(stretch, least)
    now, before = (surface_stretches(places, model.wall) for places in (wall.position, wall.position_before))
    axial, hoop = (np.maximum(new + share * (new - old), 0.5 * new) for new, old in zip(now, before, strict=True))
    return _Ahead(axial, float(axial.min()), hoop)


@dataclass
class _Stimulus:
    """Current at 0 mV [uA/cm^2], inward positive, and conductance [mS/cm^2] added to every cell over a step.

    opened: the largest of the conductances.
    """

    current: Floats
    conductance: Floats
    opened: float = 0.0

    def open(self, conductance: Floats, reversal: Floats | float) -> None:
        """Add a conductance [mS/cm^2] towards a reversal potential [mV]."""
        np.add(self.conductance, conductance, out=self.conductance)
        np.add(self.current, conductance * reversal, out=self.current)
        self.opened = float(self.conductance.max())


class _Stimuli(NamedTuple):
    longitudinal: _Stimulus
    circular: _Stimulus
    pacemaker: _Stimulus
    network: _Stimulus


def _stimuli(model: Model, state: State, start: float, stop: float) -> _Stimuli:
    """Mean stimuli over the step, Eqs. (24)-(26); the layers' have shape (n_z, n_theta), the pacemaker's (1, 1)."""
    grid = model.grid
    shape = (grid.n_z, grid.n_theta_conduction)
    stimuli = _Stimuli(*(_Stimulus(np.zeros(size), np.zeros(size)) for size in (shape, shape, (1, 1), shape)))
    along, around = model.longitudinal.response, model.circular.response
    for source in state.sources:
        for pulses, response, stimulus in (
            (source.longitudinal, along, stimuli.longitudinal),
            (source.circular, around, stimuli.circular),
        ):
            add_pulses(pulses, grid.cells, grid.cell_size, start, stop, stimulus.current, response.pacemaker)
    for listed, response, stimulus in (
        (model.stimuli_longitudinal, along, stimuli.longitudinal),
        (model.stimuli_circular, around, stimuli.circular),
    ):
        now = listed.between(start, stop)
        add_pulses(now, grid.cells, grid.cell_size, start, stop, stimulus.current, response.pacemaker)
    current, response = stimuli.circular.current, model.circular.response
    add_pulses(state.reflex.excitation, grid.cells, grid.cell_size, start, stop, current, response.excitation)
    add_trigger_current(state.trigger, start, stop, current, response.trigger)
    if state.reflex.inhibition:
        inhibition = np.zeros(shape)
        add_pulses(state.reflex.inhibition, grid.cells, grid.cell_size, start, stop, inhibition, response.inhibition)
        stimuli.circular.open(inhibition, model.circular.cell.inhibition(model.circular.constants))
    if model.network is not None and state.network is not None:
        _couple(model.network, state, state.network.potential, stimuli)
    if model.pacemaker_cell is not None:
        # Each side sees the other's potential of the step before and its own of now: stable at any coupling.
        cell = model.pacemaker_cell
        edge = 0.5 * grid.cell_size
        places = covered(grid.cells - edge, grid.cells + edge, cell.place, cell.place + cell.width)
        columns = covered_around(grid.n_theta_conduction, cell.angle, cell.sector)
        where = places[:, None] * columns * model.longitudinal.response.pacemaker
        reached = float(where.sum())
        if reached > 0.0:  # a region may cut the cell off from all of the tissue
            stimuli.longitudinal.open(cell.coupling * where, float(state.pacemaker.potential[0, 0]))
            mean = float((where * state.longitudinal.potential).sum() / reached)
            stimuli.pacemaker.open(np.full((1, 1), cell.coupling), mean)
    return stimuli


def _couple(network: Network, state: State, potential: Floats, stimuli: _Stimuli) -> None:
    """Gap currents between the network and both layers, Eq. (77): each side sees the other's potential of before."""
    for gap, muscle, stimulus in (
        (network.longitudinal, state.longitudinal, stimuli.longitudinal),
        (network.circular, state.circular, stimuli.circular),
    ):
        if gap > 0.0:
            conductance = np.full_like(potential, gap)
            stimulus.open(conductance, potential)
            stimuli.network.open(network.load * conductance, muscle.potential)


def _advance_network(
    model: Model, state: State, stretch: _Ahead, stimulus: _Stimulus, start: float
) -> SheetState | None:
    if model.network is None or state.network is None:
        return None
    return _advance_layer(model, "network", model.network.sheet, state.network, stretch, stimulus, start)


def _advance_layer(
    model: Model, name: str, layer: Layer, sheet: SheetState, stretch: _Ahead, stimulus: _Stimulus, start: float
) -> SheetState:
    grid = model.grid
    conduction: Floats | SurfaceOperator | None
    ring_rate = 0.0
    if stretch.hoop is not None:
        conduction = None
        if layer.conducts:
            conduction = _surface_operator(model, layer, Stretches(stretch.axial, stretch.hoop))
            ring_rate = conduction.ring_rate
    else:
        conduction = np.empty((grid.n_z - 1 if layer.conducts else 0, 1))
        if layer.conducts:
            scale = layer.diffusivity * 1e-3 / (24.0 * grid.cell_size) ** 2
            conduction_coefficient(*grid.elements_to_faces, scale, stretch.axial, conduction)
            if not isinstance(layer.conductivity, float):
                conduction *= layer.conductivity
    stages = model.stages(layer, stretch.least, stimulus.opened, ring_rate)
    tissue = _Tissue(layer.cell, layer.conductances, conduction, stages, layer.tables(model.dt_cell), layer.constants)
    return _advance_sheet(model, sheet, tissue, stimulus, start, f"{name} potential")


def _surface_operator(model: Model, layer: Layer, stretch: Stretches) -> SurfaceOperator:
    """Conduction of a layer on the wall of the middle of the step; what varies from place to place divides stretch."""
    grid = model.grid
    with np.errstate(divide="ignore"):  # where a region blocks conduction the resistance is infinite
        along = grid.elements_at_faces(stretch.axial) / layer.conductivity
        around = grid.nodes_at_ring_faces(stretch.hoop) / layer.conductivity_around
    return surface_operator(
        layer.diffusivity,
        layer.conductivities,
        SurfaceSizes(grid.cell_size, grid.column_width(model.wall.radius)),
        along,
        around,
    )


def _advance_pacemaker(model: Model, sheet: SheetState, stimulus: _Stimulus, start: float) -> SheetState:
    cell = model.pacemaker_cell
    if cell is None:
        return sheet
    rate = cell.constants.kinetics_rate * float(cell.conductances.sum()) + cell.coupling
    stages = explicit_stages(rate / cell.constants.capacitance, model.dt_cell)
    tables = SHIPPED_CELL.tables(model.dt_cell, cell.constants)
    tissue = _Tissue(SHIPPED_CELL, cell.conductances, np.empty((0, 1)), stages, tables, cell.constants)
    return _advance_sheet(model, sheet, tissue, stimulus, start, "pacemaker potential")


class _Tissue(NamedTuple):
    cell: Cell
    conductances: Floats
    conduction: Floats | SurfaceOperator | None
    stages: Floats
    tables: tuple[Floats, Floats]
    constants: Any


def _advance_sheet(
    model: Model, sheet: SheetState, tissue: _Tissue, stimulus: _Stimulus, start: float, field: str
) -> SheetState:
    shape = sheet.potential.shape
    potential = sheet.potential.ravel().copy()
    gates = sheet.gates.reshape(len(sheet.gates), -1).copy()
    first, last = sheet.first_activation.ravel().copy(), sheet.last_activation.ravel().copy()
    if isinstance(tissue.conduction, np.ndarray):
        bad = tissue.cell.advance_sheet(
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
            bad = tissue.cell.advance_surface_sheet(
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
        cause = _why_out_of_range(model, tissue, stimulus, field, gates, bad)
        low, high = tissue.cell.lowest, tissue.cell.highest
        raise DivergenceError(f"{field} left {low:g}...{high:g} mV at {place}, t = {start:.6g} s: {cause}")
    times = first.reshape(shape), last.reshape(shape)
    return SheetState(potential.reshape(shape), gates.reshape(-1, *shape), *times, sheet.muscle)


FINE_STEP = 0.05
"""A conduction step so short [ms] is not what takes a potential out of range: no gate moves by much within it."""


def _overwhelmed(tissue: _Tissue, stimulus: _Stimulus, gates: Floats, at: int) -> bool:
    """Whether the channels of a cell, as open as they are, carry off less than its stimulus at the end of the range."""
    current = float(stimulus.current.ravel()[at])
    edge = tissue.cell.highest if current > 0.0 else tissue.cell.lowest
    one = slice(at, at + 1)
    flows = tissue.cell.kernels.currents(np.array([edge]), gates[:, one], tissue.conductances[:, one], tissue.constants)
    carried = tissue.constants.kinetics_rate * sum(float(flow[0]) for flow in flows.values())
    carried += float(stimulus.conductance.ravel()[at]) * edge
    return current > max(carried, 0.0) if current > 0.0 else current < min(carried, 0.0)


def _why_out_of_range(model: Model, tissue: _Tissue, stimulus: _Stimulus, field: str, gates: Floats, bad: int) -> str:
    """What takes a potential out of the tables: a stimulus, a reversal potential beyond them, or the step."""
    low, high = tissue.cell.lowest, tissue.cell.highest
    current = stimulus.current.ravel()
    strongest = int(np.argmax(np.abs(current)))
    if current[strongest] != 0.0:
        # Where a cell would end up with every channel open but the fast one, which inactivates: channels that are
        # closed hold it back even less. Currents run at the tissue's rate (20), stimuli do not.
        pull, total = tissue.cell.kernels.standing_current(tissue.conductances[:, strongest], tissue.constants)
        total += float(stimulus.conductance.ravel()[strongest])
        rate = (float(current[strongest]) + pull) / tissue.constants.capacitance  # mV in a ms, from 0 mV
        target = (float(current[strongest]) + pull) / total if total > 0.0 else np.inf
        at = bad if current[bad] != 0.0 else strongest
        too_strong = model.dt_cell <= FINE_STEP and _overwhelmed(tissue, stimulus, gates, at)
        if too_strong or not low < target < high or abs(rate) * model.dt_wall * 1e3 > high - low:
            layer = field.partition(" ")[0]
            names = {
                "longitudinal": "pacemaker.intensity, or the strength of listed stimuli",
                "circular": "trigger.intensity, reflex.excitation_intensity or rings.intensity",
            }
            return (
                f"a stimulus of {current[at if too_strong else strongest]:.4g} uA/cm^2 drives the cells there, beyond "
                f"what their channels carry off; lower {names.get(layer, 'pacemaker.cell_coupling')}"
            )
    for name, value in tissue.constants._asdict().items():
        if name.endswith("_reversal") and not low < value < high:
            section = "cell" if tissue.cell is SHIPPED_CELL else f"tissue.{tissue.cell.name}"
            return f"{section}.{name} = {value:g} mV pulls it there; bring it into that range"
    return f"the conduction step of {model.dt_cell:g} ms is too large; lower step.conduction"


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
            f"{_remedy(model)}"
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


def _remedy(model: Model) -> str:
    """What may help a wall that finds no equilibrium."""
    usual = "Lower step.wall, or raise wall.bending_stiffness or grid.n_z_wall"
    if model.wall.slack_blend > 0.0:
        return usual
    return f"Raise wall.slack_blend: at 0 slack wall carries compression, Eq. (14), and is ill-posed. {usual}"


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
    request = Request(
        dt,
        wall.step_before,
        formula.older,
        formula.inverse,
        model.second_order,
        model.inertia,
        model.tolerance,
        model.gap_tolerance,
        model.max_newton,
        model.friction,
    )
    numbers = np.array(
        [pressure, pellet.position, pellet.velocity, pellet.axial_force, dry_friction_now(model, pellet)],
        dtype=np.float64,
    )
    constants = packed(model.wall), packed(model.pellet), packed(model.lumen)
    like = (wall.position, wall.velocity, wall.contact, wall.stretch_rate, wall.hoop_rate)
    new = NewWall(*(np.empty_like(array) for array in like))
    tables = workspace(wall.position.shape[0])
    code, iterations, assemblies = step_wall(wall.arrays, drive, numbers, request, *constants, *tables, new)
    if code != CONVERGED:
        return code, None
    after = WallState(
        position=new.position,
        position_before=wall.position,
        velocity=new.velocity,
        velocity_before=wall.velocity,
        contact=new.contact,
        stretch_rate=new.stretch_rate,
        hoop_rate=new.hoop_rate,
        drive=drive,
        step_before=dt,
    )
    lumen_pressure, centre, speed, force, dry = numbers.tolist()
    moved = PelletState(centre, speed, force, dry) if model.pellet.present else PelletState(centre, 0.0, 0.0)
    return code, _Solved(after, moved, lumen_pressure, iterations, assemblies, 1)


def _listen_to_muscle(
    model: Model, trigger: TriggerState, sheet: SheetState, wall: WallState, time: float
) -> TriggerState:
    """What the trigger of the circular layer makes of the new longitudinal one."""
    if model.trigger.rule in ("active", "total"):
        return observe_tension(model.trigger, trigger, _sensed_tension(model, sheet, wall), time)
    if model.trigger.rule == "delay":
        return observe_activation(model.trigger, trigger, sheet.last_activation * 1e-3, time)
    return trigger


def _listen_to_stretch(model: Model, reflex: ReflexState, wall: WallState, time: float) -> ReflexState:
    """What the mechanoreceptors make of the new wall."""
    if not (model.reflex.enabled and model.pellet.present):
        return reflex
    if refractory(model.reflex, reflex, time):
        return forget(reflex, time)
    if model.grid.is_surface:
        girth = surface_stretches(wall.position, model.wall).hoop.mean(axis=1)
        girth *= model.wall.radius / model.free_radius
    else:
        if not stretches_receptors(wall.position, wall.contact, model.free_radius, model.reflex.threshold):
            return forget(reflex, time)
        girth = wall.position[:, 0, 0] / model.free_radius
    touching = np.any(wall.contact > 0.0, axis=1)
    return observe_stretch(model.reflex, reflex, model.grid.nodes, girth, touching, time)


def _sensed_tension(model: Model, sheet: SheetState, wall: WallState) -> Floats:
    """Longitudinal tension that the trigger reads at the conduction cells [mN/cm], Eq. (25)."""
    grid = model.grid
    if model.trigger.rule == "total":
        tension = axial_tension_of_elements(wall, model.wall)
        if grid.is_surface:
            return grid.elements_at_cells(tension)
        cells = np.empty_like(sheet.potential)
        average(grid.elements_to_cells, tension, cells)
        return cells
    cells = np.empty_like(sheet.potential)
    driven, muscle = drive_of_cells(model.longitudinal, sheet), np.array(model.wall.longitudinal)
    if grid.is_surface:
        stretch = grid.elements_at_cells(surface_stretches(wall.position, model.wall).axial)
        active_force_at(stretch, driven, muscle, cells)
    else:
        size = model.wall.element_size
        active_force(*grid.elements_to_cells, wall.position, size, driven, muscle, cells)
    return cells
