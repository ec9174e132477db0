"""Fields on a tube of n rows and m columns, and operators of 3x3 blocks on its 9-point stencil.

Every column has a frame of its own, turned by 2 pi/m against the one before: x outward, y around, z along. A field
that is uniform around the ring is then the same numbers in each column, and an operator made from it is
block-circulant: its Fourier transform around the ring is one block matrix along z for each mode.

Fields have shape (n, 3, m); *padded* fields (n, 3, m + 2) hold column j at j + 1 and repeat the neighbours at the
two ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiled import compiled


class RingOperator(NamedTuple):
    """A linear operator on fields whose first and last rows are held: stencil blocks and three constant parts.

    blocks: (n, 9, 3, 3, m); entry [i, 3*(di + 1) + dj + 1, a, b, j] is what component b of node (i + di, j + dj)
    does to component a of node (i, j). bend_along, bend_around: weights of squared second differences along z (centred
    at inner rows) and around the ring, alike for all components. tether: force on each node of a ring per mean
    displacement of that ring across the axis.
    """

    blocks: np.ndarray
    bend_along: float
    bend_around: float
    tether: float


@compiled
def pad(field: np.ndarray, padded: np.ndarray) -> None:
    """Copy a field (n, 3, m) into a padded one (n, 3, m + 2)."""
    m = field.shape[2]
    for i in range(field.shape[0]):
        for a in range(3):
            for j in range(m):
                padded[i, a, j + 1] = field[i, a, j]
            padded[i, a, 0] = field[i, a, m - 1]
            padded[i, a, m + 1] = field[i, a, 0]


@compiled
def add_tether(field: np.ndarray, tether: float, out: np.ndarray) -> None:
    """Add to inner rows of `out` the mean of each row of `field` across the axis times `tether`."""
    m = field.shape[2]
    c = np.empty(m)
    s = np.empty(m)
    for j in range(m):
        c[j] = math.cos(2.0 * math.pi * j / m)
        s[j] = math.sin(2.0 * math.pi * j / m)
    for i in range(1, field.shape[0] - 1):
        x = field[i, 0]
        y = field[i, 1]
        along = 0.0
        across = 0.0
        for j in range(m):
            along += c[j] * x[j] - s[j] * y[j]
            across += s[j] * x[j] + c[j] * y[j]
        along *= tether / m
        across *= tether / m
        x = out[i, 0]
        y = out[i, 1]
        for j in range(m):
            x[j] += c[j] * along + s[j] * across
            y[j] += c[j] * across - s[j] * along


@compiled
def add_bending_of_row(
    field: np.ndarray,
    i: int,
    along: float | np.float32,
    around: float | np.float32,
    bent: np.ndarray,
    out: np.ndarray,
) -> None:
    """What the differences centred at row i add in `add_bending`; bent: work (m + 2,). All in one precision."""
    n = field.shape[0]
    m = field.shape[2] - 2
    two = field.dtype.type(2.0)
    for a in range(3):
        here = field[i, a]
        y = out[i, a]
        if along != 0.0:
            before = field[i - 1, a]
            after = field[i + 1, a]
            lower = out[i - 1, a]
            upper = out[i + 1, a]
            for j in range(m):
                value = along * (before[j + 1] - two * here[j + 1] + after[j + 1])
                bent[j] = value
                y[j] -= two * value
            if i > 1:
                for j in range(m):
                    lower[j] += bent[j]
            if i < n - 2:
                for j in range(m):
                    upper[j] += bent[j]
        if around != 0.0:
            for j in range(m):
                bent[j + 1] = around * (here[j] - two * here[j + 1] + here[j + 2])
            bent[0] = bent[m]
            bent[m + 1] = bent[1]
            for j in range(m):
                y[j] += bent[j] - two * bent[j + 1] + bent[j + 2]


@compiled
def add_bending(field: np.ndarray, along: float, around: float, out: np.ndarray) -> None:
    """Add the gradient of along/2 |second z-difference|^2 + around/2 |second theta-difference|^2 to `out`.

    field: padded (n, 3, m + 2); out: (n, 3, m), inner rows. Differences along z are centred at inner rows.
    """
    bent = np.empty(field.shape[2], field.dtype)
    for i in range(1, field.shape[0] - 1):
        add_bending_of_row(field, i, along, around, bent, out)


@compiled
def add_stencil(blocks: np.ndarray, padded: np.ndarray, i: int, a: int, out: np.ndarray) -> None:
    """Add component a of row i of the stencil times a padded field to `out` (m,), in the precision of the arrays."""
    m = out.size
    for d in range(3):
        x0 = padded[i + d - 1, 0]
        x1 = padded[i + d - 1, 1]
        x2 = padded[i + d - 1, 2]
        l0 = blocks[i, 3 * d, a, 0]
        l1 = blocks[i, 3 * d, a, 1]
        l2 = blocks[i, 3 * d, a, 2]
        c0 = blocks[i, 3 * d + 1, a, 0]
        c1 = blocks[i, 3 * d + 1, a, 1]
        c2 = blocks[i, 3 * d + 1, a, 2]
        r0 = blocks[i, 3 * d + 2, a, 0]
        r1 = blocks[i, 3 * d + 2, a, 1]
        r2 = blocks[i, 3 * d + 2, a, 2]
        for j in range(m):
            out[j] += (
                l0[j] * x0[j]
                + l1[j] * x1[j]
                + l2[j] * x2[j]
                + c0[j] * x0[j + 1]
                + c1[j] * x1[j + 1]
                + c2[j] * x2[j + 1]
                + r0[j] * x0[j + 2]
                + r1[j] * x1[j + 2]
                + r2[j] * x2[j + 2]
            )


@compiled
def multiply(
    operator: RingOperator, field: np.ndarray, first: int, last: int, padded: np.ndarray, out: np.ndarray
) -> None:
    """Rows first ... last - 1 of the operator times `field` (n, 3, m) into `out`, zero elsewhere.

    The held rows of `field` must be zero. padded: work (n, 3, m + 2). Views of single rows let loops run in vectors.
    """
    blocks = operator.blocks
    n = field.shape[0]
    pad(field, padded)
    out[:, :, :] = 0.0
    for i in range(max(first, 1), min(last, n - 1)):
        for a in range(3):
            add_stencil(blocks, padded, i, a, out[i, a])
    add_bending(padded, operator.bend_along, operator.bend_around, out)
    if operator.tether != 0.0:
        add_tether(field, operator.tether, out)


@compiled
def multiply_transposed(operator: RingOperator, field: np.ndarray, padded: np.ndarray, out: np.ndarray) -> None:
    """The transposed operator times `field` into `out`; rows of `field` that are zero throughout cost nothing."""
    blocks = operator.blocks
    n = field.shape[0]
    m = field.shape[2]
    pad(field, padded)
    out[:, :, :] = 0.0
    for i in range(1, n - 1):
        used = False
        for j in range(m):
            if field[i, 0, j] != 0.0 or field[i, 1, j] != 0.0 or field[i, 2, j] != 0.0:
                used = True
        if not used:
            continue
        for q in range(9):
            r = i + q // 3 - 1
            if r < 1 or r > n - 2:
                continue
            o = q % 3 - 1
            for b in range(3):
                for j in range(m):
                    k = j + o
                    if k < 0:
                        k += m
                    elif k >= m:
                        k -= m
                    out[r, b, k] += (
                        blocks[i, q, 0, b, j] * field[i, 0, j]
                        + blocks[i, q, 1, b, j] * field[i, 1, j]
                        + blocks[i, q, 2, b, j] * field[i, 2, j]
                    )
    add_bending(padded, operator.bend_along, operator.bend_around, out)
    if operator.tether != 0.0:
        add_tether(field, operator.tether, out)


@compiled
def bending_weight(i: int, k: int, n: int) -> float:
    """Entry (i, k) of the squared second difference along z with centres at the inner rows 1 ... n - 2."""
    total = 0.0
    for centre in range(max(1, i - 1, k - 1), min(n - 2, i + 1, k + 1) + 1):
        total += (-2.0 if centre == i else 1.0) * (-2.0 if centre == k else 1.0)
    return total
