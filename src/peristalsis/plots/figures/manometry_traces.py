"""What a manometric catheter would read: stacked traces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import data, style
from ..figure import Figure
from .manometry import SPACING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


def draw(result: Result, spacing: float = SPACING) -> Canvas:
    """One trace per sensor, the oral one at the top."""
    figure = style.canvas(result, 5.2, "Manometry traces")
    axes = figure.add_subplot()
    time, sensors, pressure = data.manometry(result, spacing)
    lumen = data.at_frames(result, "lumen_pressure", "mmHg")
    rise = pressure - lumen.min()
    step = max(2.0, 0.9 * float(rise.max()))
    for number in range(sensors.size):
        base = -step * number
        axes.fill_between(time, base, base + rise[:, number], color=style.SKY, alpha=0.45, linewidth=0)
        axes.plot(time, base + rise[:, number], color=style.BLACK, linewidth=1.1)
    axes.set_ylim(-step * (sensors.size - 0.7), 1.25 * step)
    bases = -step * np.arange(sensors.size)
    names = [f"{place:g}" for place in sensors]
    if sensors.size > 1:
        names[0], names[-1] = f"oral  {names[0]}", f"anal  {names[-1]}"
    axes.set_yticks(bases, names)
    axes.set_ylabel("place of the sensor (mm)")
    style.time_axis(axes, result)
    style.mark_expelled(axes, result)
    _scale_bar(axes, step, -step * (sensors.size - 1))
    return figure


def _scale_bar(axes: Axes, step: float, base: float) -> None:
    """A bar of a round pressure beside the lowest trace, in both units."""
    height = next(size for size in (500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0) if size <= step)
    along = axes.get_yaxis_transform()
    axes.plot([1.02, 1.02], [base, base + height], color=style.BLACK, linewidth=2.0, transform=along, clip_on=False)
    text = f"{height:g} mmHg\n({height * data.KPA_PER_MMHG:.3g} kPa)"
    axes.text(1.035, base + 0.5 * height, text, transform=along, ha="left", va="center", fontsize=8.5)


FIGURE = Figure(
    name="manometry_traces",
    title="Manometry traces",
    caption=(
        "Pressure over time at virtual sensors fixed in space, the oral one at the top: lumen pressure plus, while the "
        "wall is pressed onto the pellet at the sensor, the contact pressure there. Each trace stands on the smallest "
        "lumen pressure of the run."
    ),
    draw=draw,
    fields=("contact_pressure",),
)
