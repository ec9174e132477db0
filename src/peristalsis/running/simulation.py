"""A run in progress: advanced by hand, or to its end. The loop knows no equation."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from os import PathLike
from typing import Any

import numpy as np

from .. import units
from ..errors import ConfigurationError, DivergenceError, InterruptedRun, StoppedRun, shown, suggestion
from ..inputs import preflight, tables
from ..inputs.asked import ARREST_TRAVEL, ARREST_WINDOW
from ..inputs.build import build
from ..inputs.config import ENDS, FIELDS, Configuration
from ..inputs.protocols import changeable, values_at
from ..inputs.recording import whole_steps
from ..model.ends import ANALLY, ORALLY
from ..model.model import Model
from ..model.state import PelletState, State
from ..paths import located
from ..results import convergence
from ..results.findings import remarks_of_summary
from ..results.result import Result, load
from ..storing.checkpoint import Checkpoints, Found, Head, newest_of
from ..storing.environment import code_version
from ..storing.packing import pack, packable, unpack
from ..storing.store import LAST_STATE
from .events import Event
from .observers import AT_REST, REACHED, Callback, Observer
from .recorders import Recorders, without_history
from .stopping import stop_at_signals, way_on
from .summary import summarise
from .warm_up import warm_up


class Simulation:
    """One run that can be advanced piece by piece.

    configuration: a Configuration. observers: more of them, called after the recorders. progress: called with
    (simulated time [s], pellet position [cm]) after every step. checkpoints: where and how often they are written;
    none unless given. Raises DivergenceError if the tube cannot be inflated or hold the pellet.
    """

    def __init__(
        self,
        configuration: Configuration,
        observers: tuple[Observer, ...] = (),
        progress: Callable[[float, float], None] | None = None,
        checkpoints: Checkpoints | None = None,
    ) -> None:
        self.configuration = configuration
        self._begun_with = configuration
        explicit = configuration.solver.integrator == "explicit"
        columns = configuration.grid.n_theta
        self.compile_seconds = warm_up(columns > 1, explicit, configuration.parts_chosen())
        self._courses = configuration.time_courses()
        self._inputs = values_at(self._courses, 0.0)
        self._built_from = configuration.at_time(self._inputs)
        model = build(self._built_from)
        self.model, self.state, remarks = self._beginning(model)
        if explicit:
            preflight.check_explicit_step(configuration, self.model, self.state)
        at_start = preflight.remarks_of_start(configuration, self.state)
        self.remarks = [*preflight.remarks(configuration), *remarks, *at_start, *convergence.start_remarks(self.model)]
        self._recorders = Recorders(configuration, self.model)
        self._observers: list[Observer] = [*self._recorders.all, *observers]
        if progress is not None:
            self._observers.append(Callback(progress))
        self.stopped: str | None = None
        self.error: str | None = None
        self.failure: DivergenceError | InterruptedRun | None = None
        self._target = 0.0
        self._solver_seconds = 0.0
        self._checkpoints = checkpoints
        self._start = _hash_of_start(self.model, self.state)
        for observer in self._observers:
            observer.start(self.model, self.state)

    def __repr__(self) -> str:
        where = f"pellet at {self.pellet.position:.4g} cm" if self.model.pellet.present else "no pellet"
        return f"<Simulation of {self.configuration.scenario} at {self.time:.4g} s, {where}>"

    def _beginning(self, model: Model) -> tuple[Model, State, list[str]]:
        """The model completed with V0, the state before t = 0, and remarks; another kind of run begins otherwise."""
        found: tuple[Model, State, list[str]] = model.binding.module("model.initial").initial_state(model)
        return found

    @classmethod
    def resume(
        cls,
        folder: str | PathLike[str],
        observers: tuple[Observer, ...] = (),
        progress: Callable[[float, float], None] | None = None,
        changes: Mapping[str, Any] | None = None,
    ) -> Simulation:
        """The run whose checkpoint or last state is in a folder, or in the hidden ones beside it, as it stood then.

        observers: of the same kinds as before; those that are dataclasses of plain data go on with what they held.
        changes: another end, such as {"run.duration": "5 s"} for a run that had finished (`config.ENDS`). Raises
        ConfigurationError if there is no whole checkpoint, if it is of another version of the code, or if the run
        would have ended before with these changes.
        """
        found = newest_of(located(folder))
        with suppress(ValueError):  # of a version without tables: `restore` says what is to be said
            tables.hold_all(unpack(found.content, {"tables": dict[str, np.ndarray]})["tables"])
        configuration = Configuration.from_toml(found.head.configuration)
        if changes is not None:
            begun, configuration = configuration, configuration.with_changes(changes)
            if begun.digest(ends=False) != configuration.digest(ends=False):
                raise ConfigurationError(
                    f"a run that is under way is not made another one: only {', '.join(ENDS)} can change; run it anew"
                )
        simulation = cls(configuration, observers, progress)
        simulation.restore(found)
        return simulation

    @property
    def time(self) -> float:
        """Simulated time [s]: the integer step times the step."""
        return self.state.step * self.model.dt_wall

    @property
    def pellet(self) -> PelletState:
        """Position [cm], velocity [cm/s] and axial force [mN] of the pellet now."""
        return self.state.pellet

    def advance(self, duration: str) -> State:
        """Advance by a time such as "0.1 s" or "50 ms" and return the state.

        Whole steps only: the steps are those of an uninterrupted run whatever the pieces, and what is left of a
        piece is kept for the next. Raises DivergenceError (the history stays), ConfigurationError (bad time) and
        StoppedRun if the run has been stopped: `stopped` holds the reason, None before.
        """
        seconds = units.parse(duration, "s", "advance")
        if seconds <= 0.0:
            raise ConfigurationError(f"advance = {seconds:g} s is not a step forward; give a positive time")
        if self.stopped is not None:
            raise StoppedRun(
                f"the run was stopped at t = {self.time:.6g} s ({self.stopped}) and does not go on; "
                f"{way_on(self.stopped)}"
            )
        self._target += seconds
        self._advance_to(self._target)
        return self.state

    def set(self, changes: Mapping[str, Any]) -> None:
        """Change inputs of the run from now on, such as {"lumen.pressure": "0.2 kPa"}; V0 stays.

        Only pressure, friction, muscle force, conductances and the drivers can change (`protocols.changeable`). The
        protocol of a parameter that is set ends here, in the configuration too, and the event says so.
        Raises ConfigurationError for anything else and for bad values; nothing changes then.
        """
        fixed = [key for key in changes if key not in FIELDS or not changeable(key)]
        if fixed:
            known = [key for key in FIELDS if changeable(key)]
            raise ConfigurationError(f"{fixed[0]} cannot change during a run; {suggestion(str(fixed[0]), known)}")
        ended = {course.parameter for course in self._courses} & changes.keys()
        lasting = [
            line
            for line, course in zip(self.configuration.protocols, self._courses, strict=True)
            if course.parameter not in ended
        ]
        self.configuration = self.configuration.with_changes({**changes, "protocols": lasting} if ended else changes)
        self._courses = self.configuration.time_courses()
        self._follow_protocols(anew=True)
        words = ", ".join(
            f"{key} = {value}{' (its protocol ends)' if key in ended else ''}" for key, value in changes.items()
        )
        self._recorders.events.note(self.time, "input_changed", math.nan, words)

    def latest(self) -> dict[str, float]:
        """What is recorded of every step, as of the last one: numbers by name (`names.SCALARS`), each in its unit."""
        return self._recorders.scalars.latest()

    def events(self) -> tuple[Event, ...]:
        """What happened so far, in the order of time."""
        return tuple(sorted(self._recorders.events.events, key=lambda event: event.time))

    def run(self) -> Result:
        """Advance to the end and return the result; a run that breaks off returns its history and says why."""
        self.failure = self.error = None  # of an earlier call: this one goes on from there
        try:
            dt = self.model.dt_wall
            self._advance_to(whole_steps(self.configuration.run.duration, dt) * dt)
        except (DivergenceError, InterruptedRun) as error:
            self.failure = error
            self.error = str(error)
            if self._checkpoints is not None and self._violation() is None:
                self._checkpoints.write(self.time, self.checkpoint())
        self._target = max(self._target, self.time)
        return self.result()

    def _advance_to(self, target: float) -> None:
        last = math.floor(target / self.model.dt_wall + 1e-9)
        try:
            with stop_at_signals() as stopped:
                while self.state.step < last and self.stopped is None:
                    if stopped():
                        raise InterruptedRun(f"interrupted at t = {self.time:.6g} s; the history up to there is kept")
                    self._step()
                    if self._checkpoints is not None and self._checkpoints.due(self.time):
                        self._checkpoints.write(self.time, self.checkpoint())
        finally:  # the next piece begins where this one ended
            self._target = self.time if self.state.step < last else max(self._target, self.time)

    def checkpoint(self) -> bytes:
        """Everything that the rest of the run depends on, to the bit; `restore` takes it."""
        return pack(self._parts())

    def last_state(self) -> bytes:
        """The checkpoint of a run that is stored, without what its result holds: a longer run goes on from it."""
        return pack({name: (without_history(part), hint) for name, (part, hint) in self._parts().items()})

    def restore(self, found: Found) -> None:
        """Go on from a checkpoint of the same configuration, or of one that differs in `config.ENDS` alone.

        Raises ConfigurationError if it is of another run, or if this one would have ended before.
        """
        if found.head.digest != self._begun_with.digest():
            begun = Configuration.from_toml(found.head.configuration)
            if begun.digest(ends=False) != self._begun_with.digest(ends=False):
                raise ConfigurationError("the checkpoint is of another configuration; resume the run it belongs to")
        if found.head.code != code_version():
            raise ConfigurationError(
                f"the checkpoint was written by version {found.head.code} and this is {code_version()}: equations may "
                "have changed; run anew, or resume it with that version"
            )
        try:
            parts = unpack(found.content, {name: hint for name, (_, hint) in self._parts().items()})
        except ValueError as error:
            raise ConfigurationError(f"the checkpoint {shown(str(found.file))} cannot be taken up: {error}") from None
        self.state = parts["state"]
        clock: _Clock = parts["clock"]
        self.stopped, self._solver_seconds = clock.stopped, clock.solver_seconds
        self._target = max(clock.target, self.time)
        if clock.configuration != self.configuration.to_toml():
            ends = {key: text for key, text in self.configuration.texts().items() if key in ENDS}
            self.configuration = Configuration.from_toml(clock.configuration).with_changes(ends)
        self._courses = self.configuration.time_courses()
        self._follow_protocols(anew=True)
        for name, observer in self._kept_observers().items():
            vars(observer).update(vars(parts[name]))
        if found.file.name == LAST_STATE:
            self._take_back(found)
        if found.head.digest != self._begun_with.digest():
            self._end_otherwise()
        self.remarks += found.remarks
        if found.head.start != self._start:
            self.remarks.append(
                f"resumed at t = {found.head.time:.6g} s on another machine or with other libraries: the start is not "
                "reproduced to the bit, so this is not the result of an uninterrupted run to the bit"
            )
        if self._checkpoints is not None:
            self._checkpoints.go_on_after(found)

    def _take_back(self, found: Found) -> None:
        """Hold again what the stored run had recorded up to its last state."""
        stored = load(found.file.parent)
        arrays = stored.arrays
        if stored.configuration.digest() != found.head.digest or len(arrays["time_step"]) != found.head.step + 1:
            raise ConfigurationError(f"{shown(str(found.file))} is not of the result beside it; run anew")
        self._recorders.take_back(arrays, self.model.dt_wall)

    def _end_otherwise(self) -> None:
        """Take conditions of ending that the run did not have so far, as if it had had them from its start."""
        run, last = self.configuration.run, self.state.step
        if math.floor(run.duration / self.model.dt_wall + 1e-9) < last:
            raise ConfigurationError(
                f"run.duration = {run.duration:g} s: the run has come to t = {self.time:.6g} s and is not made "
                "shorter; give a longer time, or run it anew (--overwrite)"
            )
        endings = self._recorders.end_otherwise(run, self.model)
        first = min(endings, default=None, key=lambda ending: ending[0])
        if first is not None and first[0] < last:
            raise ConfigurationError(
                f"with this condition the run would have ended at t = {first[0] * self.model.dt_wall:.6g} s "
                f"({first[1]}), and it has come to t = {self.time:.6g} s; run it anew (--overwrite)"
            )
        if self.stopped is not None and self.stopped.startswith((ANALLY, ORALLY, REACHED, AT_REST)):
            self._recorders.forget_stop(self.stopped)
            self.stopped = None
        if first is not None and self.stopped is None:
            self._stop(first[1])

    def _parts(self) -> dict[str, tuple[Any, Any]]:
        begun = self._begun_with
        head = Head(self.state.step, self.time, begun.digest(), begun.to_toml(), code_version(), self._start)
        clock = _Clock(self.configuration.to_toml(), self._target, self.stopped, self._solver_seconds)
        parts: dict[str, tuple[Any, Any]] = {
            "head": (head, Head),
            "clock": (clock, _Clock),
            "state": (self.state, State),
            "tables": (
                tables.held((*begun.naming_tables(), *self.configuration.naming_tables())),
                dict[str, np.ndarray],
            ),
        }
        return parts | {name: (observer, type(observer)) for name, observer in self._kept_observers().items()}

    def _kept_observers(self) -> dict[str, Observer]:
        """The observers that checkpoints hold, by place and kind: dataclasses of plain data."""
        named = {f"{place} {type(observer).__name__}": observer for place, observer in enumerate(self._observers)}
        return {name: one for name, one in named.items() if is_dataclass(one) and packable(type(one))}

    def _follow_protocols(self, anew: bool = False) -> None:
        """Put the protocols' values at the start of the coming step in place, where they have changed, or all anew."""
        values = values_at(self._courses, self.time)
        if anew or values != self._inputs:
            self._inputs = values
            now = self.configuration.at_time(values)
            self.model = build(now, like=self.model, since=self._built_from)
            self._built_from = now

    def _step(self) -> None:
        before = self.state
        begin = time.perf_counter()
        if self._courses:
            self._follow_protocols()
        after, report = self.model.binding.module("model.stepping").advance_run(self.model, before)
        self._solver_seconds += time.perf_counter() - begin
        self.state = after
        for observer in self._observers:
            reason = observer.see(self.model, before, after, report)
            if reason is not None and self.stopped is None:
                self._stop(reason)

    def _violation(self) -> str | None:
        """What is wrong with the state now; None if nothing is."""
        found: str | None = self.model.binding.module("model.guards").violation(self.model, self.state)
        return found

    def _stop(self, reason: str) -> None:
        """The run ends with this step."""
        self.stopped = reason
        if reason != self._recorders.expulsion.way:  # the end that it left by is an event already
            self._recorders.events.note(self.time, "stopped", self.state.pellet.position, reason)

    def result(self) -> Result:
        """The result so far; the run itself is left as it is."""
        arrays = self._recorders.arrays(self.model, self.state, self._violation() is None, self.events())
        cost = {"solver_wall_s": self._solver_seconds, "compile_wall_s": self.compile_seconds}
        summary = summarise(
            self.configuration,
            arrays,
            self._status(arrays),
            self.error,
            self._recorders.expulsion,
            self._recorders.scalars.absolute_work,
            cost,
        )
        found = [
            *remarks_of_summary(self.configuration, summary, arrays),
            *convergence.remarks(self.configuration, arrays, summary),
        ]
        return Result(self.configuration, summary, arrays, (*self.remarks, *found))

    def _status(self, arrays: Mapping[str, Any]) -> str:
        if self.failure is not None:
            return self.failure.status
        if not self.configuration.pellet.enabled:
            return "finished"
        if self._recorders.expulsion.way is not None:
            return self._recorders.expulsion.way
        time, position = arrays["time_step"], arrays["pellet_position"]
        if time[-1] < ARREST_WINDOW:
            return "in_transit"
        moved = position[-1] - float(np.interp(time[-1] - ARREST_WINDOW, time, position))
        return "arrested" if abs(moved) < ARREST_TRAVEL else "in_transit"


@dataclass(frozen=True)
class _Clock:
    """How a run stands beside its state: the configuration with its changes, and how far it is to go."""

    configuration: str
    target: float
    stopped: str | None
    solver_seconds: float


def _hash_of_start(model: Model, state: State) -> str:
    """Hash of the state before t = 0 with V0 and the pellet-free tube: equal where runs are equal to the bit."""
    lumen = (model.lumen.reference_volume, float)
    content = pack({"state": (state, State), "free radius": (model.free_radius, np.ndarray), "V0": lumen})
    return hashlib.sha256(content).hexdigest()
