"""Small dense linear systems."""

from __future__ import annotations

import numpy as np

from .compiled import compiled


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
