"""Sums over arrays in eight interleaved parts: the same bits every time, and no addition waits for the one before.

A single running sum takes as long as its additions take one by one. Fast-math would let the compiler split it as it
likes; here the split is written down.
"""

from __future__ import annotations

import numpy as np

from .compiled import INDEX, compiled

LANES = 8


@compiled
def dot(a: np.ndarray, b: np.ndarray, first: int, end: int) -> float:
    """Sum of a[i]*b[i] over first <= i < end."""
    first, end = first & INDEX, end & INDEX
    lanes = np.zeros(LANES)
    whole = first + (end - first) // LANES * LANES
    for i in range(first, whole, LANES):
        for k in range(LANES):
            lanes[k] += a[i + k] * b[i + k]
    for i in range(whole, end):
        lanes[0] += a[i] * b[i]
    return _pairs(lanes)


@compiled
def total(a: np.ndarray) -> float:
    """Sum of all entries."""
    lanes = np.zeros(LANES)
    whole = a.size // LANES * LANES
    for i in range(0, whole, LANES):
        for k in range(LANES):
            lanes[k] += a[i + k]
    for i in range(whole, a.size):
        lanes[0] += a[i]
    return _pairs(lanes)


@compiled
def squares_and_largest(a: np.ndarray, first: int, end: int) -> tuple[float, float]:
    """Sum of squares, and the largest size, of a[i] over first <= i < end; the sum is nan where an entry is."""
    first, end = first & INDEX, end & INDEX
    lanes = np.zeros(LANES)
    largest = np.zeros(LANES)
    whole = first + (end - first) // LANES * LANES
    for i in range(first, whole, LANES):
        for k in range(LANES):
            size = abs(a[i + k])
            lanes[k] += size * size
            largest[k] = size if size > largest[k] else largest[k]
    for i in range(whole, end):
        size = abs(a[i])
        lanes[0] += size * size
        largest[0] = size if size > largest[0] else largest[0]
    return _pairs(lanes), largest.max()


@compiled
def _pairs(lanes: np.ndarray) -> float:
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]))
