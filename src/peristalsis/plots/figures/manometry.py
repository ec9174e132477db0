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

    from ...results.result import Result

SPACING = 10.0
"""Distance between sensors [mm]."""
DENSE = 0.25
"""Distance between sensors of the reference map [mm]."""
ISOBARS = (10.0, 30.0, 60.0, 100.0, 200.0, 400.0)
"""Pressures of the contour lines [mmHg]."""


def panel(axes: Axes, result: Result, spacing: float, norm: Any) -> Any:
    """Pressure read by sensors every `spacing` mm, linear between them; returns the mesh for a colour bar."""
    time, sensors, pressure = data.manometry(result, spacing)
    place = np.linspace(sensors[0], sensors[-1], max(2, round((sensors[-1] - sensors[0]) / 0.25) + 1))
    between = np.stack([np.interp(place, sensors, row) for row in pressure])
    mesh = style.colour_map(axes, result, time, place, between, style.PRESSURE, norm)
    style.axis_down(axes, result)
    style.time_axis(axes, result)
    axes.set_facecolor("0.8")
    return mesh


def isobars(axes: Axes, time: Floats, sensors: Floats, pressure: Floats) -> list[float]:
    """Contour lines at the pressures of ISOBARS that occur, and these pressures."""
    levels = [level for level in ISOBARS if pressure.min() < level < pressure.max()]
    if not levels or min(pressure.shape) < 2:
        return []
    place = np.linspace(sensors[0], sensors[-1], 8 * sensors.size)
    between = np.stack([np.interp(place, sensors, row) for row in pressure])
    lines = axes.contour(time, place, between.T, levels=levels, colors="white", linewidths=0.8)
    lines.set_path_effects(style.outlined("black", 1.4))
    return levels


def draw(result: Result, spacing: float = SPACING) -> Canvas:
    """Pressure map of sensors every `spacing` mm, above that of a catheter without gaps."""
    from matplotlib.colors import Normalize

    figure = style.canvas(result, 6.4, "Manometry, lumen pressure and contact with the pellet")
    panels = list(figure.subplots(2, 1, sharex=True, sharey=True))
    top = float(data.manometry(result, DENSE)[2].max())
    norm = Normalize(0.0, max(1.0, top))
    for axes, distance in zip(panels, (spacing, DENSE), strict=True):
        mesh = panel(axes, result, distance, norm)
    time, sensors, pressure = data.manometry(result, spacing)
    levels = isobars(panels[0], time, sensors, pressure)
    panels[0].plot(np.zeros_like(sensors), sensors, ">", color="white", mec="black", ms=5, clip_on=False, zorder=5)
    panels[0].set_xlabel("")
    bar = style.colour_bar(mesh, panels, "pressure (mmHg)", pad=0.03)
    second = bar.ax.secondary_yaxis(
        "left", functions=(lambda p: p * data.KPA_PER_MMHG, lambda p: p / data.KPA_PER_MMHG)
    )
    second.set_ylabel("pressure (kPa)")
    if levels:
        bar.ax.hlines(levels, 0.0, 1.0, colors="white", linewidth=0.9, path_effects=style.outlined("black", 1.6))
    reached = ", ".join(f"{level:g}" for level in levels)
    lines = f"; isobars {reached} mmHg" if reached else ""
    style.letters(panels, (f"sensors every {spacing:g} mm{lines}", "no gaps between sensors"))
    return figure


FIGURE = Figure(
    name="manometry",
    title="Manometry",
    caption=(
        "Pressure that virtual sensors at fixed axial places would read, oral end at the top, with isobars in (a); "
        "linear between sensors. A sensor reads the lumen pressure, which is one and the same along the tube, plus the "
        "contact pressure between wall and pellet at its place while the wall is pressed onto the pellet there. "
        "Without contact it reads the lumen pressure alone: the wall never closes on itself, and the catheter has no "
        "thickness, so a contraction away from the pellet shows in the "
        "diameter map and not here. (a) Sensors (triangles) "
        "at the distance used in the laboratory; the beads come from the gaps "
        "between them. (b) The same with a sensor every 0.25 mm. Grey: no sensor."
    ),
    draw=draw,
    fields=("contact_pressure",),
)
