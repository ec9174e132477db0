"""What figures of reports share: canvas, colours, tracks of the pellet, searches, which runs can be drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..many.rows import Row
from ..plots import style
from .outcome import Outcome
from .searches import Search

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

Floats = NDArray[np.float64]

COLOURS = (
    style.BLACK,
    style.ORANGE,
    style.SKY,
    style.GREEN,
    style.VERMILION,
    style.BLUE,
    style.PURPLE,
    style.GREY,
)
LINES = ("-", "--", "-.", ":")
ABREAST = 4
"""So many panels stand beside one another; more follow below."""


def colour(number: int) -> str:
    """Of a condition by its place; the colours come again after the last."""
    return COLOURS[number % len(COLOURS)]


def curve(number: int, label: str) -> dict[str, str]:
    """How the line of a condition is drawn, by its place: conditions of one colour differ in their dashes."""
    return {"color": colour(number), "linestyle": LINES[number // len(COLOURS) % len(LINES)], "label": label}


def canvas(width: float, height: float, title: str) -> Canvas:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=style.DPI, layout="constrained")
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def usable(outcome: Outcome, name: str) -> Row | None:
    record = outcome.records.get(name)
    return record if record is not None and "time_step" in record.arrays else None


def ending(record: Row) -> str:
    transit = record.summary.get("transit_s")
    return f"{transit:.2f} s" if transit is not None else record.status.replace("_", " ")


def tracks(axes: Axes, outcome: Outcome, runs: Mapping[str, str]) -> None:
    """Position of the pellet over time, one line for each run; runs: name to label."""
    for number, (name, label) in enumerate(runs.items()):
        record = usable(outcome, name)
        if record is None:
            refused = outcome.records.get(name)
            axes.plot([], [], " ", label=f"{label}: {refused.status if refused else 'not run'}")
            continue
        axes.plot(
            record.arrays["time_step"],
            record.arrays["pellet_position"],
            color=colour(number),
            linestyle=LINES[number % len(LINES)],
            label=f"{label}: {ending(record)}",
        )
    ends = [float(found.arrays["z"][-1]) for name in runs if (found := usable(outcome, name)) is not None]
    if ends:
        axes.set_ylim(0.0, max(ends))
    axes.set_xlim(left=0.0)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("pellet's centre (cm)")
    axes.set_title(f"reading {outcome.condition.title}")
    axes.grid(alpha=0.25)
    axes.legend(fontsize=7.5, loc="best")


def tracks_figure(title: str, runs: Mapping[str, str]) -> Callable[[Sequence[Outcome]], Canvas]:
    def draw(outcomes: Sequence[Outcome]) -> Canvas:
        figure, panels = beside(len(outcomes), 4.6, 4.2, title)
        for axes, outcome in zip(panels, outcomes, strict=True):
            tracks(axes, outcome, runs)
        return figure

    return draw


def beside(count: int, width: float, height: float, title: str) -> tuple[Canvas, list[Axes]]:
    """A canvas with a panel for each of so many conditions, in rows of ABREAST. width, height: of one, in inches."""
    columns, rows = min(count, ABREAST), -(-count // ABREAST)
    figure = canvas(max(7.4, width * columns), height * rows, title)
    panels: list[Axes] = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for axes in panels[count:]:
        axes.set_axis_off()
    return figure, panels[:count]


def thresholds_figure(searches: Mapping[str, Search]) -> Callable[[Sequence[Outcome]], Canvas]:
    """Mean velocity over each searched parameter, with the bracket."""

    def draw(outcomes: Sequence[Outcome]) -> Canvas:
        rows = -(-len(searches) // 2)
        figure = canvas(11.0, 3.4 * rows, "Thresholds: mean velocity over the parameter; shaded: the bracket")
        panels = list(figure.subplots(rows, 2, squeeze=False).ravel())
        for axes in panels[len(searches) :]:
            axes.set_axis_off()
        for axes, (name, search) in zip(panels, searches.items(), strict=False):
            for index, outcome in enumerate(outcomes):
                found = outcome.thresholds.get(name)
                if found is None:
                    continue
                speeds = []
                for point in found.points:
                    record = outcome.records.get(search.run(point.value).name)
                    speed = record.summary.get("mean_velocity_cm_s") if record is not None else None
                    speeds.append(np.nan if speed is None else speed)
                values = [point.value for point in found.points]
                axes.plot(values, speeds, marker="o", markersize=4, **curve(index, outcome.condition.title))
                if found.low is not None and found.high is not None:
                    axes.axvspan(found.low, found.high, color=colour(index), alpha=0.25)
            if search.key != "ratio":
                axes.set_xscale("log")
            unit = "" if search.unit == "1" else f" ({search.unit})"
            axes.set_xlabel(f"{'R / r0' if search.key == 'ratio' else search.key}{unit}")
            axes.set_ylabel("mean velocity (cm/s)")
            axes.set_title(search.title)
            axes.grid(alpha=0.25)
        panels[0].legend(fontsize=8)
        return figure

    return draw
