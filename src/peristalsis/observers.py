"""What watches a run: each observer starts, sees every step, and may stop the run with a stored reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .model.fields import contact_pressure, corner_tensions, nodal_stretches, nodal_tensions
from .model.friction import sliding_speed
from .model.model import Model
from .model.state import State
from .model.step import StepReport
from .model.step_summary import StepSummary, summary_of_step
from .names import SCALARS
from .recording import ALL, chosen, due
from .tissue.cells.plant import GATES
from .wall import membrane

Floats = NDArray[np.float64]

KPA = 100.0
"""mN/cm^2 in a kPa."""

ARREST_WINDOW = 1.0
ARREST_TRAVEL = 0.01
"""A pellet is arrested when it moved less than 0.01 cm over the last second (0.1 mm/s), so never earlier."""


class Observer(Protocol):
    """Sees the initial state once and then every step; a returned text stops the run and is its reason."""

    def start(self, model: Model, state: State) -> None:
        """Called once, with the state before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Called after every step."""


@dataclass
class ScalarRecorder:
    """One number for every output of `names.SCALARS` and every step, the initial state included."""

    rows: list[tuple[float, ...]] = field(default_factory=list)
    absolute_work: float = 0.0
    _work: Floats = field(default_factory=lambda: np.zeros(6))

    NAMES = tuple(output.name for output in SCALARS)

    def start(self, model: Model, state: State) -> None:
        """Record the initial state."""
        self.rows.append(self._row(model, state, 0, summary_of_step(model, state, state)))

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Add the work of the step and record its end."""
        summary = summary_of_step(model, before, after)
        work = summary.work
        self._work += (
            work.active,
            work.gas,
            work.stored + work.kinetic,
            work.lost_wall,
            work.lost_pellet,
            work.residual,
        )
        self.absolute_work += abs(work.active) + abs(work.gas)
        self.rows.append(self._row(model, after, report.newton_iterations, summary))
        return None

    def columns(self) -> dict[str, Floats]:
        """Name to values, shape (n_steps + 1,)."""
        table = np.array(self.rows, dtype=np.float64)
        return {name: table[:, k].copy() for k, name in enumerate(self.NAMES)}

    def _row(self, model: Model, state: State, iterations: int, summary: StepSummary) -> tuple[float, ...]:
        contact = summary.contact
        pellet = model.pellet
        position = state.pellet.position if pellet.present else math.nan
        viscous = -pellet.viscous * sliding_speed(model, state.pellet)
        return (
            position,
            state.pellet.velocity,
            state.pellet.axial_force,
            contact.normal_force,
            viscous,
            -state.pellet.axial_force - viscous,
            summary.oral,
            summary.anal,
            state.pressure / KPA,
            contact.largest_pressure / KPA,
            contact.start,
            contact.end,
            2.0 * contact.least_radius,
            summary.slack,
            contact.smallest_gap,
            iterations,
            *self._work.tolist(),
            summary.momentum.residual,
        )


