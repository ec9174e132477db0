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
            color=COLOURS[number % len(COLOURS)],
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
        figure = canvas(max(7.4, 4.6 * len(outcomes)), 4.2, title)
        for axes, outcome in zip(row(figure, len(outcomes)), outcomes, strict=True):
            tracks(axes, outcome, runs)
        return figure

    return draw


def row(figure: Canvas, count: int) -> list[Axes]:
    panels = figure.subplots(1, count, squeeze=False)
    return list(panels[0])


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
                axes.plot(values, speeds, "o-", color=COLOURS[index], label=outcome.condition.title, markersize=4)
                if found.low is not None and found.high is not None:
                    axes.axvspan(found.low, found.high, color=COLOURS[index], alpha=0.25)
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
