"""Pictures of a fit: tracks and residuals, profiles of the likelihood, and where the other parameters went."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...plots import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .solution import Fit

COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY, style.GREY)


def fit_figure(found: Fit) -> Figure:
    """Above, tracks and residuals; below, a profile a parameter, and how the second follows the first."""
    from matplotlib.figure import Figure

    free = found.problem.free
    below = len(found.profiles) + (len(free) > 1) if found.profiles else 0
    columns = max(2, below)
    with style.applied():
        figure = Figure(figsize=(3.7 * columns, 3.2 * (1 + bool(below))), dpi=style.DPI, layout="constrained")
        grid = figure.add_gridspec(1 + bool(below), columns)
        _tracks(figure.add_subplot(grid[0, : columns - 1]), found)
        _residuals(figure.add_subplot(grid[0, columns - 1]), found)
        for number, name in enumerate(found.profiles):
            _profile(figure.add_subplot(grid[1, number]), found, name)
        if found.profiles and len(free) > 1:
            _path(figure.add_subplot(grid[1, len(found.profiles)]), found)
        figure.suptitle(f"fit: {found.status}", x=0.01, ha="left")
    return figure


def _tracks(axes: Axes, found: Fit) -> None:
    begin = 0
    for number, one in enumerate(found.problem.observed):
        colour = COLOURS[number % len(COLOURS)]
        own = found.residuals[begin : begin + one.time.size]
        begin += one.time.size
        axes.plot(one.time, 10.0 * one.place, "o", color=colour, markersize=3.0, label=f"{one.name}, observed")
        axes.plot(one.time, 10.0 * (one.place + own), color=colour, linewidth=1.2, label="model")
    axes.set(xlabel="time (s)", ylabel="place of the pellet (mm)")
    axes.legend(fontsize=7.0)
    axes.grid(alpha=0.25)


def _residuals(axes: Axes, found: Fit) -> None:
    begin = 0
    for number, one in enumerate(found.problem.observed):
        own = found.residuals[begin : begin + one.time.size]
        begin += one.time.size
        axes.plot(one.time, 10.0 * own, "o-", color=COLOURS[number % len(COLOURS)], markersize=2.5, linewidth=0.6)
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.set(xlabel="time (s)", ylabel="model less observed (mm)")
    axes.grid(alpha=0.25)


def _profile(axes: Axes, found: Fit, name: str) -> None:
    free = next(one for one in found.problem.free if one.name == name)
    drawn = found.profiles[name]
    values = [free.value(x) for x in drawn.coordinates]
    axes.plot(values, drawn.rise, "o-", color=style.BLUE, markersize=3.5, label="profile")
    if found.covariance is not None:
        k = [one.name for one in found.problem.free].index(name)
        fine = np.linspace(drawn.coordinates[0], drawn.coordinates[-1], 100)
        parabola = (fine - found.x[k]) ** 2 / max(float(found.covariance[k, k]), 1e-300)
        axes.plot([free.value(x) for x in fine], parabola, ":", color=style.GREY, label="by curvature")
    axes.axhline(found.accepted, color=style.VERMILION, linestyle="--", linewidth=1.0, label="95 %")
    axes.set_ylim(0.0, 3.0 * found.accepted)
    axes.set(xlabel=f"{_short(name)} ({free.unit})", ylabel="rise of squares / noise variance")
    axes.legend(fontsize=7.0)
    axes.grid(alpha=0.25)


def _path(axes: Axes, found: Fit) -> None:
    """Where the second parameter goes while the first is held: a line says that they stand in for one another."""
    first, second = found.problem.free[:2]
    for k, (held, colour) in enumerate(((first, style.BLUE), (second, style.GREEN))):
        points = found.profiles[held.name].others
        axes.plot(
            [first.value(x) for x in points[:, 0]],
            [second.value(x) for x in points[:, 1]],
            "o-" if k == 0 else "s--",
            color=colour,
            markersize=3.5,
            label=f"{_short(held.name)} held",
        )
    axes.plot(found.estimates[0].value, found.estimates[1].value, "*", color=style.VERMILION, markersize=11)
    axes.set(xlabel=f"{_short(first.name)} ({first.unit})", ylabel=f"{_short(second.name)} ({second.unit})")
    axes.legend(fontsize=7.0)
    axes.grid(alpha=0.25)


def _short(name: str) -> str:
    """Tied keys by their last word, where they share it."""
    parts = name.split("+")
    lasts = {part.rpartition(".")[2] for part in parts}
    return lasts.pop().replace("_", " ") if len(lasts) == 1 else name
