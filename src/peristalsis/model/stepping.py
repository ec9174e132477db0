"""How long a step is: as long as asked, or as its error allows, Eqs. (102)-(104).

A step of the run is made in 1, 2, 4 ... parts. Whether a part was short enough is read off its two ends: how far wall
and pellet came to lie from where they were expected, and whether something began or ended in it. Nothing is carried
from step to step beside the state, so a run that is taken up again makes the same parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergenceError
from ..numerics.compiled import compiled
from ..numerics.rates import carried_on
from .friction import sliding_speed
from .guards import advance_safely, violation
from .model import Model
from .report import Part, StepReport
from .state import State
from .step import advance

Floats = NDArray[np.float64]

QUIET = 0.05
"""Time without a start by the trigger after which the next one begins a wave [s]."""


@dataclass
class _Cost:
    """What the parts of a step, and the tries that were thrown away, cost together."""

    newton_iterations: int = 0
    assemblies: int = 0
    wall_solves: int = 0
    krylov_iterations: int = 0
    halved: str = ""
    rejected: int = 0

    def add(self, report: StepReport) -> None:
        """Add what a try cost."""
        self.newton_iterations += report.newton_iterations
        self.assemblies += report.assemblies
        self.wall_solves += report.wall_solves
        self.krylov_iterations += report.krylov_iterations
        self.halved = self.halved or report.halved


def advance_run(model: Model, state: State) -> tuple[State, StepReport]:
    """One step of a run, guarded; in parts where its length follows its error. Raises DivergenceError."""
    if model.control is None:
        return advance_safely(model, state)
    cost = _Cost()
    parts: list[Part] = []
    after = _advance(model, state, model.control.halvings, parts, cost)
    made = tuple(parts) if len(parts) > 1 else ()
    counts = cost.newton_iterations, cost.assemblies, cost.wall_solves, cost.krylov_iterations
    return after, StepReport(*counts, cost.halved, made, cost.rejected)


def _advance(model: Model, state: State, halvings: int, parts: list[Part], cost: _Cost) -> State:
    """The state after a step of the model, made in parts that are halved up to so often."""
    if halvings == 0:
        after, report = advance_safely(model, state)
        cost.add(report)
    else:
        tried = None if _hopeless(model, state) else _tried(model, state, cost)
        if tried is None:
            finer = model.finer
            half = _advance(finer, replace(state, step=2 * state.step), halvings - 1, parts, cost)
            return replace(_advance(finer, half, halvings - 1, parts, cost), step=state.step + 1)
        after = tried
    parts.append(Part(model, state, after))
    return after


def _tried(model: Model, state: State, cost: _Cost) -> State | None:
    """The state after one step, if it can be kept."""
    assert model.control is not None
    try:
        after, report = advance(model, state)
    except DivergenceError:
        cost.rejected += 1
        return None
    cost.add(report)
    kept = (
        error_of_step(model, state, after) <= model.control.tolerance
        and not _something_happened(model, state, after)
        and violation(model, after) is None
    )
    cost.rejected += not kept
    return after if kept else None


def error_of_step(model: Model, before: State, after: State) -> float:
    """How far wall and pellet came to lie from where they were expected [cm], Eq. (102), the larger of both."""
    wall, dt = before.wall, model.dt_wall
    trend = carried_on(dt, wall.step_before)
    expected = wall.position + dt * (trend * wall.velocity - (trend - 1.0) * wall.velocity_before)
    off = _apart(model, after.wall.position, expected, after.wall.position)
    if not model.pellet.present:
        return off
    return max(off, abs(after.pellet.position - before.pellet.position - dt * before.pellet.velocity))


def _apart(model: Model, one: Floats, other: Floats, position: Floats) -> float:
    """Difference of two fields of (rho, vartheta, zeta) on a wall, root mean square over a diameter of the tube."""
    spread = math.sqrt(model.wall.element_size / (2.0 * model.wall.radius * model.grid.n_theta))
    return float(_distance(one, other, position)) * spread


def _hopeless(model: Model, state: State) -> bool:
    """Whether the step before, a shorter one, was already as wrong as this one, so much longer, may be, Eq. (103)."""
    assert model.control is not None
    wall, dt = state.wall, model.dt_wall
    if not 0.0 < wall.step_before < 0.75 * dt:
        return False
    change = _apart(model, wall.velocity, wall.velocity_before, wall.position)
    return 0.5 * change * dt * dt / wall.step_before > model.control.tolerance


def _something_happened(model: Model, before: State, after: State) -> bool:
    """Whether the step holds an instant that is wanted as exactly as the shortest step gives it, Eq. (104).

    The pellet starts or stops, or is touched or let go; receptors discharge; the trigger starts a wave.
    """
    if after.reflex.fired != before.reflex.fired:
        return True
    if after.trigger.start is not before.trigger.start:
        last, latest = float(before.trigger.seen.max()), float(after.trigger.seen.max())
        if last < min(latest, before.step * model.dt_wall - QUIET):
            return True
    if not model.pellet.present:
        return False
    if (sliding_speed(model, before.pellet) != 0.0) != (sliding_speed(model, after.pellet) != 0.0):
        return True
    return bool((before.wall.contact > 0.0).any()) != bool((after.wall.contact > 0.0).any())


@compiled
def _distance(one: np.ndarray, other: np.ndarray, position: np.ndarray) -> float:
    """Root of the sum of the squared differences, (n, m, 3), angles times the radius that `position` has there."""
    total = 0.0
    for i in range(one.shape[0]):
        for j in range(one.shape[1]):
            for k in range(3):
                difference = one[i, j, k] - other[i, j, k]
                if k == 1:
                    difference *= position[i, j, 0]
                total += difference * difference
    return math.sqrt(total)
