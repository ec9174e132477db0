"""All waves of a run, from the upstrokes of its cells: where each began, which way, how fast, and by what.

Upstrokes of neighbouring cells that are nearest to one another in time belong to one response of the tissue. A
response that begins between its ends, or in which two fronts meet, is taken apart where its times turn: each part is
a front that runs one way, and is called a wave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .measures import FASTEST, FEWEST_CELLS, speed_of_line

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SLOWEST = 0.25
"""Neighbouring cells that fire further apart than at this speed [cm/s] do not belong to one wave."""
FARTHEST = 0.5
"""Silent tissue that a wave may pass over [cm]."""
SAME_UPSTROKE = 0.02
"""A cell that rises again within this time [s] flickers about the level."""
LEAST_TURN = 0.01
"""Times of arrival that turn by less than this [s] are noise."""
LEAST_EXTENT = 0.5
"""A response of less than this length [cm] is local: it travelled nowhere."""
BEGINNING = (0.3, 0.1)
"""What began within this distance [cm] and time [s] of a wave's start may have started it."""

CONDUCTED, STIMULATED, SPONTANEOUS = range(3)
"""Origin of an upstroke: after a neighbour's, under a stimulus, or by the cell itself."""
ORIGINS = ("conducted", "stimulus", "spontaneous")
ANTEGRADE, RETROGRADE, STANDING, LOCAL = "antegrade", "retrograde", "standing", "local"
DIRECTIONS = (ANTEGRADE, RETROGRADE, STANDING, LOCAL)
"""Towards the anal end, towards the oral end, all cells together, and not travelling."""


class Wave(NamedTuple):
    """One wave: when [s] and where [cm] it began, where it ended, which way, speed [cm/s] or nan, cells, origin.

    speed: positive towards the anal end; nan where there is no one speed.
    """

    time: float
    start: float
    end: float
    direction: str
    speed: float
    cells: int
    origin: str


def waves(z: Floats, time: Floats, cell: Indices, origin: Indices) -> list[Wave]:
    """The waves in the upstrokes of one layer, in the order of time.

    z: cells [cm], (n_z,). time [s], cell, origin (CONDUCTED, STIMULATED or SPONTANEOUS): of the upstrokes, (n,).
    """
    found = []
    for response in _responses(z, time, cell):
        places, times, origins = z[cell[response]], time[response], origin[response]
        parts = _fronts(times)
        long = [part for part in parts if abs(places[part[1]] - places[part[0]]) >= LEAST_EXTENT]
        for first, last in long or [(0, len(times) - 1)]:
            found.append(_wave(places, times, origins, slice(first, last + 1), local=not long))
    return sorted(found, key=lambda wave: (wave.time, wave.start))


def _responses(z: Floats, time: Floats, cell: Indices) -> list[Indices]:
    """Upstrokes that belong together, as places in the arrays, in the order of z: at most one of each cell."""
    columns = _by_cell(time, cell)
    cells = sorted(columns)
    following: dict[int, int] = {}
    for low, high in pairwise(cells):
        distance = float(z[high] - z[low])
        if high - low > 1 and distance > FARTHEST:
            continue
        for a, b in _nearest_pairs(time, columns[low], columns[high]):
            if abs(time[b] - time[a]) <= distance / SLOWEST:
                following[a] = b
    found = []
    reached = set(following.values())
    for one in (k for c in cells for k in columns[c]):
        if one in reached:
            continue
        chain = [one]
        while chain[-1] in following:
            chain.append(following[chain[-1]])
        found.append(np.array(chain, dtype=np.int64))
    return found


def _by_cell(time: Floats, cell: Indices) -> dict[int, list[int]]:
    """For each cell that fired its upstrokes in the order of time, without flicker."""
    columns: dict[int, list[int]] = {}
    for k in np.argsort(time, kind="stable").tolist():
        own = columns.setdefault(int(cell[k]), [])
        if not own or time[k] - time[own[-1]] > SAME_UPSTROKE:
            own.append(k)
    return columns


def _nearest_pairs(time: Floats, low: Sequence[int], high: Sequence[int]) -> list[tuple[int, int]]:
    """Pairs of upstrokes of two cells that are each the other's nearest in time."""

    def nearest(one: int, others: Sequence[int], times: Floats) -> int:
        k = int(np.searchsorted(times, time[one]))
        around = [j for j in (k - 1, k) if 0 <= j < len(others)]
        return others[min(around, key=lambda j: abs(times[j] - time[one]))]

    low_times, high_times = time[list(low)], time[list(high)]
    partners = [(one, nearest(one, high, high_times)) for one in low]
    return [(a, b) for a, b in partners if nearest(b, low, low_times) == a]


def _fronts(times: Floats) -> list[tuple[int, int]]:
    """First and last place of each part of `times` that runs one way, turns below LEAST_TURN aside."""
    turns = [0]
    extreme, rising = 0, 0
    for k, value in enumerate(times.tolist()):
        if rising >= 0 and value >= times[extreme]:
            if value > times[turns[-1]] + LEAST_TURN:
                rising = 1
            extreme = k
        elif rising <= 0 and value <= times[extreme]:
            if value < times[turns[-1]] - LEAST_TURN:
                rising = -1
            extreme = k
        elif abs(value - times[extreme]) > LEAST_TURN:
            turns.append(extreme)
            rising = 1 if value > times[extreme] else -1
            extreme = k
    turns.append(len(times) - 1)
    return [(a, b) for a, b in pairwise(turns) if b > a] or [(0, len(times) - 1)]


def _wave(places: Floats, times: Floats, origins: Indices, part: slice, local: bool) -> Wave:
    own_places, own_times = places[part], times[part]
    begins = int(np.argmin(own_times))
    start = float(own_places[begins])
    # A wave that runs orally began at its anal end; one that stands began everywhere.
    ends = float(own_places[-1] if abs(own_places[-1] - start) >= abs(own_places[0] - start) else own_places[0])
    when = float(own_times[begins])
    near = (np.abs(places - start) <= BEGINNING[0]) & (times <= when + BEGINNING[1])
    causes = origins[near]
    origin = next((kind for kind in (STIMULATED, SPONTANEOUS) if bool((causes == kind).any())), CONDUCTED)
    speed, direction = math.nan, LOCAL
    if not local:
        direction = STANDING
        extent, passage = abs(ends - start), float(np.ptp(own_times))
        if passage * FASTEST > extent:
            direction = ANTEGRADE if ends > start else RETROGRADE
            speed = _speed(own_places, own_times)
    return Wave(when, start, ends, direction, speed, len(own_times), ORIGINS[origin])


def _speed(places: Floats, times: Floats) -> float:
    """Speed of a front [cm/s], nan if it has none: over the middle of its way, away from its start and its end."""
    low, high = times.min(), times.max()
    middle = (times >= low + 0.1 * (high - low)) & (times <= high - 0.1 * (high - low))
    if middle.sum() < FEWEST_CELLS:
        middle[:] = True
    found = speed_of_line(places[middle], times[middle], "of the front").speed
    return math.nan if found is None else found
