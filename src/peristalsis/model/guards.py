"""Guards of a run: a step whose fields are not finite, or out of bounds, is tried again in halves and never kept."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergenceError
from ..numerics.compiled import compiled
from ..tissue.cell import SHIPPED_CELL, Cell
from .model import Model
from .ranges import between, outside
from .report import StepReport
from .schemes.choice import scheme_of
from .state import SheetState, State, WallState
from .step import advance
from .verdicts import TENSION_SCALE

Floats = NDArray[np.float64]

HALVINGS = 3
"""How often a step is cut in two before the run is given up; the wall cuts its own steps further."""

ROUNDOFF = 1e-9
"""By which rounding may take a state of a cell out of its bounds, as a share of them."""
PRESSURE_ROUNDOFF = 1e-12
"""Share of the pressure's scale by which rounding may take it below zero."""


def advance_safely(model: Model, state: State, halvings: int = HALVINGS) -> tuple[State, StepReport]:
    """As `advance`, with a state that passes `violation`: a step that fails is made in two, four or eight parts.

    Raises the DivergenceError of the first part that fails at the shortest step.
    """
    try:
        after, report = advance(model, state)
        wrong = violation(model, after)
        if wrong is None:
            return after, report
        raise DivergenceError(
            f"{wrong} after the step to t = {after.step * model.dt_wall:.6g} s of {model.dt_wall:.2g} s; lower "
            "step.wall and step.conduction"
        )
    except DivergenceError as error:
        if halvings == 0:
            raise
        why = str(error)
    finer = replace(model, dt_wall=0.5 * model.dt_wall)
    half, first = advance_safely(finer, replace(state, step=2 * state.step), halvings - 1)
    full, second = advance_safely(finer, half, halvings - 1)
    report = StepReport(
        first.newton_iterations + second.newton_iterations,
        first.assemblies + second.assemblies,
        first.wall_solves + second.wall_solves,
        first.krylov_iterations + second.krylov_iterations,
        why,
    )
    return replace(full, step=state.step + 1), report


def violation(model: Model, state: State) -> str | None:
    """What is wrong with a state, naming field and place, or None: not finite, or beyond what any tissue can be."""
    found = None if _sound(model, state) else _first_wrong(model, state)
    found = found or _muscles(model, state) or scheme_of(model).stretch_fault(model, state.wall)
    if found is not None:
        return found
    pellet = state.pellet
    scalars = {
        "pellet position": pellet.position,
        "pellet velocity": pellet.velocity,
        "axial force": pellet.axial_force,
        "lumen pressure": state.pressure,
        "reflex": state.reflex.fired if state.reflex.fired != -np.inf else 0.0,
    }
    for name, value in scalars.items():
        if not math.isfinite(value):
            return f"{name} is {value}"
    # An empty lumen's pressure is zero but for rounding.
    least = -PRESSURE_ROUNDOFF * max(model.lumen.pressure, TENSION_SCALE / model.wall.radius)
    return None if state.pressure >= least else f"lumen pressure is {state.pressure:.3g} mN/cm^2"


def _sound(model: Model, state: State) -> bool:
    """Whether all fields but the stretches pass, in one compiled call; `_first_wrong` finds the words."""
    sheets = _sheets(model, state)
    wall = state.wall
    finite = (wall.position, wall.velocity, wall.contact, wall.hoop_rate, wall.stretch_rate, wall.drive)
    return bool(
        _all_within(
            tuple([sheet.potential.ravel() for _, _, sheet in sheets]),
            tuple([sheet.gates.reshape(len(sheet.gates), -1) for _, _, sheet in sheets]),
            tuple([_allowed(cell) for _, cell, _ in sheets]),
            (*[array.ravel() for array in finite], state.trigger.tension.ravel()),
        )
    )


def _sheets(model: Model, state: State) -> tuple[tuple[str, Cell, SheetState], ...]:
    found = (
        ("longitudinal", model.longitudinal.cell, state.longitudinal),
        ("circular", model.circular.cell, state.circular),
        ("pacemaker", SHIPPED_CELL, state.pacemaker),
    )
    if model.network is None or state.network is None:
        return found
    return (*found, ("network", model.network.sheet.cell, state.network))


@cache
def _allowed(cell: Cell) -> Floats:
    """Least and largest value, (2, 1 + states), of the potential and of the other states with what rounding adds."""
    low, high = cell.bounds
    margin = ROUNDOFF * np.minimum(1.0, np.abs(high))
    return np.array([[cell.lowest, *(low - margin)], [cell.highest, *(high + margin)]])


@compiled
def _all_within(
    potentials: tuple[np.ndarray, ...],
    gates: tuple[np.ndarray, ...],
    allowed: tuple[np.ndarray, ...],
    finite: tuple[np.ndarray, ...],
) -> bool:
    """Whether potentials and gates (a row each) keep what is allowed, and the rest is finite."""
    good = True
    for sheet in range(len(potentials)):
        bounds = allowed[sheet]
        good &= between(potentials[sheet], bounds[0, 0], bounds[1, 0])
        rows = gates[sheet]
        for k in range(rows.shape[0]):
            good &= between(rows[k], bounds[0, k + 1], bounds[1, k + 1])
    for values in finite:
        good &= between(values, -np.inf, np.inf)
    return good


def _first_wrong(model: Model, state: State) -> str | None:
    for name, cell, sheet in _sheets(model, state):
        wrong = _sheet(model, name, cell, sheet)
        if wrong is not None:
            return wrong
    return _wall(model, state.wall) or _trigger(model, state)


def _sheet(model: Model, name: str, cell: Cell, sheet: SheetState) -> str | None:
    places = model.grid.cells
    allowed = _allowed(cell)
    bad = outside(sheet.potential, allowed[0, 0], allowed[1, 0], places)
    if bad is not None:
        return f"{name} potential {bad} mV"
    for gate, values, low, high in zip(cell.states, sheet.gates, *allowed[:, 1:], strict=True):
        bad = outside(values, low, high, places)
        if bad is not None:
            return f"{name} gate {gate} {bad}"
    return None


def _muscles(model: Model, state: State) -> str | None:
    """What is wrong with the states of the muscles' own, which most activations have none of."""
    for name, layer, sheet in (
        ("longitudinal", model.longitudinal, state.longitudinal),
        ("circular", model.circular, state.circular),
    ):
        for (own, low, high), values in zip(layer.activation.states, sheet.muscle, strict=True):
            margin = ROUNDOFF * min(1.0, abs(high))
            bad = outside(values, low - margin, high + margin, model.grid.cells)
            if bad is not None:
                return f"{name} muscle {own} {bad}"
    return None


def _wall(model: Model, wall: WallState) -> str | None:
    nodes = model.grid.nodes
    infinite = np.inf
    lengths = {"position": wall.position, "velocity": wall.velocity}
    rates = {"contact density": wall.contact, "hoop rate": wall.hoop_rate, "stretch rate": wall.stretch_rate}
    for name, values in {**lengths, **rates, "muscle drive": wall.drive[0], "drive": wall.drive[1]}.items():
        bad = outside(values, -infinite, infinite, nodes)
        if bad is not None:
            return f"wall {name} {bad}"
    return None


def _trigger(model: Model, state: State) -> str | None:
    bad = outside(state.trigger.tension, -np.inf, np.inf, model.grid.cells)
    return None if bad is None else f"tension seen by the trigger {bad}"
