"""The tube at a few times, cut along its axis: wall, tension, contact pressure, pellet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import data, style
from ..data import Floats
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

PRESSURE_HEIGHT = 4.0
"""Height of the band that shows the largest contact pressure of the run [mm]."""


def tension_colours(result: Result) -> tuple[Colormap, Any]:
    """Colours and scale of the circumferential tension [N/cm]; the palest end, lost on white, is left out."""
    import matplotlib
    from matplotlib.colors import ListedColormap, PowerNorm

    tension = data.cut(result, "tension_circumferential", "N/cm")
    cmap = ListedColormap(matplotlib.colormaps["magma"](np.linspace(0.05, 0.82, 256)), name="tension")
    return cmap, PowerNorm(0.5, 0.0, max(0.01, float(tension.max())))


def segments(axial: Floats, height: Floats) -> Floats:
    """Both halves of a wall, each (2, n), as line segments, shape (2 (n - 1), 2, 2); upper half first."""
    halves = np.stack([axial, height], axis=-1)
    return np.concatenate([np.stack([half[:-1], half[1:]], axis=1) for half in halves])


def segment_values(nodes: Floats) -> Floats:
    """A field on the nodes of both halves, (2, n), as values of `segments`."""
    return np.asarray(0.5 * (nodes[:, 1:] + nodes[:, :-1])).ravel()


def height(result: Result) -> float:
    """Half height of a panel [mm]: the widest wall or pellet, and the band of contact pressure."""
    widest = float(np.abs(data.profile(result)).max())
    return widest + 1.5 + (PRESSURE_HEIGHT if data.has_pellet(result) else 0.0)


def largest_pressure(result: Result) -> float:
    """Largest stored contact pressure of the run [kPa], at least 0.1."""
    return max(0.1, float(np.nan_to_num(data.cut(result, "contact_pressure")).max()))


def panel(axes: Axes, result: Result, frame: int, cmap: Colormap, norm: Any) -> Any:
    """One time; returns the coloured wall for a colour bar."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    axial = data.cut(result, "axial_position", "mm")[:, frame]
    shape = data.profile(result)[:, frame]
    if data.has_pellet(result):
        centre = float(data.at_frames(result, "pellet_position", "mm")[frame])
        axes.add_patch(Polygon(data.pellet_outline(result, centre), facecolor="0.82", edgecolor="0.4", linewidth=0.8))
        axes.plot([centre], [0.0], "+", color="0.3", markersize=5, markeredgewidth=0.9)
        pressure = np.nan_to_num(data.cut(result, "contact_pressure")[:, frame])
        for side in (0, 1):
            _pressure_band(axes, result, axial[side], shape[side], centre, pressure[side] / largest_pressure(result))
    wall = LineCollection(list(segments(axial, shape)), cmap=cmap, norm=norm, linewidths=2.0, capstyle="round")
    wall.set_array(segment_values(data.cut(result, "tension_circumferential", "N/cm")[:, frame]))
    axes.add_collection(wall)
    axes.set_aspect("equal")
    half = height(result)
    axes.set_ylim(-half, half)
    axes.set_yticks([-10.0, 0.0, 10.0], ["10", "0", "10"])
    style.axis_right(axes, result, None)
    return wall


def _pressure_band(axes: Axes, result: Result, axial: Floats, shape: Floats, centre: float, pressure: Floats) -> None:
    """Contact pressure, as a share of the largest: a band outside one side of the wall, along the pellet's normal."""
    touching = np.flatnonzero(pressure > 0.0)
    for part in np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1):
        if part.size < 2:
            continue
        x, y = axial[part], shape[part]
        out = PRESSURE_HEIGHT * pressure[part]
        up, along = data.pellet_shape(result).normals(0.1 * np.abs(y), 0.1 * (x - centre))
        up = np.copysign(up, y)
        axes.fill(
            np.concatenate([x, (x + out * along)[::-1]]),
            np.concatenate([y, (y + out * up)[::-1]]),
            facecolor=style.SKY,
            edgecolor=style.BLUE,
            linewidth=0.5,
        )


def draw(result: Result, times: Sequence[float] | None = None) -> Canvas:
    """The tube at `times` [s], by default at six of even spacing over the run."""
    from matplotlib.ticker import MaxNLocator

    frames = data.spread_frames(result, 6) if times is None else data.frames_at(result, times)
    cmap, norm = tension_colours(result)
    columns = min(2, len(frames))
    rows = -(-len(frames) // columns)
    tall = 2.0 * height(result) / data.span(result) * 6.6 / columns
    figure = style.canvas(result, 1.35 + rows * (0.34 + tall), "Shape of the tube")
    figure.get_layout_engine().set(wspace=0.06)  # the ends' labels of neighbours must not touch
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.ravel()[: len(frames)])
    for spare in grid.ravel()[len(frames) :]:
        spare.set_axis_off()
    stored = data.values(result, "time")
    for axes, frame in zip(panels, frames, strict=True):
        wall = panel(axes, result, frame, cmap, norm)
    for axes in grid[-1]:
        axes.set_xlabel("axial position (mm)")
    for axes in grid[:, 0]:
        axes.set_ylabel("radius (mm)")
    style.letters(panels, [f"t = {stored[frame]:.2f} s" for frame in frames])
    bar = figure.colorbar(wall, ax=list(grid.ravel()), location="bottom", aspect=50, pad=0.02, fraction=0.05)
    bar.locator = MaxNLocator(6)
    bar.set_label("circumferential tension (N/cm)")
    if data.has_pellet(result):
        _pressure_scale(panels[0], result)
    return figure


def _pressure_scale(axes: Axes, result: Result) -> None:
    """How high the band of contact pressure is, at the anal end of the first panel."""
    largest = largest_pressure(result)
    size = next(size for size in (100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1) if size <= largest)
    right, bottom = 0.97 * data.span(result), height(result) - PRESSURE_HEIGHT - 0.7
    left, top = right - 0.02 * data.span(result), bottom + PRESSURE_HEIGHT * size / largest
    corners = [left, right, right, left], [bottom, bottom, top, top]
    axes.fill(*corners, facecolor=style.SKY, edgecolor=style.BLUE, linewidth=0.5)
    axes.text(left - 2.0, 0.5 * (bottom + top), f"contact pressure {size:g} kPa", ha="right", va="center", fontsize=8.5)


FIGURE = Figure(
    name="wall_shapes",
    title="Shape of the tube",
    caption=(
        "The tube cut along its axis, through the first column, at several times, oral end at the left, both "
        "directions to the same scale. "
        "Colour of the wall: total circumferential tension (square-root scale). Grey disc: the pellet. Blue band "
        "outside the wall: contact pressure between wall and pellet; its height along the normal of the pellet is to "
        "the scale in the first panel."
    ),
    draw=draw,
    fields=("tension_circumferential", "contact_pressure"),
)
