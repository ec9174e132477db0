"""Systems of large blocks along z, two neighbours wide on either side, in single precision, without pivots, Eq. (93).

Blocks couple low modes around the ring (`ring_coupled`). The first and last rows are held.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .compiled import compiled


class Coupled(NamedTuple):
    """Blocks (n, b, b) of every row with itself and its neighbours along z; second neighbours (n, 3, K', K').

    Those are alike in kind: K' = 2K + 1 modes of one component with the same component. `factor_coupled` puts inverses
    in place of `diagonal` and multipliers in place of `lower` and `lower2`.
    """

    diagonal: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    lower2: np.ndarray
    upper2: np.ndarray


@compiled
def _subtract_product(left: np.ndarray, first: int, last: int, right: np.ndarray, out: np.ndarray, column: int) -> None:
    """out[:, column:] -= left[:, first:last] right, four rows of `right` at a time."""
    width = right.shape[1]
    for i in range(out.shape[0]):
        y = out[i, column : column + width]
        k = first
        while k + 4 <= last:
            l0 = left[i, k]
            l1 = left[i, k + 1]
            l2 = left[i, k + 2]
            l3 = left[i, k + 3]
            r0 = right[k - first]
            r1 = right[k - first + 1]
            r2 = right[k - first + 2]
            r3 = right[k - first + 3]
            for j in range(width):
                y[j] -= (l0 * r0[j] + l1 * r1[j]) + (l2 * r2[j] + l3 * r3[j])
            k += 4
        while k < last:
            l0 = left[i, k]
            r0 = right[k - first]
            for j in range(width):
                y[j] -= l0 * r0[j]
            k += 1


@compiled
def _invert(block: np.ndarray) -> bool:
    """Invert a block in place, pivots along the diagonal (Gauss and Jordan); False where one is singular."""
    size = block.shape[0]
    one = np.float32(1.0)
    row = np.empty(size, np.float32)
    for p in range(size):
        pivot = block[p, p]
        if not (abs(pivot) > 1e-30 and abs(pivot) < 1e30):
            return False
        share = one / pivot
        block[p, p] = one
        for j in range(size):
            block[p, j] *= share
            row[j] = block[p, j]
        for i in range(size):
            if i == p:
                continue
            factor = block[i, p]
            block[i, p] = np.float32(0.0)
            y = block[i]
            for j in range(size):
                y[j] -= factor * row[j]
    return True


@compiled
def factor_coupled(coupled: Coupled) -> bool:
    """Block elimination along z, in place; False where a block is singular."""
    diagonal, lower, upper, lower2, upper2 = coupled
    n = diagonal.shape[0]
    size = diagonal.shape[1]
    count = upper2.shape[2]
    work = np.empty((size, size), np.float32)
    for i in range(1, n - 1):
        if not _invert(diagonal[i]):
            return False
        for down in range(1, 3):
            r = i + down
            if r > n - 2:
                break
            work[:, :] = np.float32(0.0)
            if down == 1:
                _subtract_product(lower[r], 0, size, diagonal[i], work, 0)
            else:
                for a in range(0, size, count):
                    _subtract_product(
                        lower2[r, a : a + count], a, a + count, diagonal[i, a : a + count], work[a : a + count], 0
                    )
            multiplier = lower[r] if down == 1 else lower2[r]
            for a in range(size):
                for b in range(size):
                    multiplier[a, b] = -work[a, b]
            _subtract_product(multiplier, 0, size, upper[i], diagonal[r] if down == 1 else lower[r], 0)
            for a in range(3):
                _subtract_product(
                    multiplier,
                    a * count,
                    (a + 1) * count,
                    upper2[i, a],
                    upper[r] if down == 1 else diagonal[r],
                    a * count,
                )
    return True


@compiled
def _take(block: np.ndarray, vector: np.ndarray, out: np.ndarray) -> None:
    """out -= vector block, of a block kept transposed: long rows are what the loop runs fastest over."""
    for k in range(vector.size):
        x = vector[k]
        row = block[k]
        for j in range(out.size):
            out[j] -= x * row[j]


@compiled
def solve_coupled(coupled: Coupled, vectors: np.ndarray, work: np.ndarray) -> None:
    """Solve in place for vectors (n, b) with factors that `transpose_coupled` has turned; work (b,)."""
    diagonal, lower, upper, lower2, upper2 = coupled
    n = vectors.shape[0]
    count = upper2.shape[2]
    for i in range(2, n - 1):
        _take(lower[i], vectors[i - 1], vectors[i])
        if i > 2:
            _take(lower2[i], vectors[i - 2], vectors[i])
    for i in range(n - 2, 0, -1):
        if i < n - 2:
            _take(upper[i], vectors[i + 1], vectors[i])
        if i < n - 3:
            for a in range(3):
                part = slice(a * count, (a + 1) * count)
                _take(upper2[i, a], vectors[i + 2, part], vectors[i, part])
        work[:] = np.float32(0.0)
        _take(diagonal[i], vectors[i], work)
        for k in range(work.size):
            vectors[i, k] = -work[k]


@compiled
def transpose_coupled(coupled: Coupled) -> None:
    """Turn every block of the factors in place."""
    for field in (coupled.diagonal, coupled.lower, coupled.upper, coupled.lower2):
        for i in range(field.shape[0]):
            for a in range(field.shape[1]):
                for b in range(a):
                    kept = field[i, a, b]
                    field[i, a, b] = field[i, b, a]
                    field[i, b, a] = kept
    for i in range(coupled.upper2.shape[0]):
        for c in range(3):
            block = coupled.upper2[i, c]
            for a in range(block.shape[0]):
                for b in range(a):
                    kept = block[a, b]
                    block[a, b] = block[b, a]
                    block[b, a] = kept
