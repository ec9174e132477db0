"""Systems on a tube in the space of low modes around the ring, coupled to one another, Eqs. (92), (93).

A wall that is slack on one side couples its modes, which the average around the ring leaves out. Here the operator,
scaled by the roots of its diagonal, is projected on the modes 1, cos t, sin t, ... cos Kt, sin Kt in each component and
row: blocks of b = 3(2K + 1) along z, two neighbours wide on either side, factored without pivots. All of it is in single
precision: it is part of a preconditioner. Where nodes are held along their normal, second neighbours along z stay free.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled
from .constraint import Constraint, constrain
from .ring_average import Scale
from .ring_blocks import RingOperator, bending_weight

Singles = NDArray[np.float32]


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
def scaled_stencil(operator: RingOperator, constraint: Constraint, scale: Scale, out: np.ndarray) -> None:
    """The scaled, constrained stencil with bending along z into `out` (n, 3, 3, 3, 3, m): [i, di, a, b, dj, j]."""
    blocks = operator.blocks
    inverse, stiffness = scale.inverse, scale.stiffness
    n = inverse.shape[0]
    m = inverse.shape[2]
    block = np.empty((3, 3))
    for i in range(n):
        for q in range(9):
            r = i + q // 3 - 1
            o = q % 3 - 1
            if i < 1 or i > n - 2 or r < 1 or r > n - 2:
                out[i, q // 3, :, :, q % 3, :] = 0.0
                continue
            extra = operator.bend_along * bending_weight(i, r, n) if o == 0 else 0.0
            if not (constraint.rows[i] or constraint.rows[r]):
                for a in range(3):
                    for b in range(3):
                        add = extra if a == b else 0.0
                        y = out[i, q // 3, a, b, q % 3]
                        v = blocks[i, q, a, b]
                        here = inverse[i, a]
                        there = inverse[r, b]
                        y[0] = (v[0] + add) * here[0] * there[(o + m) % m]
                        for j in range(1, m - 1):
                            y[j] = (v[j] + add) * here[j] * there[j + o]
                        y[m - 1] = (v[m - 1] + add) * here[m - 1] * there[(m - 1 + o) % m]
                continue
            for j in range(m):
                k = (j + o + m) % m
                for a in range(3):
                    for b in range(3):
                        block[a, b] = blocks[i, q, a, b, j]
                    block[a, a] += extra
                constrain(block, constraint, i, j, r, k)
                if q == 4 and constraint.held[i, j]:
                    for a in range(3):
                        for b in range(3):
                            block[a, b] += stiffness[i, j] * constraint.normal[i, a, j] * constraint.normal[i, b, j]
                for a in range(3):
                    for b in range(3):
                        out[i, q // 3, a, b, q % 3, j] = block[a, b] * inverse[i, a, j] * inverse[r, b, k]


@compiled
def couple_modes(tables: np.ndarray, m: int, coupled: Coupled) -> None:
    """Blocks from the Fourier sums of the stencil, tables (n, 3, 3, 3, 3, 2, 2K + 1): real and imaginary parts.

    With E(q) the sum over the columns of v_j exp(i q t_j), and T(q) that of the three neighbours turned by the l-th
    mode's phase between columns, exp(-i k t) A exp(i l t) is T(l - k), and that with -l the conjugate of T(l + k).
    """
    n = tables.shape[0]
    count = tables.shape[6]
    top = (count - 1) // 2
    one = np.float32(0.5)
    plus = np.empty((2, count), np.float32)
    minus = np.empty((2, count), np.float32)
    for i in range(1, n - 1):
        for d in range(3):
            out = coupled.lower[i] if d == 0 else (coupled.diagonal[i] if d == 1 else coupled.upper[i])
            for a in range(3):
                for b in range(3):
                    e = tables[i, d, a, b]
                    for l in range(top + 1):
                        c = np.float32(math.cos(2.0 * math.pi * l / m))
                        s = np.float32(math.sin(2.0 * math.pi * l / m))
                        for q in range(count):
                            even = e[1, 0, q] + c * (e[0, 0, q] + e[2, 0, q])
                            odd = s * (e[2, 1, q] - e[0, 1, q])
                            plus[0, q] = even - odd
                            minus[0, q] = even + odd
                            even = e[1, 1, q] + c * (e[0, 1, q] + e[2, 1, q])
                            odd = s * (e[2, 0, q] - e[0, 0, q])
                            plus[1, q] = odd + even
                            minus[1, q] = odd - even
                        norm_l = math.sqrt((1.0 if l == 0 else 2.0) / m)
                        column = b * count + max(2 * l - 1, 0)
                        for k in range(top + 1):
                            norm = np.float32(norm_l * math.sqrt((1.0 if k == 0 else 2.0) / m)) * one
                            row = a * count + max(2 * k - 1, 0)
                            real = plus[0, l - k] if l >= k else minus[0, k - l]
                            imaginary = plus[1, l - k] if l >= k else minus[1, k - l]
                            real2 = plus[0, l + k]
                            imaginary2 = -plus[1, l + k]
                            out[row, column] = norm * (real + real2)
                            if l > 0:
                                out[row, column + 1] = norm * (imaginary - imaginary2)
                            if k > 0:
                                out[row + 1, column] = -norm * (imaginary + imaginary2)
                            if k > 0 and l > 0:
                                out[row + 1, column + 1] = norm * (real - real2)


@compiled
def _subtract_product(
    left: np.ndarray, first: int, last: int, right: np.ndarray, out: np.ndarray, column: int
) -> None:
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
    for p in range(size):
        pivot = block[p, p]
        if not (abs(pivot) > 1e-30 and abs(pivot) < 1e30):
            return False
        share = one / pivot
        block[p, p] = one
        row = block[p]
        for j in range(size):
            row[j] *= share
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
                    multiplier, a * count, (a + 1) * count, upper2[i, a], upper[r] if down == 1 else diagonal[r], a * count
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


def mode_fields(modes: int, columns: int) -> Singles:
    """The modes 1, cos t, sin t, ... as columns of an orthonormal array (columns, 2 modes + 1)."""
    angles = 2.0 * np.pi * np.arange(columns) / columns
    fields = [np.full(columns, 1.0 / math.sqrt(columns))]
    for k in range(1, modes + 1):
        fields += [np.cos(k * angles) * math.sqrt(2.0 / columns), np.sin(k * angles) * math.sqrt(2.0 / columns)]
    return np.ascontiguousarray(np.stack(fields, axis=1), dtype=np.float32)


class CoupledModes:
    """The factors of an operator in the space of coupled modes. `modes`: K, below half the number of columns."""

    def __init__(self, operator: RingOperator, constraint: Constraint, scale: Scale, modes: int) -> None:
        n, m = constraint.held.shape
        count = 2 * modes + 1
        stencil = np.empty((n, 3, 3, 3, 3, m), np.float32)
        scaled_stencil(operator, constraint, scale, stencil)
        angles = 2.0 * np.pi * np.arange(m) / m
        turns = np.outer(angles, np.arange(count))
        sums = np.concatenate([np.cos(turns), np.sin(turns)], axis=1).astype(np.float32)
        tables = (stencil.reshape(-1, m) @ sums).reshape(n, 3, 3, 3, 3, 2, count)
        self.fields = mode_fields(modes, m)
        self.factors = Coupled(
            *(np.zeros((n, 3 * count, 3 * count), np.float32) for _ in range(4)),
            np.zeros((n, 3, count, count), np.float32),
        )
        couple_modes(tables, m, self.factors)
        self._add_bending(operator, scale, count)
        if operator.tether != 0.0 and modes > 0:
            self._add_tether(operator, scale, angles)
        self.singular = not factor_coupled(self.factors)
        transpose_coupled(self.factors)

    def _add_bending(self, operator: RingOperator, scale: Scale, count: int) -> None:
        """Squared second differences: around the ring, and what they couple along z two rows apart."""
        n = scale.inverse.shape[0]
        weighted = scale.inverse.astype(np.float32)[..., None] * self.fields
        bent = np.roll(weighted, 1, 2) - 2.0 * weighted + np.roll(weighted, -1, 2)
        around = np.float32(operator.bend_around) * (bent.swapaxes(2, 3) @ bent)
        apart = np.array([bending_weight(i, i + 2, n) if 0 < i < n - 3 else 0.0 for i in range(n - 2)])
        far = (operator.bend_along * apart).astype(np.float32)[:, None, None, None]
        self.factors.upper2[:-2] = far * (weighted[:-2].swapaxes(2, 3) @ weighted[2:])
        for a in range(3):
            part = slice(a * count, (a + 1) * count)
            self.factors.diagonal[1:-1, part, part] += around[1:-1, a]
            self.factors.lower2[2:, part, part] = self.factors.upper2[:-2, a].swapaxes(1, 2)

    def _add_tether(self, operator: RingOperator, scale: Scale, angles: NDArray[np.float64]) -> None:
        """The force on each node of a ring per mean displacement of that ring across the axis."""
        m = angles.size
        zero = np.zeros(m)
        for share in (
            np.stack([np.cos(angles), -np.sin(angles), zero]),
            np.stack([np.sin(angles), np.cos(angles), zero]),
        ):
            found = ((scale.inverse * share).astype(np.float32) @ self.fields).reshape(scale.inverse.shape[0], -1)
            self.factors.diagonal[1:-1] += np.float32(operator.tether / m) * found[1:-1, :, None] * found[1:-1, None, :]
