"""What watches a run: each observer starts, sees every step, and may stop the run with a stored reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError
from ..inputs.asked import ARREST_TRAVEL, ARREST_WINDOW
from ..inputs.recording import ALL, chosen, due
from ..model.balance import Work
from ..model.ends import ANALLY, ORALLY, passages
from ..model.model import Model
from ..model.report import StepReport
from ..model.state import State
from ..names import OUTPUTS, PROBES, SCALARS, Output
from ..results.moment import Done, Moment, StepMoment

Floats = NDArray[np.float64]

REACHED, AT_REST = "the pellet has reached", "the pellet has come to rest"
"""Why a run is stopped, or how the reason begins."""
AT_START = StepReport(0, 0, 0)
"""Of the state before the first step."""


class Observer(Protocol):
    """Sees the initial state once and then every step; a returned text stops the run and is its reason."""

    def start(self, model: Model, state: State) -> None:
        """Called once, with the state before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Called after every step."""


def _names(outputs: list[Output]) -> tuple[str, ...]:
    return tuple(output.name for output in outputs)


def read_off(names: tuple[str, ...], now: Moment) -> list[Any]:
    """Values of the outputs of these names at a moment, each by the output's own function."""
    found = []
    for name in names:
        output = OUTPUTS.get(name)
        if output is None or output.value is None:
            raise ConfigurationError(f"output {name} is not known here; register it before the run goes on")
        found.append(output.value(now))
    return found


@dataclass
class ScalarRecorder:
    """One number for every output of `names.SCALARS` and every step, the initial state included."""

    names: tuple[str, ...] = field(default_factory=lambda: _names(SCALARS))
    rows: list[tuple[float, ...]] = field(default_factory=list)
    absolute_work: float = 0.0
    done: Done = field(default_factory=Done)

    def start(self, model: Model, state: State) -> None:
        """Record the initial state."""
        summary = model.binding.module("model.step_summary").summary_of_step(model, state, state)
        self._record(StepMoment(model, state, summary, AT_START, self.done))

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Add the work of the step and record its end."""
        summary_of_step = model.binding.module("model.step_summary").summary_of_step
        for part in report.made_of(model, before, after):
            summary = summary_of_step(*part)
            self._add(summary.work)
        self._record(StepMoment(model, after, summary, report, self.done))
        return None

    def _add(self, work: Work) -> None:
        done = self.done
        self.done = Done(
            active=done.active + work.active,
            gas=done.gas + work.gas,
            stored=done.stored + (work.stored + work.kinetic),
            lost_wall=done.lost_wall + work.lost_wall,
            lost_pellet=done.lost_pellet + work.lost_pellet,
            residual=done.residual + work.residual,
        )
        self.absolute_work += abs(work.active) + abs(work.gas)

    def latest(self) -> dict[str, float]:
        """Name to the value after the last step."""
        return dict(zip(self.names, self.rows[-1], strict=True))

    def columns(self) -> dict[str, Floats]:
        """Name to values, shape (n_steps + 1,)."""
        table = np.array(self.rows, dtype=np.float64)
        return {name: table[:, k].copy() for k, name in enumerate(self.names)}

    def _record(self, now: StepMoment) -> None:
        self.rows.append(tuple(map(float, read_off(self.names, now))))

    def take_back(self, arrays: Mapping[str, Floats]) -> None:
        """Hold again the columns of a run that is stored."""
        table = np.column_stack([arrays[name] for name in self.names])
        self.rows = [tuple(row) for row in table.tolist()]


@dataclass
class FieldRecorder:
    """Chosen fields of `names.FIELDS` every `every` steps, or at the first step after, and at the end of the run."""

    every: float
    names: tuple[str, ...] = field(default_factory=lambda: chosen((ALL,)))
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

    def recorded(self, model: Model, state: State | None) -> tuple[list[int], dict[str, list[Floats]]]:
        """Steps and frames so far, with that of the last state if it is given and not yet there.

        That frame is not kept: a run that goes on has none that another one would not have.
        """
        if state is None or self.steps[-1] == state.step:
            return self.steps, self.frames
        ended = FieldRecorder(self.every, self.names, list(self.steps), {n: list(f) for n, f in self.frames.items()})
        ended._record(model, state)
        return ended.steps, ended.frames

    def take_back(self, steps: Sequence[int], arrays: Mapping[str, Floats]) -> None:
        """Hold again what was recorded by a run that is stored; a frame of its end alone is left out."""
        count = len(steps) - (not due(steps[-1], self.every) and steps[-1] != 0)
        self.steps = [int(step) for step in steps[:count]]
        self.frames = {name: list(arrays[name][:count]) for name in self.names}

    def _record(self, model: Model, state: State) -> None:
        self.steps.append(state.step)
        for name, value in zip(self.names, read_off(self.names, Moment(model, state)), strict=True):
            # A copy: what is seen here are slices that would keep whole arrays of the state alive.
            self.frames.setdefault(name, []).append(np.array(value, dtype=np.float64))


@dataclass
class ProbeRecorder:
    """Every output of `names.PROBES` at chosen cells (first column around), every step."""

    cells: NDArray[np.int64]
    names: tuple[str, ...] = field(default_factory=lambda: _names(PROBES))
    rows: list[Floats] = field(default_factory=list)

    def start(self, model: Model, state: State) -> None:
        """Record the initial state."""
        self._record(model, state)

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Record the end of the step."""
        self._record(model, after)
        return None

    def columns(self) -> dict[str, Floats]:
        """Name to values, shape (n_steps + 1, n_probes)."""
        table = np.array(self.rows)
        return {name: table[:, k] for k, name in enumerate(self.names)}

    def _record(self, model: Model, state: State) -> None:
        self.rows.append(np.array(read_off(self.names, Moment(model, state, self.cells)), dtype=np.float64))

    def take_back(self, arrays: Mapping[str, Floats]) -> None:
        """Hold again the columns of a run that is stored."""
        self.rows = list(np.stack([arrays[name] for name in self.names], axis=1))


