"""Contact pressure on the pellet and length of the contact."""

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


def contact_length(result: Result) -> Floats:
    """Axial length of the contact [mm] at every step; nan without contact."""
    return data.values(result, "contact_end", "mm") - data.values(result, "contact_start", "mm")


def panel(axes: Axes, result: Result) -> Any:
    """Contact pressure over time and place on the pellet; returns the mesh for a colour bar."""
    from matplotlib.colors import Normalize

    time, place, pressure = data.contact_map(result)
    norm = Normalize(0.0, max(0.1, float(pressure.max())))
    touching = np.ma.masked_less_equal(pressure, 0.0)
    mesh = style.colour_map(axes, result, time, place, touching, style.PRESSURE, norm)
    axes.set_facecolor("0.8")
    oral, anal = data.poles(result)
    axes.set_ylim(anal, -oral)
    axes.axhline(0.0, color="white", linewidth=0.8, linestyle=":")
    ticks = [-oral, -oral / 2, 0.0, anal / 2, anal]
    names = [style.signed(tick) for tick in ticks]
    axes.set_yticks(ticks, [f"oral  {names[0]}", *names[1:-1], f"anal  {names[-1]}"])
    axes.set_ylabel("from pellet's centre (mm)")
    style.time_axis(axes, result)
    return mesh


def draw(result: Result) -> Canvas:
    """Map of contact pressure and the length of the contact."""
    figure = style.canvas(result, 6.0, "Contact of wall and pellet")
    panels = list(figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1.0)))
    style.colour_bar(panel(panels[0], result), panels[0], "contact pressure (kPa)")
    length = contact_length(result)
    panels[1].plot(data.values(result, "time_step"), length, color=style.BLACK)
    panels[1].set_ylim(0.0, data.limits(length, least=1.0)[1] * 1.08)
    panels[1].set_ylabel("contact length (mm)")
    style.time_axis(panels[1], result)
    style.mark_expelled(panels[1], result)
    panels[0].set_xlabel("")
    style.letters(panels, ("contact pressure along the pellet", "axial length of the contact"))
    return figure


FIGURE = Figure(
    name="contact",
    title="Contact of wall and pellet",
    caption=(
        "(a) Contact pressure between wall and pellet, in excess of the lumen pressure, over the axial distance from "
        "the pellet's centre, oral pole at the top, and time; grey: no contact. (b) Axial distance between "
        "the oral and the anal edge of the contact; no line where nothing touches."
    ),
    draw=draw,
    needs_pellet=True,
    fields=("contact_pressure",),
)
