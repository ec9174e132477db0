"""What a manometric catheter would read: a pressure map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import data, style
from ..data import Floats
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...result import Result

SPACING = 10.0
"""Distance between sensors [mm]."""
DENSE = 1.0
"""Distance between sensors of the reference map [mm]."""
ISOBARS = (10.0, 30.0, 60.0, 100.0, 200.0, 400.0)
"""Pressures of the contour lines [mmHg]."""


def panel(axes: Axes, result: Result, spacing: float, norm: Any) -> Any:
    """Pressure read by sensors every `spacing` mm, linear between them; returns the mesh for a colour bar."""
    time, sensors, pressure = data.manometry(result, spacing)
    place = np.linspace(sensors[0], sensors[-1], max(2, round((sensors[-1] - sensors[0]) / 0.25) + 1))
    between = np.stack([np.interp(place, sensors, row) for row in pressure])
    mesh = style.colour_map(axes, result, time, place, between, style.PRESSURE, norm)
    isobars(axes, time, place, between)
    style.axis_down(axes, result)
    style.time_axis(axes, result)
    axes.set_facecolor("0.8")
    return mesh


def isobars(axes: Axes, time: Floats, place: Floats, pressure: Floats) -> None:
    """Contour lines at the pressures of ISOBARS that occur."""
    levels = [level for level in ISOBARS if pressure.min() < level < pressure.max()]
    if not levels or min(pressure.shape) < 2:
        return
    lines = axes.contour(time, place, pressure.T, levels=levels, colors="white", linewidths=0.7)
    lines.set_path_effects(style.outlined("black", 1.3))


def draw(result: Result, spacing: float = SPACING) -> Canvas:
    """Pressure map of sensors every `spacing` mm, above that of a catheter without gaps."""
    from matplotlib.colors import Normalize

    figure = style.canvas(result, 6.4, "Manometry")
    panels = list(figure.subplots(2, 1, sharex=True, sharey=True))
    top = float(data.manometry(result, DENSE)[2].max())
    norm = Normalize(0.0, max(1.0, top))
    for axes, distance in zip(panels, (spacing, DENSE), strict=True):
        mesh = panel(axes, result, distance, norm)
    sensors = data.manometry(result, spacing)[1]
    panels[0].plot(np.zeros_like(sensors), sensors, ">", color="white", mec="black", ms=5, clip_on=False, zorder=5)
    panels[0].set_xlabel("")
    bar = style.colour_bar(mesh, panels, "pressure (mmHg)")
    second = bar.ax.secondary_yaxis(
        "left", functions=(lambda p: p * data.KPA_PER_MMHG, lambda p: p / data.KPA_PER_MMHG)
    )
    second.set_ylabel("pressure (kPa)")
    reached = ", ".join(f"{level:g}" for level in ISOBARS if level < top)
    lines = f"; isobars {reached} mmHg" if reached else ""
    style.letters(panels, (f"sensors every {spacing:g} mm{lines}", f"sensors every {DENSE:g} mm"))
    return figure


FIGURE = Figure(
    name="manometry",
    title="Manometry",
    caption=(
        "Pressure that virtual sensors at fixed axial places would read, oral end at the top, with isobars; linear "
        "between sensors. A sensor reads the lumen pressure, which is one and the same along the tube, plus the "
        "contact pressure between wall and pellet at its place while the wall is pressed onto the pellet there. "
        "Without contact it reads the lumen pressure alone: the wall never closes on itself, and the catheter has no "
        "thickness. (a) Sensors (triangles) at the distance used in the laboratory; the beads come from the gaps "
        "between them. (b) The same without gaps. Grey: no sensor."
    ),
    draw=draw,
)
