"""Figures 1 to 7 of the paper, redrawn from our runs, and what else the claims ask to see. Data come from records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...many.rows import Row
from ...plots import style
from ..drawing import canvas, curve, ending, thresholds_figure, tracks, tracks_figure, usable
from ..outcome import Outcome
from ..source import Picture
from .flowchart import draw_flowchart
from .runs import CHANNELS, CURVE, PHASES, RUNS, channel_run, phase_name
from .searches import SEARCHES

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

Floats = NDArray[np.float64]


def _sequence(outcomes: Sequence[Outcome]) -> Canvas:
    """Fig. 1: shapes of the wall at six times, stretch and tension along it, contact force over the pellet."""
    outcome = outcomes[0]
    record = usable(outcome, "baseline")
    figure = canvas(11.4, 7.6, f"Fig. 1: sequence of events, reading {outcome.condition.title}")
    if record is None:
        return figure
    arrays = record.arrays
    radius = float(_pellet_radius(outcome, record))
    frames = np.unique(np.linspace(0, len(arrays["time"]) - 1, 6).astype(int))
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.0, 1.25))
    left, right = halves
    shapes = list(left.subplots(len(frames), 1, sharex=True, squeeze=False)[:, 0])
    for axes, frame in zip(shapes, frames, strict=True):
        place, wall = arrays["axial_position"][frame], arrays["radius"][frame]
        centre = float(np.interp(arrays["time"][frame], arrays["time_step"], arrays["pellet_position"]))
        for sign in (1.0, -1.0):
            axes.plot(place, sign * wall, color=style.VERMILION, linewidth=1.2)
        angle = np.linspace(0.0, 2.0 * np.pi, 90)
        axes.fill(centre + radius * np.cos(angle), radius * np.sin(angle), color="0.55")
        axes.set_aspect("equal")
        axes.set_xlim(0.0, 10.0)
        axes.set_ylabel(f"{arrays['time'][frame]:.2f} s", rotation=0, ha="right", va="center")
        axes.set_yticks([])
    shapes[-1].set_xlabel("oral end        axial position (cm)        anal end")
    panels = right.subplots(2, 2)
    shown = [
        (panels[0, 0], "stretch_circumferential", "circumferential stretch (1)"),
        (panels[0, 1], "stretch_longitudinal", "longitudinal stretch (1)"),
        (panels[1, 0], "tension_circumferential", "circumferential tension (mN/cm)"),
    ]
    from matplotlib import colormaps

    shades = colormaps["viridis"](np.linspace(0.0, 0.92, len(frames)))
    for axes, name, label in shown:
        for frame, shade in zip(frames, shades, strict=True):
            axes.plot(arrays["axial_position"][frame], arrays[name][frame], color=shade, linewidth=1.1)
        axes.set_xlabel("axial position (cm)")
        axes.set_ylabel(label)
        axes.set_xlim(0.0, 10.0)
    contact = panels[1, 1]
    for frame, shade in zip(frames, shades, strict=True):
        centre = float(np.interp(arrays["time"][frame], arrays["time_step"], arrays["pellet_position"]))
        pressure = np.nan_to_num(arrays["contact_pressure"][frame])
        label = f"{arrays['time'][frame]:.2f} s"
        contact.plot(arrays["axial_position"][frame] - centre, pressure, color=shade, linewidth=1.1, label=label)
    contact.set_xlim(-1.1 * radius, 1.1 * radius)
    contact.set_xlabel("place from the pellet's centre (cm)")
    contact.set_ylabel("contact pressure (kPa)")
    contact.legend(fontsize=7.5)
    return figure


def _pellet_radius(outcome: Outcome, record: Row) -> float:
    return RUNS["baseline"].configuration(outcome.condition.reading, outcome.condition.variant).pellet.radius


def _channels(outcomes: Sequence[Outcome]) -> Canvas:
    """Fig. 5: three channels, three states each, and below the whole curve."""
    outcome = outcomes[0]
    figure = canvas(11.0, 6.6, f"Fig. 5: permeability of the channels, reading {outcome.condition.title}")
    panels = figure.subplots(2, 3)
    for column, channel in enumerate(CHANNELS):
        runs = {f"fig5_{channel}_{state}": state for state in ("norm", "decreased", "increased")}
        tracks(panels[0, column], outcome, runs)
        panels[0, column].set_title(channel.replace("_", " "))
        axes = panels[1, column]
        for index, every in enumerate(outcomes):
            factors, transits = [], []
            for factor in sorted((*CURVE, 1.0)):
                record = every.records.get(channel_run(channel, factor))
                transit = record.summary.get("transit_s") if record is not None else None
                factors.append(factor)
                transits.append(np.nan if transit is None else transit)
            axes.plot(factors, transits, marker="o", markersize=4, **curve(index, every.condition.title))
        axes.set_xscale("log", base=2)
        axes.set_xlabel("conductance over the norm (1)")
        axes.set_ylabel("transit (s); none: not expelled")
        axes.grid(alpha=0.25)
    panels[1, 0].legend(fontsize=7.5)
    return figure


def _abstract(outcomes: Sequence[Outcome]) -> Canvas:
    """Pendular movements, segmentation and peristalsis side by side: diameter and stretch maps, track."""
    outcome = outcomes[0]
    title = f"Pendular movements, segmentation, peristalsis: reading {outcome.condition.title}"
    figure = canvas(11.0, 7.6, title)
    panels = figure.subplots(3, 3)
    for column, name in enumerate(("pendular", "segmentation", "baseline")):
        record = usable(outcome, name)
        if record is None:
            continue
        arrays = record.arrays
        axis = np.linspace(0.0, float(arrays["z"][-1]), 240)
        heading = f"{'peristalsis' if name == 'baseline' else name}: {ending(record)}"
        diameter = _in_space(arrays, 2.0 * arrays["radius"], axis)
        maps = (
            (diameter, "viridis", (0.4, 2.0), "diameter (cm)"),
            (_in_space(arrays, arrays["stretch_longitudinal"], axis), "RdBu", (0.4, 1.6), "longitudinal stretch (1)"),
        )
        for row, (field, colours, limits, label) in enumerate(maps):
            axes = panels[row, column]
            mesh = axes.pcolormesh(
                arrays["time"], axis, field.T, cmap=colours, vmin=limits[0], vmax=limits[1], rasterized=True
            )
            axes.plot(arrays["time_step"], arrays["pellet_position"], color="white", linewidth=1.0)
            axes.set_ylim(10.0, 0.0)
            if column == 0:
                axes.set_ylabel("axial position (cm)")
            if column == 2:
                figure.colorbar(mesh, ax=axes, label=label)
        panels[0, column].set_title(heading)
        track = panels[2, column]
        track.plot(arrays["time_step"], arrays["pellet_position"] - arrays["pellet_position"][0], color=style.BLACK)
        words = (
            f"travel {_text(record, 'travel_cm')} cm\nlibration {_text(record, 'libration_cm')} cm\n"
            f"mixing {_text(record, 'mixing')}"
        )
        track.annotate(words, (0.03, 0.95), xycoords="axes fraction", va="top", fontsize=8.5)
        track.set_xlabel("time (s)")
        if column == 0:
            track.set_ylabel("displacement (cm)")
    return figure


def _text(record: Row, name: str) -> str:
    value = record.summary.get(name)
    return "–" if value is None else f"{value:.3g}"


def _in_space(arrays: Mapping[str, NDArray[Any]], field: NDArray[Any], axis: Floats) -> Floats:
    """A field on wall nodes at places fixed in space, (n_time, n_axis)."""
    places = np.maximum.accumulate(arrays["axial_position"], axis=1)
    return np.stack([np.interp(axis, place, row) for place, row in zip(places, field, strict=True)])


def _phases(outcomes: Sequence[Outcome]) -> Canvas:
    """Transit and mixing against the delay of the circular layer."""
    figure = canvas(7.4, 5.6, "Transit and mixing against the phase between the layers (receptors off)")
    above, below = figure.subplots(2, 1, sharex=True)
    for index, outcome in enumerate(outcomes):
        rows = [(delay, outcome.records.get(phase_name(delay))) for delay in PHASES]
        found = [(delay, record.summary) for delay, record in rows if record is not None]
        delays = [delay for delay, _ in found]
        for axes, key in ((above, "transit_s"), (below, "mixing")):
            values = [np.nan if numbers.get(key) is None else numbers[key] for _, numbers in found]
            axes.plot(delays, values, marker="o", markersize=4, **curve(index, outcome.condition.title))
    above.set_ylabel("transit (s); none: not expelled")
    below.set_ylabel("mixing (1)")
    below.set_xlabel("circular after longitudinal layer (s)")
    for axes in (above, below):
        axes.axvline(0.0, color=style.GREY, linewidth=0.8)
        axes.grid(alpha=0.25)
    above.legend(fontsize=8)
    return figure


def _circular_force(outcomes: Sequence[Outcome]) -> Canvas:
    """Active circular force of the wall over the pellet's place."""
    figure = canvas(7.4, 4.0, "Active force of the circular layer while the pellet is propelled (baseline)")
    axes = figure.subplots()
    for index, outcome in enumerate(outcomes):
        record = usable(outcome, "baseline")
        if record is None:
            continue
        force = 1e-3 * record.arrays["circular_force"]
        axes.plot(record.arrays["pellet_position"], force, **curve(index, outcome.condition.title))
    axes.set_xlabel("pellet's centre (cm)")
    axes.set_ylabel("active circular force (N)")
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8)
    return figure


