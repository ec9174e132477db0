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

    from ...result import Result

PRESSURE_HEIGHT = 5.0
"""Height of the band that shows the largest contact pressure of the run [mm]."""


def tension_colours(result: Result) -> tuple[Colormap, Any]:
    """Colours and scale of the circumferential tension [N/cm]; the palest end, lost on white, is left out."""
    import matplotlib
    from matplotlib.colors import ListedColormap, PowerNorm

    tension = data.values(result, "tension_circumferential", "N/cm")
    cmap = ListedColormap(matplotlib.colormaps["magma"](np.linspace(0.05, 0.82, 256)), name="tension")
    return cmap, PowerNorm(0.5, 0.0, max(0.01, float(tension.max())))


def segments(axial: Floats, radius: Floats) -> Floats:
    """Both halves of a wall as line segments, shape (2 (n - 1), 2, 2); upper half first."""
    halves = [np.stack([axial, side * radius], axis=-1) for side in (1.0, -1.0)]
    return np.concatenate([np.stack([half[:-1], half[1:]], axis=1) for half in halves])


def segment_values(nodes: Floats) -> Floats:
    """A field on nodes as values of `segments`."""
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    return np.concatenate([middle, middle])


def height(result: Result) -> float:
    """Half height of a panel [mm]: the widest wall or pellet, and the band of contact pressure."""
    widest = float(data.values(result, "radius", "mm").max())
    return widest + 2.0 + (PRESSURE_HEIGHT if data.has_pellet(result) else 0.0)


def panel(axes: Axes, result: Result, frame: int, cmap: Colormap, norm: Any) -> Any:
    """One time; returns the coloured wall for a colour bar."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    axial = data.values(result, "axial_position", "mm")[frame]
    radius = data.values(result, "radius", "mm")[frame]
    if data.has_pellet(result):
        centre = float(data.at_frames(result, "pellet_position", "mm")[frame])
        axes.add_patch(
            Circle((centre, 0.0), data.pellet_radius(result), facecolor="0.82", edgecolor="0.4", linewidth=0.8)
        )
        axes.plot([centre], [0.0], "+", color="0.3", markersize=5, markeredgewidth=0.9)
        _pressure_band(axes, result, frame, centre)
    wall = LineCollection(list(segments(axial, radius)), cmap=cmap, norm=norm, linewidths=2.2, capstyle="round")
    wall.set_array(segment_values(data.values(result, "tension_circumferential", "N/cm")[frame]))
    axes.add_collection(wall)
    axes.set_aspect("equal")
    axes.set_ylim(-height(result), height(result))
    axes.set_yticks([-10.0, 0.0, 10.0], ["10", "0", "10"])
    style.axis_right(axes, result, None)
    return wall


def _pressure_band(axes: Axes, result: Result, frame: int, centre: float) -> None:
    """Contact pressure as a band outside the wall, along the normal of the pellet."""
    pressure = np.nan_to_num(data.values(result, "contact_pressure")[frame])
    touching = pressure > 0.0
    largest = max(0.1, float(np.nanmax(data.values(result, "contact_pressure"))))
    if touching.sum() < 2:
        return
    axial = data.values(result, "axial_position", "mm")[frame][touching]
    radius = data.values(result, "radius", "mm")[frame][touching]
    distance = np.hypot(axial - centre, radius)
    out = PRESSURE_HEIGHT * pressure[touching] / largest
    along, up = (axial - centre) / distance, radius / distance
    for side in (1.0, -1.0):
        axes.fill(
            np.concatenate([axial, (axial + out * along)[::-1]]),
            side * np.concatenate([radius, (radius + out * up)[::-1]]),
            facecolor=style.SKY,
            edgecolor=style.BLUE,
            linewidth=0.6,
        )


def draw(result: Result, times: Sequence[float] | None = None) -> Canvas:
    """The tube at `times` [s], by default at six of even spacing over the run."""
    frames = data.spread_frames(result, 6) if times is None else data.frames_at(result, times)
    cmap, norm = tension_colours(result)
    figure = style.canvas(result, 0.9 + len(frames) * (0.35 + 0.125 * height(result)), "Shape of the tube")
    panels = list(figure.subplots(len(frames), 1, sharex=True, squeeze=False)[:, 0])
    stored = data.values(result, "time")
    for axes, frame in zip(panels, frames, strict=True):
        wall = panel(axes, result, frame, cmap, norm)
    panels[-1].set_xlabel("axial position (mm)")
    figure.supylabel("radius (mm)", fontsize=9.5)
    style.letters(panels, [f"t = {stored[frame]:.2f} s" for frame in frames])
    bar = figure.colorbar(wall, ax=panels, aspect=40, pad=0.015, fraction=0.05)
    bar.set_label("circumferential tension (N/cm)")
    if data.has_pellet(result):
        _pressure_scale(panels[0], result)
    return figure


def _pressure_scale(axes: Axes, result: Result) -> None:
    """How high the band of contact pressure is, at the anal end of the first panel."""
    largest = max(0.1, float(np.nanmax(data.values(result, "contact_pressure"))))
    size = next(size for size in (100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1) if size <= largest)
    x, y = 0.66 * data.length(result), height(result) - 1.2
    tall = PRESSURE_HEIGHT * size / largest
    axes.fill(
        [x, x + 2.5, x + 2.5, x], [y, y, y - tall, y - tall], facecolor=style.SKY, edgecolor=style.BLUE, linewidth=0.6
    )
    axes.text(x + 4.0, y - 0.5 * tall, f"contact pressure {size:g} kPa", va="center", fontsize=8.5)


FIGURE = Figure(
    name="wall_shapes",
    title="Shape of the tube",
    caption=(
        "The tube cut along its axis at several times, oral end at the left, all lengths to the same scale. Colour of "
        "the wall: total circumferential tension (square-root scale). Grey disc: the pellet. Blue band outside the "
        "wall: contact pressure between wall and pellet; its height along the normal of the pellet is to the scale in "
        "the first panel."
    ),
    draw=draw,
)
