"""What may be done to a recording before it is measured: on demand, each a line in its history; nothing by default.

Gaps stay gaps unless a function says otherwise.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..errors import ConfigurationError, shown
from .recording import Floats, Map, Numbers, locked

SIGMA = 1.4826
"""Median absolute deviation times this is the standard deviation of normal noise."""
MOST_VALUES = 200_000_000
"""Values of a map that is resampled, 1.6 GB: a step that makes more was hardly meant."""


def resampled(recorded: Map, time_step: float | None = None, place_step: float | None = None) -> Map:
    """The map at even times, places or both, `time_step` [s] and `place_step` [mm] apart.

    Where a new step holds two or more of the old, the mean of what lies within half a step (a gap where half of that is
    missing); else linear, a gap where a neighbour is one.
    """
    values, time, place, lines = recorded.values, recorded.time, recorded.place, []
    if time_step is not None:
        values, time = _along(values, time, _checked(time_step, "time_step (--resample)", "s", recorded.duration))
        lines.append(f"every {time_step:g} s")
    if place_step is not None:
        turned, place = _along(values.T, place, _checked(place_step, "place_step", "mm", recorded.length))
        values = np.ascontiguousarray(turned.T)
        lines.append(f"every {place_step:g} mm")
    return recorded.done(
        f"resampled {' and '.join(lines) or 'not at all'}", values=locked(values), time=time, place=place
    )


def despiked(recorded: Map, window: float, limit: float = 6.0) -> Map:
    """The map without values that lie further than `limit` robust deviations from the running median of `window` [s].

    They become gaps. The deviation is that of each place: 1.4826 times the median distance from its running median.
    """
    step = recorded.time_step()
    width = 2 * max(1, round(0.5 * _checked(window, "window (--despike)", "s", recorded.duration) / step)) + 1
    if not limit > 0.0:
        raise ConfigurationError(f"limit = {shown(limit)} must be above 0; 6 is usual")
    from scipy.ndimage import median_filter

    values, count = recorded.values.copy(), 0
    for column in range(values.shape[1]):
        own = values[:, column]
        known = np.isfinite(own)
        if known.sum() < width:
            continue
        whole = own if known.all() else np.interp(recorded.time, recorded.time[known], own[known])
        away = np.abs(whole - median_filter(whole, width, mode="nearest"))
        spikes = known & (away > limit * max(SIGMA * float(np.median(away[known])), 1e-12))
        own[spikes] = np.nan
        count += int(spikes.sum())
    line = f"de-spiked: {count} values further than {limit:g} deviations from the median of {width} became gaps"
    return recorded.done(line, values=locked(values))


def level(recorded: Map, window: float) -> Map:
    """The map without slow drift: less the running median of `window` [s] at each place, plus the median of the whole.

    The median is taken of a window every quarter of one, of half a one at both ends, and is linear between their
    middles and beyond the first and last. Choose a window several times as long as a contraction, or these are
    flattened too.
    """
    window = _checked(window, "window (--level)", "s", 0.5 * recorded.duration)
    first, last = recorded.time[0] + 0.5 * window, recorded.time[-1] - 0.5 * window
    centres = np.linspace(first, last, max(2, round(4.0 * (last - first) / window) + 1))
    values = recorded.values
    middle = median_of_places(values)
    spans = [(one - 0.5 * window, one + 0.5 * window) for one in centres]
    spans = [(recorded.time[0], first), *spans, (last, recorded.time[-1])]
    centres = np.concatenate([[first - 0.25 * window], centres, [last + 0.25 * window]])
    borders = [np.searchsorted(recorded.time, span) for span in spans]
    knots = np.stack([median_of_places(values[begin:end]) for begin, end in borders])
    drift = np.where(np.isnan(knots), middle, knots) - middle
    right = np.clip(np.searchsorted(centres, recorded.time), 1, centres.size - 1)
    share = (recorded.time - centres[right - 1]) / (centres[right] - centres[right - 1])
    found = np.empty_like(values)
    for column in range(values.shape[1]):
        early, late = drift[right - 1, column], drift[right, column]
        found[:, column] = values[:, column] - (early + share * (late - early))
    return recorded.done(
        f"level: less the running median of {window:g} s, plus that of the whole", values=locked(found)
    )


def filled(recorded: Map, longest: float) -> Map:
    """The map with gaps of up to `longest` [s] filled, linear in time between what is on both sides."""
    values = across_gaps(recorded.values, recorded.time, _checked(longest, "longest", "s", np.inf))
    count = int(np.isnan(recorded.values).sum() - np.isnan(values).sum())
    return recorded.done(
        f"filled: {count} values in gaps of up to {longest:g} s, linear in time", values=locked(values)
    )


def across_gaps(values: Numbers, time: Floats, longest: float) -> Numbers:
    """A copy of values, (n_time, n_place), with gaps of up to `longest` [s] filled linearly in time."""
    found = values.copy()
    for column in np.flatnonzero(np.isnan(values).any(axis=0)):
        known = np.flatnonzero(np.isfinite(values[:, column]))
        if known.size < 2:
            continue
        own = found[:, column]
        missing = np.flatnonzero(np.isnan(own))
        right = np.searchsorted(known, missing)
        inside = (right > 0) & (right < known.size)
        missing, right = missing[inside], right[inside]
        short = time[known[right]] - time[known[right - 1]] <= longest + 1e-9
        at = missing[short]
        own[at] = np.interp(time[at], time[known], values[known, column])
    return found


def median_of_places(values: Numbers) -> Floats:
    """Median over time at each place, nan where there is no number."""
    if not np.isnan(values).any():
        return np.asarray(np.median(values, axis=0), dtype=np.float64)
    columns = (column[np.isfinite(column)] for column in values.T)
    return np.array([np.median(one) if one.size else np.nan for one in columns], dtype=np.float64)


def _along(values: Numbers, axis: Floats, step: float) -> tuple[Numbers, Floats]:
    """Values, (n, m), and the axis of their rows at even steps."""
    count = int((axis[-1] - axis[0]) / step + 1e-9) + 1
    if count * values.shape[1] > MOST_VALUES:
        raise ConfigurationError(
            f"a step of {step:g} makes {count:.3g} by {values.shape[1]} values of {axis.size} by {values.shape[1]}, "
            f"more than {MOST_VALUES:.0e}; resample at a longer one"
        )
    fresh = axis[0] + step * np.arange(count)
    if axis.size > 1 and step >= 2.0 * float(np.median(np.diff(axis))):
        borders = np.searchsorted(axis, np.append(fresh - 0.5 * step, fresh[-1] + 0.5 * step))
        rows = []
        for first, last in pairwise(borders.tolist()):
            block = values[first:last]
            known = np.isfinite(block)
            count = known.sum(axis=0)
            total = np.where(known, block, 0.0).sum(axis=0)
            enough = (count > 0) & (2 * count >= len(block))
            rows.append(np.where(enough, total / np.maximum(count, 1), np.nan))
        return np.stack(rows), fresh
    right = np.clip(np.searchsorted(axis, fresh), 1, axis.size - 1)
    share = ((fresh - axis[right - 1]) / (axis[right] - axis[right - 1]))[:, None]
    left_part, right_part = values[right - 1], values[right]
    between = (1.0 - share) * left_part + share * right_part
    return np.where(share <= 0.0, left_part, np.where(share >= 1.0, right_part, between)), fresh


def _checked(value: float, key: str, unit: str, most: float) -> float:
    if not 0.0 < value <= most:
        raise ConfigurationError(f"{key} = {value:g} {unit} must be above 0 and at most {most:g} {unit}; change it")
    return float(value)
