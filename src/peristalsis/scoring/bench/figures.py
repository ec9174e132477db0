"""Pictures of the bench: speed against diameter and load, isometric force, the diameter map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...plots import style
from ..drawing import beside, canvas, colour, curve, usable
from ..outcome import Outcome
from ..source import Picture
from .claims import STALLED
from .runs import ABOVE, BELOW, CONTROL, HELD, LOADS, diameter_run, load_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

SPEED = "middle_speed_mm_s"
WIDE = (7.4, 4.2)


def _points(outcome: Outcome, runs: Sequence[str], at: str | None, metric: str, places: Sequence[float] = ()) -> Any:
    """Places and values of a metric over runs, (2, n); `at`: the metric that is the place, else `places`."""
    found = []
    for index, run in enumerate(runs):
        numbers = outcome.measured.get(run, {})
        value, place = numbers.get(metric), numbers.get(at) if at else places[index]
        if value is not None and place is not None:
            found.append((float(place), float(value)))
    return np.array(sorted(found)).T if found else np.empty((2, 0))


def _curve(
    title: str, across: str, up: str, draw: Callable[[Axes, Outcome, int], None]
) -> Callable[[Sequence[Outcome]], Canvas]:
    def made(outcomes: Sequence[Outcome]) -> Canvas:
        figure = canvas(*WIDE, title)
        axes: Axes = figure.subplots()
        for index, outcome in enumerate(outcomes):
            draw(axes, outcome, index)
        axes.set_xlabel(across)
        axes.set_ylabel(up)
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.25)
        axes.legend(fontsize=8)
        return figure

    return made


def _sizes(held: bool) -> list[str]:
    return [*(diameter_run(ratio, held) for ratio in (*BELOW, *ABOVE)), HELD if held else CONTROL]


def _speed_by_diameter(axes: Axes, outcome: Outcome, number: int) -> None:
    axes.plot(*_points(outcome, _sizes(False), "ratio", SPEED), marker="o", **curve(number, outcome.condition.title))
    control = outcome.measured.get(CONTROL, {})
    if control.get(SPEED) and number == 0:
        natural, speed = float(control["ratio"]), float(control[SPEED])
        axes.axvline(natural, color="0.6", linestyle=":")
        axes.fill_between((natural, ABOVE[-1]), 0.85 * speed, 1.15 * speed, color="0.85", label="asked above it")


def _force_by_diameter(axes: Axes, outcome: Outcome, number: int) -> None:
    force = _points(outcome, _sizes(True), "ratio", "isometric_force_mN")
    axes.plot(*force, marker="o", **curve(number, outcome.condition.title))


def _speed_by_load(axes: Axes, outcome: Outcome, number: int) -> None:
    runs = [CONTROL, *(load_run(weight) for weight in LOADS)]
    axes.plot(*_points(outcome, runs, None, SPEED, (0, *LOADS)), marker="o", **curve(number, outcome.condition.title))
    if number == 0:
        axes.axhline(STALLED, color="0.6", linestyle=":", label="stalled below")


def _isometric(outcomes: Sequence[Outcome]) -> Canvas:
    figure = canvas(*WIDE, "Axial force on a held pellet")
    axes = figure.subplots()
    outcome = outcomes[0]
    for number, (run, label) in enumerate(((HELD, "control"), ("held_hexamethonium", "reflex weakened by half"))):
        record = usable(outcome, run)
        if record is not None:
            arrays = record.arrays
            axes.plot(arrays["time_step"], arrays["axial_force"], color=colour(number), label=label)
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("axial force (mN)")
    axes.grid(alpha=0.25)
    if axes.get_lines()[:-1]:  # beside the line at zero
        axes.legend(fontsize=8)
    return figure


def _maps(outcomes: Sequence[Outcome]) -> Canvas:
    """Inner diameter over place and time as a camera above the bench sees it, oral end at the top."""
    figure, panels = beside(len(outcomes), 5.4, 4.4, "Diameter map of the control")
    for axes, outcome in zip(panels, outcomes, strict=True):
        record = usable(outcome, CONTROL)
        axes.set_title(outcome.condition.title, fontsize=9)
        if record is None:
            continue
        arrays = record.arrays
        grid = np.linspace(0.0, float(arrays["axial_position"].max()), 200)  # between the ends, as they are held
        shown = np.array(
            [20.0 * np.interp(grid, x, r) for x, r in zip(arrays["axial_position"], arrays["radius"], strict=True)]
        )
        mesh = axes.pcolormesh(arrays["time"], 10.0 * grid, shown.T, cmap="gray", shading="nearest")
        axes.plot(arrays["time_step"], 10.0 * arrays["pellet_position"], color=style.ORANGE, linewidth=1.0)
        axes.invert_yaxis()
        axes.set_xlabel("time (s)")
        axes.set_ylabel("anal   axial position (mm)   oral")
        figure.colorbar(mesh, ax=axes, label="inner diameter (mm)")
    return figure


PICTURES: tuple[Picture, ...] = (
    Picture(
        "speed_diameter",
        "",
        "Speed against the pellet's diameter",
        "Mean speed over the middle 3 cm. Dotted: the natural pellet; grey: within 15 % of its speed.",
        tuple(_sizes(False)),
        _curve(
            "Speed against diameter", "girth of the pellet over that of the tube", "speed (mm/s)", _speed_by_diameter
        ),
    ),
    Picture(
        "speed_load",
        "",
        "Speed against a resistive load",
        "A weight on a string behind the natural pellet. Below 0.1 mm/s it counts as stalled.",
        (CONTROL, *(load_run(weight) for weight in LOADS)),
        _curve("Speed against load", "weight (mN)", "speed (mm/s)", _speed_by_load),
    ),
    Picture(
        "isometric",
        "",
        "Isometric force",
        "The natural pellet held in the middle of the segment, and the same with the reflex weakened by half.",
        (HELD, "held_hexamethonium"),
        _isometric,
    ),
    Picture(
        "force_diameter",
        "",
        "Isometric force against the pellet's diameter",
        "Mean over the second half of 40 s, held in the middle of the segment.",
        tuple(_sizes(True)),
        _curve(
            "Isometric force against diameter",
            "girth of the pellet over that of the tube",
            "axial force (mN)",
            _force_by_diameter,
        ),
    ),
    Picture(
        "diameter_map",
        "",
        "Diameter map",
        "Grey as in a laboratory's map: narrow is dark. In recordings of the isolated colon a bright band, the pellet "
        "with relaxed wall ahead of it, moves anally at a steady slope, with a dark band of contraction behind it that "
        "ends after some seconds (PMC3997013, abstract). Here the band and its slope are there; the contraction behind "
        "lasts to the end of the run. Orange: the pellet's centre.",
        (CONTROL,),
        _maps,
    ),
)
