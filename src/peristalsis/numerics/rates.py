"""Time derivatives of the wall: variable-step BDF2 or backward Euler in one form, Eq. (32)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class RateFormula(NamedTuple):
    """x_dot(t+dt) = (x - (keep*x_n + older*x_{n-1})) * inverse, with `inverse` in 1/s; static when it is 0."""

    keep: float
    older: float
    inverse: float

    def history(self, now: Floats, before: Floats) -> Floats:
        """keep*now + older*before, exact for what does not move: the two weights sum to one."""
        return now - self.older * (now - before)


STATIC = RateFormula(1.0, 0.0, 0.0)


def rate_formula(dt: float, dt_before: float, second_order: bool) -> RateFormula:
    """Formula for a step `dt` after a step `dt_before` [s]; dt_before = 0 (a start) gives backward Euler."""
    ratio = dt / dt_before if second_order and dt_before > 0.0 else 0.0
    beta = (1.0 + ratio) / (1.0 + 2.0 * ratio)
    return RateFormula(beta * (1.0 + ratio), -beta * ratio * ratio / (1.0 + ratio), 1.0 / (beta * dt))


def carried_on(dt: float, dt_before: float) -> float:
    """Weight k of the rate now, less k - 1 of that before, with which a step `dt` is foreseen; 1 at a start."""
    return 1.0 + 0.5 * dt / dt_before if dt_before > 0.0 else 1.0
