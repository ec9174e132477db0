"""Fig. 2: the flow of the paper's program beside that of this one, drawn with boxes and arrows."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from ...plots import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

ROWS = (
    (
        "MAIN: input, initial configuration,\nstress and strain at rest",
        "config, scenarios, parameters: checked input\nmodel.initial: insert the pellet, inflate, rest of the cells",
    ),
    (
        "EXCLONG: wave of the longitudinal layer\n(explicit differences)",
        "tissue.sheet: kinetics, conduction, kinetics (Strang),\nlongitudinal layer; control.pacemaker drives it",
    ),
    (
        "EXCCIRC: wave of the circular layer,\nafter the longitudinal force's maximum",
        "control.sequence, control.reflex: start and inhibit\ntissue.sheet: the same for the circular layer",
    ),
    (
        "BIOSHELL: stress and strain of the wall\n(explicit differences)",
        "wall.membrane, model.equilibrium: implicit BDF2,\nNewton with the analytic tangent",
    ),
    (
        "TRSOLID: stress over the sphere,\nits propulsion",
        "pellet.contact, pellet.friction: contact in the same Newton\nloop; the pellet sticks or slips",
    ),
    (
        "OUTPRN: print results",
        "observers, events: record every step, may stop the run\nresult, plots, scoring: files, figures, verdicts",
    ),
)
"""The paper's routine, and what does its work here."""


def draw_flowchart(figure: Canvas) -> Canvas:
    """Two columns of boxes with the loop over time."""
    axes = figure.subplots()
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 10.0)
    axes.axis("off")
    heights = [9.0 - 1.6 * row for row in range(len(ROWS))]
    for column, (middle, width, colour, heading) in enumerate(
        ((2.25, 3.5, style.GREY, "paper"), (7.0, 4.9, style.BLUE, "this program"))
    ):
        axes.text(middle, 9.85, heading, ha="center", va="center", fontweight="bold")
        for height, row in zip(heights, ROWS, strict=True):
            axes.text(
                middle,
                height,
                row[column],
                ha="center",
                va="center",
                fontsize=8.5,
                bbox={"boxstyle": "round,pad=0.5", "facecolor": "white", "edgecolor": colour, "linewidth": 1.2},
            )
        for above, below in pairwise(heights):
            _arrow(axes, (middle, above - 0.3), (middle, below + 0.3), colour)
        edge = middle - 0.5 * width - 0.15
        inside = middle - 0.38 * width
        turns = [heights[4], heights[4], heights[1], heights[1]]
        axes.plot([inside, edge, edge, inside], turns, color=colour, linewidth=1.2, zorder=0)
        _arrow(axes, (edge, heights[1]), (inside, heights[1]), colour)
        axes.text(edge - 0.08, 0.5 * (heights[1] + heights[4]), "every time step", rotation=90, ha="right", va="center")
    return figure


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.2})
