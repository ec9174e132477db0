"""Operators on a tube in the space of low modes around the ring, coupled to one another, Eqs. (92), (93).

A wall that is slack on one side couples its modes, which the average around the ring leaves out. Here the operator,
scaled by the roots of its diagonal, is projected on the modes 1, cos t, sin t, ... cos Kt, sin Kt in each component and
row: blocks of 3(2K + 1) along z. All of it is in single precision: it is part of a preconditioner.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled
from .constraint import Constraint
from .coupled_band import Coupled, factor_coupled, transpose_coupled
from .ring_average import Scale, constrained_block
from .ring_blocks import RingOperator, bending_weight

Singles = NDArray[np.float32]


@compiled
def scaled_stencil(operator: RingOperator, constraint: Constraint, scale: Scale, out: np.ndarray) -> None:
    """The scaled, constrained stencil with bending between neighbours into `out` (n, 3, 3, 3, 3, m).

    [i, di, a, b, dj, j]: what component b of node (i + di - 1, j + dj - 1) does to component a of node (i, j).
    """
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
            if r == i:
                extra += operator.bend_around * (6.0 if o == 0 else -4.0)
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
                constrained_block(operator, constraint, stiffness, (i, j), q, extra, block)
                for a in range(3):
                    for b in range(3):
                        out[i, q // 3, a, b, q % 3, j] = block[a, b] * inverse[i, a, j] * inverse[r, b, k]


@compiled
def scaled_bending(operator: RingOperator, scale: Scale, out: np.ndarray) -> None:
    """What bending couples two nodes apart into `out` (n, 2, 3, m): around the ring with j + 2, along z with i + 2."""
    inverse = scale.inverse
    n = inverse.shape[0]
    m = inverse.shape[2]
    for i in range(n):
        along = operator.bend_along * bending_weight(i, i + 2, n) if 0 < i < n - 3 else 0.0
        for a in range(3):
            here = inverse[i, a]
            there = inverse[min(i + 2, n - 1), a]
            for j in range(m):
                out[i, 0, a, j] = operator.bend_around * here[j] * here[(j + 2) % m]
                out[i, 1, a, j] = along * here[j] * there[j]


@compiled
def _add_couplings(
    plus: np.ndarray, minus: np.ndarray, l: int, m: int, out: np.ndarray, first: int, column: int
) -> None:
    """Add what the l-th mode does to all modes to the block of one component by another that begins there in `out`.

    plus, minus: sums T(q) of the neighbours turned by the phase of the mode, and of their conjugates, real and
    imaginary (2, 2K + 1). exp(-i k t) A exp(i l t) is T(l - k), and that with -l the conjugate of T(l + k).
    """
    top = (plus.shape[1] - 1) // 2
    norm_l = math.sqrt((1.0 if l == 0 else 2.0) / m)
    at = column + max(2 * l - 1, 0)
    for k in range(top + 1):
        norm = np.float32(0.5 * norm_l * math.sqrt((1.0 if k == 0 else 2.0) / m))
        row = first + max(2 * k - 1, 0)
        real = plus[0, l - k] if l >= k else minus[0, k - l]
        imaginary = plus[1, l - k] if l >= k else minus[1, k - l]
        real2 = plus[0, l + k]
        imaginary2 = -plus[1, l + k]
        out[row, at] += norm * (real + real2)
        if l > 0:
            out[row, at + 1] += norm * (imaginary - imaginary2)
        if k > 0:
            out[row + 1, at] -= norm * (imaginary + imaginary2)
            if l > 0:
                out[row + 1, at + 1] += norm * (real - real2)


@compiled
def couple_modes(tables: np.ndarray, m: int, coupled: Coupled) -> None:
    """Add the blocks of the stencil's Fourier sums, tables (n, 3, 3, 3, 3, 2, 2K + 1): real and imaginary parts.

    Sums E(q) over the columns of v_j exp(i q t_j).
    """
    n = tables.shape[0]
    count = tables.shape[6]
    plus = np.empty((2, count), np.float32)
    minus = np.empty((2, count), np.float32)
    for i in range(1, n - 1):
        for d in range(3):
            out = coupled.lower[i] if d == 0 else (coupled.diagonal[i] if d == 1 else coupled.upper[i])
            for a in range(3):
                for b in range(3):
                    e = tables[i, d, a, b]
                    for l in range((count - 1) // 2 + 1):
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
                        _add_couplings(plus, minus, l, m, out, a * count, b * count)


@compiled
def couple_bending(tables: np.ndarray, m: int, coupled: Coupled) -> None:
    """Add what bending couples two nodes apart, from Fourier sums (n, 2, 3, 2, 2K + 1) of `scaled_bending`."""
    n = tables.shape[0]
    count = tables.shape[4]
    plus = np.empty((2, count), np.float32)
    minus = np.empty((2, count), np.float32)
    block = np.empty((count, count), np.float32)
    for i in range(1, n - 1):
        for a in range(3):
            block[:, :] = np.float32(0.0)
            for way in range(2):
                e = tables[i, way, a]
                for l in range((count - 1) // 2 + 1):
                    c = np.float32(math.cos(4.0 * math.pi * l / m)) if way == 0 else np.float32(1.0)
                    s = np.float32(math.sin(4.0 * math.pi * l / m)) if way == 0 else np.float32(0.0)
                    for q in range(count):
                        plus[0, q] = c * e[0, q] - s * e[1, q]
                        plus[1, q] = c * e[1, q] + s * e[0, q]
                        minus[0, q] = c * e[0, q] + s * e[1, q]
                        minus[1, q] = s * e[0, q] - c * e[1, q]
                    _add_couplings(plus, minus, l, m, block if way == 0 else coupled.upper2[i, a], 0, 0)
            for k in range(count):
                for l in range(count):
                    coupled.diagonal[i, a * count + k, a * count + l] += block[k, l] + block[l, k]
                    if i + 2 < n - 1:
                        coupled.lower2[i + 2, a * count + l, a * count + k] = coupled.upper2[i, a, k, l]


def mode_fields(modes: int, columns: int) -> Singles:
    """The modes 1, cos t, sin t, ... as columns of an orthonormal array (columns, 2 modes + 1)."""
    angles = 2.0 * np.pi * np.arange(columns) / columns
    fields = [np.full(columns, 1.0 / math.sqrt(columns))]
    for k in range(1, modes + 1):
        fields += [np.cos(k * angles) * math.sqrt(2.0 / columns), np.sin(k * angles) * math.sqrt(2.0 / columns)]
    return np.ascontiguousarray(np.stack(fields, axis=1), dtype=np.float32)


class CoupledModes:
    """The factors of operators of one shape (n rows, m columns) in the space of coupled modes; `factor` takes one.

    modes: K, below half the number of columns. Where nodes are held along their normal, what bending couples two nodes
    apart stays free.
    """

    def __init__(self, n: int, m: int, modes: int) -> None:
        count = 2 * modes + 1
        self._angles = 2.0 * np.pi * np.arange(m) / m
        turns = np.outer(self._angles, np.arange(count))
        self._sums = np.concatenate([np.cos(turns), np.sin(turns)], axis=1).astype(np.float32)
        self._stencil = np.zeros((n, 3, 3, 3, 3, m), np.float32)
        self._tables = np.zeros((n, 3, 3, 3, 3, 2, count), np.float32)
        self._bending = np.zeros((n, 2, 3, m), np.float32)
        self._modes = modes
        self.fields = mode_fields(modes, m)
        whole = [np.zeros((n, 3 * count, 3 * count), np.float32) for _ in range(4)]
        self.factors = Coupled(whole[0], whole[1], whole[2], whole[3], np.zeros((n, 3, count, count), np.float32))

    def factor(self, operator: RingOperator, constraint: Constraint, scale: Scale) -> bool:
        """Put the factors of an operator into `factors`; False where a block is singular."""
        m, count = self._angles.size, self.fields.shape[1]
        for part in self.factors:
            part.fill(0.0)
        scaled_stencil(operator, constraint, scale, self._stencil)
        np.matmul(self._stencil.reshape(-1, m), self._sums, out=self._tables.reshape(-1, 2 * count))
        couple_modes(self._tables, m, self.factors)
        if operator.bend_along != 0.0 or operator.bend_around != 0.0:
            scaled_bending(operator, scale, self._bending)
            tables = (self._bending.reshape(-1, m) @ self._sums).reshape(-1, 2, 3, 2, count)
            couple_bending(tables, m, self.factors)
        if operator.tether != 0.0 and self._modes > 0:
            self._add_tether(operator, scale)
        if not factor_coupled(self.factors):
            return False
        transpose_coupled(self.factors)
        return True

    def _add_tether(self, operator: RingOperator, scale: Scale) -> None:
        """The force on each node of a ring per mean displacement of that ring across the axis."""
        angles = self._angles
        m, zero = angles.size, np.zeros(angles.size)
        for share in (
            np.stack([np.cos(angles), -np.sin(angles), zero]),
            np.stack([np.sin(angles), np.cos(angles), zero]),
        ):
            found = ((scale.inverse * share).astype(np.float32) @ self.fields).reshape(scale.inverse.shape[0], -1)
            self.factors.diagonal[1:-1] += np.float32(operator.tether / m) * found[1:-1, :, None] * found[1:-1, None, :]
