"""Depolarisation of both muscle layers over place and time, with the activation front."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

LAYERS = ("longitudinal", "circular")


def norm_of(result: Result) -> Any:
    """One colour scale for both layers [mV]."""
    from matplotlib.colors import Normalize

    return Normalize(*data.limits(*(data.values(result, f"potential_{layer}") for layer in LAYERS), least=5.0))


def panel(axes: Axes, result: Result, layer: str, norm: Any) -> Any:
    """The map of one layer with its front; returns the mesh for a colour bar."""
    time, place = data.values(result, "time"), data.values(result, "z_cell", "mm")
    mesh = style.colour_map(axes, result, time, place, data.values(result, f"potential_{layer}"), style.POTENTIAL, norm)
    front = data.values(result, f"activation_{layer}")
    axes.plot(
        front,
        place,
        color="white",
        linewidth=1.2,
        path_effects=style.outlined("black", 2.4),
        label=front_label(result, layer),
    )
    style.axis_down(axes, result, style.ON_THE_TUBE)
    style.time_axis(axes, result)
    return mesh


def front_label(result: Result, layer: str) -> str:
    """The measured speed of the first wave in words."""
    speed = result.summary["wave_speed_cm_s"][layer]
    return (
        "first activation (no speed: 30 to 80 mm not passed)"
        if speed is None
        else f"first activation, {speed:.2f} cm/s"
    )


def draw(result: Result) -> Canvas:
    """Maps of the potential of both layers."""
    figure = style.canvas(result, 6.2, "Depolarisation")
    panels = list(figure.subplots(2, 1, sharex=True, sharey=True))
    norm = norm_of(result)
    for axes, layer in zip(panels, LAYERS, strict=True):
        mesh = panel(axes, result, layer, norm)
        style.legend_on_map(axes)
    panels[0].set_xlabel("")
    style.colour_bar(mesh, panels, "membrane potential (mV)")
    style.letters(panels, [f"{layer} muscle" for layer in LAYERS])
    return figure


FIGURE = Figure(
    name="potential_maps",
    title="Depolarisation of both layers",
    caption=(
        "Membrane potential of the longitudinal (a) and the circular muscle (b) over the place in the undeformed tube, "
        "oral end at the top, and time. White line: first activation of each place (rise through \N{MINUS SIGN}40 mV)"
        "; its speed is the slope of place over time between z = 30 and 80 mm."
    ),
    draw=draw,
    fields=("potential_longitudinal", "potential_circular"),
)
