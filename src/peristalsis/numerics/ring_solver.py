"""Linear systems on a tube by averaging around the ring: the preconditioner of the wall on the whole surface, Eq. (40).

The operator is scaled by the roots of its diagonal, averaged over the columns in their own frames, and Fourier
transformed around the ring: one system of 3x3 blocks along z, two neighbours wide on either side, for each mode. For
a ring-uniform operator this is the operator itself. Modes are factored when a right-hand side first needs them.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled
from .ring_blocks import RingOperator, bending_weight

Floats = NDArray[np.float64]

FEW = 8
"""Modes are factored in groups, when first needed: the mean, those below this number, the rest."""


class Constraint(NamedTuple):
    """Nodes (n, m) that may move only across their unit `normal` (n, 3, m): `held` tells which, `rows` where any is."""

    held: np.ndarray
    rows: np.ndarray
    normal: np.ndarray


class Modes(NamedTuple):
    """Block systems of all modes, real and imaginary parts, (n, 3, 3, modes): diagonal, and neighbours along z."""

    diagonal: tuple[np.ndarray, np.ndarray]
    lower: tuple[np.ndarray, np.ndarray]
    lower2: tuple[np.ndarray, np.ndarray]
    upper: tuple[np.ndarray, np.ndarray]
    upper2: tuple[np.ndarray, np.ndarray]


@compiled
def project(constraint: Constraint, field: np.ndarray) -> None:
    """Take the part along the normal out of `field` (n, 3, m) where nodes are held, in place."""
    held = constraint.held
    normal = constraint.normal
    for i in range(field.shape[0]):
        if not constraint.rows[i]:
            continue
        for j in range(field.shape[2]):
            if held[i, j]:
                along = (
                    normal[i, 0, j] * field[i, 0, j]
                    + normal[i, 1, j] * field[i, 1, j]
                    + normal[i, 2, j] * field[i, 2, j]
                )
                for a in range(3):
                    field[i, a, j] -= along * normal[i, a, j]


@compiled
def add_normal(constraint: Constraint, stiffness: np.ndarray, field: np.ndarray, out: np.ndarray) -> None:
    """Add stiffness (n, m) times the part of `field` along the normal of held nodes to `out`."""
    held = constraint.held
    normal = constraint.normal
    for i in range(field.shape[0]):
        if not constraint.rows[i]:
            continue
        for j in range(field.shape[2]):
            if held[i, j]:
                along = stiffness[i, j] * (
                    normal[i, 0, j] * field[i, 0, j]
                    + normal[i, 1, j] * field[i, 1, j]
                    + normal[i, 2, j] * field[i, 2, j]
                )
                for a in range(3):
                    out[i, a, j] += along * normal[i, a, j]


@compiled
def scale_of_nodes(operator: RingOperator, constraint: Constraint, inverse: np.ndarray, stiffness: np.ndarray) -> None:
    """1/root of the constrained operator's diagonal into `inverse` (n, 3, m); `stiffness` (n, m) of held normals."""
    blocks = operator.blocks
    n = inverse.shape[0]
    m = inverse.shape[2]
    block = np.empty((3, 3))
    inverse[0] = 0.0
    inverse[n - 1] = 0.0
    for i in range(1, n - 1):
        extra = operator.bend_along * bending_weight(i, i, n) + 6.0 * operator.bend_around
        for j in range(m):
            for a in range(3):
                for b in range(3):
                    block[a, b] = blocks[i, 4, a, b, j]
                block[a, a] += extra
            mean = (abs(block[0, 0]) + abs(block[1, 1]) + abs(block[2, 2])) / 3.0
            stiffness[i, j] = mean
            if constraint.held[i, j]:
                constrain(block, constraint.normal, i, j, constraint.normal, i, j, True, True)
                for a in range(3):
                    block[a, a] += mean * constraint.normal[i, a, j] ** 2
            for a in range(3):
                inverse[i, a, j] = 1.0 / math.sqrt(max(abs(block[a, a]), 1e-6 * mean))


