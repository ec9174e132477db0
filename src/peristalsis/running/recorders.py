"""What every run records and watches, together: the recorders, the expulsion, the conditions of its end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..inputs.config import Configuration
from ..inputs.config.fields import Run
from ..inputs.recording import chosen, frames_apart, probe_names
from ..model.model import Model
from ..model.state import State
from ..names import ACTIVATION, EVENTS
from ..results.moment import Moment
from .events import Event, EventRecorder
from .observers import Expulsion, FieldRecorder, Observer, ProbeRecorder, ScalarRecorder, StopConditions, read_off
from .upstrokes import UpstrokeRecorder, wave_columns


class Recorders:
    """Those of one run, as its configuration asks for them."""

    def __init__(self, configuration: Configuration, model: Model) -> None:
        every = frames_apart(configuration.output.interval, model.dt_wall)
        probes = np.array(configuration.output.probes, dtype=float)
        cells = np.clip((probes / model.grid.cell_size).astype(np.int64), 0, model.grid.n_z - 1)
        run = configuration.run
        self.scalars = ScalarRecorder()
        self.fields = FieldRecorder(every, chosen(configuration.output.fields, configuration.cells()))
        self.probes = ProbeRecorder(cells, probe_names(configuration.cells()))
        self.events = EventRecorder()
        self.upstrokes = UpstrokeRecorder()
        self.expulsion = Expulsion(run.stop_when_expelled)
        self.stops = StopConditions(run.stop_position, run.stop_when_arrested)

    @property
    def all(self) -> tuple[Observer, ...]:
        """Every one, in the order in which they see a step."""
        return (
            self.scalars,
            self.fields,
            self.probes,
            self.events,
            self.upstrokes,
            self.expulsion,
            self.stops,
        )

    def take_back(self, arrays: Mapping[str, Any], dt: float) -> None:
        """Hold again what a stored run with steps of dt [s] had recorded."""
        self.scalars.take_back(arrays)
        self.probes.take_back(arrays)
        self.fields.take_back(np.rint(arrays["time"] / dt).astype(np.int64).tolist(), arrays)

    def end_otherwise(self, run: Run, model: Model) -> list[tuple[int, str]]:
        """Take other conditions of ending; step and reason of the ends that the run so far would have had with them."""
        self.expulsion.stop = run.stop_when_expelled
        self.stops.position, self.stops.when_arrested = run.stop_position, run.stop_when_arrested
        endings: list[tuple[int, str]] = []
        if self.expulsion.stop and self.expulsion.way is not None:
            left = self.expulsion.time if self.expulsion.time is not None else self.expulsion.oral_time
            assert left is not None
            endings.append((math.ceil(left / model.dt_wall - 1e-9), self.expulsion.way))
        if model.pellet.present:
            met = self.stops.replayed(model.dt_wall, self.scalars.columns()["pellet_position"].tolist())
            endings += [] if met is None else [met]
        return endings

    def forget_stop(self, reason: str) -> None:
        """Take back the event that the run was stopped for this reason."""
        events = self.events.events
        self.events.events = [one for one in events if one.kind != "stopped" or one.words != reason]

    def arrays(self, model: Model, state: State, acceptable: bool, events: Sequence[Event]) -> dict[str, Any]:
        """Everything recorded so far by name; the state now is a frame of it where it is acceptable."""
        grid, dt = model.grid, model.dt_wall
        steps, frames = self.fields.recorded(model, state if acceptable else None)
        arrays: dict[str, Any] = {
            "time": np.array(steps) * dt,
            "time_step": np.arange(len(self.scalars.rows)) * dt,
            "z": grid.nodes.copy(),
            "z_cell": grid.cells.copy(),
            "theta": grid.shown_columns.copy(),
            "theta_cell": grid.cell_columns.copy(),
            "probe": grid.cells[self.probes.cells],
        }
        once = tuple(output.name for output in ACTIVATION)
        arrays |= dict(zip(once, read_off(once, Moment(model, state)), strict=True))
        arrays |= {name: np.stack(stored) for name, stored in frames.items()}
        arrays |= self.scalars.columns()
        arrays |= self.probes.columns()
        arrays |= wave_columns(self.upstrokes.waves(grid.cells))
        for output in EVENTS:
            found = [output.value(event) for event in events if output.value is not None]
            arrays[output.name] = np.array(found, dtype=float if output.unit else object)
        return arrays


def without_history(part: Any) -> Any:
    """A part of a checkpoint without what the result of the run holds; any other as it is."""
    match part:
        case ScalarRecorder():
            return replace(part, rows=[])
        case ProbeRecorder():
            return replace(part, rows=[])
        case FieldRecorder():
            return replace(part, steps=[], frames={})
    return part
