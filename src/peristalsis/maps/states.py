"""What the wall does, told from pressure and diameter together: contracting, relaxing, moved passively, or quiet.

A wall that narrows while the pressure rises contracts, one that widens while it falls relaxes; one that widens under
rising or narrows under falling pressure is moved by what is in it. After Costa et al. 2013, doi
10.3389/fnsys.2013.00007 (abstract), with a threshold for each rate; the finer states of theirs are not told apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError
from .comparing import grid, on_grid
from .contractions import Rule, smoothed
from .recording import Floats, Map, Numbers, locked

QUIET, CONTRACTING, RELAXING, DISTENDED, EMPTYING = range(5)
STATES = ("quiet", "contracting", "relaxing", "passive: distended", "passive: emptying")


class States(NamedTuple):
    """State of the wall over time and place: numbers of STATES, -1 in gaps, (n_time, n_place).

    time [s]; place [mm]; thresholds: of the rates of pressure [mmHg/s] and diameter [mm/s]; shares: of each state.
    """

    state: NDArray[np.int8]
    time: Floats
    place: Floats
    thresholds: tuple[float, float]
    shares: dict[str, float]


def states(
    diameter: Map, pressure: Map, thresholds: tuple[float, float] | None = None, smooth_time: float = 0.5
) -> States:
    """The states of the wall where both maps have numbers, on the coarser of their steps.

    thresholds: rates of pressure [mmHg/s] and diameter [mm/s] below which the wall is quiet; a tenth of the rate that
    one value in a hundred exceeds unless given. smooth_time: deviation of the bell in time before rates are taken [s].
    """
    for one, wanted in ((diameter, "diameter"), (pressure, "pressure")):
        if one.quantity != wanted:
            raise ConfigurationError(f"{one.name} is a map of {one.quantity}, and one of {wanted} is needed here")
    time, place = grid(diameter, pressure)
    rule = Rule(smooth_time=smooth_time, smooth_place=0.0, bridge=0.0)
    rates = []
    for one in (pressure, diameter):
        shared = one.done("on a grid with another", values=locked(on_grid(one, time, place)), time=time, place=place)
        rates.append(np.gradient(smoothed(np.array(shared.values), shared, rule), time, axis=0))
    least = thresholds or (_tenth(rates[0]), _tenth(rates[1]))
    rising, falling = rates[0] > least[0], rates[0] < -least[0]
    widening, narrowing = rates[1] > least[1], rates[1] < -least[1]
    found = np.full(rates[0].shape, QUIET, dtype=np.int8)
    found[rising & narrowing], found[falling & widening] = CONTRACTING, RELAXING
    found[rising & widening], found[falling & narrowing] = DISTENDED, EMPTYING
    known = np.isfinite(rates[0]) & np.isfinite(rates[1])
    found[~known] = -1
    shares = {name: float((found[known] == number).mean()) for number, name in enumerate(STATES)}
    return States(found, time, place, least, shares)


def _tenth(rate: Numbers) -> float:
    known = np.abs(rate[np.isfinite(rate)])
    return 0.1 * float(np.quantile(known, 0.99))
