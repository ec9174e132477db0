"""A wall step by the explicit scheme: from a state to the arrays of `kernel` and back, Eqs. (53)-(57).

Between wall steps the state keeps `MicroStep` besides: the acceleration of now follows from it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...errors import DivergenceError
from ...tissue.explicit_sheet import Excitable
from ..friction import dry_friction_now, sliding_speed
from ..model import ACTIVATION_LEVEL, Layer, Model
from ..report import StepReport
from ..state import MicroStep, PelletState, SheetState, State, WallState
from ..stimulation import Stimuli, Stimulus
from .kernel import CIRCULAR, DONE, LONGITUDINAL, STRETCH, Kinetics, Laws, Plan, Shell, Transfers, march
from .limits import Limits, conduction_limit, limits

Floats = NDArray[np.float64]


def march_explicitly(model: Model, state: State, stimuli: Stimuli) -> tuple[State, StepReport]:
    """Sheets, wall, pellet and pressure one wall step later; assemblies are micro-steps.

    Raises DivergenceError naming field, place, time and limits when anything leaves its range.
    """
    scheme = model.explicit
    assert scheme is not None
    start = state.step * model.dt_wall
    dt_cell = model.dt_wall / model.substeps
    allowed = limits(model, state)
    micro = scheme.micro or max(1, math.ceil(dt_cell / (scheme.safety * allowed.shell)))
    dt = dt_cell / micro
    if dt > allowed.shell * (1.0 + 1e-9):
        # Slack wall bounds the ripples of an unstable step: they would spoil a run without ever leaving any range.
        raise DivergenceError(
            f"wall position at t = {start:.6g} s: the explicit step of {1e3 * dt:.4g} ms is beyond the limit of "
            f"{1e3 * allowed.shell:.4g} ms for the wall as it is now ({allowed.words()}); lower step.explicit, or 0 to "
            "have it follow the limit"
        )
    longitudinal = _excitable(model, model.longitudinal, state, state.longitudinal, stimuli.longitudinal)
    circular = _excitable(model, model.circular, state, state.circular, stimuli.circular)
    shell = _shell(model, state)
    begun = state.micro_step
    code, cell, made = march(
        longitudinal,
        circular,
        shell,
        Laws(model.wall, model.pellet, model.lumen, model.friction, scheme.contact_stiffness),
        Kinetics(model.cell, model.tables[0], model.tables[1], model.exact_kinetics, ACTIVATION_LEVEL),
        Transfers(model.grid.elements_to_faces, model.grid.cells_to_half_elements),
        Plan(
            start,
            dt,
            micro,
            model.substeps,
            0.5 * (begun.length + dt) if begun is not None else 0.5 * dt,
            begun is None,
            scheme.predicted,
        ),
    )
    if code != DONE:
        raise DivergenceError(_complaint(model, shell, code, cell, start + made * dt, dt, allowed))
    after = replace(
        state,
        step=state.step + 1,
        longitudinal=_sheet(longitudinal, state.longitudinal),
        circular=_sheet(circular, state.circular),
        wall=_wall(model, state.wall, shell, dt),
        pellet=_pellet(model, shell),
        pressure=float(shell.pressure[0]),
        micro_step=MicroStep(_spatial(shell.rate), dt),
    )
    return after, StepReport(0, made, 1)


def explicit_acceleration(state: State) -> Floats:
    """Acceleration of the nodes now [cm/s^2], in the shape of their places; zero before the first step."""
    if state.micro_step is None:
        return np.zeros_like(state.wall.velocity)
    return np.asarray(2.0 / state.micro_step.length * (state.wall.velocity - state.micro_step.rate))


def contact_energy(model: Model, wall: WallState) -> float:
    """Energy in the springs of the contact [mN cm]; the implicit scheme has none."""
    if model.explicit is None:
        return 0.0
    area = 2.0 * math.pi * model.wall.radius * model.wall.element_size
    return 0.5 * area / model.explicit.contact_stiffness * float((wall.contact**2).sum())


def _excitable(model: Model, layer: Layer, state: State, sheet: SheetState, stimulus: Stimulus) -> Excitable:
    cells = model.grid.n_z
    spread = np.empty(0)
    if layer.conducts:
        factor = np.broadcast_to(np.ravel(layer.conductivity), cells - 1)
        spread = factor * (1e-3 * layer.diffusivity / model.grid.cell_size**2)
    opened = float(stimulus.conductance.max())
    safety = model.explicit.safety if model.explicit is not None else 1.0
    allowed = safety * conduction_limit(model, layer, state, opened)
    return Excitable(
        sheet.potential.ravel().copy(),
        sheet.gates.reshape(len(sheet.gates), -1).copy(),
        sheet.first_activation.ravel().copy(),
        sheet.last_activation.ravel().copy(),
        layer.conductances,
        spread,
        stimulus.current.ravel(),
        stimulus.conductance.ravel(),
        np.ascontiguousarray(np.broadcast_to(np.ravel(layer.force_factor), cells), dtype=np.float64),
        float(layer.threshold),
        max(1, math.ceil(model.dt_wall / model.substeps / allowed)),
    )


def _shell(model: Model, state: State) -> Shell:
    wall, pellet = state.wall, state.pellet
    dry = dry_friction_now(model, pellet)
    sliding = sliding_speed(model, pellet) if model.pellet.present else 0.0

    def plane(field: Floats) -> Floats:
        return np.ascontiguousarray(field[:, 0, [0, 2]].T)

    return Shell(
        plane(wall.position),
        plane(wall.velocity if state.micro_step is None else state.micro_step.rate),
        plane(explicit_acceleration(state)),
        wall.contact[:, 0].copy(),
        wall.stretch_rate[:, 0].copy(),
        wall.hoop_rate[:, 0].copy(),
        wall.drive[:, :, 0].copy(),
        np.array([pellet.position, pellet.velocity, pellet.axial_force, dry, sliding]),
        np.array([state.pressure]),
    )


def _sheet(sheet: Excitable, before: SheetState) -> SheetState:
    shape = before.potential.shape
    return SheetState(
        sheet.potential.reshape(shape),
        sheet.gates.reshape(-1, *shape),
        sheet.first_activation.reshape(shape),
        sheet.last_activation.reshape(shape),
        before.muscle,
    )


def _spatial(plane: Floats, angle: Floats | float = 0.0) -> Floats:
    """Nodes (n, 1, 3) from their rho and zeta, (2, n)."""
    nodes = np.empty((plane.shape[1], 1, 3))
    nodes[:, 0, 0], nodes[:, 0, 1], nodes[:, 0, 2] = plane[0], angle, plane[1]
    return nodes


def _wall(model: Model, before: WallState, shell: Shell, dt: float) -> WallState:
    return WallState(
        position=_spatial(shell.place, before.position[:, 0, 1]),
        position_before=before.position,
        velocity=_spatial(shell.rate + 0.5 * dt * shell.acceleration),
        velocity_before=before.velocity,
        contact=shell.density[:, None],
        stretch_rate=shell.stretch_rate[:, None],
        hoop_rate=shell.hoop_rate[:, None],
        drive=shell.drive[:, :, None],
        step_before=model.dt_wall,
    )


def _pellet(model: Model, shell: Shell) -> PelletState:
    centre, velocity, force, dry, _ = (float(value) for value in shell.pellet)
    return PelletState(centre, velocity, force, dry) if model.pellet.present else PelletState(centre, 0.0, 0.0)


def _complaint(model: Model, shell: Shell, code: int, cell: int, time: float, dt: float, allowed: Limits) -> str:
    """What went wrong in the middle of a wall step, where, and what to change."""
    where = f"t = {time:.6g} s"
    if code in (LONGITUDINAL, CIRCULAR):
        layer = "longitudinal" if code == LONGITUDINAL else "circular"
        return (
            f"{layer} potential left -200...150 mV at z = {model.grid.cells[cell]:.3g} cm, {where}: lower "
            "step.conduction or the intensity of a stimulus"
        )
    what = "wall position: the tube has no volume left"
    if code == STRETCH:
        bad = ~np.isfinite(shell.place).all(axis=0)
        lengths = np.hypot(*np.diff(shell.place, axis=1)) / model.wall.element_size
        worst = int(np.argmax(np.where(bad, np.inf, np.r_[lengths, 1.0])))
        what = f"wall position: a stretch went out of range near z = {model.grid.nodes[worst]:.3g} cm"
    return (
        f"{what}, {where}, with explicit steps of {1e3 * dt:.3g} ms; stable at the start of the step were "
        f"{1e3 * allowed.shell:.3g} ms ({allowed.words()}); lower step.explicit, solver.explicit_safety or step.wall"
    )
