"""Contractions as objects: where each began, which way and how fast it went, how far, how deep, how long.

The depth of a contraction is how far a value lies below (diameter, stretch) or above (pressure) the median of its place
over time. What is deeper than a threshold is labelled (scipy.ndimage), each region is followed from place to place
(`fronts`), and a straight line through its points gives speed and direction. `Rule` holds every number of it.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError, shown
from .fronts import RECENT, Point, linked, median_width, near, points, turned
from .recording import QUANTITIES, Floats, Map, Numbers
from .treatment import SIGMA, across_gaps, median_of_places

DIRECTIONS = ("antegrade", "retrograde", "standing")
FRONTS = ("ridge", "threshold")
NOISE = 5.0
"""Deviations of the noise that a chosen threshold is at least."""


@dataclass(frozen=True)
class Rule:
    """What counts as a contraction.

    threshold: depth in the unit of the map; unless given, `share` of the depth that one value in a thousand exceeds,
    and at least five robust deviations of the noise. front: ridge (where a place is deepest) or threshold (where it
    crosses it). smooth_time [s], smooth_place [mm]: deviations of the bell that depths are smoothed with before they
    are labelled; 0.4 s, or a hundredth of a recording shorter than 40 s, unless given; places that are not evenly
    spaced are not smoothed. least_extent [mm], least_places, least_duration [s]: what is smaller is left out. bridge
    [s]: gaps up to this are crossed. reach [mm]: parts of one front may lie this far apart, or two places. standing: a
    contraction whose front is earlier at one end than at the other by less than this share of its duration, or by less
    than twice the error of that, stands.
    """

    threshold: float | None = None
    share: float = 0.4
    front: str = "ridge"
    smooth_time: float | None = None
    smooth_place: float = 1.0
    least_extent: float = 8.0
    least_places: int = 3
    least_duration: float = 0.2
    bridge: float = 2.0
    reach: float = 10.0
    standing: float = 0.25

    def __post_init__(self) -> None:
        if self.front not in FRONTS:
            raise ConfigurationError(f"front = {shown(self.front)}: a front is found by ridge or threshold; say which")
        for one in fields(self):
            value = getattr(self, one.name)
            if one.name != "front" and value is not None and not 0.0 <= float(value) < 1e6:
                raise ConfigurationError(f"rule: {one.name} = {shown(value)} must not be below 0; change it")


@dataclass(frozen=True)
class Contraction:
    """One contraction. Times in s, places in mm from the oral end, speeds in mm/s, depths in the unit of the map.

    begin, place: when and where its front begins; end, until: when and where it ends. speed: of the front, None if it
    stands; error: its standard error. amplitude: median depth along the way; deepest: the largest once smoothed.
    duration: time at half the depth of the mean course about the front, not smoothed. interval: since the one before
    at the middle of its way, None for the first. occlusion: median depth over the median diameter of the place (of
    diameters; else None). front: places and times.
    """

    number: int
    direction: str
    begin: float
    place: float
    end: float
    until: float
    extent: float
    speed: float | None
    error: float | None
    amplitude: float
    deepest: float
    duration: float
    interval: float | None
    occlusion: float | None
    front: tuple[Floats, Floats]


@dataclass(frozen=True)
class Contractions(Sequence[Contraction]):
    """The contractions of a map in the order of their begins, and the threshold and rule that found them."""

    found: tuple[Contraction, ...]
    rule: Rule
    threshold: float
    noise: float
    unit: str
    duration: float
    """Of the map [s]."""

    @property
    def chosen_by_noise(self) -> bool:
        """Whether the threshold was chosen, and noise (or drift, which looks like it) decided it."""
        return self.rule.threshold is None and self.threshold <= NOISE * self.noise * (1.0 + 1e-9)

    def __len__(self) -> int:
        return len(self.found)

    def __getitem__(self, index: Any) -> Any:
        return self.found[index]

    def of(self, direction: str) -> list[Contraction]:
        """Those of one direction."""
        return [one for one in self.found if one.direction == direction]

    def csv(self) -> str:
        """One row a contraction, units in the header; what found them in lines that begin with #."""
        names = [one.name for one in fields(Contraction) if one.name != "front"]
        units = {
            **dict.fromkeys(("begin", "end", "duration", "interval"), "s"),
            **dict.fromkeys(("place", "until", "extent"), "mm"),
            **dict.fromkeys(("speed", "error"), "mm/s"),
            **dict.fromkeys(("amplitude", "deepest"), self.unit),
        }
        text = io.StringIO()
        for number in fields(Rule):
            text.write(f"# rule, {number.name}: {getattr(self.rule, number.name)}\n")
        text.write(f"# threshold used [{self.unit}]: {self.threshold:.6g}\n")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([f"{name} [{units[name]}]" if name in units else name for name in names])
        for one in self.found:
            values = (getattr(one, name) for name in names)
            writer.writerow([f"{value:.6g}" if isinstance(value, float) else value for value in values])
        return text.getvalue()

    def numbers(self) -> dict[str, float | int | None]:
        """Counts, rate and medians, as they stand beside those of another map."""
        speeds = [one.speed for one in self.of("antegrade") if one.speed is not None]
        back = [one.speed for one in self.of("retrograde") if one.speed is not None]
        intervals = [one.interval for one in self.found if one.interval is not None]
        return {
            "contractions": len(self.found),
            **{direction: len(self.of(direction)) for direction in DIRECTIONS},
            "rate_per_min": 60.0 * len(self.found) / self.duration if self.duration else None,
            "antegrade_speed_mm_s": _median(speeds),
            "retrograde_speed_mm_s": _median(back),
            "interval_s": _median(intervals),
            "extent_mm": _median([one.extent for one in self.found]),
            "amplitude": _median([one.amplitude for one in self.found]),
            "duration_s": _median([one.duration for one in self.found]),
            "largest_occlusion": max((one.occlusion for one in self.found if one.occlusion is not None), default=None),
        }


