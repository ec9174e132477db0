"""What is found in recordings with a known answer: 20 synthetic maps, round trips, a recording of two hours.

Writes docs/evidence/maps.md and the pictures docs/images/maps_*.png. About five minutes on one core; one run of the
baseline, for the pictures and round trips, is among them.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from common import ROOT, save_text, table

import peristalsis as ps
from peristalsis import maps
from peristalsis.maps import STANDING, Contraction, Map, Ring
from peristalsis.maps.drawing import comparison, manometry, map_figure
from peristalsis.maps.synthetic import example
from peristalsis.plots import style

IMAGES = ROOT / "docs" / "images"
AMPLITUDE = 4.0
UNEVEN = np.array([0.0, 8.0, 16.0, 24.0, 32.0, 45.0, 58.0, 71.0, 90.0, 110.0, 130.0, 150.0, 175.0, 200.0])
"""Places of the channels of a catheter [mm]."""
SPEED, EXTENT, BEGIN = 0.05, 8.0, 1.0
"""What may be missed: share of the speed, extent [mm], time of the begin [s]."""


def ring(begin: float, place: float, speed: float, extent: float, **more: float) -> Ring:
    """A ring of the usual depth."""
    return Ring(begin, place, speed, extent, **{"amplitude": AMPLITUDE, **more})


def without(rows: slice, columns: slice) -> Callable[[Map], Map]:
    """A map with a part of it missing."""

    def cut(recorded: Map) -> Map:
        values = np.array(recorded.values)
        values[rows, columns] = np.nan
        return recorded.done("a part is missing", values=values)

    return cut


@dataclass(frozen=True)
class Case:
    """A synthetic map: its rings, noise as a share of the amplitude, what else it has, and what is done to it."""

    name: str
    rings: tuple[Ring, ...]
    noise: float = 0.0
    drift: float = 0.0
    dropped: float = 0.0
    duration: float = 120.0
    then: Callable[[Map], Map] | None = None
    places: np.ndarray | None = None
    quantity: str = "diameter"

    def recorded(self, seed: int) -> Map:
        """The map."""
        height = max(one.amplitude for one in self.rings)
        rest = 8.0 if self.quantity == "pressure" else 12.0
        made = maps.recording(
            self.rings,
            self.duration,
            place=self.places,
            quantity=self.quantity,
            rest=rest,
            noise=self.noise * height,
            drift=self.drift * height,
            dropped=self.dropped,
            seed=seed,
        )
        return made if self.then is None else self.then(made)


TRAIN = tuple(ring(20.0 + 40.0 * k, 5.0, 2.0, 85.0) for k in range(5))
CROSSING = (ring(15.0, 5.0, 2.0, 90.0), ring(15.0, 95.0, -2.0, 90.0))
PRESSURES = tuple(replace(ring(20.0 + 45.0 * k, 4.0, 20.0, 186.0, duration=6.0), amplitude=70.0) for k in range(3))
CASES = (
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),)),
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),), 0.1),
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),), 0.2),
    Case("retrograde", (ring(20.0, 95.0, -2.0, 85.0),), 0.2),
    Case("fast, 30 mm/s", (ring(20.0, 5.0, 30.0, 90.0),), 0.2),
    Case("slow, 0.5 mm/s", (ring(10.0, 30.0, 0.5, 40.0),), 0.2),
    Case("every 40 s", TRAIN, 0.2, duration=260.0),
    Case("one each way, apart", (ring(15.0, 5.0, 2.0, 85.0), ring(75.0, 95.0, -3.0, 85.0)), 0.2),
    Case("crossing", CROSSING),
    Case("crossing", CROSSING, 0.1),
    Case("crossing", CROSSING, 0.2),
    Case("fading by 70 %", (ring(20.0, 5.0, 2.0, 85.0, fade=0.7),), 0.1),
    Case("fading to nothing", (ring(20.0, 5.0, 2.0, 85.0, fade=1.0),), 0.2),
    Case("standing", (ring(30.0, 20.0, STANDING, 50.0),), 0.2),
    Case("spreading both ways", (ring(20.0, 50.0, 2.0, 45.0), ring(20.0, 50.0, -2.0, 45.0)), 0.1),
    Case("overtaking", (ring(10.0, 5.0, 1.2, 90.0), ring(35.0, 5.0, 3.0, 90.0)), 0.1),
    Case("5 % of frames lost", TRAIN[:2], 0.2, dropped=0.05),
    Case("10 mm not recorded", TRAIN[:2], 0.1, then=without(slice(None), slice(45, 55))),
    Case("4 s lost in a front", TRAIN[:1], 0.1, then=without(slice(380, 420), slice(None))),
    Case("pressure, uneven channels", PRESSURES, 0.2, drift=0.5, dropped=0.02, duration=180.0, places=UNEVEN,
         quantity="pressure", then=lambda one: maps.level(one, 60.0)),
)  # fmt: skip


def reached(one: Ring, places: np.ndarray) -> float:
    """Extent of a ring as the places of a recording can show it [mm]: from the first to the last that it reaches."""
    low, high = one.span
    inside = places[(places >= low) & (places <= high)]
    return float(inside[-1] - inside[0])


def matched(truth: Sequence[Ring], found: Sequence[Contraction]) -> list[Contraction | None]:
    """For each ring the contraction whose front lies nearest to its own, within its duration; each once."""
    left = list(found)
    pairs: list[Contraction | None] = []
    for one in truth:
        away = [float(np.median(np.abs(other.front[1] - one.arrival(other.front[0])))) for other in left]
        best = int(np.argmin(away)) if away else -1
        pairs.append(left.pop(best) if away and away[best] <= one.duration else None)
    return pairs


def verdict(one: Ring, got: Contraction | None, places: np.ndarray) -> str:
    """What is wrong with a contraction that was found, in words; "" where nothing is."""
    if got is None:
        return "missed"
    wrong = []
    if got.direction != one.direction:
        wrong.append(f"taken as {got.direction}")
    elif got.speed is not None and abs(got.speed / one.speed - 1.0) > SPEED:
        wrong.append(f"speed off by {100.0 * (got.speed / one.speed - 1.0):+.0f} %")
    missed = got.extent - reached(one, places)
    if abs(missed) > EXTENT:
        wrong.append(f"extent off by {missed:+.0f} mm")
    expected = float(one.arrival(np.array([got.place]))[0])
    if abs(got.begin - expected) > BEGIN:
        wrong.append(f"begin off by {got.begin - expected:+.1f} s")
    return ", ".join(wrong)


def score() -> tuple[list[list[object]], list[str]]:
    """A row for each map, and what went wrong in each."""
    rows, failures = [], []
    for number, case in enumerate(CASES, 1):
        recorded = case.recorded(number)
        found = maps.contractions(recorded)
        pairs = matched(case.rings, found.found)
        words = [text for text in (verdict(one, got, recorded.place) for one, got in zip(case.rings, pairs, strict=True)) if text]
        extra = len(found) - sum(got is not None for got in pairs)
        words += [f"{extra} that {'is' if extra == 1 else 'are'} none"] if extra else []
        got = [one for one in pairs if one is not None]
        intervals = [one.interval for one in got if one.interval is not None and len(case.rings) > 2]
        true_gap = f"{case.rings[1].begin - case.rings[0].begin:g}" if len(case.rings) > 2 else "–"
        rows.append(
            [
                number,
                f"{case.name}, noise {100.0 * case.noise:.0f} %",
                f"{len(case.rings)} / {len(found)}",
                " ".join("∞" if np.isinf(one.speed) else f"{one.speed:g}" for one in _firsts(case.rings)),
                " ".join("∞" if one.speed is None else f"{one.speed:.3g}" for one in _firsts(got)),
                " ".join(f"{reached(one, recorded.place):g}" for one in _firsts(case.rings)),
                " ".join(f"{one.extent:g}" for one in _firsts(got)),
                true_gap,
                f"{np.median(intervals):.2f}" if intervals else "–",
                "; ".join(words) or "yes",
            ]
        )
        if words:
            failures.append(f"{number} ({case.name}): {'; '.join(words)}")
    return rows, failures


def _firsts(several: Sequence) -> Sequence:
    return several[:3]