@compiled
def constrain(
    block: np.ndarray,
    left: np.ndarray,
    i: int,
    j: int,
    right: np.ndarray,
    r: int,
    k: int,
    held_left: bool,
    held_right: bool,
) -> None:
    """Project a 3x3 block on the left by the normal of node (i, j), on the right by that of (r, k), where held."""
    if held_left:
        for b in range(3):
            along = left[i, 0, j] * block[0, b] + left[i, 1, j] * block[1, b] + left[i, 2, j] * block[2, b]
            for a in range(3):
                block[a, b] -= along * left[i, a, j]
    if held_right:
        for a in range(3):
            along = right[r, 0, k] * block[a, 0] + right[r, 1, k] * block[a, 1] + right[r, 2, k] * block[a, 2]
            for b in range(3):
                block[a, b] -= along * right[r, b, k]


@compiled
def average_around(
    operator: RingOperator,
    constraint: Constraint,
    stiffness: np.ndarray,
    inverse: np.ndarray,
    near: np.ndarray,
    far: np.ndarray,
    around: np.ndarray,
) -> None:
    """Mean over the columns of the scaled, constrained operator.

    near (n, 9, 3, 3): the stencil; far (n, 2, 3, 3): rows i - 2 and i + 2; around (n, 3, 3): factor of squared second
    differences around the ring.
    """
    blocks = operator.blocks
    n = inverse.shape[0]
    m = inverse.shape[2]
    block = np.empty((3, 3))
    near[:, :, :, :] = 0.0
    far[:, :, :, :] = 0.0
    around[:, :, :] = 0.0
    for i in range(1, n - 1):
        for q in range(9):
            r = i + q // 3 - 1
            if r < 1 or r > n - 2:
                continue
            o = q % 3 - 1
            extra = operator.bend_along * bending_weight(i, r, n) if o == 0 else 0.0
            if not (constraint.rows[i] or constraint.rows[r]):
                for a in range(3):
                    for b in range(3):
                        add = extra if a == b else 0.0
                        total = (blocks[i, q, a, b, 0] + add) * inverse[i, a, 0] * inverse[r, b, (o + m) % m]
                        for j in range(1, m - 1):
                            total += (blocks[i, q, a, b, j] + add) * inverse[i, a, j] * inverse[r, b, j + o]
                        total += (
                            (blocks[i, q, a, b, m - 1] + add) * inverse[i, a, m - 1] * inverse[r, b, (m - 1 + o) % m]
                        )
                        near[i, q, a, b] = total / m
                continue
            for j in range(m):
                k = (j + o + m) % m
                for a in range(3):
                    for b in range(3):
                        block[a, b] = blocks[i, q, a, b, j]
                    block[a, a] += extra
                constrain(
                    block,
                    constraint.normal,
                    i,
                    j,
                    constraint.normal,
                    r,
                    k,
                    constraint.held[i, j],
                    constraint.held[r, k],
                )
                if q == 4 and constraint.held[i, j]:
                    for a in range(3):
                        for b in range(3):
                            block[a, b] += stiffness[i, j] * constraint.normal[i, a, j] * constraint.normal[i, b, j]
                for a in range(3):
                    for b in range(3):
                        near[i, q, a, b] += block[a, b] * inverse[i, a, j] * inverse[r, b, k] / m
        for side in range(2):
            r = i - 2 if side == 0 else i + 2
            if operator.bend_along == 0.0 or r < 1 or r > n - 2:
                continue
            weight = operator.bend_along * bending_weight(i, r, n)
            for j in range(m):
                block[:, :] = 0.0
                for a in range(3):
                    block[a, a] = weight
                constrain(
                    block,
                    constraint.normal,
                    i,
                    j,
                    constraint.normal,
                    r,
                    j,
                    constraint.held[i, j],
                    constraint.held[r, j],
                )
                for a in range(3):
                    for b in range(3):
                        far[i, side, a, b] += block[a, b] * inverse[i, a, j] * inverse[r, b, j] / m
        for j in range(m):
            for a in range(3):
                around[i, a, a] += operator.bend_around * inverse[i, a, j] ** 2 / m


