"""What happened when: starts of stimuli, sticking and slipping, contact, the ends of the segment, changed inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..model.ends import ANALLY, ORALLY, passages
from ..model.friction import rests_on_end, sliding_speed
from ..model.model import Model
from ..model.report import StepReport
from ..model.state import State

KINDS = (
    "pacemaker",
    "stimulus",
    "trigger",
    "receptors",
    "slip",
    "stick",
    "contact_lost",
    "contact_made",
    "expelled",
    "oral_end",
    "end_reached",
    "expelled_orally",
    "input_changed",
    "stopped",
    "step_halved",
)
QUIET_TIME = 0.05
"""A trigger event is the first firing after this long without one [s]; what runs on from it is the wave."""


class Event(NamedTuple):
    """One event: time [s], kind (one of KINDS), place from the oral end [cm] or nan, and a few words."""

    time: float
    kind: str
    place: float
    words: str


@dataclass
class EventRecorder:
    """Collects the events of a run by comparing the two ends of every step."""

    events: list[Event] = field(default_factory=list)
    _last_trigger: float = -np.inf
    _left: list[str] = field(default_factory=list)

    def start(self, model: Model, state: State) -> None:
        """Nothing has happened before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Note what this step brought."""
        time = after.step * model.dt_wall
        if report.halved:
            self.note(time, "step_halved", math.nan, f"the step was made in parts: {report.halved}")
        for part in report.made_of(model, before, after):
            time = part.after.step * part.model.dt_wall
            self._stimuli(*part, time)
            if model.pellet.present:
                self._pellet(*part, time)
                self._ends(*part)
        return None

    def note(self, time: float, kind: str, place: float, words: str) -> None:
        """Add an event seen elsewhere."""
        self.events.append(Event(time, kind, place, words))

    def _stimuli(self, model: Model, before: State, after: State, time: float) -> None:
        start = before.step * model.dt_wall
        for layer in ("longitudinal", "circular"):
            for source in after.sources:
                for pulse in getattr(source, layer):
                    if start <= pulse.begin < time:
                        middle = 0.5 * (pulse.low + pulse.high)
                        self.note(pulse.begin, "pacemaker", middle, f"pulse on the {layer} layer")
        for layer, pulses in (("longitudinal", model.stimuli_longitudinal), ("circular", model.stimuli_circular)):
            for pulse in pulses.between(start, time):
                if start <= pulse.begin < time:
                    middle = 0.5 * (pulse.low + pulse.high)
                    words = f"{pulse.strength:g} uA/cm^2 for {pulse.end - pulse.begin:g} s on the {layer} layer"
                    self.note(pulse.begin, "stimulus", middle, words)
        # Where no cell fires the array is mostly the same one, and need not be looked at.
        same = after.trigger.start is before.trigger.start
        fired: Any = () if same else np.flatnonzero((after.trigger.start != before.trigger.start).any(axis=1))
        if len(fired) > 0:
            if time - self._last_trigger > QUIET_TIME:
                place = float(model.grid.cells[fired[0]])
                self.note(time, "trigger", place, f"the circular layer is started (rule {model.trigger.rule})")
            self._last_trigger = time
        if after.reflex.fired != before.reflex.fired:
            words = "mechanoreceptors discharge: excitation above, inhibition below the pellet"
            self.note(time, "receptors", after.pellet.position, words)

    def _pellet(self, model: Model, before: State, after: State, time: float) -> None:
        slides = [sliding_speed(model, state.pellet) != 0.0 for state in (before, after)]
        touches = [bool(state.wall.contact.max() > 0.0) for state in (before, after)]
        place = after.pellet.position
        if slides[1] and not slides[0]:
            self.note(
                time, "slip", place, f"the axial force of {after.pellet.axial_force:.1f} mN overcomes dry friction"
            )
        elif slides[0] and not slides[1]:
            self.note(time, "stick", place, "dry friction holds the pellet")
        if touches[0] and not touches[1]:
            self.note(time, "contact_lost", place, "the wall no longer touches the pellet")
        elif touches[1] and not touches[0]:
            self.note(time, "contact_made", place, "the wall touches the pellet again")

    def _ends(self, model: Model, before: State, after: State) -> None:
        place = after.pellet.position
        if model.pellet.oral < place < model.grid.span - model.pellet.anal:
            return
        found = passages(model, before, after)
        if found.oral_pole is not None:
            self.note(found.oral_pole, "oral_end", place, "the oral pole of the pellet passes the oral end")
        if rests_on_end(model, after.pellet) and not rests_on_end(model, before.pellet):
            end = "oral" if place <= model.pellet.lowest else "anal"
            self.note(after.step * model.dt_wall, "end_reached", place, f"the closed {end} end holds the pellet")
        for moment, kind in ((found.anal, ANALLY), (found.oral, ORALLY)):
            if moment is not None and kind not in self._left:
                self._left.append(kind)
                self.note(moment, kind, place, kind.replace("_", " "))
