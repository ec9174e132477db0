"""Pictures of studies: what each parameter does, pairs of parameters, times; maps of classes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...plots import style
from ...plots.placing import whole_in_folder
from .cohort import Cohort
from .outputs import LABELS
from .sensitivity import Sensitivity
from .stall_map import StallMap
from .table import CLOCK, WITHOUT_RESULT, Table
from .variables import Variable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

Floats = NDArray[np.float64]

COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILION, style.PURPLE, style.SKY, style.YELLOW, style.GREY)
MOST_PANELS = 6
"""Outputs and parameters that are drawn; the table has all."""
BINS, FEWEST = 8, 5
"""Parts of a range over which a main effect is averaged, unless it has fewer levels; points that each has at least."""


def draw_sweep(table: Table, folder: Path) -> list[Path]:
    """Draw main effects, pairs and times of a study into a folder; the files. Raises WriteError."""
    drawings: dict[str, Callable[[], Canvas]] = {"effects": lambda: effects(table), "times": lambda: times(table)}
    if len(table.study.variables) > 1:
        drawings["pairs"] = lambda: pairs(table)
    return save(drawings, folder)


def draw_map(found: StallMap, folder: Path) -> list[Path]:
    """Draw a map of classes into a folder; the file. Raises WriteError."""
    return save({"map": lambda: class_map(found)}, folder)


def save(drawings: dict[str, Callable[[], Canvas]], folder: Path) -> list[Path]:
    """Write each drawing as FOLDER/NAME.png, whole; the files. Raises WriteError."""
    files: list[Path] = []
    with style.applied():
        for name, draw in drawings.items():
            files.append(folder / f"{name}.png")
            with whole_in_folder(files[-1]) as temporary:
                draw().savefig(temporary, dpi=style.DPI)
    return files


def canvas(width: float, height: float, title: str) -> Canvas:
    """An empty picture [inch] with a title."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def effects(table: Table) -> Canvas:
    """Every output over every parameter: the points, and their mean at each level or over parts of the range."""
    variables, outputs = table.study.variables[:MOST_PANELS], table.study.outputs[:MOST_PANELS]
    size = (max(style.WIDTH, 2.4 * len(variables)), 0.6 + 2.1 * len(outputs))
    figure = canvas(*size, f"Main effects: {len(table)} points, means with their standard errors")
    panels = figure.subplots(len(outputs), len(variables), squeeze=False, sharey="row")
    for row, output in zip(panels, outputs, strict=True):
        results = table.output(output)
        row[0].set_ylabel(_folded(LABELS.get(output, output)))
        for axes, variable in zip(row, variables, strict=True):
            places = scale(axes, variable, table.values(variable.name), "x")
            axes.plot(places, results, ".", color=style.SKY, markersize=4, alpha=0.6, zorder=2)
            lost = ~np.isfinite(results)
            if lost.any():  # along the lower edge: there is no number to put them at
                axes.plot(
                    places[lost], np.full(lost.sum(), 0.02), "x", color=style.VERMILION, markersize=4,
                    transform=axes.get_xaxis_transform(), zorder=2,
                )  # fmt: skip
            _means(axes, variable, places, results)
            axes.grid(alpha=0.25)
    for axes, variable in zip(panels[-1], variables, strict=True):
        axes.set_xlabel(_folded(variable.label))
    if any(not np.isfinite(table.output(one)).all() for one in outputs):
        figure.supxlabel("crosses: points without this number", fontsize=8, x=0.99, ha="right")
    return figure


