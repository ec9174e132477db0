"""A direct elliptic solver on the cylinder: Fourier modes around the ring, a banded system along z for each, Eq. (38).

The operator is the fourth-order staggered one of Eq. (30) in both directions. Its coefficients may vary along z, not
around: then the modes part. `scipy.fft` transforms; a compiled L D L^T of half bandwidth 3 solves, many modes abreast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled

Floats = NDArray[np.float64]

BLOCK = 64
"""Modes that are eliminated abreast: their work fits into a core's cache, and neighbours share vector registers."""

NEGLIGIBLE = 1e-16
"""Modes above the last one that exceeds this share of the largest are rounding, and are left out."""


def ring_symbol(n_theta: int) -> Floats:
    """What the ring's stencil makes of the modes 0...n_theta//2, times (24 cell sizes)^2; shape (n_theta//2 + 1,)."""
    angle = np.pi * np.arange(n_theta // 2 + 1) / n_theta
    return (2.0 * (27.0 * np.sin(angle) - np.sin(3.0 * angle))) ** 2


@compiled
def _bands(along: np.ndarray, n_z: int, bands: np.ndarray) -> None:
    """Upper bands of minus the operator along z with sealed ends, (4, n_z): entry [d, i] is A[i, i + d]."""
    weights = (1.0, -27.0, 27.0, -1.0)
    for face in range(n_z - 1):
        for a in range(4):
            row = min(max(face - 1 + a, 0), n_z - 1)
            for b in range(4):
                column = min(max(face - 1 + b, 0), n_z - 1)
                if column >= row:
                    bands[column - row, row] += along[face] * weights[a] * weights[b]


@compiled
def _factor(bands: np.ndarray, around: np.ndarray, symbol: np.ndarray, factor: np.ndarray) -> None:
    """L D L^T of every mode, (n_z, 4, modes): 1/d, then L one, two and three to the left of the diagonal."""
    n_z, _, modes = factor.shape
    for i in range(n_z):
        for m in range(modes):
            d = bands[0, i] + symbol[m] * around[i]
            if i > 2:
                u3 = bands[3, i - 3]
                left3 = u3 * factor[i - 3, 0, m]
            else:
                u3 = left3 = 0.0
            if i > 1:
                u2 = bands[2, i - 2] - u3 * factor[i - 2, 1, m]
                left2 = u2 * factor[i - 2, 0, m]
            else:
                u2 = left2 = 0.0
            if i > 0:
                u1 = bands[1, i - 1] - u3 * factor[i - 1, 2, m] - u2 * factor[i - 1, 1, m]
                left1 = u1 * factor[i - 1, 0, m]
            else:
                u1 = left1 = 0.0
            factor[i, 0, m] = 1.0 / (d - u3 * left3 - u2 * left2 - u1 * left1)
            factor[i, 1, m] = left1
            factor[i, 2, m] = left2
            factor[i, 3, m] = left3
    # The mean around the ring is fixed up to a constant: its last pivot is zero but for rounding.
    factor[n_z - 1, 0, 0] = 0.0


@compiled
def _solve(factor: np.ndarray, spectrum: np.ndarray, first: int, stop: int, work: np.ndarray) -> None:
    """Solve the modes first...stop-1 in place; spectrum: (n_z, modes, 2), real and imaginary parts."""
    n_z = factor.shape[0]
    for begin in range(first, stop, BLOCK):
        size = min(BLOCK, stop - begin)
        for i in range(n_z):
            here = factor[i, :, begin : begin + size]
            right = spectrum[i, begin : begin + size]
            one, two, three = work[i + 2], work[i + 1], work[i]
            new = work[i + 3]
            for m in range(size):
                new[0, m] = right[m, 0] - here[1, m] * one[0, m] - here[2, m] * two[0, m] - here[3, m] * three[0, m]
                new[1, m] = right[m, 1] - here[1, m] * one[1, m] - here[2, m] * two[1, m] - here[3, m] * three[1, m]
        for i in range(n_z - 1, -1, -1):
            new = work[i + 3]
            pivot = factor[i, 0, begin : begin + size]
            for m in range(size):
                new[0, m] *= pivot[m]
                new[1, m] *= pivot[m]
            for down in range(1, min(3, n_z - 1 - i) + 1):
                left = factor[i + down, down, begin : begin + size]
                known = work[i + 3 + down]
                for m in range(size):
                    new[0, m] -= left[m] * known[0, m]
                    new[1, m] -= left[m] * known[1, m]
            left_side = spectrum[i, begin : begin + size]
            for m in range(size):
                left_side[m, 0] = new[0, m]
                left_side[m, 1] = new[1, m]


@compiled
def _last_mode(spectrum: np.ndarray, share: float) -> int:
    """One more than the last mode that somewhere exceeds `share` of the largest value; 0 if all vanish."""
    n_z, modes, _ = spectrum.shape
    top = np.zeros(modes)
    for i in range(n_z):
        for m in range(modes):
            top[m] = max(top[m], abs(spectrum[i, m, 0]), abs(spectrum[i, m, 1]))
    limit = share * top.max()
    for m in range(modes - 1, -1, -1):
        if top[m] > limit:
            return m + 1
    return 0


class CylinderSolver:
    """Solves -(d/dz a du/dz + b(z) d2u/ds2) = f with sealed ends, for coefficients that do not vary around the ring.

    along: a at the n_z - 1 inner faces over (24 h)^2. around: b at the n_z cells over (24 ds)^2, all positive. The
    factorisation is done here, once; `solve` may then be called for any number of right-hand sides.
    """

    def __init__(self, along: Floats, around: Floats, n_theta: int) -> None:
        n_z = around.size
        if along.shape != (n_z - 1,) or not (np.all(around > 0.0) and np.all(along > 0.0)):
            raise ValueError(
                f"coefficients of shapes {along.shape} and {around.shape}: {n_z - 1} and {n_z} positive numbers are "
                "needed; check stretches and conductivities"
            )
        self.shape = (n_z, n_theta)
        modes = n_theta // 2 + 1
        bands = np.zeros((4, n_z))
        _bands(along, n_z, bands)
        self._factor = np.empty((n_z, 4, modes))
        _factor(bands, around, ring_symbol(n_theta), self._factor)
        self._work = np.zeros((n_z + 3, 2, BLOCK))

    def solve(self, right: Floats, with_mean: bool = True) -> Floats:
        """u of zero mean for a right-hand side f of zero sum, both (n_z, n_theta).

        with_mean = False leaves the mean around each ring out: where f has none, only rounding would be solved for.
        A mean of f over the whole surface has no solution; what there is of it is taken off, so callers check it.
        """
        n_theta = self.shape[1]
        import scipy.fft  # here: runs of one column never need it, and it takes long to load

        spectrum = scipy.fft.rfft(right, axis=1)
        if with_mean:
            spectrum[:, 0] -= spectrum[:, 0].mean()
        else:
            spectrum[:, 0] = 0.0
        pairs = spectrum.view(np.float64).reshape(*spectrum.shape, 2)
        stop = _last_mode(pairs, NEGLIGIBLE)
        spectrum[:, stop:] = 0.0
        _solve(self._factor, pairs, 0 if with_mean else 1, stop, self._work)
        if with_mean:
            spectrum[:, 0] -= spectrum[:, 0].mean()
        return np.asarray(scipy.fft.irfft(spectrum, n=n_theta, axis=1, overwrite_x=True))
