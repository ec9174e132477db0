"""Lines along z of an operator on the tube: each column solved exactly while the others rest, even ones before odd.

Stiffness that changes from column to column (slack beside taut wall) is what an average around the ring misses; lines
along z, where edges are shortest and stiffest, catch it. One sweep over the even and the odd columns is a smoother.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled
from .constraint import Constraint, constrain
from .ring_blocks import RingOperator, bending_weight

Floats = NDArray[np.float64]


class Columns(NamedTuple):
    """Blocks (n, 3, 3, m) of every row with itself and its neighbours along z, even columns first, then odd ones."""

    diagonal: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    lower2: np.ndarray
    upper2: np.ndarray


@compiled
def fill_columns(
    operator: RingOperator,
    constraint: Constraint,
    stiffness: np.ndarray,
    columns: Columns,
) -> None:
    """Blocks of the constrained operator within each column; what leads out of the grid stays as it is."""
    n = columns.diagonal.shape[0]
    m = columns.diagonal.shape[3]
    evens = (m + 1) // 2
    held = constraint.held
    normal = constraint.normal
    block = np.empty((3, 3))
    for i in range(1, n - 1):
        for d in range(-2, 3):
            r = i + d
            if r < 1 or r > n - 2:
                continue
            extra = operator.bend_along * bending_weight(i, r, n) + (6.0 * operator.bend_around if d == 0 else 0.0)
            if d == 0:
                target = columns.diagonal[i]
            elif d == -1:
                target = columns.lower[i]
            elif d == 1:
                target = columns.upper[i]
            elif d == -2:
                target = columns.lower2[i]
            else:
                target = columns.upper2[i]
            for j in range(m):
                p = j // 2 if j % 2 == 0 else evens + j // 2
                for a in range(3):
                    for b in range(3):
                        block[a, b] = operator.blocks[i, 3 * d + 4, a, b, j] if -2 < d < 2 else 0.0
                    block[a, a] += extra
                if constraint.rows[i] or constraint.rows[r]:
                    constrain(block, constraint, i, j, r, j)
                    if d == 0 and held[i, j]:
                        for a in range(3):
                            for b in range(3):
                                block[a, b] += stiffness[i, j] * normal[i, a, j] * normal[i, b, j]
                for a in range(3):
                    for b in range(3):
                        target[a, b, p] = block[a, b]


@compiled
def _times(left: np.ndarray, right: np.ndarray, out: np.ndarray) -> None:
    """out -= left right, for every column."""
    for a in range(3):
        l0 = left[a, 0]
        l1 = left[a, 1]
        l2 = left[a, 2]
        for b in range(3):
            r0 = right[0, b]
            r1 = right[1, b]
            r2 = right[2, b]
            y = out[a, b]
            for k in range(y.size):
                y[k] -= l0[k] * r0[k] + l1[k] * r1[k] + l2[k] * r2[k]


@compiled
def factor_columns(columns: Columns, wide: bool) -> bool:
    """Block elimination along z in place, diagonals become inverses; False where singular. wide: second neighbours."""
    diagonal, lower, upper, lower2, upper2 = columns
    n = diagonal.shape[0]
    m = diagonal.shape[3]
    work = np.empty((3, 3, m))
    for i in range(1, n - 1):
        block = diagonal[i]
        for k in range(m):
            a = block[0, 0, k]
            b = block[0, 1, k]
            c = block[0, 2, k]
            d = block[1, 0, k]
            e = block[1, 1, k]
            f = block[1, 2, k]
            g = block[2, 0, k]
            h = block[2, 1, k]
            l = block[2, 2, k]
            c0 = e * l - f * h
            c1 = f * g - d * l
            c2 = d * h - e * g
            det = a * c0 + b * c1 + c * c2
            if not (abs(det) > 1e-200 and abs(det) < 1e200):
                return False
            r = 1.0 / det
            block[0, 0, k] = c0 * r
            block[0, 1, k] = (c * h - b * l) * r
            block[0, 2, k] = (b * f - c * e) * r
            block[1, 0, k] = c1 * r
            block[1, 1, k] = (a * l - c * g) * r
            block[1, 2, k] = (c * d - a * f) * r
            block[2, 0, k] = c2 * r
            block[2, 1, k] = (b * g - a * h) * r
            block[2, 2, k] = (a * e - b * d) * r
        if i + 1 < n - 1:
            work[:, :, :] = 0.0
            _times(lower[i + 1], block, work)
            for a in range(3):
                for b in range(3):
                    for k in range(m):
                        lower[i + 1, a, b, k] = -work[a, b, k]
            _times(lower[i + 1], upper[i], diagonal[i + 1])
            if wide:
                _times(lower[i + 1], upper2[i], upper[i + 1])
        if wide and i + 2 < n - 1:
            work[:, :, :] = 0.0
            _times(lower2[i + 2], block, work)
            for a in range(3):
                for b in range(3):
                    for k in range(m):
                        lower2[i + 2, a, b, k] = -work[a, b, k]
            _times(lower2[i + 2], upper[i], lower[i + 2])
            _times(lower2[i + 2], upper2[i], diagonal[i + 2])
    return True


@compiled
def take(block: np.ndarray, source: np.ndarray, first: int, last: int, out: np.ndarray) -> None:
    """out -= block source for the columns first ... last - 1."""
    for a in range(3):
        y = out[a]
        b0 = block[a, 0]
        b1 = block[a, 1]
        b2 = block[a, 2]
        s0 = source[0]
        s1 = source[1]
        s2 = source[2]
        for k in range(first, last):
            y[k] -= b0[k] * s0[k] + b1[k] * s1[k] + b2[k] * s2[k]


@compiled
def solve_columns(columns: Columns, wide: bool, odd: bool, right: np.ndarray, field: np.ndarray) -> None:
    """Solve for the odd or the even columns of `field` (n, 3, m), leaving the others; right: (n, 3, m)."""
    diagonal, lower, upper, lower2, upper2 = columns
    n = right.shape[0]
    m = right.shape[2]
    evens = (m + 1) // 2
    first = evens if odd else 0
    last = m if odd else evens
    shift = 1 if odd else 0
    work = np.zeros((n, 3, m), right.dtype)
    hold = np.empty((3, m), right.dtype)
    for i in range(1, n - 1):
        for a in range(3):
            for k in range(first, last):
                work[i, a, k] = right[i, a, 2 * (k - first) + shift]
        if i > 1:
            take(lower[i], work[i - 1], first, last, work[i])
        if wide and i > 2:
            take(lower2[i], work[i - 2], first, last, work[i])
    for i in range(n - 2, 0, -1):
        if i < n - 2:
            take(upper[i], work[i + 1], first, last, work[i])
        if wide and i < n - 3:
            take(upper2[i], work[i + 2], first, last, work[i])
        hold[:, :] = 0.0
        take(diagonal[i], work[i], first, last, hold)
        for a in range(3):
            for k in range(first, last):
                work[i, a, k] = -hold[a, k]
                field[i, a, 2 * (k - first) + shift] = -hold[a, k]


class ColumnSolver:
    """Factors of all columns of a constrained operator."""

    def __init__(self, operator: RingOperator, constraint: Constraint, stiffness: Floats) -> None:
        n, m = constraint.held.shape
        self.columns = Columns(*(np.zeros((n, 3, 3, m)) for _ in range(5)))
        self._wide = operator.bend_along != 0.0
        fill_columns(operator, constraint, stiffness, self.columns)
        self.singular = not factor_columns(self.columns, self._wide)

    def solve(self, odd: bool, right: Floats, field: Floats) -> None:
        """Put the solution for the odd or the even columns into `field`; right, field: (n, 3, m)."""
        solve_columns(self.columns, self._wide, odd, right, field)
