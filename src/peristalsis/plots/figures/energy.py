"""Where the work of the muscle goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

TERMS = (
    ("work_active", "done by the muscle", style.BLUE, "-"),
    ("work_gas", "done by the lumen's content", style.SKY, "-"),
    ("energy_wall", "stored in the passive wall", style.GREEN, "--"),
    ("loss_wall", "lost in the viscous wall", style.ORANGE, "--"),
    ("loss_pellet", "lost in friction of the pellet", style.VERMILION, "--"),
)


def draw(result: Result) -> Canvas:
    """Cumulative work by term, and the residual of their balance."""
    figure = style.canvas(result, 5.8, "Work")
    panels = list(figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0)))
    time = data.values(result, "time_step")
    for name, label, colour, line in TERMS:
        work = data.values(result, name, "mJ")
        panels[0].plot(time, work, color=colour, linestyle=line, label=f"{label}: {style.signed(work[-1])} mJ")
    panels[0].set_ylabel("work since t = 0 (mJ)")
    panels[0].set_ylim(style.finite_range(*(data.values(result, name, "mJ") for name, *_ in TERMS), least=1e-3))
    panels[0].legend(loc="upper left")
    residual = data.values(result, "power_residual", "mJ")
    panels[1].axhline(0.0, color=style.GREY, linewidth=0.6)
    panels[1].plot(time, 1e3 * residual, color=style.BLACK)
    panels[1].set_ylim(style.finite_range(1e3 * residual, least=1e-3))
    panels[1].set_ylabel("residual (µJ)")
    for axes in panels:
        style.time_axis(axes, result)
        style.mark_expelled(axes, result)
    panels[0].set_xlabel("")
    share = result.summary["power_residual"]
    style.letters(
        panels,
        (
            "work done (solid) and where it went (dashed)",
            f"balance: residual at most {style.signed(share, 2)} of the work done",
        ),
    )
    return figure


FIGURE = Figure(
    name="energy",
    title="Balance of work",
    caption=(
        "(a) Work since t = 0: done by the muscle and by the content of the lumen (solid lines), stored in the passive "
        "wall, lost in the viscous wall, and lost in friction of the pellet (dashed lines). (b) What the balance "
        "leaves over: stored and lost less done, from the error of the time step."
    ),
    draw=draw,
)
