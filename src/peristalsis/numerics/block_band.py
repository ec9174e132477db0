"""Linear systems with two unknowns a node that meet two nodes on either side, solved block by block in place.

The system is one array with a row for every entry of the 2x2 blocks and of the right-hand sides, and a column for every
node, so that passes over the nodes run on vector registers. Row 4*k + 2*a + b holds entry (a, b) of the block that
joins a node to the node k - 2 away; row RIGHT + 2*c + a holds entry a of right-hand side c.
"""

from __future__ import annotations

import numpy as np

from .compiled import INDEX, compiled, inlined

FARTHEST, LOWER, DIAGONAL, UPPER, LAST = 0, 4, 8, 12, 16
"""First rows of the blocks of the nodes two before, one before, itself, one behind, two behind."""
RIGHT = 20
COLUMNS = 4
ROWS = RIGHT + 2 * COLUMNS
PADDING = 2
"""Columns to allocate beyond the last node: elimination runs over them, nothing is read from them."""

SMALLEST_PIVOT, LARGEST_PIVOT = 1e-300, 1e300


@compiled
def solve_blocks_in_place(system: np.ndarray, first: int, n: int, columns: int) -> bool:
    """Solve for the first 1, 3 or 4 right-hand sides of the n nodes from `first` on; solutions stand in their place.

    system: (ROWS, at least first + n + PADDING), finite. Blocks that point beyond the n nodes count for nothing; the
    columns of the PADDING nodes behind them are overwritten. Returns False when a block is singular or not finite: the
    caller must not use the solution. Blocks are inverted, not pivoted among each other: the matrices here
    come from equilibria with positive tension, whose pivots stay away from zero.
    """
    a = system
    if first < 0:
        return False
    first, n = first & INDEX, n & INDEX
    for o in range(first, first + n):
        i = o & INDEX
        determinant = a[8, i] * a[11, i] - a[9, i] * a[10, i]
        if not (SMALLEST_PIVOT < abs(determinant) < LARGEST_PIVOT):
            return False
        inverse = 1.0 / determinant
        i00 = a[11, i] * inverse
        i01 = -a[9, i] * inverse
        i10 = -a[10, i] * inverse
        i11 = a[8, i] * inverse
        a[8, i] = i00
        a[9, i] = i01
        a[10, i] = i10
        a[11, i] = i11
        u00, u01, u10, u11 = a[12, i], a[13, i], a[14, i], a[15, i]
        v00, v01, v10, v11 = a[16, i], a[17, i], a[18, i], a[19, i]
        j = i + 1
        l00 = a[4, j] * i00 + a[5, j] * i10
        l01 = a[4, j] * i01 + a[5, j] * i11
        l10 = a[6, j] * i00 + a[7, j] * i10
        l11 = a[6, j] * i01 + a[7, j] * i11
        a[8, j] -= l00 * u00 + l01 * u10
        a[9, j] -= l00 * u01 + l01 * u11
        a[10, j] -= l10 * u00 + l11 * u10
        a[11, j] -= l10 * u01 + l11 * u11
        a[12, j] -= l00 * v00 + l01 * v10
        a[13, j] -= l00 * v01 + l01 * v11
        a[14, j] -= l10 * v00 + l11 * v10
        a[15, j] -= l10 * v01 + l11 * v11
        k = i + 2
        m00 = a[0, k] * i00 + a[1, k] * i10
        m01 = a[0, k] * i01 + a[1, k] * i11
        m10 = a[2, k] * i00 + a[3, k] * i10
        m11 = a[2, k] * i01 + a[3, k] * i11
        a[4, k] -= m00 * u00 + m01 * u10
        a[5, k] -= m00 * u01 + m01 * u11
        a[6, k] -= m10 * u00 + m11 * u10
        a[7, k] -= m10 * u01 + m11 * u11
        a[8, k] -= m00 * v00 + m01 * v10
        a[9, k] -= m00 * v01 + m01 * v11
        a[10, k] -= m10 * v00 + m11 * v10
        a[11, k] -= m10 * v01 + m11 * v11
        r, z = a[20, i], a[21, i]
        a[20, j] -= l00 * r + l01 * z
        a[21, j] -= l10 * r + l11 * z
        a[20, k] -= m00 * r + m01 * z
        a[21, k] -= m10 * r + m11 * z
        if columns > 1:
            r, z = a[22, i], a[23, i]
            a[22, j] -= l00 * r + l01 * z
            a[23, j] -= l10 * r + l11 * z
            a[22, k] -= m00 * r + m01 * z
            a[23, k] -= m10 * r + m11 * z
            r, z = a[24, i], a[25, i]
            a[24, j] -= l00 * r + l01 * z
            a[25, j] -= l10 * r + l11 * z
            a[24, k] -= m00 * r + m01 * z
            a[25, k] -= m10 * r + m11 * z
        if columns > 3:
            r, z = a[26, i], a[27, i]
            a[26, j] -= l00 * r + l01 * z
            a[27, j] -= l10 * r + l11 * z
            a[26, k] -= m00 * r + m01 * z
            a[27, k] -= m10 * r + m11 * z
    # Every column is a chain in which each node waits for the one behind: in one pass the chains overlap.
    end = (first + n) & INDEX
    for row in range(RIGHT, RIGHT + 2 * columns):
        a[row, end] = 0.0
        a[row, end + 1] = 0.0
    for t in range(n):
        i = (end - 1 - t) & INDEX
        _substitute(a, i, RIGHT)
        if columns > 1:
            _substitute(a, i, RIGHT + 2)
            _substitute(a, i, RIGHT + 4)
        if columns > 3:
            _substitute(a, i, RIGHT + 6)
    return True


@inlined
def _substitute(a: np.ndarray, i: int, row: int) -> None:
    """Solution of node i in the rows `row` and `row` + 1 from those of the two nodes behind it."""
    r_1, z_1, r_2, z_2 = a[row, i + 1], a[row + 1, i + 1], a[row, i + 2], a[row + 1, i + 2]
    r = a[row, i] - (a[12, i] * r_1 + a[13, i] * z_1) - (a[16, i] * r_2 + a[17, i] * z_2)
    z = a[row + 1, i] - (a[14, i] * r_1 + a[15, i] * z_1) - (a[18, i] * r_2 + a[19, i] * z_2)
    a[row, i] = a[8, i] * r + a[9, i] * z
    a[row + 1, i] = a[10, i] * r + a[11, i] * z
