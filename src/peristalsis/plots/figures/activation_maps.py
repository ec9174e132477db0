"""When each place was first activated, on the unrolled sheet: isochrones and velocities of the front."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import data, style, unrolled
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

LAYERS = ("longitudinal", "circular")
ARROWS = (14, 6)
"""Arrows along the tube and around it."""
ISOCHRONES = 10
ARROW_TIME = 0.15
"""An arrow is the way of the front in this time [s], on the scales of both axes."""


def norm_of(result: Result) -> Any:
    """One colour scale of time for both layers [s]."""
    from matplotlib.colors import Normalize

    return Normalize(*data.limits(*(unrolled.field(result, f"activation_{layer}") for layer in LAYERS), least=0.05))


def panel(axes: Axes, result: Result, layer: str, norm: Any) -> Any:
    """The map of one layer with isochrones and arrows; returns the mesh for a colour bar."""
    times = unrolled.field(result, f"activation_{layer}")
    shown = np.repeat(times, 8, axis=1) if times.shape[1] == 1 else times
    place, turn = data.values(result, "z_cell", "mm"), unrolled.angles(shown.shape[1])
    sheet = np.ma.masked_invalid(unrolled.closed(shown))
    borders = np.concatenate([[0.0], 0.5 * (place[1:] + place[:-1]), [data.length(result)]])
    axes.set_facecolor("0.86")
    mesh = axes.pcolormesh(
        borders, data.edges(turn), sheet.T, cmap=style.ACTIVATION, norm=norm, shading="flat", rasterized=True
    )
    levels = unrolled.even(norm.vmin, norm.vmax, ISOCHRONES)
    reached = sheet.compressed()
    if reached.size and np.any((levels > reached.min()) & (levels < reached.max())):
        lines = axes.contour(place, turn, sheet.T, levels=levels, colors="white", linewidths=1.0)
        axes.clabel(lines, fmt="%g s", fontsize=7.5)
    if reached.size:
        _arrows(axes, result, times)
    else:
        axes.text(0.5, 0.5, "not activated", transform=axes.transAxes, ha="center", va="center")
    style.unrolled_axes(axes, result)
    return mesh


def _arrows(axes: Axes, result: Result, times: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    n, m = times.shape
    centres, turns = data.values(result, "z_cell", "mm"), unrolled.angles(m)
    places = np.unique(np.linspace(0, n - 1, ARROWS[0] + 2).round().astype(np.int64)[1:-1])
    columns = np.unique((np.arange(ARROWS[1]) * m / ARROWS[1]).round().astype(np.int64) % m)
    reach = max(1, n // (4 * ARROWS[0]))
    wall = result.configuration.wall
    along, around = unrolled.front_velocity(times, wall.length / n, wall.radius, places, columns, reach)
    shown = turns[columns]
    if m == 1:  # the same all around
        shown = (np.arange(ARROWS[1]) + 0.5) * 360.0 / ARROWS[1]
        along, around = (np.repeat(part, ARROWS[1], axis=1) for part in (along, around))
    x, y = np.meshgrid(centres[places], shown, indexing="ij")
    known = np.isfinite(along)
    axes.quiver(
        x[known],
        y[known],
        10.0 * along[known],  # mm/s and deg/s, the units of the axes
        np.rad2deg(around[known] / wall.radius),
        angles="xy",
        scale=1.0 / ARROW_TIME,
        scale_units="xy",
        width=0.003,
        color="black",
    )


def draw(result: Result) -> Canvas:
    """Activation maps of both layers."""
    figure = style.canvas(result, 5.6, "First activation on the unrolled sheet")
    panels = list(figure.subplots(2, 1, sharex=True, sharey=True))
    norm = norm_of(result)
    for axes, layer in zip(panels, LAYERS, strict=True):
        mesh = panel(axes, result, layer, norm)
    panels[0].set_xlabel("")
    style.colour_bar(mesh, panels, "first activation (s)")
    titles = [f"{layer} muscle" for layer in LAYERS]
    if unrolled.is_uniform(unrolled.field(result, "activation_longitudinal")):
        titles = [f"{title}, uniform around the ring" for title in titles]
    style.letters(panels, titles)
    for axes in panels:
        axes.set_title(f"arrows: way of the front in {ARROW_TIME:g} s", loc="right", fontsize=8.5)
    return figure


FIGURE = Figure(
    name="activation_maps",
    title="First activation on the unrolled sheet",
    caption=(
        "Time of the first activation (rise through \N{MINUS SIGN}40 mV) of the longitudinal (a) and the circular "
        "muscle (b) over place and angle on the undeformed surface, cut open and laid flat, oral end at the left. "
        "White lines: isochrones. Arrows: velocity of the front along the undeformed surface, from the slope of "
        f"time, as its way in {ARROW_TIME:g} s; none where neighbours were activated together. Grey: never activated."
    ),
    draw=draw,
)
