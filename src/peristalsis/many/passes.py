"""Repeated passes, or a train of pellets: one pellet at a time, each on the tissue that the one before left."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from .. import scenarios, units
from ..control.pulses import listed
from ..errors import ConfigurationError
from ..inputs.build import build
from ..inputs.config import Configuration
from ..inputs.protocols import values_at
from ..inputs.recording import whole_steps
from ..model.model import Model
from ..model.state import State
from ..results.measures import speed_between
from ..results.result import Result
from ..running.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MIDDLE = 3.0 / 14.0
"""Half of the stretch in the middle of the segment over which speed is taken, as a share of it: 1.5 of 7 cm."""
MOVING = 0.01
"""Speed of the wall at the beginning of a pass from which it is said that it still moves [cm/s]."""
MOST = 1000
"""Passes of one series."""


@dataclass(frozen=True)
class Pass:
    """One pass: when it began, and what came of it.

    begins: since the beginning of the first [s]. speed: mean over the middle 3/7 of the segment [cm/s]. drive: the
    largest drive of either layer as it began [mV]; narrowest: the least radius of the wall then [cm]. result: its run,
    at whose time 0 it began.
    """

    number: int
    begins: float
    speed: float
    drive: float
    narrowest: float
    result: Result

    def row(self) -> dict[str, Any]:
        """Its numbers by name, each with its unit in it."""
        summary = self.result.summary
        return {
            "pass": self.number,
            "begins_s": round(self.begins, 9),
            "status": self.result.status,
            "transit_s": summary["transit_s"],
            "mean_velocity_cm_s": summary["mean_velocity_cm_s"],
            "middle_speed_cm_s": self.speed,
            "max_axial_force_mN": summary["max_axial_force_mN"],
            "drive_at_begin_mV": self.drive,
            "narrowest_at_begin_cm": self.narrowest,
        }


@dataclass(frozen=True)
class Passes:
    """A series of passes; rest: between the end of each and the beginning of the next [s]."""

    rest: float
    passes: tuple[Pass, ...]

    def rows(self) -> list[dict[str, Any]]:
        """One row a pass."""
        return [one.row() for one in self.passes]

    def csv(self) -> str:
        """The rows as CSV text; a number that is not there is empty."""
        return passes_csv(self.passes)

    def figure(self) -> Figure:
        """Place of the pellet over the time since the first began, and speed and force of every pass."""
        from matplotlib.figure import Figure

        from ..plots import style

        numbers = [one.number for one in self.passes]
        with style.applied():
            figure = Figure(figsize=(1.35 * style.WIDTH, 3.6), dpi=style.DPI, layout="constrained")
            figure.suptitle(f"{len(numbers)} passes with {self.rest:g} s of rest between them", x=0.01, ha="left")
            along, across = figure.subplots(1, 2, width_ratios=(2, 1))
            for one in self.passes:
                arrays = one.result.arrays
                along.plot(one.begins + arrays["time_step"], 10.0 * arrays["pellet_position"], color=style.BLUE)
            along.set(xlabel="time since the first pass began (s)", ylabel="place of the pellet (mm)")
            across.plot(numbers, [10.0 * one.speed for one in self.passes], "o-", color=style.BLUE)
            across.set(xlabel="pass", ylabel="speed in the middle (mm/s)", xticks=numbers[:: 1 + len(numbers) // 12])
            across.set_ylim(0.0, 12.0 * max((one.speed for one in self.passes), default=0.0) or 1.0)
            for axes in (along, across):
                axes.grid(alpha=0.25)
        return figure


def passes_csv(several: Sequence[Pass]) -> str:
    """Rows of one pass or more as CSV text; a number that is not there is empty."""
    text = io.StringIO()
    rows = [one.row() for one in several]
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: "" if value is None else value for name, value in row.items()} for row in rows)
    return text.getvalue()


def passes(
    scenario: str | Configuration = "guinea_pig",
    changes: Mapping[str, Any] | None = None,
    count: int = 3,
    rest: str = "60 s",
    progress: Callable[[Pass], None] | None = None,
) -> Passes:
    """Pass a pellet through the same segment again and again; the next one enters when the one before is out.

    At the end of a pass the pellet is taken out, wherever it is. For `rest`, such as "60 s", the tube is empty and open
    to the bath, its cells and wall go on, and nothing paces. Then the next pellet is put in, Eq. (105), and pacing and
    protocols begin anew. A run that breaks off ends the series. progress: told of every pass. Raises
    ConfigurationError for what has no passes, and DivergenceError if a pellet cannot be put in.
    """
    configuration = scenario if isinstance(scenario, Configuration) else scenarios.configuration(scenario)
    if changes:
        configuration = configuration.with_changes(changes)
    seconds = _checked(configuration, count, rest)
    found: list[Pass] = []
    simulation, begins = Simulation(configuration), 0.0
    while True:
        one = _passed(simulation, len(found) + 1, begins)
        found.append(one)
        if progress is not None:
            progress(one)
        if len(found) == count or simulation.failure is not None:
            return Passes(seconds, tuple(found))
        state = rested(simulation.model, simulation.state, configuration, seconds)
        begins += state.step * simulation.model.dt_wall
        simulation = NextPass(configuration, simulation.model, state, len(found) + 1)


class NextPass(Simulation):
    """A run that begins on the tissue and the wall that another left.

    before: the model of that one. left: its state, without its pellet. number: of the pass.
    """

    def __init__(self, configuration: Configuration, before: Model, left: State, number: int) -> None:
        self._before, self._left, self._number = before, left, number
        super().__init__(configuration)

    def _beginning(self, model: Model) -> tuple[Model, State, list[str]]:
        complete = replace(model, free_radius=self._before.free_radius)
        found = model.binding.module("model.insertion").inserted(complete, self._left)
        remarks = [
            f"pass {self._number} of a series: it begins on the tissue that the one before left, and its configuration "
            "alone does not repeat it"
        ]
        if found.speed > MOVING:
            remarks.append(
                f"pass {self._number}: the wall still moves at up to {10.0 * found.speed:.2g} mm/s as it begins; its "
                "speed is lost there"
            )
        return found.model, found.state, remarks


def rested(model: Model, state: State, configuration: Configuration, seconds: float) -> State:
    """The state after the pellet was taken out and the empty tube left alone for a time [s]; model: with the pellet."""
    at_start = configuration.at_time(values_at(configuration.time_courses(), 0.0))
    alone = at_start.with_changes({"pellet.enabled": False, "lumen.adiabatic_exponent": 0.0, "protocols": []})
    none = listed(())
    empty = replace(build(alone, like=model), sources=(), stimuli_longitudinal=none, stimuli_circular=none)
    advance = empty.binding.module("model.stepping").advance_run
    left: State = model.binding.module("model.insertion").emptied(state)
    for _ in range(whole_steps(seconds, empty.dt_wall)):
        left = advance(empty, left)[0]
    return left


def _passed(simulation: Simulation, number: int, begins: float) -> Pass:
    """Carry a pass to its end and measure it."""
    drive, rho = simulation.state.wall.drive, simulation.state.wall.position[:, :, 0]
    at_begin = float(drive.max()), float(rho.min())
    result = simulation.run()
    time, place = result.arrays["time_step"], result.arrays["pellet_position"]
    span = result.configuration.wall.span
    speed = speed_between(time, place, (0.5 - MIDDLE) * span, (0.5 + MIDDLE) * span)
    return Pass(number, begins, speed, *at_begin, result)


def _checked(configuration: Configuration, count: int, rest: str) -> float:
    """The rest [s]. Raises ConfigurationError for what has no passes."""
    seconds = units.parse(rest, "s", "rest")
    if seconds < 0.0:
        raise ConfigurationError(f"rest = {seconds:g} s: the next pellet cannot enter before; give 0 s or more")
    if not 1 <= count <= MOST:
        raise ConfigurationError(f"count = {count}: not a number of passes; choose 1 to {MOST}")
    refused = {
        "pellet.enabled = false: there is nothing to pass": not configuration.pellet.enabled,
        "pellet.held = true: a held pellet does not pass": configuration.pellet.held,
        "solver.integrator = explicit: passes are stepped implicitly": configuration.solver.integrator == "explicit",
        f"grid.n_theta = {configuration.grid.n_theta}: passes are there for one column": configuration.grid.n_theta > 1,
    }
    for words, bad in refused.items():
        if bad:
            raise ConfigurationError(f"{words}; change it, or make single runs")
    return seconds
