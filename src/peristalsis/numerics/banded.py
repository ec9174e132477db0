"""Banded linear systems with several right-hand sides, factored in place without pivoting."""

from __future__ import annotations

import numpy as np

from .compiled import compiled


@compiled
def solve_banded_in_place(matrix: np.ndarray, half_width: int, right: np.ndarray) -> bool:
    """Solve A X = B by Gaussian elimination inside the band; both arguments are overwritten, B by X.

    matrix: rows of A, shape (n, 2*half_width + 1), entry [i, half_width + j - i] is A[i, j].
    right: B, shape (n, m). Returns False when a pivot vanishes or is not finite: the caller must not use X.
    No pivoting: the matrices here come from equilibria with positive tension, whose pivots stay away from zero.
    """
    n = matrix.shape[0]
    columns = right.shape[1]
    for i in range(n):
        pivot = matrix[i, half_width]
        if not np.isfinite(pivot) or abs(pivot) < 1e-300:
            return False
        inverse = 1.0 / pivot
        last = min(n - 1, i + half_width)
        width = last - i
        for row in range(i + 1, last + 1):
            factor = matrix[row, half_width + i - row] * inverse
            if factor != 0.0:
                offset = half_width + i - row
                for k in range(1, width + 1):
                    matrix[row, offset + k] -= factor * matrix[i, half_width + k]
                for c in range(columns):
                    right[row, c] -= factor * right[i, c]
        matrix[i, half_width] = inverse
    for i in range(n - 1, -1, -1):
        last = min(n - 1, i + half_width)
        for c in range(columns):
            value = right[i, c]
            for k in range(1, last - i + 1):
                value -= matrix[i, half_width + k] * right[i + k, c]
            right[i, c] = value * matrix[i, half_width]
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
