"""Rectangular stimulus pulses in time and space, and the current they bring to the cells of a sheet."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]


RING = 2.0 * math.pi
"""The whole ring [rad]."""


class Pulse(NamedTuple):
    """A stimulus from time `begin` to `end` [s] over z in [low, high] [cm], around `angle` over `sector` [rad].

    strength: a current [uA/cm^2], inward positive, or an opened conductance [mS/cm^2]; who reads it knows which.
    """

    begin: float
    end: float
    low: float
    high: float
    strength: float
    angle: float = 0.0
    sector: float = RING


class Listed(NamedTuple):
    """Pulses in the order of their begins [s]; reach: the latest end of each and of all before it [s]."""

    begins: tuple[float, ...] = ()
    pulses: tuple[Pulse, ...] = ()
    reach: tuple[float, ...] = ()

    def between(self, start: float, stop: float) -> list[Pulse]:
        """The pulses that are on at some time in [start, stop] [s]."""
        first = bisect.bisect_right(self.reach, start)  # all before are over
        last = bisect.bisect_left(self.begins, stop, first)
        return [pulse for pulse in self.pulses[first:last] if pulse.end > start]


NO_PULSES = Listed()


def listed(pulses: Iterable[Pulse]) -> Listed:
    """Pulses, put in order."""
    ordered = tuple(sorted(pulses, key=lambda pulse: pulse.begin))
    reach = tuple(itertools.accumulate((pulse.end for pulse in ordered), max))
    return Listed(tuple(pulse.begin for pulse in ordered), ordered, reach)


def covered(edges_low: Floats, edges_high: Floats, low: float, high: float) -> Floats:
    """Share of each cell [edges_low, edges_high] inside [low, high]: exact at partly covered cells."""
    inside = np.minimum(edges_high, high) - np.maximum(edges_low, low)
    return np.clip(inside, 0.0, None) / (edges_high - edges_low)


def covered_around(columns: int, angle: float, sector: float) -> Floats:
    """Share of each column, centred at 2 pi j / columns, inside the sector of `sector` [rad] centred at `angle`."""
    if sector >= RING * (1.0 - 1e-12):
        return np.ones(columns)
    half = math.pi / columns
    offset = (RING * np.arange(columns) / columns - angle + math.pi) % RING - math.pi
    share = np.zeros(columns)
    for turn in (-RING, 0.0, RING):  # a column may reach around to both ends of the sector
        share += covered(offset + turn - half, offset + turn + half, -0.5 * sector, 0.5 * sector)
    return share


def overlap_in_time(begin: float, end: float, start: float, stop: float) -> float:
    """Share of the step [start, stop] during which a pulse is on: the charge delivered is exact for any step."""
    return max(min(stop, end) - max(start, begin), 0.0) / (stop - start)


def add_pulses(
    pulses: Iterable[Pulse],
    cells: Floats,
    cell_size: float,
    start: float,
    stop: float,
    drive: Floats,
    response: Floats | float = 1.0,
) -> None:
    """Add the mean strength of every pulse over the step [start, stop] to `drive`, shape (n_z, n_theta).

    response: factor on what the cells get, a number or of the shape of `drive`.
    """
    for pulse in pulses:
        share = overlap_in_time(pulse.begin, pulse.end, start, stop)
        if share > 0.0 and drive.shape[1] == 1 and isinstance(response, float):
            around = float(covered_around(1, pulse.angle, pulse.sector)[0])
            _add_ring(cells, cell_size, pulse.low, pulse.high, pulse.strength * share, around, response, drive)
        elif share > 0.0:
            where = covered(cells - 0.5 * cell_size, cells + 0.5 * cell_size, pulse.low, pulse.high)
            columns = covered_around(drive.shape[1], pulse.angle, pulse.sector)
            drive += (pulse.strength * share * where)[:, None] * columns * response


@compiled
def _add_ring(
    cells: np.ndarray,
    cell_size: float,
    low: float,
    high: float,
    strength: float,
    around: float,
    response: float,
    drive: np.ndarray,
) -> None:
    """One pulse onto rings of cells, (n_z, 1): `covered` and the factors in the order of `add_pulses`."""
    for k in range(cells.size):
        edge_low, edge_high = cells[k] - 0.5 * cell_size, cells[k] + 0.5 * cell_size
        inside = max(min(edge_high, high) - max(edge_low, low), 0.0)
        drive[k, 0] += strength * (inside / (edge_high - edge_low)) * around * response