@dataclass
class Expulsion:
    """Stops the run when the pellet leaves; remembers when, to within the step (`ends.passages`).

    time: of the leading pole at the anal end [s]. oral_time: of the centre at the oral end. The first of them counts.
    """

    stop: bool
    time: float | None = None
    oral_time: float | None = None

    def start(self, model: Model, state: State) -> None:
        """Nothing to do before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Note the time of arrival, linear within the step."""
        if not model.pellet.present or self.way is not None:
            return None
        for part in report.made_of(model, before, after):
            found = passages(*part)
            self.time, self.oral_time = found.anal, found.oral
            if self.way is not None:
                break
        return self.way if self.stop else None

    @property
    def way(self) -> str | None:
        """How the pellet left: a status, None while it is inside."""
        if self.time is not None:
            return ANALLY
        return ORALLY if self.oral_time is not None else None


@dataclass
class StopConditions:
    """Stops the run when the pellet's centre reaches a place, from either side, or has rested for a second after having
    moved.
    """

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
        return self.met(model.dt_wall, before.pellet.position, after.pellet.position)

    def met(self, step: float, before: float, place: float) -> str | None:
        """Whether to stop after a step [s] that brought the pellet from one place [cm] to another."""
        if before < self.position <= place or place <= self.position < before:
            return f"{REACHED} {self.position:g} cm"
        if not self.when_arrested:
            return None
        self._track.append(place)
        window = round(ARREST_WINDOW / step)
        if len(self._track) <= window or abs(self._track[-1 - window] - self._track[0]) < ARREST_TRAVEL:
            return None
        rested = abs(place - self._track[-1 - window]) < ARREST_TRAVEL
        return AT_REST if rested else None

    def replayed(self, step: float, track: Sequence[float]) -> tuple[int, str] | None:
        """The first step of a recorded track [cm] at which to stop, and why; None if there is none."""
        self._track = [track[0]]
        for number, (before, place) in enumerate(pairwise(track), start=1):
            reason = self.met(step, before, place)
            if reason is not None:
                return number, reason
        return None


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
