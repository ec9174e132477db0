"""What the figures of the paper share: canvas, colours, tracks of the pellet, which runs can be drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..many.rows import Row
from ..plots import style
from .experiments import Outcome

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
    axes.set_ylim(0.0, 10.0)
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
