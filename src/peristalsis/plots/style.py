"""How every figure looks: fonts, colours, axes, and how it is written to a file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ConfigurationError, shown
from . import data
from .data import Floats
from .placing import whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ..results.result import Result

WIDTH = 7.4
"""Width of every figure [inch]; with DPI, 1184 pixels."""
DPI = 160

# Okabe and Ito's palette: told apart with any colour vision, and in print.
BLACK, ORANGE, SKY, GREEN, YELLOW = "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#7A7A7A"
LAYER_COLOURS = {"longitudinal": BLUE, "circular": VERMILION}

DIAMETER, STRETCH, POTENTIAL, PRESSURE, TENSION = "viridis", "RdBu", "cividis", "magma", "viridis"
ACTIVATION = "viridis"
"""Colour maps, all perceptually even; the diverging one is for stretch about 1."""

_SETTINGS: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 8.5,
    "legend.frameon": True,
    "legend.framealpha": 0.85,
    "legend.edgecolor": "none",
    "figure.titlesize": 10.0,
    "axes.linewidth": 0.8,
    "lines.linewidth": 1.6,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "svg.hashsalt": "peristalsis",
    "pdf.fonttype": 42,
}


LEAST_BEYOND = 0.5
"""What stands out over an end by less than this is not shown [mm]."""


@contextmanager
def applied() -> Iterator[None]:
    """The settings of this package, whatever those of the caller; the caller's come back afterwards.

    Raises ConfigurationError where the environment keeps matplotlib from being imported.
    """
    try:
        import matplotlib
    except ValueError:
        named = os.environ.get("MPLBACKEND")
        if not named:
            raise
        raise ConfigurationError(
            f"MPLBACKEND = {shown(named)} is no backend of matplotlib; unset it, or set it to agg"
        ) from None

    base = {key: value for key, value in matplotlib.rcParamsDefault.items() if not key.startswith("backend")}
    with matplotlib.rc_context({**base, **_SETTINGS}):
        yield


def canvas(result: Result, height: float, title: str) -> Canvas:
    """An empty figure with a line that says what it is and of which run."""
    from .canvas import ShownFigure

    figure = ShownFigure(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.05, h_pad=0.05, hspace=0.03, wspace=0.03)
    figure.suptitle(f"{title}: {of_run(result)}", x=0.01, ha="left")
    return figure


def of_run(result: Result) -> str:
    """Scenario, reading and end of a run in a few words."""
    summary = result.summary
    left = data.left(result)
    if left is not None:
        ended = f"{left[1]} at {left[0]:.2f} s"
    else:
        ended = f"{result.status.replace('_', ' ')}, {data.values(result, 'time_step')[-1]:.3g} s"
    return f"{summary['scenario']}, reading {summary['reading']} ({ended})"


def letters(panels: Sequence[Axes], titles: Sequence[str]) -> None:
    """A bold letter and a title on every panel."""
    for number, (panel, title) in enumerate(zip(panels, titles, strict=True)):
        panel.set_title(rf"$\mathbf{{{chr(ord('a') + number)}}}$  {title}")


def time_axis(axes: Axes, result: Result, label: bool = True) -> None:
    """Time to the right [s], over the whole run."""
    axes.set_xlim(0.0, data.end_time(result))
    if label:
        axes.set_xlabel("time (s)")


def _ends(extent: float, joint: str) -> tuple[list[float], list[str]]:
    from matplotlib.ticker import MaxNLocator

    inner = [tick for tick in MaxNLocator(5).tick_values(0.0, extent) if 0.06 * extent < tick < 0.94 * extent]
    ticks = [0.0, *(float(tick) for tick in inner), extent]
    names = [f"{tick:g}" for tick in ticks]
    names[0], names[-1] = f"oral{joint}{names[0]}", f"anal{joint}{names[-1]}"
    if joint == "\n":
        names[0], names[-1] = f"{ticks[0]:g}\noral", f"{ticks[-1]:g}\nanal"
    return ticks, names


IN_SPACE, ON_THE_TUBE = "axial position (mm)", "undeformed position z (mm)"
"""Labels of places: in space, between the clamped ends, or on the tube as it was."""


def _extent(result: Result, label: str) -> float:
    """How far an axis with this label goes [mm]."""
    return data.length(result) if label == ON_THE_TUBE else data.span(result)


def axis_down(axes: Axes, result: Result, label: str = IN_SPACE) -> None:
    """Place along the tube downwards [mm], the oral end at the top."""
    extent = _extent(result, label)
    axes.set_ylim(extent, 0.0)
    axes.set_yticks(*_ends(extent, "  "))
    axes.set_ylabel(label)


def show_ends(axes: Axes, result: Result) -> None:
    """On an axis that runs down: room for what stands out over the clamped ends, and lines at these; else nothing."""
    extent, (oral, anal) = data.span(result), data.beyond_ends(result)
    if max(oral, anal) < LEAST_BEYOND:
        return
    room = 0.07 * extent  # for the words
    axes.set_ylim(extent + max(1.1 * anal, room), -max(1.1 * oral, room))
    bulges = result.summary.get("bulge_cm") or {}
    for name, place in (("oral", 0.0), ("anal", extent)):
        axes.axhline(place, color="0.35", linewidth=1.2, label="_end")
        bulge = 10.0 * float(bulges.get(name) or 0.0)
        words = f"clamped {name} end" + (f"; wall bulges {bulge:.2g} mm" if bulge >= LEAST_BEYOND else "")
        axes.annotate(
            words,
            (0.99, place),
            xycoords=("axes fraction", "data"),
            xytext=(0, 2 if name == "oral" else -2),
            textcoords="offset points",
            ha="right",
            va="bottom" if name == "oral" else "top",
            fontsize=8,
            color="0.25",
            path_effects=outlined("white", 2.0),
        )


def axis_right(axes: Axes, result: Result, label: str | None = IN_SPACE) -> None:
    """Place along the tube to the right [mm], the oral end at the left."""
    extent = _extent(result, label or IN_SPACE)
    axes.set_xlim(0.0, extent)
    axes.set_xticks(*_ends(extent, "\n"))
    if label is not None:
        axes.set_xlabel(label)


def unrolled_axes(axes: Axes, result: Result) -> None:
    """Place on the undeformed tube to the right [mm], angle upwards [deg]."""
    axis_right(axes, result, ON_THE_TUBE)
    axes.set_ylim(0.0, 360.0)
    axes.set_yticks([0.0, 90.0, 180.0, 270.0, 360.0])
    axes.set_ylabel("angle (deg)")


def colour_map(axes: Axes, result: Result, time: Floats, place: Floats, field: Floats, cmap: str, norm: Any) -> Any:
    """A map with time to the right and place downwards; `field` has shape (n_time, n_place)."""
    width = result.configuration.output.interval
    borders = data.edges(place)
    return axes.pcolormesh(
        data.edges(time, width), borders, field.T, cmap=cmap, norm=norm, shading="flat", rasterized=True
    )


def colour_bar(mesh: Any, axes: Axes | Sequence[Axes], label: str, cax: Axes | None = None, pad: float = 0.015) -> Any:
    """A colour bar to the right of a panel, of several panels, or in the place kept for it."""
    panels = list(axes) if isinstance(axes, Sequence) else [axes]
    if cax is not None:
        bar = panels[0].figure.colorbar(mesh, cax=cax)
    else:
        bar = panels[0].figure.colorbar(mesh, ax=panels, aspect=16 * len(panels), pad=pad, fraction=0.06)
    bar.set_label(label)
    bar.outline.set_linewidth(0.6)
    return bar


def legend_above(axes: Axes, columns: int = 4, size: float = 8.5) -> None:
    """A legend outside the panel, at the right of its title, where it hides nothing."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=columns,
        fontsize=size,
        frameon=False,
        borderpad=0.2,
        borderaxespad=0.0,
        handlelength=1.4,
        handletextpad=0.5,
        columnspacing=1.2,
    )


