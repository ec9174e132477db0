"""Constants of lumen, pellet and step, and all constants as flat arrays.

A compiled call takes an array in a tenth of the time that it takes a tuple of tuples.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..wall.constants import WallConstants


class PelletConstants(NamedTuple):
    """Pellet and friction: cm, mN, s. `frame` w is 0 for friction at rest, 1 against the moving wall, Eq. (27).

    tangential: a part of the reaction on the wall lies in its tangent plane, that of Eq. (51); else all of it is axial.
    lowest, highest: between which the centre stays [cm], Eq. (60); infinite where the segment's end is open.
    """

    present: bool
    radius: float
    viscous: float
    dry: float
    frame: float
    volume: float
    tangential: bool = False
    lowest: float = -math.inf
    highest: float = math.inf


PELLET_DRY = 3
"""Place of `dry` among the numbers of `PelletConstants`."""


class LumenConstants(NamedTuple):
    """Adiabatic lumen, Eq. (17): p = pressure*(reference_volume/V)^exponent in mN/cm^2 and cm^3."""

    pressure: float
    reference_volume: float
    exponent: float


class Step(NamedTuple):
    """Formulas of one step: wall rates (history*, slope), pellet Z = pellet_history + pellet_weight*velocity."""

    slope: float
    inertia: bool
    pellet_history: float
    pellet_weight: float


@lru_cache(maxsize=256)
def packed(constants: WallConstants | PelletConstants | LumenConstants) -> NDArray[np.float64]:
    """All numbers of a (nested) tuple in order, flags as 0 and 1; shared, read-only."""
    numbers = np.array(_numbers(constants), dtype=np.float64)
    numbers.setflags(write=False)
    return numbers


def _numbers(part: Any) -> list[float]:
    if isinstance(part, tuple):
        return [number for inner in part for number in _numbers(inner)]
    return [float(part)]


@compiled
def unpack_pellet(p: np.ndarray) -> PelletConstants:
    """The pellet's constants from what `packed` made of them."""
    return PelletConstants(p[0] != 0.0, p[1], p[2], p[3], p[4], p[5], p[6] != 0.0, p[7], p[8])


@compiled
def unpack_lumen(p: np.ndarray) -> LumenConstants:
    """The lumen's constants from what `packed` made of them."""
    return LumenConstants(p[0], p[1], p[2])