_FIG3 = {
    f"fig3{letter}": f"{letter.upper()} {label}"
    for letter, label in zip(
        "abcdefg", ("230/20", "230/2", "200/20", "90/450", "230/450", "1200/20", "230/800"), strict=True
    )
}
_FIG4 = {f"fig4{letter}": f"{p} kPa" for letter, p in zip("abcd", ("0.1", "0.15", "0.075", "20"), strict=True)}
_FIG6 = {
    "fig6a": "A, C 230, stimulated",
    "fig6b": "B 230, receptors alone",
    "fig6d": "D 100, receptors alone",
    "fig6_neither": "230, neither",
    "fig6_neither_lubricated": "100, neither",
}
_FIG7 = {f"fig7{letter}": f"r0 = {r} cm" for letter, r in zip("abc", ("0.795", "0.9", "0.6"), strict=True)}

FIGURES: tuple[Picture, ...] = (
    Picture(
        "fig1",
        "1",
        "The sequence of events",
        "Wall and pellet at six times from start to end; stretches and circumferential tension along the wall, and the "
        "contact pressure over the pellet, at the same times.",
        ("baseline",),
        _sequence,
    ),
    Picture(
        "fig2",
        "2",
        "Flow of the program",
        "The subroutines the paper names, left, and the parts of this program that do their work, right.",
        (),
        lambda outcomes: draw_flowchart(canvas(9.6, 7.2, "Fig. 2: the paper's program and this one")),
    ),
    Picture(
        "fig3",
        "3",
        "Friction",
        "Position of the pellet's centre for the paper's seven pairs of viscous (mN s/cm) and dry friction (mN).",
        tuple(_FIG3),
        tracks_figure("Fig. 3: viscous friction (mN s/cm) / dry friction (mN)", _FIG3),
    ),
    Picture(
        "fig4",
        "4",
        "Lumen pressure",
        "Position of the pellet's centre at four lumen pressures.",
        tuple(_FIG4),
        tracks_figure("Fig. 4: lumen pressure", _FIG4),
    ),
    Picture(
        "fig5",
        "5",
        "Permeability of the channels",
        "Above: the pellet's centre at the norm, 0.75 and 1.25 of the conductance of each channel, in both layers. "
        "Below: transit over the factor on the conductance.",
        tuple(channel_run(channel, factor) for channel in CHANNELS for factor in (*CURVE, 1.0)),
        _channels,
    ),
    Picture(
        "fig6",
        "6",
        "Stimulation",
        "Position of the pellet's centre with and without pacemaker, and with neither pacemaker nor receptors.",
        tuple(_FIG6),
        tracks_figure("Fig. 6: stimulation and viscous friction (mN s/cm)", _FIG6),
    ),
    Picture(
        "fig7",
        "7",
        "Radius of the tube",
        "Position of the pellet's centre in tubes of three radii; the pellet is that of the reading.",
        tuple(_FIG7),
        tracks_figure("Fig. 7: radius of the tube", _FIG7),
    ),
    Picture(
        "abstract",
        "",
        "Three kinds of movement",
        "Diameter, longitudinal stretch and displacement of the pellet (white line: its centre) when the longitudinal "
        "layer pulls alone, when rings of the circular layer stand, and when both layers act.",
        ("pendular", "segmentation", "baseline"),
        _abstract,
    ),
    Picture(
        "phases",
        "",
        "Phase between the layers",
        "Transit and mixing when the circular layer is started orally before, with or after the longitudinal one.",
        tuple(phase_name(delay) for delay in PHASES),
        _phases,
    ),
    Picture(
        "circular_force",
        "",
        "Active circular force",
        "Active force of the circular layer, summed along the wall, over the place of the pellet.",
        ("baseline",),
        _circular_force,
    ),
    Picture(
        "thresholds",
        "",
        "Thresholds",
        "Mean velocity over each parameter that was searched; shaded, the bracket of the threshold.",
        (),
        thresholds_figure(SEARCHES),
        searched=True,
    ),
)