def contractions(recorded: Map, rule: Rule | None = None) -> Contractions:
    """The contractions of a map. Its times must be even (ConfigurationError); the same map gives the same bits."""
    chosen = rule or Rule()
    raw, level = depths(recorded)
    smooth = smoothed(raw, recorded, chosen)
    noise, threshold = _threshold(smooth, chosen)
    fronts = _fronts(smooth, recorded, chosen, threshold)
    measured = [_measured(front, raw, level, recorded, chosen) for front in fronts]
    kept = sorted((one for one in measured if one is not None), key=lambda one: (one["begin"], one["place"]))
    found: list[Contraction] = []
    for number, one in enumerate(kept, 1):
        found.append(Contraction(number=number, interval=_interval(one["front"], found), **one))
    return Contractions(tuple(found), chosen, threshold, noise, recorded.unit, recorded.duration)


def depths(recorded: Map) -> tuple[Numbers, Floats]:
    """Depth of contraction over time and place in single precision, and the median of each place; gaps stay."""
    level = median_of_places(recorded.values)
    sign = QUANTITIES[recorded.quantity].contraction
    found = np.asarray(recorded.values, dtype=np.float32) - level.astype(np.float32)
    return (found if sign > 0 else np.negative(found, out=found)), level


def smoothed(depth: Numbers, recorded: Map, rule: Rule) -> Numbers:
    """Depths smoothed with a bell, gaps up to `bridge` crossed; what is missing has no weight."""
    from scipy.ndimage import gaussian_filter

    spread = min(0.4, 0.01 * recorded.duration) if rule.smooth_time is None else rule.smooth_time
    widths = [spread / recorded.time_step(), 0.0]
    if recorded.even_places:
        widths[1] = rule.smooth_place / recorded.place_step()
    filled = across_gaps(depth, recorded.time, rule.bridge)
    missing = np.isnan(filled)
    if not any(widths):
        return filled
    if not missing.any():
        return np.asarray(gaussian_filter(filled, widths, mode="nearest", truncate=3.0))
    filled[missing] = 0.0
    weight = gaussian_filter((~missing).astype(np.float32), widths, mode="nearest", truncate=3.0)
    found = gaussian_filter(filled, widths, mode="nearest", truncate=3.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        found /= weight
    found[missing] = np.nan
    return np.asarray(found)


def _threshold(depth: Numbers, rule: Rule) -> tuple[float, float]:
    """Deviation of the noise, and the depth from which on a place is in contraction."""
    thinned = depth[:: max(1, depth.shape[0] // 20_000)].ravel()
    known = thinned[np.isfinite(thinned)]
    noise = SIGMA * float(np.median(np.abs(known - np.median(known))))
    if rule.threshold is not None:
        return noise, float(rule.threshold)
    return noise, max(rule.share * float(np.quantile(known, 0.999)), NOISE * noise, 1e-9)


def _fronts(depth: Numbers, recorded: Map, rule: Rule, threshold: float) -> list[list[Point]]:
    """Points of each front by rising place, those of one contraction joined, what is too small left out."""
    from scipy.ndimage import find_objects, label

    known = np.flatnonzero(np.isfinite(depth).mean(axis=0) > 0.1)
    deep = np.nan_to_num(depth[:, known], nan=-1.0) > threshold if known.size else np.zeros((1, 0), dtype=bool)
    labels, count = label(deep, structure=np.ones((3, 3), dtype=int))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    place, found = recorded.place[known], list[list[Point]]()
    kept = depth[:, known]
    for number, region in enumerate(find_objects(labels), 1):
        if region is None or sizes[number] < 3:
            continue
        rows, columns = region
        margin = int(np.ceil(2.0 * (rows.stop - rows.start))) + 2
        first, last = max(0, rows.start - margin), min(len(deep), rows.stop + margin)
        inside = labels[first:last, columns] == number
        here = points(
            kept[first:last], recorded.time[first:last], place, range(columns.start, columns.stop), inside, threshold
        )
        for front in linked(here, rule.reach):
            found += turned(front)
    return [one for one in _joined(found, rule) if _large(one, rule)]


def _large(front: list[Point], rule: Rule) -> bool:
    widths = [point.end - point.onset for point in front]
    longest = max((width for width in widths if np.isfinite(width)), default=np.inf)
    far = front[-1].place - front[0].place
    return far >= rule.least_extent and len(front) >= rule.least_places and longest >= rule.least_duration


def _joined(parts: list[list[Point]], rule: Rule) -> list[list[Point]]:
    """Parts of one front put together: the next begins within reach, and where and when the last leads to."""
    waiting = sorted((one for one in parts if len(one) >= 2), key=lambda one: one[0].place)
    done: list[list[Point]] = []
    while waiting:
        front = waiting.pop(0)
        while True:
            fits = [
                (abs(miss), k) for k, other in enumerate(waiting) if (miss := _miss(front, other, rule)) is not None
            ]
            if not fits:
                break
            front = front + waiting.pop(min(fits)[1])
        done.append(front)
    return done


def _miss(front: list[Point], other: list[Point], rule: Rule) -> float | None:
    """How much later another part would be halfway to it than a front [s]; None if it cannot be its continuation.

    Both are straight lines through their nearest points, far more than a gap between them disturbs.
    """
    apart = other[0].place - front[-1].place
    if apart <= 0.0 or not near(front[-1], other[0].column, other[0].place, rule.reach):
        return None
    if min(len(front), len(other)) < 3:
        return None
    middle = front[-1].place + 0.5 * apart
    ways = []
    for part in (front[-3 * RECENT :], other[: 3 * RECENT]):
        x, t = np.array([p.place for p in part]), np.array([p.ridge for p in part])
        slope, level = np.polyfit(x - middle, t, 1)
        ways.append((float(slope), float(level)))
    (slope, early), (other_slope, late) = ways
    width = median_width([*front, *other])
    alike = abs(slope - other_slope) * max(apart, 5.0) <= 0.5 * width
    return late - early if alike and abs(late - early) <= 0.5 * width else None


def _measured(front: list[Point], raw: Numbers, level: Floats, recorded: Map, rule: Rule) -> dict[str, Any] | None:
    """What is known of a front but its number and its interval."""
    pairs = [(p.place, p.ridge if rule.front == "ridge" else p.onset) for p in front]
    place, when = (np.array(one, dtype=np.float64) for one in zip(*pairs, strict=True))
    known = np.isfinite(when)
    place, when, kept = place[known], when[known], [p for p, ok in zip(front, known, strict=True) if ok]
    if place.size < max(2, rule.least_places):
        return None
    slope, error, base = _line(place, when, recorded, rule)
    extent = float(place[-1] - place[0])
    duration = median_width(kept)
    lag = slope * extent
    stands = abs(lag) < max(rule.standing * (duration if np.isfinite(duration) else 0.0), 2.0 * error * extent)
    onward = slope >= 0.0
    column = np.searchsorted(recorded.place, place - 1e-9)
    row = np.clip(
        np.round((np.array([p.ridge for p in kept]) - recorded.time[0]) / recorded.time_step()), 0, len(raw) - 1
    )
    deep = raw[row.astype(int), column].astype(np.float64)
    deep = np.where(np.isfinite(deep), deep, [p.depth for p in kept])
    smooth = np.array([p.depth for p in kept])
    lasting = _lasting(raw, row.astype(int), column, duration / recorded.time_step()) * recorded.time_step()
    ends = (float(place[0]), float(place[-1])) if onward else (float(place[-1]), float(place[0]))
    times = [base + slope * one for one in ends]
    return {
        "direction": "standing" if stands else "antegrade" if onward else "retrograde",
        "begin": float(times[0]),
        "place": ends[0],
        "end": float(times[1]),
        "until": ends[1],
        "extent": extent,
        "speed": None if stands else 1.0 / slope,
        "error": None if stands else error / slope**2,
        "amplitude": float(np.median(deep)),
        "deepest": float(smooth.max()),
        "duration": lasting if np.isfinite(lasting) else duration,
        "occlusion": float(np.median(deep / level[column])) if recorded.quantity == "diameter" else None,
        "front": (place, when),
    }


def _lasting(raw: Numbers, rows: NDArray[np.int_], columns: NDArray[np.int_], width: float) -> float:
    """Samples at half the depth of the mean course about the points of a front; nan where it does not fall so far."""
    if not np.isfinite(width):
        return float("nan")
    reach = int(np.ceil(1.5 * width)) + 1
    at = rows[:, None] + np.arange(-reach, reach + 1)
    inside = (at >= 0) & (at < len(raw))
    courses = np.where(inside, raw[np.clip(at, 0, len(raw) - 1), columns[:, None]], np.nan)
    known = np.isfinite(courses)
    if not known.any(axis=0).all():
        return float("nan")
    mean = np.where(known, courses, 0.0).sum(axis=0) / known.sum(axis=0)
    near = max(1, reach // 8)
    half = 0.5 * float(mean[reach - near : reach + near + 1].mean())
    low = np.flatnonzero(mean <= half)
    left, right = low[low < reach], low[low > reach]
    if not left.size or not right.size:
        return float("nan")
    ends = []
    for outer, inner in ((int(left[-1]), int(left[-1]) + 1), (int(right[0]), int(right[0]) - 1)):
        share = (half - mean[outer]) / (mean[inner] - mean[outer])
        ends.append(outer + float(share) * (inner - outer))
    return ends[1] - ends[0]


def _line(place: Floats, when: Floats, recorded: Map, rule: Rule) -> tuple[float, float, float]:
    """Slope [s/mm] of a front, its standard error, its time at place 0: least squares without what lies far off."""
    keep = np.ones(place.size, dtype=bool)
    slope = base = 0.0
    for _ in range(4):
        slope, base = np.polyfit(place[keep], when[keep], 1)
        rest = when - base - slope * place
        spread = SIGMA * float(np.median(np.abs(rest[keep])))
        fresh = np.abs(rest) <= max(3.5 * spread, 1e-9)
        if fresh.sum() < 3 or (fresh == keep).all():
            break
        keep = fresh
    rest, count = (when - base - slope * place)[keep], int(keep.sum())
    middle = place[keep] - place[keep].mean()
    alike = 1.0 + (
        2.0 * rule.smooth_place / recorded.place_step() if recorded.even_places else 0.0
    )  # smoothed together
    freedom = max(count / alike - 2.0, 1.0)
    error = float(np.sqrt(rest @ rest / count * (count / alike) / freedom / (middle @ middle) * alike))
    return float(slope), error, float(base)


def _interval(front: tuple[Floats, Floats], before: Sequence[Contraction]) -> float | None:
    """Time since the contraction before at the middle of a front's way [s]."""
    place = 0.5 * (front[0][0] + front[0][-1])
    here = float(np.interp(place, *front))
    times = [float(np.interp(place, *one.front)) for one in before if one.front[0][0] <= place <= one.front[0][-1]]
    gone = [here - time for time in times if time < here]
    return min(gone) if gone else None


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None