def _means(axes: Axes, variable: Variable, places: Floats, results: Floats) -> None:
    good = np.isfinite(results)
    if not good.any():
        return
    levels = np.unique(places)
    if levels.size > BINS and variable.distribution is not None:
        order = np.argsort(places[good], kind="stable")
        count = min(max(int(good.sum()) // FEWEST, 1), BINS)  # means of two or three points are noise
        parts = np.array_split(np.flatnonzero(good)[order], count)
    else:
        parts = [found for one in levels if (found := np.flatnonzero(good & (places == one))).size]
    middles = [float(np.mean(places[part])) for part in parts]
    means = [float(results[part].mean()) for part in parts]
    errors = [float(results[part].std(ddof=1) / np.sqrt(part.size)) if part.size > 1 else 0.0 for part in parts]
    axes.errorbar(middles, means, errors, color=style.BLACK, marker="o", markersize=3.5, capsize=2, zorder=3)


def pairs(table: Table) -> Canvas:
    """Every pair of parameters, points coloured by the first output; those without a number are crosses."""
    variables, output = table.study.variables[:MOST_PANELS], table.study.outputs[0]
    count, results = len(variables), table.output(table.study.outputs[0])
    good = np.isfinite(results)
    side = max(style.WIDTH, 1.9 * count)
    figure = canvas(side, 0.85 * side, f"Pairs of parameters; crosses: no {LABELS.get(output, output)}")
    panels = figure.subplots(count - 1, count - 1, squeeze=False)
    shown = None
    for i in range(count - 1):
        for j in range(count - 1):
            axes = panels[i, j]
            if j > i:
                axes.set_axis_off()
                continue
            across, up = variables[j], variables[i + 1]
            x = scale(axes, across, table.values(across.name), "x")
            y = scale(axes, up, table.values(up.name), "y")
            axes.plot(x[~good], y[~good], "x", color=style.VERMILION, markersize=4)
            if good.any():
                shown = axes.scatter(x[good], y[good], c=results[good], s=12, cmap="viridis")
            axes.set_xlabel(_folded(across.label) if i == count - 2 else "")
            axes.set_ylabel(_folded(up.label) if j == 0 else "")
    if shown is not None:
        figure.colorbar(shown, ax=panels, label=LABELS.get(output, output), shrink=0.8)
    return figure


def times(table: Table) -> Canvas:
    """How long runs took, and how they ended."""
    figure = canvas(style.WIDTH, 2.8, "Time to finish, and how runs ended")
    left, right = figure.subplots(1, 2)
    spent = [row.summary.get(CLOCK) for row in table.rows]
    known = [float(one) for one in spent if one]
    if known:
        left.hist(known, bins=20, color=style.SKY)
        left.axvline(
            float(np.median(known)), color=style.BLACK, linestyle="--", label=f"median {np.median(known):.2g} s"
        )
        left.legend()
    left.set_xlabel("time in the solver (s)")
    left.set_ylabel("runs")
    counted = table.statuses.most_common()
    colours = [style.VERMILION if one in WITHOUT_RESULT else style.SKY for one, _ in counted]
    right.barh([one.replace("_", " ") for one, _ in counted], [count for _, count in counted], 0.5, color=colours)
    right.set_ylim(-0.75, len(counted) - 0.25)
    right.invert_yaxis()
    right.set_xlabel("points")
    return figure


def class_map(found: StallMap) -> Canvas:
    """The class of every node as colour, the nodes that were run as dots, the boundaries between."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    names = sorted({one for row in found.refined.classes for one in row})
    numbers = np.array([[names.index(one) for one in row] for row in found.refined.classes])
    title = f"{found.runs} runs for {found.nodes} nodes; dots: nodes that were run"
    figure = canvas(style.WIDTH, 5.2, title)
    axes = figure.subplots()
    across, up = found.study.variables
    x, y = map(np.array, found.levels)
    colours = [COLOURS[k % len(COLOURS)] for k in range(len(names))]
    edges = [_edges(variable, axis) for variable, axis in zip((across, up), (x, y), strict=True)]
    kinds = ListedColormap(colours)
    axes.pcolormesh(*edges, numbers.T, cmap=kinds, vmin=-0.5, vmax=len(names) - 0.5, alpha=0.55, linewidth=0)
    run = np.array(sorted(found.refined.evaluated))
    axes.plot(x[run[:, 0]], y[run[:, 1]], ".", color=style.BLACK, markersize=2.5, clip_on=False)
    for axis, variable in (("x", across), ("y", up)):
        if variable.distribution is not None and variable.distribution.logarithmic:
            _logarithmic(axes, axis)
    axes.set_xlim(edges[0][0], edges[0][-1])
    axes.set_ylim(edges[1][0], edges[1][-1])
    axes.set_xlabel(across.label)
    axes.set_ylabel(up.label)
    handles = [Patch(color=colour, alpha=0.55, label=name) for colour, name in zip(colours, names, strict=True)]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(names), 5))
    return figure


AXES = {
    "total": "share of the variance (1)",
    "mean size": "mean size of effects, in the unit above",
    "median distance": "median distance (1)",
}
"""The index by which a method ranks, in words."""


def bars(found: Sensitivity) -> Canvas:
    """The ranking index of every parameter with its band, the largest on top, for every output."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    outputs = list(found.indices)[:MOST_PANELS]
    count = len(found.table.study.variables)
    columns = min(len(outputs), 2)
    rows = -(-len(outputs) // columns)
    title = f"Sensitivity, {found.method}: {len(found.table)} runs, bands of 95 %"
    figure = canvas(style.WIDTH, 1.0 + rows * (0.9 + 0.28 * count), title)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(outputs) :]:
        axes.set_axis_off()
    alone = False
    for axes, output in zip(panels, outputs, strict=False):
        ranked = found.ranked(output)
        names = [one.variable.replace("_", " ") for one in ranked]
        values = [one.value for one in ranked]
        first = {one.variable: one.value for one in found.indices[output] if one.name == "first"}
        axes.barh(names, values, color=style.SKY, height=0.6)
        below = [max(one.value - one.low, 0.0) for one in ranked]
        above = [max(one.high - one.value, 0.0) for one in ranked]
        axes.errorbar(values, names, xerr=[below, above], fmt="none", color=style.BLACK, capsize=3)
        if first:
            alone = True
            places = [first[one.variable] for one in ranked]
            axes.plot(places, names, "D", color=style.VERMILION, markersize=4, clip_on=False, zorder=4)
        axes.axvline(0.0, color=style.BLACK, linewidth=0.8)
        axes.invert_yaxis()
        axes.set_title(LABELS.get(output, output))
        axes.set_xlabel(AXES[found.ranks])
    if alone:  # beside the panels: a marker inside them would look like one more value
        handles: list[Patch | Line2D] = [Patch(color=style.SKY, label=f"{found.ranks}: with all interactions")]
        handles.append(Line2D([], [], color=style.VERMILION, marker="D", linestyle="", markersize=4, label="alone"))
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def draw_sensitivity(found: Sensitivity, folder: Path) -> list[Path]:
    """Draw the bars of a sensitivity into a folder; the file. Raises WriteError."""
    return save({"sensitivity": lambda: bars(found)}, folder)


def distributions(found: Cohort) -> Canvas:
    """Share of the accepted members that have expelled the pellet by a time, and shifts member by member."""
    count = len(found.shifts) - 1
    title = f"{found.accepted} members of {len(found.table)} drawn; a research model, not medical advice"
    figure = canvas(style.WIDTH, 3.8 + 0.2 * ((count + 2) // 2), title)
    left, *rest = figure.subplots(1, 2 if count else 1, squeeze=False)[0]
    last = max((float(np.nanmax(one)) for one in found.transits.values() if np.isfinite(one).any()), default=1.0)
    for k, (name, times_) in enumerate(found.transits.items()):
        there = np.sort(times_[np.isfinite(times_)])
        shares = np.arange(1, there.size + 1) / times_.size
        steps = (np.concatenate([[0.0], there, [1.05 * last]]), np.concatenate([[0.0], shares, shares[-1:]]))
        words = f"{name.replace('_', ' ')}: {there.size or 'none'} expelled"
        if there.size:
            left.step(*steps, where="post", color=COLOURS[k % len(COLOURS)], label=words)
        else:
            left.plot([], [], color=COLOURS[k % len(COLOURS)], label=words)
    if found.slow is not None:
        left.axvline(found.slow, color=style.GREY, linestyle=":", label="slow beyond")
    left.set_xlim(0.0, 1.05 * last)
    left.set_ylim(0.0, 1.02)
    left.set_xlabel("transit time (s)")
    left.set_ylabel("share of members that expelled")
    left.grid(alpha=0.25)
    figure.legend(loc="outside lower center", ncols=2)  # curves rise anywhere: beside the panels it hides none
    for axes in rest:
        before = found.transits[found.shifts[0].name]
        named = [name for name in found.transits if name != found.shifts[0].name]
        moved = [(found.transits[name] - before)[np.isfinite(found.transits[name] - before)] for name in named]
        axes.axvline(0.0, color=style.GREY, linewidth=0.8)
        labels = [_folded(name.replace("_", " "), 14) for name in named]
        axes.boxplot(moved, orientation="horizontal", tick_labels=labels, widths=0.5, showfliers=True)
        axes.set_xlabel("shift of transit, member by member (s)")
        axes.invert_yaxis()
    return figure


def draw_cohort(found: Cohort, folder: Path) -> list[Path]:
    """Draw transits and shifts of a cohort into a folder; the file. Raises WriteError."""
    return save({"cohort": lambda: distributions(found)}, folder)


def _edges(variable: Variable, axis: Floats) -> Floats:
    """Borders halfway between nodes on the scale of a parameter; the outer ones at the ends."""
    log = variable.distribution is not None and variable.distribution.logarithmic
    middles = np.sqrt(axis[1:] * axis[:-1]) if log else 0.5 * (axis[1:] + axis[:-1])
    return np.concatenate([axis[:1], middles, axis[-1:]])


def scale(axes: Axes, variable: Variable, values: Sequence[Any], axis: str) -> Floats:
    """Places of values along an axis, which gets the scale of the parameter; texts are put side by side."""
    if not all(isinstance(one, int | float) and not isinstance(one, bool) for one in values):
        names = list(dict.fromkeys(map(str, values)))
        getattr(axes, f"set_{axis}ticks")(range(len(names)), names)
        return np.array([float(names.index(str(one))) for one in values])
    if variable.distribution is not None and variable.distribution.logarithmic:
        _logarithmic(axes, axis)
    return np.array(values, dtype=np.float64)


def _logarithmic(axes: Axes, axis: str) -> None:
    """A logarithmic scale with plain numbers: ranges of parameters seldom span several powers of ten."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    getattr(axes, f"set_{axis}scale")("log")
    one = axes.xaxis if axis == "x" else axes.yaxis
    one.set_major_locator(LogLocator(base=10.0, subs=(1.0, 2.0, 5.0)))
    one.set_major_formatter(StrMethodFormatter("{x:g}"))
    one.set_minor_formatter(NullFormatter())


def _folded(text: str, most: int = 24) -> str:
    """A label in as many lines as it needs."""
    import textwrap

    return "\n".join(textwrap.wrap(text.replace(".", ". "), most)).replace(". ", ".")
