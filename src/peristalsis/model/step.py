"""One coupled step: drives, sheets, wall with lumen and pellet, then what the nerves saw. `advance` is pure.

What depends on the grid of the wall is asked of its scheme (`scheme.WallScheme`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..control.graded import observe_receptors
from ..control.pacemaker import follow
from ..control.reflex import ReflexState, forget, observe_stretch, refractory, stretched_part
from ..control.sequence import TriggerState, observe_activation, observe_tension, prepare
from ..errors import DivergenceError
from ..pellet.body import require_shape
from .explicit.marching import march_explicitly
from .model import Model
from .report import StepReport
from .scheme import Solved
from .schemes.choice import scheme_of
from .sheets import advance_pacemaker, advance_tissue
from .state import PelletState, SheetState, State, WallState
from .stimulation import Stimuli, stimuli_of_step
from .verdicts import REASONS

Floats = NDArray[np.float64]


def advance(model: Model, state: State) -> tuple[State, StepReport]:
    """The state one wall step later, and what it took. Raises DivergenceError naming field, place and time."""
    require_shape(model.pellet)
    stop = (state.step + 1) * model.dt_wall
    state, stimuli, start = _brought(model, state)
    integrate = _in_turn if model.explicit is None else march_explicitly
    after, report = integrate(model, state, stimuli)
    after = replace(
        after,
        pacemaker=advance_pacemaker(model, state.pacemaker, stimuli.pacemaker, start),
        trigger=_listen_to_muscle(model, state.trigger, after.longitudinal, after.wall, stop),
        reflex=_listen_to_stretch(model, state.reflex, after.wall, stop),
    )
    return after, report


def advance_sheets(model: Model, state: State) -> None:
    """Take both layers through a step, for the kernels that it compiles; the outcome is dropped."""
    state, stimuli, start = _brought(model, state)
    advance_tissue(model, state, stimuli, start)


def _brought(model: Model, state: State) -> tuple[State, Stimuli, float]:
    """The state with its sources followed into the coming step, what they bring to the cells, and the time now [s]."""
    start, stop = state.step * model.dt_wall, (state.step + 1) * model.dt_wall
    state = replace(state, sources=follow(model.sources, state.sources, start, stop))
    return state, stimuli_of_step(model, state, start, stop), start


def _in_turn(model: Model, state: State, stimuli: Stimuli) -> tuple[State, StepReport]:
    """Sheets on the wall of before, extrapolated, then the wall under their drive, implicitly."""
    longitudinal, circular, network, drive = advance_tissue(model, state, stimuli, state.step * model.dt_wall)
    stop = (state.step + 1) * model.dt_wall
    solved = solve_wall(model, state.wall, state.pellet, state.pressure, drive, model.dt_wall, model.max_halvings, stop)
    after = replace(
        state,
        step=state.step + 1,
        longitudinal=longitudinal,
        circular=circular,
        network=network,
        wall=solved.wall,
        pellet=solved.pellet,
        pressure=solved.pressure,
    )
    return after, StepReport(solved.iterations, solved.assemblies, solved.solves, solved.krylov)


def solve_wall(
    model: Model,
    wall: WallState,
    pellet: PelletState,
    pressure: float,
    drive: Floats,
    dt: float,
    halvings: int,
    time: float,
) -> Solved:
    """Equilibrium after `dt`, in two half steps where one does not converge; the drive is linear in between."""
    code, solved = scheme_of(model).solve_wall(model, wall, pellet, pressure, drive, dt)
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
    half = solve_wall(model, wall, pellet, pressure, middle, 0.5 * dt, halvings - 1, time - 0.5 * dt)
    full = solve_wall(model, half.wall, half.pellet, half.pressure, drive, 0.5 * dt, halvings - 1, time)
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


def _listen_to_muscle(
    model: Model, trigger: TriggerState, sheet: SheetState, wall: WallState, time: float
) -> TriggerState:
    """What the trigger of the circular layer makes of the new longitudinal one, Eq. (25), where its gate lets it."""
    if model.trigger.gate.kind == "stretch":
        grid = model.grid
        trigger = prepare(model.trigger.gate, trigger, grid.cells, grid.cell_size, _stretched(model, wall), time)
    match model.trigger.rule:
        case "active":
            return observe_tension(
                model.trigger, trigger, scheme_of(model).trigger_force(model, sheet, wall), time, model.dt_wall
            )
        case "total":
            return observe_tension(
                model.trigger, trigger, scheme_of(model).trigger_tension(model, wall), time, model.dt_wall
            )
        case "delay":
            return observe_activation(model.trigger, trigger, sheet.last_activation * 1e-3, time)
    return trigger


def _stretched(model: Model, wall: WallState) -> tuple[float, float] | None:
    """The part of the wall that stretches its receptors, from z to z [cm]: of the gate, which is never refractory."""
    if not (model.reflex.enabled and model.pellet.present):
        return None
    stretch = scheme_of(model).receptor_stretch(model, wall)
    if stretch is None:
        return None
    return stretched_part(model.reflex, model.grid.nodes, stretch, np.any(wall.contact > 0.0, axis=1))


def _listen_to_stretch(model: Model, reflex: ReflexState, wall: WallState, time: float) -> ReflexState:
    """What the mechanoreceptors make of the new wall, Eq. (26)."""
    if not (model.reflex.enabled and model.pellet.present):
        return reflex
    if model.reflex.graded:
        stretch = scheme_of(model).receptor_stretch(model, wall)
        return observe_receptors(model.reflex, reflex, stretch, np.any(wall.contact > 0.0, axis=1), time)
    if refractory(model.reflex, reflex, time):
        return forget(reflex, time)
    stretch = scheme_of(model).receptor_stretch(model, wall)
    if stretch is None:
        return forget(reflex, time)
    touching = np.any(wall.contact > 0.0, axis=1)
    return observe_stretch(model.reflex, reflex, model.grid.nodes, stretch, touching, time)
