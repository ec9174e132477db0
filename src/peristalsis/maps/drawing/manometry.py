"""What a catheter read: a colour plot with isobars, channels marked, and stacked traces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...plots import data, style
from ..contractions import Contractions
from ..recording import Map
from ..treatment import median_of_places
from . import frame
from .map_figure import fronts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

ISOBARS = (10.0, 30.0, 60.0, 100.0, 200.0, 400.0)
"""Pressures of the contour lines [mmHg]."""
MOST_TRACES = 24
"""Traces on a page; of more channels every second, third or so is drawn."""
CAPTION = (
    "Pressure (colour, mmHg and kPa) over distance from the oral end, downwards, and time; triangles: channels; linear "
    "between them. Isobars where they are marked on the colour bar. Grey: not recorded."
)
TRACES_CAPTION = (
    "Pressure over time at each channel, the oral one on top, above the median of the channel. The bar is the scale of "
    "all. Gaps are left blank."
)


def norm_of(recorded: Map) -> Any:
    """Colours from 0, or the lowest pressure below it, to all but the highest two in a thousand."""
    from matplotlib.colors import Normalize

    usual = frame.norm_of(recorded)
    return Normalize(min(0.0, usual.vmin), max(usual.vmax, 1.0))


def panel(axes: Axes, recorded: Map, found: Contractions | None = None, norm: Any = None) -> tuple[Any, list[float]]:
    """The colour plot; the mesh for a colour bar, and the isobars that were drawn [mmHg]."""
    drawn = frame.mesh(axes, recorded, norm or norm_of(recorded))
    unit = frame.clock(recorded.duration)[0]
    values, time, place = frame.shrunk(recorded)
    low, high = drawn.norm.vmin, min(1.2 * drawn.norm.vmax, float(np.nanmax(values)))
    least = max(low, 0.15 * drawn.norm.vmax)  # lower ones would follow the noise
    levels = [level for level in ISOBARS if least < level < high]
    if levels and min(values.shape) > 1:
        lines = axes.contour(
            time / unit, place, np.ma.masked_invalid(values.T), levels=levels, colors="white", linewidths=0.7
        )
        lines.set_path_effects(style.outlined("black", 1.2))
    axes.plot(
        np.full(recorded.place.size, recorded.time[0] / unit),
        recorded.place,
        ">",
        color="white",
        markeredgecolor="black",
        markersize=4,
        clip_on=False,
        zorder=5,
    )
    fronts(axes, found, unit)
    frame.place_axis(axes, recorded)
    frame.time_axis(axes, recorded)
    if axes.get_legend_handles_labels()[0]:
        style.legend_above(axes, columns=3)
    return drawn, levels


def pressure_bar(drawn: Any, axes: Axes, levels: list[float]) -> None:
    """A colour bar in mmHg and kPa with the isobars on it."""
    made = frame.bar(drawn, axes, "pressure (mmHg)")
    second = made.ax.secondary_yaxis(
        "left", functions=(lambda p: p * data.KPA_PER_MMHG, lambda p: p / data.KPA_PER_MMHG)
    )
    second.set_ylabel("pressure (kPa)")
    inside = [level for level in levels if level < drawn.norm.vmax]
    made.ax.hlines(inside, 0.0, 1.0, colors="white", linewidth=0.9, path_effects=style.outlined("black", 1.6))


def draw(recorded: Map, found: Contractions | None = None) -> Canvas:
    """The colour plot with isobars."""
    figure = frame.canvas(f"Manometry: {recorded.name}")
    axes = figure.add_subplot()
    drawn, levels = panel(axes, recorded, found)
    pressure_bar(drawn, axes, levels)
    return figure


def draw_traces(recorded: Map) -> Canvas:
    """Stacked traces, one for each channel, above its median."""
    every = -(-recorded.place.size // MOST_TRACES)
    columns = range(0, recorded.place.size, every)
    said = "" if every == 1 else f", one channel in {every}"
    figure = frame.canvas(f"Manometry traces: {recorded.name}{said}", height=max(2.6, 1.2 + 0.24 * len(columns)))
    axes = figure.add_subplot()
    unit = frame.clock(recorded.duration)[0]
    time, rise = _envelope(recorded, list(columns))
    top = float(np.nanquantile(rise, 0.998))
    step = 0.9 * top if top > 0.0 else 1.0
    for number in range(len(columns)):
        base = -step * number
        axes.fill_between(time / unit, base, base + np.maximum(rise[:, number], 0.0), color=style.SKY, alpha=0.5, lw=0)
        axes.plot(time / unit, base + rise[:, number], color=style.BLACK, linewidth=0.7)
    names = [f"{recorded.place[k]:.4g}" for k in columns]
    names[0], names[-1] = f"oral  {names[0]}", f"anal  {names[-1]}" if len(names) > 1 else names[-1]
    axes.set_yticks(-step * np.arange(len(columns)), names)
    axes.set_ylim(-step * (len(columns) - 0.5), 1.3 * step)
    axes.set_ylabel("channel, distance from the oral end (mm)")
    frame.time_axis(axes, recorded)
    height = next((one for one in (200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0) if one <= step), step)
    along, base = axes.get_yaxis_transform(), -step * (len(columns) - 1)
    axes.plot([1.02, 1.02], [base, base + height], color=style.BLACK, linewidth=2.0, transform=along, clip_on=False)
    text = f"{height:g} mmHg\n({height * data.KPA_PER_MMHG:.3g} kPa)"
    axes.text(1.035, base + 0.5 * height, text, transform=along, ha="left", va="center", fontsize=8.5)
    return figure


def _envelope(recorded: Map, columns: list[int]) -> tuple[Any, Any]:
    """Times and courses above their medians; of long recordings the highest and lowest of each block, in turn."""
    values = np.asarray(recorded.values[:, columns], dtype=np.float64) - median_of_places(recorded.values[:, columns])
    count = -(-recorded.time.size // frame.WIDEST)
    if count < 3:
        return recorded.time, values
    starts = np.arange(0, recorded.time.size, count)
    missing = np.isnan(values)
    high = np.maximum.reduceat(np.where(missing, -np.inf, values), starts, axis=0)
    low = np.minimum.reduceat(np.where(missing, np.inf, values), starts, axis=0)
    pairs = np.stack([high, low], axis=1).reshape(-1, len(columns))
    times = np.repeat(recorded.time[starts], 2)
    return times, np.where(np.isfinite(pairs), pairs, np.nan)
