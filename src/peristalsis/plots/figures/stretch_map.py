"""Longitudinal stretch over the undeformed tube and time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


def panel(axes: Axes, result: Result) -> Any:
    """The map; returns the mesh for a colour bar."""
    from matplotlib.colors import CenteredNorm

    stretch = data.values(result, "stretch_longitudinal")
    farthest = max(0.05, float(np.abs(stretch - 1.0).max()))
    time, place = data.values(result, "time"), data.values(result, "z", "mm")
    mesh = style.colour_map(
        axes, result, time, place, stretch, style.STRETCH, CenteredNorm(vcenter=1.0, halfrange=farthest)
    )
    style.axis_down(axes, result, style.ON_THE_TUBE)
    style.time_axis(axes, result)
    return mesh


def draw(result: Result) -> Canvas:
    """Map of longitudinal stretch."""
    figure = style.canvas(result, 4.2, "Longitudinal stretch map")
    axes = figure.add_subplot()
    style.colour_bar(panel(axes, result), axes, "longitudinal stretch")
    return figure


FIGURE = Figure(
    name="stretch_map",
    title="Longitudinal stretch map",
    caption=(
        "Longitudinal stretch of the wall over the place of the wall point in the undeformed tube, oral end at the "
        "top, and time. White is the undeformed length, red shortened, blue lengthened. A diameter map does not show "
        "these contractions of the longitudinal muscle."
    ),
    draw=draw,
    fields=("stretch_longitudinal",),
)
