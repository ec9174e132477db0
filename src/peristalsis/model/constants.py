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
from ..wall.active import ActiveConstants
from ..wall.membrane import WallConstants
from ..wall.passive import PassiveConstants

__all__ = ["PELLET_DRY", "LumenConstants", "PelletConstants", "Step", "packed", "unpack_lumen", "unpack_wall"]


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
def unpack_wall(p: np.ndarray) -> WallConstants:
    """The wall's constants from what `packed` made of them."""
    return WallConstants(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10] != 0.0,
        PassiveConstants(p[11], p[12], p[13], p[14], p[15], p[16], p[17]),
        ActiveConstants(p[18], p[19], p[20]),
        ActiveConstants(p[21], p[22], p[23]),
    )  # fmt: skip


@compiled
def unpack_lumen(p: np.ndarray) -> LumenConstants:
    """The lumen's constants from what `packed` made of them."""
    return LumenConstants(p[0], p[1], p[2])