@compiled
def fill_modes(
    near: np.ndarray,
    far: np.ndarray,
    around: np.ndarray,
    tether: float,
    inverse: np.ndarray,
    first: int,
    last: int,
    modes: Modes,
) -> None:
    """Block systems of the modes first ... last - 1 from the averages; tether: see `RingOperator`."""
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


class RingSolver:
    """The averaged operator with its factors: `solve` is the preconditioner. One object serves one tangent."""

    def __init__(self, operator: RingOperator, constraint: Constraint) -> None:
        n, m = constraint.held.shape
        self.inverse_scale = np.empty((n, 3, m))
        self.stiffness = np.zeros((n, m))
        self._near, self._far = np.empty((n, 9, 3, 3)), np.empty((n, 2, 3, 3))
        self._around = np.empty((n, 3, 3))
        self._tether = operator.tether
        scale_of_nodes(operator, constraint, self.inverse_scale, self.stiffness)
        average_around(operator, constraint, self.stiffness, self.inverse_scale, self._near, self._far, self._around)
        count = m // 2 + 1
        self._modes = Modes(*((np.empty((n, 3, 3, count)), np.empty((n, 3, 3, count))) for _ in range(5)))
        edges = sorted({0, 1, min(FEW, count), count})
        self._groups = list(pairwise(edges))
        self._ready = [False] * len(self._groups)
        self.singular = False

    def solve(self, field: Floats, negligible: float) -> Floats:
        """Approximate solution for a right-hand side (n, 3, m); what is negligible of it, by whole groups, is let be.

        negligible: Euclidean norm that a group of modes may have in the right-hand side and be taken for zero.
        """
        from scipy import fft  # here: runs of one column never need it, and it takes long to load

        m = field.shape[2]
        if not field.any():
            return np.zeros_like(field)
        if negligible > 0.0:
            spectrum = fft.rfft(field, axis=2).reshape(-1, m // 2 + 1)
            energy = np.einsum("ik,ik->k", spectrum.real, spectrum.real)
            energy += np.einsum("ik,ik->k", spectrum.imag, spectrum.imag)
            energy[1 : (m + 1) // 2] *= 2.0
            wanted = [float(energy[a:b].sum()) > negligible**2 * m for a, b in self._groups]
        else:
            wanted = [True] * len(self._groups)
        transformed = fft.rfft(field * self.inverse_scale, axis=2)
        real, imaginary = np.ascontiguousarray(transformed.real), np.ascontiguousarray(transformed.imag)
        # All at once where all are wanted: long rows of modes are what the loops run fastest over.
        spans = (
            [(0, m // 2 + 1, all(self._ready))]
            if all(wanted) and len(set(self._ready)) == 1
            else [(*span, ready) for span, ready in zip(self._groups, self._ready, strict=True)]
        )
        whole = len(spans) == 1
        for g, (first, last, ready) in enumerate(spans):
            if not (whole or wanted[g]):
                real[:, :, first:last] = 0.0
                imaginary[:, :, first:last] = 0.0
                continue
            if not ready:
                fill_modes(
                    self._near, self._far, self._around, self._tether, self.inverse_scale, first, last, self._modes
                )
                if not factor_modes(first, last, self._modes):
                    self.singular = True
                    return np.zeros_like(field)
                self._ready = [True] * len(self._ready) if whole else [r or k == g for k, r in enumerate(self._ready)]
            solve_modes(first, last, self._modes, real, imaginary)
        real[[0, -1]] = 0.0
        imaginary[[0, -1]] = 0.0
        return np.asarray(fft.irfft(real + 1j * imaginary, n=m, axis=2) * self.inverse_scale)
