"""What a calibration left: tables of its constants, combinations, points and claims held out, and their picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..plots import style
from .calibration import SHIPPED, Calibration, Candidate, good_points, ranked
from .claim import Claim
from .drawing import canvas
from .score import HOLDS, score, score_all
from .source import Picture, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EVEN = 12.0**-0.5
"""Spread of points that are even over a range, in ranges."""
FIXED = 0.5
"""Spread, as a share of that of even points, below which a constant counts as fixed."""


def constants(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """One row a free constant: its prior, the range of the points that hold, their spread, the shipped value."""
    good = good_points(claims, plan, candidates)
    first = [one for one in candidates if one.round_ == 0 and one.name != SHIPPED]
    lone = [one for one in first if score(claims[0], one.measured).verdict == HOLDS]
    shares, alone = _shares(plan, good), _shares(plan, lone)
    shipped = next(one for one in candidates if one.name == SHIPPED)
    rows = []
    for place, one in enumerate(plan.free):
        values = [float(point.values[one.name]) for point in good]
        value = float(shipped.values[one.name])
        inside = bool(values) and min(values) <= value <= max(values)
        spread = _spread(shares[:, place])
        rows.append(
            (
                *(", ".join(one.keys), one.unit, f"{one.low:g} to {one.high:g}"),
                f"{min(values):.3g} to {max(values):.3g}" if values else "–",
                *(_percent(_spread(alone[:, place])), _percent(spread)),
                "free" if not spread < FIXED else "fixed",
                f"{value:g}, {'inside' if inside else 'outside'}",
            )
        )
    note = (
        f"{len(good)} of {len(candidates) - 1} points hold; of the {len(first)} of the first round {len(lone)} do as "
        "far as the first claim. Spread: of the points over the prior range, as a share of that of even points."
    )
    head = ("constant", "unit", "prior range", "range that holds", "spread, first claim alone", "spread, all asked")
    return Table("calibration", "What the calibration fixes", note, (*head, "left", "shipped"), tuple(rows))


def combinations(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """Principal directions of the points that hold, the best fixed first, in shares of the prior ranges."""
    shares = _shares(plan, good_points(claims, plan, candidates))
    rows = []
    if len(shares) > len(plan.free):
        sizes, directions = np.linalg.eigh(np.cov(shares.T))
        for size, direction in zip(sizes, directions.T, strict=True):
            signed = direction * np.sign(direction[np.argmax(np.abs(direction))])
            words = " ".join(
                f"{weight:+.2f} {one.name}" for weight, one in zip(signed, plan.free, strict=True) if abs(weight) > 0.2
            )
            rows.append((_percent(float(np.sqrt(max(size, 0.0))) / EVEN), words))
    note = "Weights below 0.2 are left out. A combination with a small spread is what the claims together fix."
    return Table("combinations", "Which combinations they fix", note, ("spread", "combination"), tuple(rows))


def points(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """Every point as a row, the best first: its constants, the aim, and the verdicts asked and held out."""
    rows = []
    for one in ranked(claims, plan, candidates):
        verdicts = {found.claim.number: found.verdict for found in score_all(claims, one.measured)}
        speed = one.measured.get(plan.aim.run, {}).get(plan.aim.metric)
        asked = [verdicts[number] for number in plan.claims]
        out = [verdicts[number] if one.complete else "" for number in plan.held_out]
        numbers = [f"{float(one.values[free.name]):.4g}" for free in plan.free]
        rows.append((one.name, f"{speed:.3f}" if speed is not None else "", *asked, *out, *numbers))
    head = [f"claim {number}" for number in (*plan.claims, *plan.held_out)]
    columns = ("point", plan.aim.metric, *head, *(one.name for one in plan.free))
    return Table("calibration_points", "Points of the calibration", "", columns, tuple(rows))


def predicted(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """At how many of the points that hold each claim holds that was not asked."""
    good = good_points(claims, plan, candidates)
    rows = []
    for claim in claims:
        if claim.number in plan.held_out:
            count = sum(score(claim, one.measured).verdict == HOLDS for one in good)
            rows.append((str(claim.number), claim.statement, claim.use, f"{count} of {len(good)}"))
    return Table(
        "held_out",
        "Claims that were held out",
        "At the points where all asked claims hold.",
        ("claim", "statement", "worth", "holds at"),
        tuple(rows),
    )


def _shares(plan: Calibration, found: Sequence[Candidate]) -> NDArray[np.float64]:
    return np.array([plan.shares(one.values) for one in found]).reshape(-1, len(plan.free))


def _spread(shares: NDArray[np.float64]) -> float:
    return float(np.std(shares, ddof=1)) / EVEN if shares.size > 1 else float("nan")


def _percent(share: float) -> str:
    return f"{share:.0%}" if np.isfinite(share) else "–"


def picture(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Picture:
    """Where the points lie that hold, in the prior range of every constant."""
    good, shipped = good_points(claims, plan, candidates), next(one for one in candidates if one.name == SHIPPED)

    def draw(_: object) -> Canvas:
        figure = canvas(7.4, 0.6 + 0.55 * len(plan.free), "Points at which all claims asked hold")
        axes = figure.subplots()
        for row, one in enumerate(plan.free):
            own = [one.share(float(point.values[one.name])) for point in good]
            axes.plot((0.0, 1.0), (row, row), color="0.85", linewidth=7, solid_capstyle="butt", zorder=0)
            axes.plot(
                own, np.full(len(own), row), "|", color=style.BLUE, markersize=13, label="holds" if not row else ""
            )
            ours = one.share(float(shipped.values[one.name]))
            axes.plot([ours], [row], "o", color=style.ORANGE, label="" if row else "shipped")
            axes.annotate(f"{one.low:g}", (0.0, row), (-4, 0), textcoords="offset points", ha="right", va="center")
            words = f"{one.high:g}" + (f" {one.unit}" if one.unit != "1" else "")
            axes.annotate(words, (1.0, row), (4, 0), textcoords="offset points", ha="left", va="center")
        axes.set_yticks(range(len(plan.free)), [one.name.replace("_", " ") for one in plan.free])
        axes.tick_params(axis="y", length=0, pad=44)
        axes.set_xticks([])
        axes.set_xlim(-0.02, 1.02)
        axes.set_ylim(len(plan.free) - 0.5, -0.9)
        for side in axes.spines.values():
            side.set_visible(False)
        axes.legend(loc="upper center", ncols=2, fontsize=8, frameon=False)
        return figure

    caption = "Grey: the prior range, by the logarithm but where it begins at 0. Blue: points. Orange: shipped."
    return Picture("calibration", "", "What the calibration leaves", caption, (), draw)
