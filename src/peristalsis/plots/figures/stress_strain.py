"""Stretch and tension along the wall at chosen times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import data, style
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

PARTS = (
    ("active_tension", "active", style.VERMILION, "-"),
    ("passive_tension", "passive", style.GREEN, "-"),
    ("rest", "viscous", style.SKY, "-"),
    ("tension", "total", style.BLACK, "-"),
)


def draw(result: Result, times: Sequence[float] | None = None) -> Canvas:
    """Profiles at `times` [s], by default at three of even spacing within the run."""
    if times is None:
        last = float(data.values(result, "time")[-1])
        times = [share * last for share in (0.2, 0.5, 0.8)]
    frames = data.frames_at(result, times)
    figure = style.canvas(result, 6.8, "Stretch and tension along the wall")
    grid = figure.subplots(3, len(frames), sharex=True, sharey="row", squeeze=False)
    for side, frame in enumerate(frames):
        _stretches(grid[0, side], result, frame)
        for row, direction in ((1, "longitudinal"), (2, "circumferential")):
            _tensions(grid[row, side], result, frame, direction)
        for axes in grid[:, side]:
            _contact_band(axes, result, frame)
        style.axis_right(grid[2, side], result, style.ON_THE_TUBE)
    for row, label in enumerate(("stretch", "longitudinal\ntension (N/cm)", "circumferential\ntension (N/cm)")):
        grid[row, 0].set_ylabel(label)
    grid[0, 0].legend(loc="best")
    grid[1, 0].legend(loc="best")
    stored = data.values(result, "time")
    style.letters(list(grid[0]), [f"t = {stored[frame]:.2f} s" for frame in frames])
    figure.align_ylabels(grid[:, 0])
    return figure


def _stretches(axes: Axes, result: Result, frame: int) -> None:
    z = data.values(result, "z", "mm")
    axes.axhline(1.0, color=style.GREY, linewidth=0.6)
    for name, colour in (("longitudinal", style.BLUE), ("circumferential", style.PURPLE)):
        axes.plot(z, data.values(result, f"stretch_{name}")[frame], color=colour, label=name, linewidth=1.2)


def _tensions(axes: Axes, result: Result, frame: int, direction: str) -> None:
    z = data.values(result, "z", "mm")
    curves = {
        name: data.values(result, f"{name}_{direction}", "N/cm")[frame]
        for name in ("tension", "active_tension", "passive_tension")
    }
    curves["rest"] = curves["tension"] - curves["active_tension"] - curves["passive_tension"]
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    for name, label, colour, line in PARTS:
        axes.plot(z, curves[name], color=colour, linestyle=line, label=label, linewidth=1.2)


def _contact_band(axes: Axes, result: Result, frame: int) -> None:
    """Grey where the wall is pressed onto the pellet."""
    z = data.values(result, "z", "mm")
    touching = np.flatnonzero(np.nan_to_num(data.values(result, "contact_pressure")[frame]) > 0.0)
    if touching.size:
        axes.axvspan(z[touching[0]], z[touching[-1]], color="0.85", linewidth=0, zorder=0)


FIGURE = Figure(
    name="stress_strain",
    title="Stretch and tension along the wall",
    caption=(
        "Stretches (top), longitudinal tension (middle) and circumferential tension (bottom) over the place in the "
        "undeformed tube at three times. Total tension is the sum of the active, the passive and the viscous part; the "
        "last is negative where the wall shortens, and holds the smoothed floor of the total besides. Grey: the wall "
        "is pressed onto the pellet."
    ),
    draw=draw,
    fields=(
        "stretch_longitudinal",
        "tension_longitudinal",
        "active_tension_longitudinal",
        "passive_tension_longitudinal",
        "stretch_circumferential",
        "tension_circumferential",
        "active_tension_circumferential",
        "passive_tension_circumferential",
        "contact_pressure",
    ),
)
