"""A map in colours, with the fronts of its contractions and tracks of pellets on it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ...plots import style
from ..contractions import Contractions
from ..recording import Map, Track
from . import frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

FRONT_COLOURS = {"antegrade": "white", "retrograde": style.ORANGE, "standing": style.PURPLE}
CAPTIONS = {
    "diameter": "Inner diameter (colour) over distance from the oral end, downwards, and time. Grey: not recorded.",
    "pressure": "Pressure (colour) over distance from the oral end, downwards, and time. Grey: not recorded.",
    "stretch": "Longitudinal stretch (colour) over distance from the oral end, downwards, and time; 1 is no stretch.",
    "strain": "Strain (colour) over distance from the oral end, downwards, and time. Grey: not recorded.",
}
TITLES = {"diameter": "Diameter map", "pressure": "Pressure map", "stretch": "Stretch map", "strain": "Strain map"}


def panel(
    axes: Axes,
    recorded: Map,
    found: Contractions | None = None,
    tracks: Iterable[Track] = (),
    norm: Any = None,
) -> Any:
    """The map with what is drawn on it; returns the mesh for a colour bar."""
    drawn = frame.mesh(axes, recorded, norm)
    unit = frame.clock(recorded.duration)[0]
    fronts(axes, found, unit)
    for number, track in enumerate(tracks):
        label = track.name if number == 0 else "_"
        axes.plot(
            track.time / unit,
            track.position,
            color=style.SKY,
            linewidth=1.8,
            path_effects=style.outlined("black", 3.2),
            label=label,
        )
    frame.place_axis(axes, recorded)
    frame.time_axis(axes, recorded)
    if axes.get_legend_handles_labels()[0]:
        style.legend_above(axes, columns=4)
    return drawn


def fronts(axes: Axes, found: Contractions | None, unit: float) -> None:
    """The fronts of contractions, a colour for each direction."""
    for direction, colour in FRONT_COLOURS.items():
        for number, one in enumerate(found.of(direction) if found is not None else ()):
            place, when = one.front
            axes.plot(
                when / unit,
                place,
                color=colour,
                linewidth=0.8,
                path_effects=style.outlined("black", 1.5),
                label=direction if number == 0 else "_",
            )


def draw(recorded: Map, found: Contractions | None = None, tracks: Iterable[Track] = ()) -> Canvas:
    """The map, with the fronts of contractions and the tracks that are given."""
    figure = frame.canvas(f"{TITLES[recorded.quantity]}: {recorded.name}")
    axes = figure.add_subplot()
    frame.bar(panel(axes, recorded, found, tuple(tracks)), axes, recorded.label)
    return figure
