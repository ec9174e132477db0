"""One page with the most important figures of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import data, style
from ..figure import Figure
from . import contact, diameter_map, potential_maps, stretch_map, track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


def draw(result: Result) -> Canvas:
    """Maps of diameter, stretch and potential; with a pellet its track, forces and contact besides."""
    pellet = data.has_pellet(result)
    figure = style.canvas(result, 9.4 if pellet else 5.2, "Overview")
    rows = 4 if pellet else 2
    grid = figure.subplots(rows, 2, sharex=True)

    def bar(mesh: Any, row: int, side: int, label: str) -> None:
        # A bar inside its panel's axes takes no room from the panel: those above one another line up.
        axes = grid[row, side]
        style.colour_bar(mesh, axes, label, axes.inset_axes((1.03, 0.0, 0.04, 1.0)))

    bar(diameter_map.panel(grid[0, 0], result), 0, 0, "diameter (mm)")
    bar(stretch_map.panel(grid[0, 1], result), 0, 1, "stretch")
    norm = potential_maps.norm_of(result)
    for side, layer in enumerate(potential_maps.LAYERS):
        bar(potential_maps.panel(grid[1, side], result, layer, norm), 1, side, "potential (mV)")
    for axes in (grid[0, 1], *grid[1]):
        axes.set_ylabel("undeformed z (mm)")
    titles = ["diameter", "longitudinal stretch", *(_wave_title(result, layer) for layer in potential_maps.LAYERS)]
    if pellet:
        track.position(grid[2, 0], result)
        track.velocity(grid[2, 1], result)
        track.forces(grid[3, 0], result)
        style.legend_above(grid[3, 0], size=8.0)
        bar(contact.panel(grid[3, 1], result), 3, 1, "pressure (kPa)")
        titles += ["pellet position", "pellet velocity", "", "contact pressure"]
    panels: list[Axes] = list(grid.ravel())
    for axes in panels[:-2]:
        axes.set_xlabel("")
    style.letters(panels, titles)
    return figure


def _wave_title(result: Result, layer: str) -> str:
    speed = result.summary["wave_speed_cm_s"][layer]
    return f"{layer} muscle" + ("" if speed is None else f", {speed:.2f} cm/s")


FIGURE = Figure(
    name="overview",
    title="Overview of a run",
    caption=(
        "(a) Inner diameter in space with the pellet's centre (solid) and poles (dashed). (b) Longitudinal stretch and "
        "(c, d) membrane potential of both muscle layers over the place in the undeformed tube; white line: first "
        "activation, with its speed. (e) Position and (f) velocity of the pellet. (g) Axial forces on it, positive "
        "towards the anal end. (h) Contact pressure over the distance from its centre. Oral end at the top throughout."
    ),
    draw=draw,
    fields=("stretch_longitudinal", "potential_longitudinal", "potential_circular", "contact_pressure"),
)
