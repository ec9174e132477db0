"""Banded linear systems with several right-hand sides, factored in place without pivoting."""

from __future__ import annotations

import numpy as np

from .compiled import compiled

HALF_WIDTH = 5
"""Half bandwidth of every system here: two unknowns a wall node, coupled to two nodes on either side."""


@compiled
def solve_banded_in_place(matrix: np.ndarray, right: np.ndarray, columns: int) -> bool:
    """Solve A X = B by Gaussian elimination inside the band; both arguments are overwritten, B by X.

    matrix: rows of A, shape (n + HALF_WIDTH, 2*HALF_WIDTH + 1), entry [i, HALF_WIDTH + j - i] is A[i, j].
    right: B, shape (n + HALF_WIDTH, at least `columns`). The last HALF_WIDTH rows of both and all entries that
    point outside A must be zero on entry: the loops then have fixed lengths. Returns False when a pivot vanishes
    or is not finite: the caller must not use X. No pivoting: the matrices here come from equilibria with positive
    tension, whose pivots stay away from zero.
    """
    n = matrix.shape[0] - HALF_WIDTH
    for i in range(n):
        pivot = matrix[i, HALF_WIDTH]
        if not abs(pivot) > 1e-300 or not np.isfinite(pivot):
            return False
        inverse = 1.0 / pivot
        for down in range(1, HALF_WIDTH + 1):
            factor = matrix[i + down, HALF_WIDTH - down] * inverse
            for k in range(1, HALF_WIDTH + 1):
                matrix[i + down, HALF_WIDTH - down + k] -= factor * matrix[i, HALF_WIDTH + k]
            for c in range(columns):
                right[i + down, c] -= factor * right[i, c]
        matrix[i, HALF_WIDTH] = inverse
    for i in range(n - 1, -1, -1):
        for c in range(columns):
            value = right[i, c]
            for k in range(1, HALF_WIDTH + 1):
                value -= matrix[i, HALF_WIDTH + k] * right[i + k, c]
            right[i, c] = value * matrix[i, HALF_WIDTH]
    return True


@compiled
def solve_small_in_place(matrix: np.ndarray, right: np.ndarray) -> bool:
    """Solve a small dense system by elimination with row pivoting; overwritten, `right` (shape (n,)) by X."""
    n = matrix.shape[0]
    for i in range(n):
        best = i
        for row in range(i + 1, n):
            if abs(matrix[row, i]) > abs(matrix[best, i]):
                best = row
        if not abs(matrix[best, i]) > 0.0:
            return False
        if best != i:
            for k in range(n):
                held = matrix[i, k]
                matrix[i, k] = matrix[best, k]
                matrix[best, k] = held
            held = right[i]
            right[i] = right[best]
            right[best] = held
        for row in range(i + 1, n):
            factor = matrix[row, i] / matrix[i, i]
            for k in range(i, n):
                matrix[row, k] -= factor * matrix[i, k]
            right[row] -= factor * right[i]
    for i in range(n - 1, -1, -1):
        value = right[i]
        for k in range(i + 1, n):
            value -= matrix[i, k] * right[k]
        right[i] = value / matrix[i, i]
    return True
