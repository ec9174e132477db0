"""Stretch, tension, contact pressure and radius at one time, on the unrolled surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import data, style, unrolled
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result


class Shown(NamedTuple):
    """One panel: the output, its unit, its label, its colours, and the least extent of its scale."""

    name: str
    unit: str
    label: str
    colours: str
    least: float


PANELS = (
    Shown("stretch_longitudinal", "1", "longitudinal stretch", style.STRETCH, 0.1),
    Shown("stretch_circumferential", "1", "circumferential stretch", style.STRETCH, 0.1),
    Shown("tension_longitudinal", "N/cm", "longitudinal tension (N/cm)", style.TENSION, 0.01),
    Shown("tension_circumferential", "N/cm", "circumferential tension (N/cm)", style.TENSION, 0.01),
    Shown("contact_pressure", "kPa", "contact pressure (kPa)", style.PRESSURE, 0.1),
    Shown("radius", "mm", "radius (mm)", style.DIAMETER, 0.2),
)


def default_frame(result: Result) -> int:
    """The stored time at which the wall presses hardest on the pellet; without one, the middle of the run."""
    if not data.has_pellet(result):
        return data.values(result, "time").size // 2
    return int(np.argmax(np.nan_to_num(data.at_frames(result, "normal_force"))))


def panel(axes: Axes, result: Result, shown: Shown, frame: int) -> Any:
    """One field; returns the mesh for a colour bar."""
    from matplotlib.colors import CenteredNorm, Normalize

    sheet = np.nan_to_num(unrolled.field(result, shown.name, frame, shown.unit))
    norm: Any = Normalize(*data.limits(sheet, least=shown.least))
    if shown.colours == style.STRETCH:
        norm = CenteredNorm(vcenter=1.0, halfrange=max(0.5 * shown.least, float(np.abs(sheet - 1.0).max())))
    mesh = axes.pcolormesh(
        data.edges(data.values(result, "z", "mm")),
        data.edges(unrolled.angles(sheet.shape[1])),
        unrolled.closed(sheet).T,
        cmap=shown.colours,
        norm=norm,
        shading="flat",
        rasterized=True,
    )
    style.unrolled_axes(axes, result)
    return mesh


def draw(result: Result, time: float | None = None) -> Canvas:
    """The six fields at the stored time nearest to `time` [s]; by default where the wall presses hardest."""
    frame = default_frame(result) if time is None else data.frames_at(result, [time])[0]
    when = f"t = {data.values(result, 'time')[frame]:.2f} s"
    uniform = unrolled.is_uniform(unrolled.field(result, "radius", frame))
    figure = style.canvas(result, 6.4, f"Unrolled surface at {when}{', uniform around the ring' if uniform else ''}")
    grid = figure.subplots(3, 2, sharex=True, sharey=True)
    for axes, shown in zip(grid.ravel(), PANELS, strict=True):
        style.colour_bar(panel(axes, result, shown, frame), axes, "")
        axes.label_outer()
    style.letters(list(grid.ravel()), [shown.label for shown in PANELS])
    return figure


FIGURE = Figure(
    name="surface_maps",
    title="Fields on the unrolled surface",
    caption=(
        "Stretches (a, b; white is the undeformed length), total tensions (c, d), contact pressure on the pellet (e) "
        "and radius (f) at one time over place and angle on the undeformed surface, cut open and laid flat, oral end "
        "at the left."
    ),
    draw=draw,
    fields=tuple(shown.name for shown in PANELS),
)
