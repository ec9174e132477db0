"""Forces on the pellet and their balance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ...result import Result


def draw(result: Result) -> Canvas:
    """Axial forces with their sum, and the forces that squeeze the pellet."""
    figure = style.canvas(result, 6.0, "Forces on the pellet")
    panels = list(figure.subplots(2, 1, sharex=True, height_ratios=(1.4, 1.0)))
    time = data.values(result, "time_step")
    axial = {
        "wall (contact)": (data.values(result, "axial_force", "N"), style.BLUE),
        "viscous friction": (data.values(result, "viscous_force", "N"), style.VERMILION),
        "dry friction": (data.values(result, "dry_force", "N"), style.GREEN),
    }
    for label, (force, colour) in axial.items():
        panels[0].plot(time, force, color=colour, label=label)
    total = np.sum([force for force, _ in axial.values()], axis=0)
    panels[0].plot(time, np.zeros_like(time), color=style.SKY, linewidth=3.0, label="lumen pressure (net 0)")
    panels[0].plot(time, total, color=style.BLACK, linestyle=(0, (3, 3)), label="sum")
    panels[0].set_ylim(style.finite_range(*(force for force, _ in axial.values()), least=0.02))
    panels[0].set_ylabel("axial force (N)")
    panels[0].legend(loc="upper left", ncols=2)

    normal = data.values(result, "normal_force", "N")
    section = np.pi * result.configuration.pellet.radius**2
    end = data.values(result, "lumen_pressure") * 0.1 * section  # 1 kPa cm^2 = 0.1 N
    panels[1].plot(time, normal, color=style.PURPLE, label="contact, sum of normal forces")
    panels[1].plot(time, end, color=style.SKY, label=r"lumen pressure on each half, $p\,\pi R^2$")
    panels[1].set_ylim(style.finite_range(normal, end, least=0.02))
    panels[1].set_ylabel("force (N)")
    panels[1].legend(loc="upper left")
    for axes in panels:
        style.time_axis(axes, result)
        style.mark_expelled(axes, result, text=axes is panels[1])
    panels[0].set_xlabel("")
    style.letters(panels, ("along the tube (anal direction positive)", "squeezing the pellet"))
    return figure


FIGURE = Figure(
    name="force_budget",
    title="Forces on the pellet",
    caption=(
        "(a) Axial forces on the pellet, positive towards the anal end: the wall through its contact pressure, viscous "
        "friction, dry friction, and their sum, which is zero because the pellet has no inertia (dry friction is what "
        "balances the other two, up to its limit). Lumen pressure gives no net force: the model has one pressure on "
        "both sides of the pellet. (b) Sum of the normal contact forces over the surface, and the force with which "
        "lumen pressure acts on each half of the pellet, equal and opposite."
    ),
    draw=draw,
    needs_pellet=True,
)