def legend_on_map(axes: Axes) -> None:
    """A dark legend inside a map, at the lower left, where the wave has not been yet."""
    legend = axes.legend(loc="lower left", labelcolor="white", framealpha=0.6)
    legend.get_frame().set_facecolor("0.25")


def signed(value: float, digits: int = 3) -> str:
    """A number in text with a true minus and a power of ten where it needs one."""
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    text = mantissa.replace("-", "\N{MINUS SIGN}")
    return rf"{text} $\times$ 10$^{{{int(exponent)}}}$" if exponent else text


def second_unit(axes: Axes, factor: float, label: str) -> None:
    """A second ordinate on the right: the left one times `factor`."""
    other = axes.secondary_yaxis("right", functions=(lambda y: y * factor, lambda y: y / factor))
    other.set_ylabel(label)


def outlined(colour: str = "black", width: float = 3.0) -> list[Any]:
    """A path effect that keeps a thin line or a text visible on any map."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=width, foreground=colour), Normal()]


def mark_expelled(axes: Axes, result: Result, text_top: float | None = None) -> None:
    """A vertical line where the pellet was expelled; a text downwards from `text_top` (share of the panel) says so."""
    left = data.left(result)
    if left is None:
        return
    when, words = left
    axes.axvline(when, color=GREY, linewidth=1.0, linestyle=(0, (4, 2)), label="_expelled")
    if text_top is not None:
        axes.annotate(
            f"{words} {when:.2f} s",
            (when, text_top),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=8.5,
            color="0.35",
        )


def widened(low: float, high: float, share: float = 0.06) -> tuple[float, float]:
    """Limits of an axis with some air around the data; never of no height."""
    air = share * (high - low)
    return (low - air, high + air) if high > low else (low - 1.0, high + 1.0)


def finite_range(*curves: Floats, least: float) -> tuple[float, float]:
    """Limits of an axis for curves that may be flat or hold nan."""
    return widened(*data.limits(*curves, np.zeros(1), least=least))


def write(figure: Canvas, path: Path, title: str, caption: str) -> None:
    """Write a figure with its title and caption inside the file; the file appears whole or not at all."""
    described: dict[str, dict[str, Any]] = {
        "png": {"Title": title, "Description": caption},
        "svg": {"Title": title, "Description": caption, "Date": None},
        "pdf": {"Title": title, "Subject": caption, "CreationDate": None},
    }
    ending = path.suffix.removeprefix(".")
    with whole(path) as temporary, applied():
        figure.savefig(temporary, format=ending, metadata=described[ending])
