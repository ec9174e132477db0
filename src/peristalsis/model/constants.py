"""Constants of lumen and step, and all constants as flat arrays.

A compiled call takes an array in a tenth of the time that it takes a tuple of tuples.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..pellet.constants import PELLET_DRY, PelletConstants
from ..wall.constants import WallConstants

__all__ = ["PELLET_DRY", "LumenConstants", "PelletConstants", "Step", "packed", "unpack_lumen"]


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
def unpack_lumen(p: np.ndarray) -> LumenConstants:
    """The lumen's constants from what `packed` made of them."""
    return LumenConstants(p[0], p[1], p[2])
