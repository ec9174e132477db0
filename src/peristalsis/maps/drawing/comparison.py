"""Two maps beside one another: on one scale of colours, and their difference where they share times and places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...plots import style
from ..comparing import Compared
from ..contractions import Contractions
from ..recording import Map, Track
from . import frame, manometry
from .map_figure import panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

DIFFERENCE_CAPTION = (
    "Two maps on the grid that they share, on one scale of colours, and the second less the first. r: Pearson's "
    "correlation over all values that both have."
)
BESIDE_CAPTION = (
    "Two maps on one scale of colours, each over its own time; the oral end is on top. Lines: fronts of contractions "
    "and tracks of pellets."
)


def draw_difference(found: Compared) -> Canvas:
    """Both maps and their difference, one above the other."""
    from matplotlib.colors import Normalize

    moved = f", second moved by {found.shift:g} s" if found.shift else ""
    names = (found.first.name, found.second.name)
    figure = frame.canvas(f"{names[0]} and {names[1]}{moved}", height=7.0)
    panels = list(figure.subplots(3, 1, sharex=True, sharey=True))
    norm = frame.norm_of(found.first, found.second)
    for axes, one in zip(panels, (found.first, found.second), strict=False):
        drawn = frame.mesh(axes, one, norm)
    known = found.difference[np.isfinite(found.difference)]
    far = max(float(np.quantile(np.abs(known), 0.995)), 1e-9)
    gap = found.first.done("difference", values=found.difference, name="difference")
    changed = frame.mesh(panels[2], gap, Normalize(-far, far), "RdBu_r")
    for axes in panels:
        frame.place_axis(axes, found.first)
        axes.set_ylabel("")
    figure.supylabel("distance from the oral end (mm)", fontsize=9.5)
    frame.time_axis(panels[2], found.first)
    frame.bar(drawn, panels[:2], found.first.label)
    unit = "" if found.first.unit == "1" else f" ({found.first.unit})"
    frame.bar(changed, panels[2], f"difference{unit}")
    numbers = f"r = {found.correlation:.3f}, rms {found.rms:.3g} {found.first.unit}".rstrip(" 1")
    style.letters(panels, (*names, f"{names[1]} less {names[0]}: {numbers}"))
    return figure


def draw_beside(
    maps: tuple[Map, Map], found: tuple[Contractions, Contractions], tracks: tuple[tuple[Track, ...], tuple[Track, ...]]
) -> Canvas:
    """Two maps of one quantity, such as of a recording and of a run, each over its own time."""
    figure = frame.canvas(f"{maps[0].name} beside {maps[1].name}", height=4.0, width=1.35 * style.WIDTH)
    panels = list(figure.subplots(1, 2))
    drawn: Any = None
    levels: list[float] = []
    norm = frame.norm_of(*maps)
    for axes, one, contractions, pellets in zip(panels, maps, found, tracks, strict=True):
        if one.quantity == "pressure":
            drawn, more = manometry.panel(axes, one, contractions, norm)
            levels = sorted({*levels, *more})
        else:
            drawn = panel(axes, one, contractions, pellets, norm)
    panels[1].set_ylabel("")
    for axes, one in zip(panels, maps, strict=True):
        axes.set_title(one.name, loc="left", pad=20.0)
    frame.bar(drawn, panels, maps[0].label)
    return figure
