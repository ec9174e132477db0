"""How much of a result's variance each of two factors carries, from a full factorial, with bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Shares:
    """Total share of the variance [1] of the two factors (main effect and interaction), each with a band."""

    first: float
    first_band: tuple[float, float]
    second: float
    second_band: tuple[float, float]


def total_shares(table: Floats) -> tuple[float, float]:
    """Total shares of the row factor and of the column factor: 1 - variance of the other one's means over the whole.

    table: a result at every pair of levels, (n_rows, n_columns). Zero for both if nothing varies.
    """
    variance = float(table.var())
    if variance <= 0.0:
        return 0.0, 0.0
    return 1.0 - float(table.mean(axis=0).var()) / variance, 1.0 - float(table.mean(axis=1).var()) / variance


def shares(table: Floats) -> Shares:
    """Total shares with bands: the range over leaving out one level of one factor at a time."""
    whole = total_shares(table)
    left_out = [total_shares(np.delete(table, row, axis=0)) for row in range(table.shape[0])]
    left_out += [total_shares(np.delete(table, column, axis=1)) for column in range(table.shape[1])]
    every = np.array([whole, *left_out])
    low, high = every.min(axis=0), every.max(axis=0)
    return Shares(whole[0], (float(low[0]), float(high[0])), whole[1], (float(low[1]), float(high[1])))
