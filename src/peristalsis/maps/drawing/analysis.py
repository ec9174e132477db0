"""Pictures of what was worked out of maps: spectrum along the gut, states of the wall, velocity against diameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...plots import data, style
from ..measures import Spectrum, velocity_against_diameter
from ..recording import Map, Track
from ..states import STATES, States
from . import frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

STATE_COLOURS = ("#f2f2f2", style.VERMILION, style.GREEN, style.SKY, style.YELLOW)
SPECTRUM_CAPTION = (
    "Power spectral density by Welch's method over frequency and distance from the oral end (colour, logarithmic), and "
    "its mean along the gut. Dashed: the peak; band: its 95 % limits from leaving out one segment after the other."
)
STATES_CAPTION = (
    "State of the wall from the rates of pressure and diameter: contracting (narrows under rising pressure), relaxing "
    "(widens under falling pressure), passively distended or emptying, quiet (either rate below its threshold). Grey: "
    "not recorded."
)
VELOCITY_CAPTION = "Velocity of the pellet against the diameter of the gut at its place; colour is time."


def draw_spectrum(found: Spectrum, recorded: Map, highest: float | None = None) -> Canvas:
    """Power over frequency and place, beside its mean; frequencies up to `highest` [1/min]."""
    from matplotlib.colors import LogNorm

    most = highest or min(found.frequency[-1], 4.0 * found.peak if found.peak else 60.0)
    shown = (found.frequency > 0.0) & (found.frequency <= most)
    figure = frame.canvas(f"Spectrum along the gut: {recorded.name}")
    left, right = figure.subplots(1, 2, width_ratios=(2.2, 1.0))
    power = found.power[shown]
    known = power[np.isfinite(power) & (power > 0.0)]
    high = float(known.max())
    drawn = left.pcolormesh(
        data.edges(found.frequency[shown]),
        data.edges(found.place),
        np.ma.masked_invalid(power.T),
        cmap="magma",
        norm=LogNorm(max(float(known.min()), 1e-4 * high), high),
        rasterized=True,
    )
    left.set_facecolor(frame.GAP)
    frame.place_axis(left, recorded)
    left.set_xlabel("frequency (1/min)")
    unit = f"{found.unit}$^2$ min" if found.unit != "1" else "min"
    frame.bar(drawn, left, f"power ({unit})")
    right.semilogy(found.frequency[shown], np.nanmean(power, axis=1), color=style.BLACK, linewidth=1.2)
    if found.peak is not None:
        right.axvline(found.peak, color=style.VERMILION, linewidth=1.0, linestyle=(0, (4, 2)))
        said = f"{found.peak:.3g} /min"
        if found.limits is not None:
            right.axvspan(*found.limits, color=style.VERMILION, alpha=0.25, linewidth=0)
            said += f"\n({found.limits[0]:.3g} to {found.limits[1]:.3g})"
        right.text(0.97, 0.97, said, transform=right.transAxes, ha="right", va="top", fontsize=8.5)
    right.set_xlabel("frequency (1/min)")
    right.set_title("mean along the gut")
    return figure


def draw_states(found: States, diameter: Map) -> Canvas:
    """The state of the wall over time and place."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure = frame.canvas(f"State of the wall: {diameter.name}", height=4.4)
    axes = figure.add_subplot()
    shown = diameter.done("its states", values=found.state.astype(np.float64), time=found.time, place=found.place)
    unit = frame.clock(shown.duration)[0]
    rows = -(-found.time.size // frame.WIDEST)
    axes.pcolormesh(
        data.edges(found.time[::rows]) / unit,
        data.edges(found.place),
        np.ma.masked_less(found.state[::rows].T, 0),
        cmap=ListedColormap(list(STATE_COLOURS)),
        vmin=-0.5,
        vmax=len(STATES) - 0.5,
        rasterized=True,
    )
    axes.set_facecolor(frame.GAP)
    frame.place_axis(axes, shown)
    frame.time_axis(axes, shown)
    patches = [
        Patch(facecolor=colour, edgecolor="0.4", linewidth=0.5, label=f"{name} {100.0 * found.shares[name]:.0f} %")
        for name, colour in zip(STATES, STATE_COLOURS, strict=True)
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=3, frameon=False)
    return figure


def draw_velocity(track: Track, recorded: Map, window: float, behind: float = 0.0) -> Canvas:
    """Velocity of a pellet against the diameter of the gut at its place, or `behind` it [mm] (below 0: ahead)."""
    time, speed, width = velocity_against_diameter(track, recorded, window, behind)
    figure = frame.canvas(f"Velocity against diameter: {track.name} on {recorded.name}", width=5.2)
    axes = figure.add_subplot()
    drawn = axes.scatter(width, speed, c=time, s=9, cmap="viridis", linewidths=0)
    axes.plot(width, speed, color="0.6", linewidth=0.5, zorder=0)
    axes.axhline(0.0, color="0.5", linewidth=0.7)
    where = "at" if not behind else f"{behind:g} mm behind" if behind > 0.0 else f"{-behind:g} mm ahead of"
    axes.set_xlabel(f"inner diameter {where} the pellet (mm)")
    axes.set_ylabel("velocity of the pellet (mm/s)")
    bar = figure.colorbar(drawn, ax=axes, pad=0.015)
    bar.set_label("time (s)")
    return figure
