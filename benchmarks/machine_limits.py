"""Loops that do one thing as fast as this processor can when compiled as every kernel is: the limits of a roofline.

No physics and no result: `python -m benchmarks roofline` times them beside the kernels, in the same run.
"""

from __future__ import annotations

import numpy as np

from peristalsis.numerics.compiled import compiled

PAIRS = 8
"""Multiplications and additions that `multiply_add` does for an element and round."""
NOT_NEGATIVE = 2**31 - 1


@compiled
def multiply_add(x: np.ndarray, factor: float, rounds: int) -> None:
    """2*PAIRS floating-point operations for each element of x and each round, in registers; elements independent."""
    for _ in range(rounds):
        for k in range(x.size):
            y = x[k]
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            y = y * factor + 1.0
            x[k] = y


@compiled
def chain(x: float, factor: float, length: int) -> float:
    """A multiplication and an addition, each waiting for the one before, `length` times over."""
    for _ in range(length):
        x = x * factor + 1.0
    return x


@compiled
def division_chain(x: float, length: int) -> float:
    """A division and an addition, each waiting for the one before, `length` times over."""
    for _ in range(length):
        x = 1.0 + 1.0 / x
    return x


@compiled
def divisions(x: np.ndarray, rounds: int) -> None:
    """A division and an addition for each element of x and each round; elements independent."""
    for _ in range(rounds):
        for k in range(x.size):
            x[k] = 1.0 + 1.0 / x[k]


@compiled
def triad(a: np.ndarray, b: np.ndarray, c: np.ndarray, factor: float) -> None:
    """a = b + factor*c: two loads and a store of 8 bytes an element, as in the STREAM benchmark."""
    for k in range(a.size):
        a[k] = b[k] + factor * c[k]


@compiled
def table_reads(v: np.ndarray, table: np.ndarray, low: float, per_step: float, out: np.ndarray) -> None:
    """What an interpolating loop must read at least: two neighbouring rows of 7 entries at every v, here added up."""
    for k in range(v.size):
        i = int((v[k] - low) * per_step) & NOT_NEGATIVE
        before = table[i, 0] + table[i, 1] + table[i, 2] + table[i, 3] + table[i, 4] + table[i, 5] + table[i, 6]
        i += 1
        behind = table[i, 0] + table[i, 1] + table[i, 2] + table[i, 3] + table[i, 4] + table[i, 5] + table[i, 6]
        out[k] = before + behind
