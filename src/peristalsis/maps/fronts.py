"""Fronts of contractions: points where a place is deepest or crosses the threshold, linked from place to place.

Contractions that cross have one deepest time where they meet. Both are followed through by the way that they came.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .recording import Floats, Numbers

RECENT = 12
"""Points of a front that say where it goes next."""
TOP = 0.8
"""Share of the depth of a peak above which lies its top; its middle is the ridge."""
MISSED = 2
"""Places that a front may miss, such as dead channels of a catheter."""


class Point(NamedTuple):
    """A place in contraction: its column, place [mm], deepest time and times of the threshold [s], depth there."""

    column: int
    place: float
    ridge: float
    onset: float
    end: float
    width: float
    depth: float


@dataclass
class _Front:
    """A front while it is followed, from one side to the other."""

    points: list[Point]
    slope: float = 0.0
    known: bool = False
    passing: int = 0

    def expected(self, place: float) -> float:
        last = self.points[-1]
        return last.ridge + self.slope * (place - last.place)

    def take(self, point: Point) -> None:
        self.points.append(point)
        recent = self.points[-RECENT:]
        self.passing = 0
        if len(recent) >= 2:
            places, times = np.array([p.place for p in recent]), np.array([p.ridge for p in recent])
            middle = places - places.mean()
            self.slope = float(middle @ times / (middle @ middle))
            self.known = len(recent) >= 4


def points(
    depth: Numbers, time: Floats, place: Floats, columns: range, inside: Numbers, threshold: float
) -> list[Point]:
    """The points of a region: one for each peak of depth in each run above the threshold, by column.

    depth: (n_time, n_place). inside: whether a sample belongs to the region, (n_time, columns).
    """
    from scipy.signal import find_peaks

    found = []
    for number, column in enumerate(columns):
        own = np.concatenate([[False], inside[:, number], [False]])
        borders = np.flatnonzero(own[1:] != own[:-1])
        for first, last in zip(borders[::2].tolist(), borders[1::2].tolist(), strict=True):
            course = depth[first:last, column]
            padded = np.concatenate([[threshold], course, [threshold]])
            peaks = (find_peaks(padded, prominence=0.25 * threshold)[0] - 1).tolist() or [int(np.argmax(course))]
            cuts = [0, *(a + int(np.argmin(course[a:b])) for a, b in pairwise(peaks)), last - first]
            for peak, begin, end in zip(peaks, cuts, cuts[1:], strict=False):
                found.append(
                    _point(
                        depth[:, column],
                        time,
                        (column, float(place[column])),
                        first + begin,
                        first + end,
                        first + peak,
                        threshold,
                    )
                )
    return found


def _point(
    course: Numbers, time: Floats, at: tuple[int, float], first: int, last: int, peak: int, threshold: float
) -> Point:
    height = float(course[peak])
    low, high = peak, peak + 1  # the top of the peak, about which even a slow relaxation is level
    while low > first and course[low - 1] > TOP * height:
        low -= 1
    while high < last and course[high] > TOP * height:
        high += 1
    part, when = course[low:high], time[low:high]
    weight = np.clip(part - max(threshold, TOP * height), 0.0, None)
    total = float(weight.sum())
    ridge = float(weight @ when) / total if total > 0.0 else float(time[peak])
    onset, end = _crossing(course, time, first, -1, threshold), _crossing(course, time, last - 1, 1, threshold)
    half = 0.5 * height
    left, right = peak, peak
    while left > 0 and course[left] > half:
        left -= 1
    while right < course.size - 1 and course[right] > half:
        right += 1
    rise = _crossing(course, time, left + 1, -1, half) if left < peak else np.nan
    fall = _crossing(course, time, right - 1, 1, half) if right > peak else np.nan
    return Point(*at, ridge, onset, end, fall - rise, height)


def _crossing(course: Numbers, time: Floats, inner: int, way: int, level: float) -> float:
    """When a course crosses a level between a sample inside and the one beside it; nan where that is missing."""
    outer = inner + way
    if not 0 <= outer < course.size or not np.isfinite(course[outer]) or course[outer] > level:
        return float("nan")
    share = (float(course[inner]) - level) / max(float(course[inner]) - float(course[outer]), 1e-30)
    return float(time[inner] + min(max(share, 0.0), 1.0) * (time[outer] - time[inner]))


def linked(found: list[Point], reach: float) -> list[list[Point]]:
    """Points linked to fronts, each a list by rising place.

    A front goes on at the point that lies nearest to where its last points lead, within half its own duration. Two that
    lead to one point leave it out and go on by the way they came. reach: how far a front may miss points [mm]; two
    places may be missed however far apart they are.
    """
    by_column: dict[int, list[Point]] = {}
    for point in found:
        by_column.setdefault(point.column, []).append(point)
    active: list[_Front] = []
    done: list[_Front] = []
    for column in sorted(by_column):
        here = by_column[column]
        place = here[0].place
        gone = [front for front in active if not front.passing and not near(front.points[-1], column, place, reach)]
        done += gone
        active = [front for front in active if front not in gone]
        taken = _shared_out(active, here, place)
        for index, point in enumerate(here):
            if index not in taken:
                active.append(_Front([point]))
    return [front.points for front in (*done, *active)]


def near(last: Point, column: int, place: float, reach: float) -> bool:
    """Whether a front may go on at a place after its last point."""
    return place - last.place <= reach or column - last.column <= MISSED + 1


def _shared_out(active: list[_Front], here: list[Point], place: float) -> set[int]:
    """Give the points of a column to the fronts; the points that are not left to begin new ones."""
    wishes = []
    for front in active:
        expected = front.expected(place)
        for index, point in enumerate(here):
            early, late = _bounds(point)
            last_early, last_late = _bounds(front.points[-1])
            spread = 0.5 * max(late - early, last_late - last_early)
            away = abs(point.ridge - expected)
            near = away <= spread if front.known else early <= last_late and late >= last_early
            if near:
                wishes.append((away, id(front), front, index))
    wanted: dict[int, list[_Front]] = {}
    for _, _, front, index in wishes:
        wanted.setdefault(index, []).append(front)
    only = {id(front) for front in active if sum(one is front for _, _, one, _ in wishes) == 1}
    taken: set[int] = set()
    busy: set[int] = set()
    for index, fronts in wanted.items():
        rivals = [front for front in fronts if front.known and id(front) in only]
        if len(rivals) >= 2 and len(here) < len(active):  # they meet here: neither learns its way from this point
            taken.add(index)
            for front in rivals:
                front.passing += 1
                busy.add(id(front))
    for _, key, front, index in sorted(wishes, key=lambda wish: wish[0]):
        if index not in taken and key not in busy:
            front.take(here[index])
            taken.add(index)
            busy.add(key)
    return taken


def _bounds(point: Point) -> tuple[float, float]:
    """From when to when a place is in contraction [s]."""
    half = 0.5 * point.width if np.isfinite(point.width) else 0.0
    early = point.onset if np.isfinite(point.onset) else point.ridge - half
    late = point.end if np.isfinite(point.end) else point.ridge + half
    return min(early, point.ridge), max(late, point.ridge)


def median_width(front: list[Point]) -> float:
    """Median time at half the depth [s]; nan where no point has one, such as at the end of a recording."""
    known = [point.width for point in front if np.isfinite(point.width)]
    return float(np.median(known)) if known else float("nan")


def turned(front: list[Point], least: int = 4) -> list[list[Point]]:
    """A front, cut in two where it turns around: a contraction that spreads both ways has one for each."""
    if len(front) < 2 * least:
        return [front]
    x, t = np.array([p.place for p in front]), np.array([p.ridge for p in front])
    whole = _line(x, t)[1]
    best, cut = whole, 0
    for index in range(least, len(front) - least + 1):
        (left, first), (right, second) = _line(x[:index], t[:index]), _line(x[index:], t[index:])
        if left * right < 0.0 and first + second < best:
            best, cut = first + second, index
    width = median_width(front)
    floor = 0.25 * (0.1 * width) ** 2 * len(front) if np.isfinite(width) else 0.0
    if not cut or best > 0.25 * whole or whole < floor:
        return [front]
    return [front[:cut], front[cut:]]


def _line(x: Floats, t: Floats) -> tuple[float, float]:
    """Slope of a straight line through points, and the sum of the squares that it leaves."""
    middle = x - x.mean()
    slope = float(middle @ t / (middle @ middle))
    rest = t - t.mean() - slope * middle
    return slope, float(rest @ rest)
