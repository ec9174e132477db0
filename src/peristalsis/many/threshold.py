"""Where a yes-or-no property of a run changes along a parameter: scan, show every change, bracket the last.

A property need not be monotone: the scan lists every interval of its points over which it changes, and the
bisection closes in on one of them. What changes twice between two points of the scan is not seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

Predicate = Callable[[float], bool | None]
"""True, False, or None where the run says nothing."""


@dataclass(frozen=True, slots=True)
class Point:
    """One value that was tried, and what came out."""

    value: float
    holds: bool | None


@dataclass(frozen=True, slots=True)
class Threshold:
    """The bracket of the last change to True, or None where there is none; all points, in order of value.

    changes: every interval of the scan over which the property changes; more than one means not monotone.
    """

    low: float | None
    high: float | None
    points: tuple[Point, ...]
    changes: tuple[tuple[float, float], ...]

    @property
    def value(self) -> float | None:
        """Middle of the bracket."""
        return None if self.low is None or self.high is None else 0.5 * (self.low + self.high)

    @property
    def monotone(self) -> bool:
        """Whether the scan saw at most one change, and that one upwards."""
        judged = [point.holds for point in self.points if point.holds is not None]
        return judged == sorted(judged)

    def regions(self) -> tuple[tuple[float, float, bool], ...]:
        """Runs of tried values with the same outcome: first, last, outcome."""
        found: list[tuple[float, float, bool]] = []
        for point in self.points:
            if point.holds is None:
                continue
            if found and found[-1][2] == point.holds:
                found[-1] = (found[-1][0], point.value, point.holds)
            else:
                found.append((point.value, point.value, point.holds))
        return tuple(found)


def find_threshold(
    predicate: Predicate,
    values: Sequence[float],
    tolerance: float = 0.02,
    scan: Callable[[Sequence[float]], Sequence[bool | None]] | None = None,
) -> Threshold:
    """Scan rising `values`, then bisect the last change from False to True to a width of `tolerance` of its middle.

    The last such change, because beyond it the property stays: for one that is monotone it is the only one. scan:
    evaluates many values at once, in parallel for example; by default one after the other.
    """
    ordered = sorted(values)
    outcomes = [predicate(value) for value in ordered] if scan is None else list(scan(ordered))
    points = [Point(value, holds) for value, holds in zip(ordered, outcomes, strict=True)]
    judged = [point for point in points if point.holds is not None]
    changes = tuple((one.value, two.value) for one, two in pairwise(judged) if one.holds != two.holds)
    upward = [(one.value, two.value) for one, two in pairwise(judged) if two.holds and not one.holds]
    if not upward:
        return Threshold(None, None, tuple(points), changes)
    low, high = upward[-1]
    while high - low > tolerance * 0.5 * (high + low):
        middle = 0.5 * (low + high)
        holds = predicate(middle)
        points.append(Point(middle, holds))
        if holds is None:  # nothing to be learned there: the bracket stays as wide as it is
            break
        low, high = (low, middle) if holds else (middle, high)
    return Threshold(low, high, tuple(sorted(points, key=lambda point: point.value)), changes)
