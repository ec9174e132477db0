"""Rectangular stimulus pulses in time and space, and the current they bring to the cells of a sheet."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Pulse(NamedTuple):
    """A stimulus from time `begin` to `end` [s] over z in [low, high] [cm].

    strength: a current [uA/cm^2], inward positive, or an opened conductance [mS/cm^2]; who reads it knows which.
    """

    begin: float
    end: float
    low: float
    high: float
    strength: float


def covered(edges_low: Floats, edges_high: Floats, low: float, high: float) -> Floats:
    """Share of each cell [edges_low, edges_high] inside [low, high]: exact at partly covered cells."""
    inside = np.minimum(edges_high, high) - np.maximum(edges_low, low)
    return np.clip(inside, 0.0, None) / (edges_high - edges_low)


def overlap_in_time(begin: Floats | float, end: Floats | float, start: float, stop: float) -> Floats:
    """Share of the step [start, stop] during which a pulse is on: the charge delivered is exact for any step."""
    inside = np.minimum(stop, end) - np.maximum(start, begin)
    return np.asarray(np.clip(inside, 0.0, None) / (stop - start))


def add_pulses(
    pulses: Iterable[Pulse], cells: Floats, cell_size: float, start: float, stop: float, drive: Floats
) -> None:
    """Add the mean strength of every pulse over the step [start, stop] to `drive`, shape (n_z, n_theta)."""
    for pulse in pulses:
        share = float(overlap_in_time(pulse.begin, pulse.end, start, stop))
        if share > 0.0:
            where = covered(cells - 0.5 * cell_size, cells + 0.5 * cell_size, pulse.low, pulse.high)
            drive += (pulse.strength * share * where)[:, None]
