"""Position and velocity of the pellet and the forces on it, over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


def position(axes: Axes, result: Result) -> None:
    """Position of the pellet's centre between where it starts and where it leaves."""
    centre = data.values(result, "pellet_position", "mm")
    start, end = centre[0], data.span(result) - data.poles(result)[1]
    for place, text, side in ((start, "start", 1), (end, "end", -1)):
        axes.axhline(place, color=style.GREY, linewidth=0.9, linestyle=":")
        axes.annotate(
            text,
            (0.01, place),
            xycoords=("axes fraction", "data"),
            xytext=(0, 3 * side),
            textcoords="offset points",
            ha="left",
            va="bottom" if side > 0 else "top",
            fontsize=8.5,
            color="0.35",
        )
    axes.plot(data.values(result, "time_step"), centre, color=style.BLACK, label="pellet, centre")
    style.axis_down(axes, result, "position (mm)")
    style.show_ends(axes, result)
    style.time_axis(axes, result)
    style.mark_expelled(axes, result, text_top=0.83)


def velocity(axes: Axes, result: Result) -> None:
    """Velocity of the pellet in cm/s and mm/s."""
    speed = data.values(result, "pellet_velocity")
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    axes.plot(data.values(result, "time_step"), speed, color=style.BLACK)
    axes.set_ylim(style.finite_range(speed, least=0.1))
    axes.set_ylabel("velocity (cm/s)")
    style.second_unit(axes, data.FACTORS["cm/s", "mm/s"], "velocity (mm/s)")
    style.time_axis(axes, result)
    style.mark_expelled(axes, result)


def forces(axes: Axes, result: Result) -> None:
    """Axial forces on the pellet."""
    curves = {
        "wall": ("axial_force", style.BLUE, "-"),
        "viscous": ("viscous_force", style.VERMILION, "-"),
        "dry": ("dry_force", style.GREEN, "-"),
    }
    time = data.values(result, "time_step")
    unit = data.force_unit(result, *(name for name, _, _ in curves.values()))
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    for label, (name, colour, line) in curves.items():
        axes.plot(time, data.values(result, name, unit), color=colour, linestyle=line, label=label)
    axes.set_ylim(style.finite_range(*(data.values(result, name, unit) for name, _, _ in curves.values()), least=0.02))
    axes.set_ylabel(f"axial force ({unit})")
    style.time_axis(axes, result)
    style.mark_expelled(axes, result)


def draw(result: Result) -> Canvas:
    """Track, velocity and forces."""
    figure = style.canvas(result, 7.2, "Pellet")
    panels = list(figure.subplots(3, 1, sharex=True, height_ratios=(1.2, 1.0, 1.0)))
    position(panels[0], result)
    velocity(panels[1], result)
    forces(panels[2], result)
    style.legend_above(panels[2])
    for axes in panels[:-1]:
        axes.set_xlabel("")
    style.letters(panels, ("position of the centre", "velocity", "axial force of the wall, viscous and dry friction"))
    return figure


FIGURE = Figure(
    name="track",
    title="Pellet: position, velocity, forces",
    caption=(
        "(a) Position of the pellet's centre, oral end at the top; dotted lines: where it starts, and where its "
        "leading pole reaches the anal end. (b) Its velocity. (c) Axial force of the wall on the pellet and the two "
        "friction forces; positive towards the anal end. Dashed vertical line: the pellet is expelled. "
        "Where pellet or wall stand out over a clamped end, a line shows it."
    ),
    draw=draw,
    needs_pellet=True,
)
