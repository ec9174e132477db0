"""Forces on the pellet and their balance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import data, style
from ..data import Floats
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

AXIAL = (
    ("axial_force", "wall (contact)", style.BLUE),
    ("viscous_force", "viscous friction", style.VERMILION),
    ("dry_force", "dry friction", style.GREEN),
)


def total(result: Result) -> Floats:
    """Sum of all axial forces on the pellet [mN]; the pressures on its two sides cancel."""
    return np.asarray(np.sum([data.values(result, name) for name, _, _ in AXIAL], axis=0))


def draw(result: Result) -> Canvas:
    """Axial forces, the small ones again on their own scale, and the forces that squeeze the pellet."""
    figure = style.canvas(result, 7.2, "Forces on the pellet")
    panels = list(figure.subplots(3, 1, sharex=True, height_ratios=(1.5, 1.0, 1.0)))
    time = data.values(result, "time_step")
    large, small, squeeze = panels
    unit = data.force_unit(result, *(name for name, _, _ in AXIAL))

    large.axhline(0.0, color=style.GREY, linewidth=0.6)
    for name, label, colour in AXIAL:
        large.plot(time, data.values(result, name, unit), color=colour, label=label)
    large.set_ylim(style.finite_range(*(data.values(result, name, unit) for name, _, _ in AXIAL), least=0.02))
    large.set_ylabel(f"axial force ({unit})")

    limit = data.values(result, "dry_friction_limit")
    for side in (-limit, limit):
        small.plot(time, side, color=style.GREY, linewidth=0.9, linestyle=":")
    dry = data.values(result, "dry_force")
    small.plot(time, dry, color=style.GREEN, label="dry friction")
    small.plot(time, np.zeros_like(time), color=style.SKY, linewidth=3.0, label="lumen pressure, net")
    small.plot(time, total(result), color=style.BLACK, linestyle=(0, (3, 3)), label="sum of all")
    small.set_ylim(style.finite_range(dry, -limit, limit, least=1.0))
    small.set_ylabel("axial force (mN)")

    normal = data.values(result, "normal_force", unit)
    section = np.pi * result.configuration.pellet.radius**2
    newtons = 0.1 * data.values(result, "lumen_pressure") * section  # 1 kPa cm^2 = 0.1 N
    end = newtons if unit == "N" else 1e3 * newtons
    squeeze.plot(time, normal, color=style.PURPLE, label="contact")
    squeeze.plot(time, end, color=style.SKY, label=r"lumen pressure on each half, $p\,\pi R^2$")
    squeeze.set_ylim(style.finite_range(normal, end, least=0.02))
    squeeze.set_ylabel(f"force ({unit})")

    for axes in panels:
        style.legend_above(axes)
        style.time_axis(axes, result, label=axes is squeeze)
        style.mark_expelled(axes, result)
    style.letters(panels, ("along the tube", "the small ones in mN", "squeezing the pellet"))
    figure.align_ylabels(panels)
    return figure


FIGURE = Figure(
    name="force_budget",
    title="Forces on the pellet",
    caption=(
        "(a) Axial forces on the pellet, positive towards the anal end: the wall through its contact pressure, viscous "
        "friction and dry friction. (b) The small ones again: dry friction within the limits that it had (dotted); the "
        "net force "
        "of lumen pressure, which is zero because the model has one pressure on both sides of the pellet; and the sum "
        "of all forces, which is zero because the pellet has no inertia (dry friction is recorded as what balances the "
        "other two). (c) Sum of the normal contact forces over the surface, and the force with which lumen pressure "
        "acts on each half of the pellet, equal and opposite."
    ),
    draw=draw,
    needs_pellet=True,
)
