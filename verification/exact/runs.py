"""Short coupled runs on small grids, marched with the package's own step and kept state by state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from peristalsis import scenarios
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.initial import initial_state
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.model.step import advance

PLAIN = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "tissue.front_correction": "none",
    "grid.exchange": "averages",
    "trigger.timing": "step",
}
"""Short steps, and the equations between the grids as (25), (30) and (33) write them."""

SMALL = PLAIN | {
    "grid.n_z": 400,
    "grid.n_z_wall": 400,
    "solver.residual_tolerance": 1e-10,
    "solver.penetration_tolerance": 1e-10,
}
"""A small grid for balances and inequalities, which hold on any grid, and tolerances at which they can be told."""

EXACT = {
    "wall.tension": "consistent",
    "wall.slack_blend": "0 mN/cm",
    "wall.slack_slope": 0.0,
    "wall.bending_stiffness": "0 mN*cm",
    "wall.bending_viscosity": "0 mN*s*cm",
    "wall.fold_tension": "0 mN/cm",
    "solver.residual_tolerance": 2e-9,
    "solver.penetration_tolerance": 1e-10,
}
"""The wall of the exact problems: energetic convention, no smoothing, no floor, no bending."""

IDLE = {"pacemaker.kind": "none", "trigger.rule": "none", "reflex.enabled": False}
"""Nothing starts anything."""


def configured(*changes: Mapping[str, Any], scenario: str = "baseline") -> Configuration:
    """The configuration of a scenario on the small grid with these changes, the later ones over the earlier."""
    merged = dict(SMALL)
    for more in changes:
        merged |= more
    return scenarios.configuration(scenario, changes=merged)


def started(*changes: Mapping[str, Any], scenario: str = "baseline") -> tuple[Model, State]:
    """Model and state before t = 0."""
    model, state, _ = initial_state(build(configured(*changes, scenario=scenario).at_start()))
    return model, state


@dataclass(frozen=True)
class March:
    """A model and its states, the initial one first."""

    model: Model
    states: list[State]

    @property
    def last(self) -> State:
        """The state at the end."""
        return self.states[-1]


def march(seconds: float, *changes: Mapping[str, Any], scenario: str = "baseline") -> March:
    """Every state of a run over so many seconds."""
    model, state = started(*changes, scenario=scenario)
    states = [state]
    for _ in range(round(seconds / model.dt_wall)):
        state, _ = advance(model, state)
        states.append(state)
    return March(model, states)


@cache
def wave_catches_pellet() -> March:
    """The baseline on the small grid over its first 0.8 s: rest, the wave, contact that travels, sliding."""
    return march(0.8)


def moved(state: State, position: Any) -> State:
    """The state with its wall put somewhere else, at rest."""
    wall = replace(state.wall, position=position, position_before=position)
    return replace(state, wall=wall)
