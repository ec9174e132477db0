"""Linear systems on a tube by averaging around the ring: the preconditioner of the wall on the whole surface, Eq. (40).

The operator is scaled by the roots of its diagonal, averaged over the columns in their own frames, and Fourier
transformed around the ring: one system of 3x3 blocks along z, two neighbours wide on either side, for each mode. For
a ring-uniform operator this is the operator itself. Modes are factored when a right-hand side first needs them.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .constraint import Constraint
from .ring_average import Averages, Scale, average_around, scale_of_nodes
from .ring_blocks import RingOperator
from .ring_modes import Modes, factor_modes, fill_modes, solve_modes

Floats = NDArray[np.float64]

FEW = 8
"""Modes are factored in groups, when first needed: the mean, those below this number, the rest."""


class RingSolver:
    """The averaged operator with its factors: `solve` is the preconditioner. One object serves one tangent."""

    def __init__(self, operator: RingOperator, constraint: Constraint) -> None:
        n, m = constraint.held.shape
        self._scale = Scale(np.empty((n, 3, m)), np.zeros((n, m)))
        self._averages = Averages(np.empty((n, 9, 3, 3)), np.empty((n, 2, 3, 3)), np.empty((n, 3, 3)))
        self._tether = operator.tether
        scale_of_nodes(operator, constraint, self._scale)
        average_around(operator, constraint, self._scale, self._averages)
        count = m // 2 + 1
        self._modes = Modes(*((np.empty((n, 3, 3, count)), np.empty((n, 3, 3, count))) for _ in range(5)))
        edges = sorted({0, 1, min(FEW, count), count})
        self._groups = list(pairwise(edges))
        self._ready = [False] * len(self._groups)
        self.singular = False

    @property
    def stiffness(self) -> Floats:
        """What was put along the normals of held nodes, (n, m)."""
        return self._scale.stiffness

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
        transformed = fft.rfft(field * self._scale.inverse, axis=2)
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
                fill_modes(self._averages, self._tether, self._scale.inverse, first, last, self._modes)
                if not factor_modes(first, last, self._modes):
                    self.singular = True
                    return np.zeros_like(field)
                self._ready = [True] * len(self._ready) if whole else [r or k == g for k, r in enumerate(self._ready)]
            solve_modes(first, last, self._modes, real, imaginary)
        real[[0, -1]] = 0.0
        imaginary[[0, -1]] = 0.0
        return np.asarray(fft.irfft(real + 1j * imaginary, n=m, axis=2) * self._scale.inverse)
