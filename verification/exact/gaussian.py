"""A Gaussian potential on a wide cylinder of unequal anisotropy, with its exact membrane current in Fourier space."""

from __future__ import annotations

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from peristalsis.tissue.surface import SurfaceSizes
from verification.exact.kernel import KernelProblem, Variant, interstitial_source, kernel_current

from .surface import LONGITUDINAL

Floats = NDArray[np.float64]


class Gaussian:
    """B4: a Gaussian of unit width in the middle of a wide cylinder, with its exact current in Fourier space."""

    def __init__(self, cell: float, aspect: float = 1.0, width: float = 20.0, unit: float = 1.0) -> None:
        n_z, n_theta = round(width / cell), round(width / (aspect * cell))
        sizes = SurfaceSizes(width * unit / n_z, width * unit / n_theta)
        z = (np.arange(n_z) + 0.5)[:, None] * sizes.axial - 0.5 * width * unit
        s = np.arange(n_theta)[None, :] * sizes.around - 0.5 * width * unit
        self.potential = np.exp(-(z**2 + s**2) / (2.0 * unit**2))
        self.problem = KernelProblem(LONGITUDINAL, sizes)
        along = (np.pi * np.arange(n_z)[:, None] / (width * unit)) ** 2
        around = (2.0 * np.pi * scipy.fft.rfftfreq(n_theta, sizes.around)) ** 2
        inner, outer = 20.0 * along + 2.0 * around, 80.0 * along + 20.0 * around
        symbol = inner * outer / np.where(inner + outer > 0.0, inner + outer, 1.0)
        spectrum = -symbol * scipy.fft.rfft(scipy.fft.dct(self.potential, axis=0), axis=1)
        self.current = scipy.fft.idct(scipy.fft.irfft(spectrum, n=n_theta, axis=1), axis=0)

    def by_kernel(self, variant: Variant = "corrected", closed: bool = True) -> Floats:
        return kernel_current(interstitial_source(self.potential, self.problem), self.problem, variant, closed)

    def error(self, variant: Variant = "corrected", closed: bool = True) -> float:
        """Largest error over the largest current."""
        return float(np.abs(self.by_kernel(variant, closed) - self.current).max() / np.abs(self.current).max())
