"""Diameter of the tube over place and time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


def panel(axes: Axes, result: Result) -> Any:
    """The map with the pellet on it; returns the mesh for a colour bar."""
    from matplotlib.colors import Normalize

    time, place, diameter = data.diameter_map(result)
    norm = Normalize(*data.limits(diameter, least=0.2))
    mesh = style.colour_map(axes, result, time, place, diameter, style.DIAMETER, norm)
    if data.has_pellet(result):
        pellet_track(axes, result)
    style.axis_down(axes, result)
    style.show_ends(axes, result)
    style.time_axis(axes, result)
    return mesh


def pellet_track(axes: Axes, result: Result, colour: str = "white", outline: str = "black") -> None:
    """The pellet's centre and both its poles over time."""
    time, centre = data.values(result, "time_step"), data.values(result, "pellet_position", "mm")
    oral, anal = data.poles(result)
    effects = style.outlined(outline, 2.6)
    axes.plot(time, centre, color=colour, linewidth=1.4, path_effects=effects, label="pellet, centre")
    for pole, label in ((centre - oral, "pellet, poles"), (centre + anal, "_")):
        axes.plot(time, pole, color=colour, linewidth=1.0, linestyle=(0, (4, 2)), path_effects=effects, label=label)


def draw(result: Result) -> Canvas:
    """Diameter map with the pellet's track."""
    figure = style.canvas(result, 4.2, "Diameter map")
    axes = figure.add_subplot()
    mesh = panel(axes, result)
    style.colour_bar(mesh, axes, "inner diameter (mm)")
    if data.has_pellet(result):
        style.legend_on_map(axes)
    return figure


FIGURE = Figure(
    name="diameter_map",
    title="Diameter map",
    caption=(
        "Inner diameter of the tube (colour) over axial position in space, oral end at the top, and time. The wall "
        "is interpolated from its moving points onto places fixed in space; where it varies around the ring, the "
        "diameter is that of the circle with the same area. Solid line: centre of the pellet; dashed lines: its poles. "
        "Where pellet or wall stand out over a clamped end, a line shows it; the map ends there."
    ),
    draw=draw,
)
