"""What all pictures of maps share: the canvas, axes of time and place with the oral end on top, meshes with gaps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...plots import data, style
from ..recording import Floats, Map, Numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

GAP = "0.75"
"""Grey of what was not recorded."""
WIDEST, HIGHEST = 2400, 1000
"""Columns and rows of a mesh; what has more is averaged in blocks, so that a picture stays light."""
COLOURS = {"diameter": style.DIAMETER, "pressure": style.PRESSURE, "stretch": style.STRETCH, "strain": style.STRETCH}
CLOCK = ((7200.0, 3600.0, "time (h)"), (600.0, 60.0, "time (min)"), (0.0, 1.0, "time (s)"))
"""From which duration on [s], seconds of a unit, label."""


def canvas(title: str, height: float = 4.2, width: float = style.WIDTH) -> Canvas:
    """An empty figure with a line that says what it is."""
    from ...plots.canvas import ShownFigure

    figure = ShownFigure(figsize=(width, height), dpi=style.DPI, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.05, h_pad=0.05, hspace=0.04, wspace=0.04)
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def clock(duration: float) -> tuple[float, str]:
    """Seconds of the unit that suits a duration [s], and the label of its axis."""
    return next((unit, label) for least, unit, label in CLOCK if duration >= least)


def time_axis(axes: Axes, recorded: Map, label: bool = True) -> float:
    """Time to the right, in s, min or h; the seconds of its unit."""
    unit, words = clock(recorded.duration)
    axes.set_xlim(recorded.time[0] / unit, recorded.time[-1] / unit)
    if label:
        axes.set_xlabel(words)
    return unit


def place_axis(axes: Axes, recorded: Map, down: bool = True) -> None:
    """Place in mm, the oral end on top (down) or at the left."""
    from matplotlib.ticker import MaxNLocator

    first, last = float(recorded.place[0]), float(recorded.place[-1])
    room = 0.06 * max(last - first, 1.0)
    inner = [tick for tick in MaxNLocator(5).tick_values(first, last) if first + room < tick < last - room]
    ticks = [first, *(float(tick) for tick in inner), last]
    names = [f"{tick:.4g}" for tick in ticks]
    if down:
        axes.set_ylim(last, first)
        axes.set_yticks(ticks, [f"oral  {names[0]}", *names[1:-1], f"anal  {names[-1]}"])
        axes.set_ylabel("distance from the oral end (mm)")
    else:
        axes.set_xlim(first, last)
        axes.set_xticks(ticks, [f"{names[0]}\noral", *names[1:-1], f"{names[-1]}\nanal"])
        axes.set_xlabel("distance from the oral end (mm)")


def mesh(axes: Axes, recorded: Map, norm: Any = None, colours: str | None = None) -> Any:
    """The map in colours, time to the right and place down, gaps grey; between uneven places it is linear."""
    values, time, place = shrunk(recorded)
    unit = clock(recorded.duration)[0]
    drawn = axes.pcolormesh(
        data.edges(time) / unit,
        data.edges(place),
        np.ma.masked_invalid(values.T),
        cmap=colours or COLOURS[recorded.quantity],
        norm=norm or norm_of(recorded),
        shading="flat",
        rasterized=True,
    )
    axes.set_facecolor(GAP)
    return drawn


def norm_of(*maps: Map) -> Any:
    """Colours over all but the outermost two in a thousand values; about 1 for stretches."""
    from matplotlib.colors import Normalize

    parts = [one.values[:: max(1, one.time.size // 4000)].ravel() for one in maps]
    known = np.concatenate([part[np.isfinite(part)] for part in parts])
    low, high = (float(one) for one in np.quantile(known, (0.002, 0.998)))
    if maps[0].quantity in ("stretch", "strain"):
        middle = 1.0 if maps[0].quantity == "stretch" else 0.0
        far = max(abs(low - middle), abs(high - middle), 1e-3)
        return Normalize(middle - far, middle + far)
    return Normalize(low, high if high > low else low + 1.0)


def shrunk(recorded: Map) -> tuple[Numbers, Floats, Floats]:
    """Values, times and places of no more than a mesh shows: means of blocks, and columns between uneven places."""
    values, time, place = recorded.values, recorded.time, recorded.place
    for axis, most in ((0, WIDEST), (1, HIGHEST)):
        size = values.shape[axis]
        count = -(-size // most)
        if count > 1:
            values, time, place = _blocks(values, time, place, axis, count)
    if not recorded.even_places and place.size > 1:
        fine = np.linspace(place[0], place[-1], max(200, 4 * place.size))
        values, place = np.stack([_between(row, place, fine) for row in values]), fine
    return values, time, place


def _between(row: Numbers, place: Floats, fine: Floats) -> Floats:
    known = np.isfinite(row)
    if not known.any():
        return np.full(fine.shape, np.nan)
    found = np.interp(fine, place, row)  # nan on both sides of a gap
    return np.asarray(found, dtype=np.float64)


def _blocks(values: Numbers, time: Floats, place: Floats, axis: int, count: int) -> tuple[Numbers, Floats, Floats]:
    starts = np.arange(0, values.shape[axis], count)
    known = np.isfinite(values)
    total = np.add.reduceat(np.where(known, values, 0.0), starts, axis=axis)
    number = np.add.reduceat(known.astype(np.float32), starts, axis=axis)
    with np.errstate(divide="ignore", invalid="ignore"):
        means = np.where(number > 0, total / number, np.nan)
    old = time if axis == 0 else place
    middles = np.add.reduceat(old, starts) / np.diff(np.append(starts, old.size))
    middles[0], middles[-1] = old[0], old[-1]
    return (means, middles, place) if axis == 0 else (means, time, middles)


def bar(drawn: Any, panels: Axes | Sequence[Axes], label: str) -> Any:
    """A colour bar to the right, with arrows where values lie beyond it."""
    several = list(panels) if isinstance(panels, Sequence) else [panels]
    made = several[0].figure.colorbar(
        drawn, ax=several, aspect=18 * len(several), pad=0.015, fraction=0.06, extend="both", extendfrac=0.02
    )
    made.set_label(label)
    made.outline.set_linewidth(0.6)
    return made
