"""Speeds of waves and of a pellet between two places, defined on plain arrays: a number, or none with the reason."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FAST_PART = (0.3, 0.8)
"""Part of the undeformed tube over which wave speeds are measured, as shares of its length: 3 to 8 of 10 cm."""
USUAL_LENGTH = 10.0
"""Length of the tube on which the shipped waves were calibrated [cm]."""
FEWEST_CELLS = 3
"""A line through fewer cells says nothing."""
LEAST_SHARE = 0.9
"""Share of the cells that must have been reached, both ends among them, and of these in order: a wave that passed."""
LARGEST_RESIDUAL = 0.1
"""RMS distance of the arrivals from the line, as a share of the passage, beyond which a wave has no one speed."""
FASTEST = 100.0
"""Nothing is conducted faster than this [cm/s]: cells that are reached within less time fire together."""


class Speed(NamedTuple):
    """A speed [cm/s], positive towards the anal end, or None with the reason; how well the line fits.

    residual: RMS of the arrivals about the line [s]; share: the same over the time that the wave took. cells: how
    many cells the line goes through.
    """

    speed: float | None
    reason: str | None
    residual: float | None
    share: float | None
    cells: int


def wave_speed(z: Floats, activation: Floats, length: float = USUAL_LENGTH) -> float | None:
    """Speed of the first wave [cm/s], None if it cannot be measured: `speed_of_passage` says why."""
    return speed_of_passage(z, activation, length).speed


def speed_of_passage(z: Floats, activation: Floats, length: float, fastest: float = FASTEST) -> Speed:
    """Speed of a wave over the fast part of the tube: slope of place over time of arrival.

    z: cells [cm], (n_z,); activation: times of arrival [s], (n_z,), nan where there was none. length: of the tube
    [cm]. fastest: no conducted wave can be faster [cm/s].
    """
    low, high = FAST_PART[0] * length, FAST_PART[1] * length
    part = (z > low) & (z < high)
    where = f"between {low:.4g} and {high:.4g} cm"
    if part.sum() < FEWEST_CELLS:
        return _none(f"there are fewer than {FEWEST_CELLS} cells {where}; raise grid.n_z", 0)
    places, times = z[part], activation[part]
    there = np.isfinite(times)
    reached = int(there.sum())
    through = bool(there[:FEWEST_CELLS].any() and there[-FEWEST_CELLS:].any())
    if not through or reached < FEWEST_CELLS or reached < LEAST_SHARE * len(times):
        return _none(f"no wave passed: {reached} of {len(times)} cells {where} were reached", reached)
    return speed_of_line(places[there], times[there], where, fastest)


def speed_of_line(places: Floats, times: Floats, where: str, fastest: float = FASTEST) -> Speed:
    """Speed of a front that reached the places [cm] at the times [s], all finite: one line through those in order."""
    ordered = in_order(times)
    if len(ordered) < max(FEWEST_CELLS, LEAST_SHARE * len(times)):
        return _none(
            f"the cells {where} were not reached in order, {len(ordered)} of {len(times)} at most: fronts met there, "
            "or one began there",
            len(ordered),
        )
    places, times = places[ordered], times[ordered]
    passage = float(np.ptp(times))
    if not passage * fastest > float(np.ptp(places)):
        return _none(
            f"the cells {where} were reached within {1e3 * passage:.3g} ms, faster than a wave is conducted: they were "
            "excited together, or oscillate by themselves",
            len(ordered),
        )
    # The plain fit, to the bit, where all cells were reached in order.
    slowness, start = (float(number) for number in np.polyfit(places, times, 1))
    residual = float(np.sqrt(np.mean((times - start - slowness * places) ** 2)))
    share = residual / passage
    if share > LARGEST_RESIDUAL or slowness == 0.0 or abs(1.0 / slowness) > fastest:
        reason = f"the wave has no one speed {where}: its arrivals are {100.0 * share:.2g} % of its passage off a line"
        return Speed(None, reason, residual, share, len(ordered))
    return Speed(1.0 / slowness, None, residual, share, len(ordered))


def in_order(times: Floats) -> NDArray[np.int64]:
    """Places of the longest part of `times` that never falls, or of the longest that never rises if that is longer."""
    rising, falling = _never_falling(times.tolist()), _never_falling((-times).tolist())
    return np.array(rising if len(rising) >= len(falling) else falling, dtype=np.int64)


def _never_falling(values: list[float]) -> list[int]:
    """Places of the longest subsequence that never falls (patience sorting, n log n)."""
    tails: list[float] = []
    heads: list[int] = []
    before: list[int] = []
    for k, value in enumerate(values):
        place = bisect_right(tails, value)
        before.append(heads[place - 1] if place > 0 else -1)
        if place == len(tails):
            tails.append(value)
            heads.append(k)
        else:
            tails[place], heads[place] = value, k
    found: list[int] = []
    k = heads[-1] if heads else -1
    while k >= 0:
        found.append(k)
        k = before[k]
    return found[::-1]


def _none(reason: str, cells: int) -> Speed:
    return Speed(None, reason, None, None, cells)


def largest(values: Floats) -> float | None:
    """Largest size of the finite values; None where there is none."""
    sizes = np.abs(values[np.isfinite(values)])
    return float(sizes.max()) if sizes.size else None


def share_of(part: float | None, whole: float, least: float) -> float | None:
    """A part as a share of the whole, of `least` at any rate; None where either is unknown."""
    if part is None or not math.isfinite(part) or not math.isfinite(whole):
        return None
    return part / max(whole, least)


def speed_between(time: Floats, place: Floats, low: float, high: float) -> float:
    """Mean speed of a pellet between two places [cm/s], never negative.

    Of one that does not pass the second, over the time that is left to it; of one that does not come to the first, over
    the whole course. time [s], place [cm]: of its centre, (n,).
    """
    enters, leaves = _passes(time, place, low), _passes(time, place, high)
    if enters is None:
        return max(0.0, float(place[-1] - place[0]) / float(time[-1] - time[0]))
    if leaves is None:
        left = float(time[-1]) - enters
        return max(0.0, (float(place[-1]) - low) / left) if left > 0.0 else 0.0
    return (high - low) / (leaves - enters)


def _passes(time: Floats, place: Floats, where: float) -> float | None:
    """When a place is first passed [s], between two steps; None if it is not, or was before."""
    beyond = np.flatnonzero(place >= where)
    if beyond.size == 0 or beyond[0] == 0:
        return None
    i = int(beyond[0])
    share = (where - place[i - 1]) / (place[i] - place[i - 1])
    return float(time[i - 1] + share * (time[i] - time[i - 1]))