@dataclass
class FieldRecorder:
    """Chosen fields of `names.FIELDS` every `every` steps, or at the first step after, and at the end of the run."""

    every: float
    names: tuple[str, ...] = chosen((ALL,))
    steps: list[int] = field(default_factory=list)
    frames: dict[str, list[Floats]] = field(default_factory=dict)

    def start(self, model: Model, state: State) -> None:
        """Record the initial state."""
        self._record(model, state)

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Record if the step is due."""
        if due(after.step, self.every):
            self._record(model, after)
        return None

    def finish(self, model: Model, state: State) -> None:
        """Record the last state if it is not yet there."""
        if self.steps[-1] != state.step:
            self._record(model, state)

    def _record(self, model: Model, state: State) -> None:
        self.steps.append(state.step)
        fields = fields_of(model, state)
        for name in self.names:
            # A copy: what is seen here are slices that would keep whole arrays of the state alive.
            self.frames.setdefault(name, []).append(fields[name].copy())


def fields_of(model: Model, state: State) -> dict[str, Floats]:
    """Every field of `names.FIELDS` of one state, in the units of the files."""
    wall = state.wall
    tension = nodal_tensions(corner_tensions(wall, model.wall))
    along, around = nodal_stretches(wall, model.wall)
    return {
        "radius": wall.position[:, :, 0],
        "angle": wall.position[:, :, 1],
        "axial_position": wall.position[:, :, 2],
        "stretch_longitudinal": along,
        "stretch_circumferential": around,
        "tension_longitudinal": tension[..., membrane.TOTAL_LONGITUDINAL],
        "tension_circumferential": tension[..., membrane.TOTAL_CIRCULAR],
        "active_tension_longitudinal": tension[..., membrane.ACTIVE_LONGITUDINAL],
        "active_tension_circumferential": tension[..., membrane.ACTIVE_CIRCULAR],
        "passive_tension_longitudinal": tension[..., membrane.PASSIVE_LONGITUDINAL],
        "passive_tension_circumferential": tension[..., membrane.PASSIVE_CIRCULAR],
        "contact_pressure": contact_pressure(wall, model.wall) / KPA,
        "potential_longitudinal": state.longitudinal.potential,
        "potential_circular": state.circular.potential,
        "calcium_longitudinal": state.longitudinal.gates[GATES.index("c")],
        "calcium_circular": state.circular.gates[GATES.index("c")],
    }


@dataclass
class ProbeRecorder:
    """Potential and gates of both layers at chosen cells (first column around), every step."""

    cells: NDArray[np.int64]
    rows: list[Floats] = field(default_factory=list)

    def start(self, model: Model, state: State) -> None:
        """Record the initial state."""
        self.rows.append(self._row(state))

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Record the end of the step."""
        self.rows.append(self._row(after))
        return None

    def columns(self) -> dict[str, Floats]:
        """Name of `names.PROBES` to values, shape (n_steps + 1, n_probes)."""
        table = np.array(self.rows)
        labels = ("potential", "h", "n", "x", "calcium")
        return {
            f"{label}_{layer}_probe": table[:, 5 * number + k]
            for number, layer in enumerate(("longitudinal", "circular"))
            for k, label in enumerate(labels)
        }

    def _row(self, state: State) -> Floats:
        sheets = (state.longitudinal, state.circular)
        values = [part for sheet in sheets for part in (sheet.potential[None], sheet.gates)]
        return np.concatenate([part[:, self.cells, 0] for part in values])


@dataclass
class Expulsion:
    """Stops the run when the leading pole of the pellet reaches the anal end; remembers when, to within the step."""

    stop: bool
    time: float | None = None

    def start(self, model: Model, state: State) -> None:
        """Nothing to do before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Note the time of arrival, linear within the step."""
        if not model.pellet.present or self.time is not None:
            return None
        goal = model.grid.length - model.pellet.radius
        if after.pellet.position < goal:
            return None
        travelled = after.pellet.position - before.pellet.position
        share = (goal - before.pellet.position) / travelled if travelled > 0.0 else 1.0
        self.time = (before.step + share) * model.dt_wall
        return "expelled" if self.stop else None


@dataclass
class StopConditions:
    """Stops the run when the pellet's centre reaches a place, or when it has rested for a second after having moved."""

    position: float
    when_arrested: bool
    _track: list[float] = field(default_factory=list)

    def start(self, model: Model, state: State) -> None:
        """Remember where the pellet starts."""
        self._track.append(state.pellet.position)

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Whether to stop now."""
        if not model.pellet.present:
            return None
        place = after.pellet.position
        if before.pellet.position < self.position <= place:
            return f"the pellet has reached {self.position:g} cm"
        if not self.when_arrested:
            return None
        self._track.append(place)
        window = round(ARREST_WINDOW / model.dt_wall)
        if len(self._track) <= window or abs(self._track[-1 - window] - self._track[0]) < ARREST_TRAVEL:
            return None
        rested = abs(place - self._track[-1 - window]) < ARREST_TRAVEL
        return "the pellet has come to rest" if rested else None


@dataclass
class Callback:
    """Shows each step to a function of (simulated time [s], pellet position [cm]): progress bars, notebooks."""

    call: Any

    def start(self, model: Model, state: State) -> None:
        """Show the start."""
        self.call(0.0, state.pellet.position)

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Show the step."""
        self.call(after.step * model.dt_wall, after.pellet.position)
        return None
