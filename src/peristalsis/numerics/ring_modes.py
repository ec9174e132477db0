"""Block systems along z, one for each Fourier mode around the ring: made from averages, factored and solved, Eq. (40).

Blocks are 3x3 and complex, two neighbours wide on either side; the first and last rows are held.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiled import compiled
from .ring_average import Averages


class Modes(NamedTuple):
    """Block systems of all modes, real and imaginary parts, (n, 3, 3, modes): diagonal, and neighbours along z."""

    diagonal: tuple[np.ndarray, np.ndarray]
    lower: tuple[np.ndarray, np.ndarray]
    lower2: tuple[np.ndarray, np.ndarray]
    upper: tuple[np.ndarray, np.ndarray]
    upper2: tuple[np.ndarray, np.ndarray]


@compiled
def fill_modes(averages: Averages, tether: float, inverse: np.ndarray, first: int, last: int, modes: Modes) -> None:
    """Block systems of the modes first ... last - 1 from the averages; tether: see `RingOperator`."""
    near, far, around = averages.near, averages.far, averages.around
    n = near.shape[0]
    m = inverse.shape[2]
    for i in range(n):
        for a in range(3):
            for b in range(3):
                for k in range(first, last):
                    c = math.cos(2.0 * math.pi * k / m)
                    s = math.sin(2.0 * math.pi * k / m)
                    bend = around[i, a, b] * (2.0 - 2.0 * c) ** 2
                    modes.diagonal[0][i, a, b, k] = near[i, 4, a, b] + c * (near[i, 3, a, b] + near[i, 5, a, b]) + bend
                    modes.diagonal[1][i, a, b, k] = s * (near[i, 5, a, b] - near[i, 3, a, b])
                    modes.lower[0][i, a, b, k] = near[i, 1, a, b] + c * (near[i, 0, a, b] + near[i, 2, a, b])
                    modes.lower[1][i, a, b, k] = s * (near[i, 2, a, b] - near[i, 0, a, b])
                    modes.upper[0][i, a, b, k] = near[i, 7, a, b] + c * (near[i, 6, a, b] + near[i, 8, a, b])
                    modes.upper[1][i, a, b, k] = s * (near[i, 8, a, b] - near[i, 6, a, b])
                    modes.lower2[0][i, a, b, k] = far[i, 0, a, b]
                    modes.lower2[1][i, a, b, k] = 0.0
                    modes.upper2[0][i, a, b, k] = far[i, 1, a, b]
                    modes.upper2[1][i, a, b, k] = 0.0
        if first <= 1 < last and tether != 0.0 and 0 < i < n - 1:
            x = inverse[i, 0].mean()
            y = inverse[i, 1].mean()
            modes.diagonal[0][i, 0, 0, 1] += 0.5 * tether * x * x
            modes.diagonal[1][i, 0, 1, 1] -= 0.5 * tether * x * y
            modes.diagonal[1][i, 1, 0, 1] += 0.5 * tether * x * y
            modes.diagonal[0][i, 1, 1, 1] += 0.5 * tether * y * y


@compiled
def _times(
    left: tuple[np.ndarray, np.ndarray],
    i: int,
    right: tuple[np.ndarray, np.ndarray],
    r: int,
    first: int,
    last: int,
    sign: float,
    out: tuple[np.ndarray, np.ndarray],
    o: int,
) -> None:
    """out[o] += sign * left[i] right[r], 3x3 complex products for the modes first ... last - 1."""
    lr, li = left
    rr, ri = right
    tr, ti = out
    for a in range(3):
        for b in range(3):
            for k in range(first, last):
                tr[o, a, b, k] += sign * (
                    lr[i, a, 0, k] * rr[r, 0, b, k]
                    - li[i, a, 0, k] * ri[r, 0, b, k]
                    + lr[i, a, 1, k] * rr[r, 1, b, k]
                    - li[i, a, 1, k] * ri[r, 1, b, k]
                    + lr[i, a, 2, k] * rr[r, 2, b, k]
                    - li[i, a, 2, k] * ri[r, 2, b, k]
                )
                ti[o, a, b, k] += sign * (
                    lr[i, a, 0, k] * ri[r, 0, b, k]
                    + li[i, a, 0, k] * rr[r, 0, b, k]
                    + lr[i, a, 1, k] * ri[r, 1, b, k]
                    + li[i, a, 1, k] * rr[r, 1, b, k]
                    + lr[i, a, 2, k] * ri[r, 2, b, k]
                    + li[i, a, 2, k] * rr[r, 2, b, k]
                )


@compiled
def _invert(blocks: tuple[np.ndarray, np.ndarray], i: int, first: int, last: int) -> bool:
    """Invert the 3x3 blocks of row i in place by cofactors; False where one is singular or not finite."""
    re, im = blocks
    for k in range(first, last):
        a = complex(re[i, 0, 0, k], im[i, 0, 0, k])
        b = complex(re[i, 0, 1, k], im[i, 0, 1, k])
        c = complex(re[i, 0, 2, k], im[i, 0, 2, k])
        d = complex(re[i, 1, 0, k], im[i, 1, 0, k])
        e = complex(re[i, 1, 1, k], im[i, 1, 1, k])
        f = complex(re[i, 1, 2, k], im[i, 1, 2, k])
        g = complex(re[i, 2, 0, k], im[i, 2, 0, k])
        h = complex(re[i, 2, 1, k], im[i, 2, 1, k])
        l = complex(re[i, 2, 2, k], im[i, 2, 2, k])
        c0 = e * l - f * h
        c1 = f * g - d * l
        c2 = d * h - e * g
        det = a * c0 + b * c1 + c * c2
        size = det.real * det.real + det.imag * det.imag
        if not (size > 1e-280 and size < 1e280):
            return False
        r = complex(det.real / size, -det.imag / size)
        cofactors = (
            c0 * r,
            (c * h - b * l) * r,
            (b * f - c * e) * r,
            c1 * r,
            (a * l - c * g) * r,
            (c * d - a * f) * r,
            c2 * r,
            (b * g - a * h) * r,
            (a * e - b * d) * r,
        )
        for q in range(9):
            re[i, q // 3, q % 3, k] = cofactors[q].real
            im[i, q // 3, q % 3, k] = cofactors[q].imag
    return True


@compiled
def factor_modes(first: int, last: int, modes: Modes) -> bool:
    """Block elimination along z, in place: diagonals become inverses, lower blocks their multipliers."""
    n = modes.diagonal[0].shape[0]
    work = (np.empty((1, 3, 3, last)), np.empty((1, 3, 3, last)))
    for i in range(1, n - 1):
        if not _invert(modes.diagonal, i, first, last):
            return False
        for down in range(1, 3):
            r = i + down
            if r > n - 2:
                break
            lower = modes.lower if down == 1 else modes.lower2
            for part in range(2):
                work[part][0] = 0.0
            _times(lower, r, modes.diagonal, i, first, last, 1.0, work, 0)
            for a in range(3):
                for b in range(3):
                    for k in range(first, last):
                        lower[0][r, a, b, k] = work[0][0, a, b, k]
                        lower[1][r, a, b, k] = work[1][0, a, b, k]
            if down == 1:
                _times(work, 0, modes.upper, i, first, last, -1.0, modes.diagonal, r)
                _times(work, 0, modes.upper2, i, first, last, -1.0, modes.upper, r)
            else:
                _times(work, 0, modes.upper, i, first, last, -1.0, modes.lower, r)
                _times(work, 0, modes.upper2, i, first, last, -1.0, modes.diagonal, r)
    return True


@compiled
def _subtract(
    blocks: tuple[np.ndarray, np.ndarray],
    i: int,
    real: np.ndarray,
    imaginary: np.ndarray,
    r: int,
    first: int,
    last: int,
    o: int,
) -> None:
    """Row o of the vectors -= block i times row r."""
    br, bi = blocks
    for a in range(3):
        for k in range(first, last):
            real[o, a, k] -= (
                br[i, a, 0, k] * real[r, 0, k]
                - bi[i, a, 0, k] * imaginary[r, 0, k]
                + br[i, a, 1, k] * real[r, 1, k]
                - bi[i, a, 1, k] * imaginary[r, 1, k]
                + br[i, a, 2, k] * real[r, 2, k]
                - bi[i, a, 2, k] * imaginary[r, 2, k]
            )
            imaginary[o, a, k] -= (
                br[i, a, 0, k] * imaginary[r, 0, k]
                + bi[i, a, 0, k] * real[r, 0, k]
                + br[i, a, 1, k] * imaginary[r, 1, k]
                + bi[i, a, 1, k] * real[r, 1, k]
                + br[i, a, 2, k] * imaginary[r, 2, k]
                + bi[i, a, 2, k] * real[r, 2, k]
            )


@compiled
def solve_modes(first: int, last: int, modes: Modes, real: np.ndarray, imaginary: np.ndarray) -> None:
    """Solve for the modes first ... last - 1 in place; real, imaginary: (n, 3, modes)."""
    n = real.shape[0]
    dr, di = modes.diagonal
    hold = np.empty((6, last))
    for i in range(2, n - 1):
        _subtract(modes.lower, i, real, imaginary, i - 1, first, last, i)
        if i > 2:
            _subtract(modes.lower2, i, real, imaginary, i - 2, first, last, i)
    for i in range(n - 2, 0, -1):
        if i < n - 2:
            _subtract(modes.upper, i, real, imaginary, i + 1, first, last, i)
        if i < n - 3:
            _subtract(modes.upper2, i, real, imaginary, i + 2, first, last, i)
        for a in range(3):
            for k in range(first, last):
                hold[a, k] = (
                    dr[i, a, 0, k] * real[i, 0, k]
                    - di[i, a, 0, k] * imaginary[i, 0, k]
                    + dr[i, a, 1, k] * real[i, 1, k]
                    - di[i, a, 1, k] * imaginary[i, 1, k]
                    + dr[i, a, 2, k] * real[i, 2, k]
                    - di[i, a, 2, k] * imaginary[i, 2, k]
                )
                hold[a + 3, k] = (
                    dr[i, a, 0, k] * imaginary[i, 0, k]
                    + di[i, a, 0, k] * real[i, 0, k]
                    + dr[i, a, 1, k] * imaginary[i, 1, k]
                    + di[i, a, 1, k] * real[i, 1, k]
                    + dr[i, a, 2, k] * imaginary[i, 2, k]
                    + di[i, a, 2, k] * real[i, 2, k]
                )
        for a in range(3):
            for k in range(first, last):
                real[i, a, k] = hold[a, k]
                imaginary[i, a, k] = hold[a + 3, k]
