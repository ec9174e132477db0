"""What a calibration left: tables of its constants, combinations, points and claims held out, and their picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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

Floats = NDArray[np.float64]

EVEN = 12.0**-0.5
"""Spread of points that are even over a range, in ranges."""
FIXED = 0.5
"""Spread, as a share of that of even points, below which a constant that the claims narrow is fixed by them."""
SURE = 0.01
"""Chance below which points that hold are narrower, or lie elsewhere, than as many taken at random."""
DRAWS = 2000
"""Random choices of points by which that chance is told."""


UNITS = {"1": "", "uA/cm^2": "µA/cm²", "mN*s/cm": "mN·s/cm"}
"""Units as a picture writes them."""


@dataclass(frozen=True)
class Held:
    """Where points lie in the prior ranges, (n, n_free), of which round each is, and which of them hold, (n,)."""

    shares: Floats
    round_: NDArray[np.int64]
    holds: NDArray[np.bool_]

    @property
    def good(self) -> Floats:
        """Those that hold."""
        return self.shares[self.holds]

    def at_random(self, seed: int) -> list[Floats]:
        """As many points as hold, of each round as many, taken at random among those drawn; the same for a seed."""
        random = np.random.default_rng((seed, 1))
        rounds = [np.flatnonzero(self.round_ == one) for one in np.unique(self.round_)]
        counts = [int(self.holds[places].sum()) for places in rounds]
        return [
            self.shares[
                np.concatenate([random.choice(p, n, replace=False) for p, n in zip(rounds, counts, strict=True)])
            ]
            for _ in range(DRAWS)
        ]


def held(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Held:
    """All drawn points, without the shipped one."""
    drawn = [one for one in candidates if one.name != SHIPPED]
    shares = np.array([plan.shares(one.values) for one in drawn])
    good = {one.name for one in good_points(claims, plan, candidates)}
    return Held(shares, np.array([one.round_ for one in drawn]), np.array([one.name in good for one in drawn]))


def chances(found: Held, seed: int) -> Floats:
    """For each constant, how often points taken at random are as narrow as those that hold, or as far from the middle
    of all; doubled, because either counts; nan where fewer than two hold. (n_free,)."""
    good = found.good
    if len(good) < 2:
        return np.full(found.shares.shape[1], np.nan)
    others = np.array(found.at_random(seed))
    spreads, means = others.std(axis=1), others.mean(axis=1)
    middle = means.mean(axis=0)
    narrow = (spreads <= good.std(axis=0)).mean(axis=0)
    aside = (np.abs(means - middle) >= np.abs(good.mean(axis=0) - middle)).mean(axis=0)
    return np.asarray(np.minimum(2.0 * np.minimum(narrow, aside), 1.0))


def constants(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """One row a free constant: its prior, the range of the points that hold, what chance makes of it, the shipped."""
    found = held(claims, plan, candidates)
    good = good_points(claims, plan, candidates)
    first = [one for one in candidates if one.round_ == 0 and one.name != SHIPPED]
    lone = [one for one in first if score(claims[0], one.measured).verdict == HOLDS]
    shipped = next(one for one in candidates if one.name == SHIPPED)
    rows = []
    for place, (one, chance) in enumerate(zip(plan.free, chances(found, plan.seed), strict=True)):
        values = [float(point.values[one.name]) for point in good]
        value = float(shipped.values[one.name])
        inside = bool(values) and min(values) <= value <= max(values)
        spread = _spread(found.good[:, place])
        rows.append(
            (
                *(", ".join(one.keys), one.unit, f"{one.low:g} to {one.high:g}"),
                f"{min(values):.3g} to {max(values):.3g}" if values else "–",
                *(_percent(spread), f"{chance:.2g}" if np.isfinite(chance) else "–"),
                _left(spread, chance),
                f"{value:g}, {'inside' if inside else 'outside'}",
            )
        )
    note = (
        f"{len(good)} of {len(candidates) - 1} points hold; of the {len(first)} of the first round {len(lone)} do as "
        f"far as claim {claims[0].number} alone is asked. Spread: of the points that hold over the prior range, as a "
        "share of that of even points. Chance: of as many points, taken at random from those drawn, being as narrow or "
        f"as far to one side; below {SURE:g} the claims narrow a constant, and fix it where the spread is below "
        f"{FIXED:.0%}."
    )
    head = ("constant", "unit", "prior range", "range that holds", "spread", "chance", "left", "shipped")
    return Table("calibration", "What the calibration fixes", note, head, tuple(rows))


def _left(spread: float, chance: float) -> str:
    if not chance < SURE:
        return "free"
    return "fixed" if spread < FIXED else "narrowed"


def combinations(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> Table:
    """Principal directions of the points that hold, the best fixed first, in shares of the prior ranges."""
    found = held(claims, plan, candidates)
    rows, note = [], "Too few points hold to tell."
    if len(found.good) > len(plan.free):
        sizes, directions = np.linalg.eigh(np.cov(found.good.T))
        others = [np.linalg.eigvalsh(np.cov(one.T))[0] for one in found.at_random(plan.seed)]
        usual = _percent(_width(float(np.quantile(others, SURE))))
        for size, direction in zip(sizes, directions.T, strict=True):
            signed = direction * np.sign(direction[np.argmax(np.abs(direction))])
            words = " ".join(
                f"{weight:+.2f} {one.name}" for weight, one in zip(signed, plan.free, strict=True) if abs(weight) > 0.2
            )
            rows.append((_percent(_width(float(size))), words))
        rows.append((usual, "narrowest of as many points taken at random, once in 100 times"))
        note = (
            "Directions in the prior ranges along which the points that hold spread least and most, as shares of the "
            "spread of even points; weights below 0.2 are left out. The claims fix what is below the last row."
        )
    return Table("combinations", "Which combinations it fixes", note, ("spread", "combination"), tuple(rows))


def _width(variance: float) -> float:
    return float(np.sqrt(max(variance, 0.0))) / EVEN


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


def _spread(shares: Floats) -> float:
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
            words = f"{one.high:g} {UNITS.get(one.unit, one.unit)}"
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
