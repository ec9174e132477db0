"""The bidomain as a local term and a kernel, Eqs. (7) and (8): an independent check of `bidomain`, not used in runs.

Form of A. L. Muler and V. S. Markin as the paper prints it, corrected; for stretches that do not vary. The misprints
are kept as variants, so that tests can show what each costs. The kernel is exact over each cell.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, get_args

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from peristalsis.tissue.surface import Conductivities, SurfaceSizes

Floats = NDArray[np.float64]

Variant = Literal["corrected", "no_pi", "inverted_root", "outer_share", "unsquared", "midpoint"]
"""As it is right; four misprints of (7) and (8): no 1/pi before the arctangent, its root upside down, g_oz/G_z for
g_iz/G_z, the denominator of the kernel not squared; and the kernel taken at the middle of each cell."""


class KernelProblem(NamedTuple):
    """Conductivities in one unit, cell sizes [cm], and the uniform stretches along z and around."""

    conductivities: Conductivities
    sizes: SurfaceSizes
    axial_stretch: float = 1.0
    hoop_stretch: float = 1.0

    @property
    def total_axial(self) -> float:
        """G_z, Eq. (10)."""
        return (self.conductivities.inner_axial + self.conductivities.outer_axial) / self.axial_stretch

    @property
    def total_around(self) -> float:
        """G_s, Eq. (10)."""
        return (self.conductivities.inner_around + self.conductivities.outer_around) / self.hoop_stretch

    @property
    def anisotropy(self) -> float:
        """d of Eqs. (7) and (8), from the ratios of Eq. (9)."""
        g = self.conductivities
        around, axial = g.outer_around / g.inner_around, g.outer_axial / g.inner_axial
        return (around - axial) / ((1.0 + around) * (1.0 + axial))

    @property
    def scaled_sizes(self) -> tuple[float, float]:
        """Cell sizes (dx, dy) in x = s/sqrt(G_s), y = z/sqrt(G_z)."""
        return self.sizes.around / math.sqrt(self.total_around), self.sizes.axial / math.sqrt(self.total_axial)


def interstitial_source(potential: Floats, problem: KernelProblem) -> Floats:
    """D of Eq. (7), d/ds(g_os/lambda_c dphi/ds) + d/dz(g_oz/lambda_l dphi/dz), exact in Fourier space.

    potential: (n_z, n_theta), on a closed ring with mirrored ends. Cosines along z, Fourier modes around.
    """
    n_z, n_theta = potential.shape
    along = (math.pi * np.arange(n_z) / (n_z * problem.sizes.axial)) ** 2
    around = (2.0 * math.pi * scipy.fft.rfftfreq(n_theta, problem.sizes.around)) ** 2
    g = problem.conductivities
    symbol = g.outer_axial / problem.axial_stretch * along[:, None] + g.outer_around / problem.hoop_stretch * around
    spectrum = -symbol * scipy.fft.rfft(scipy.fft.dct(potential, axis=0), axis=1)
    return np.asarray(scipy.fft.idct(scipy.fft.irfft(spectrum, n=n_theta, axis=1), axis=0))


def kernel_current(
    source: Floats, problem: KernelProblem, variant: Variant = "corrected", closed: bool = True
) -> Floats:
    """Transmembrane current per M_vs, the sum of (7) and (8), for the source D at the cells, (n_z, n_theta).

    closed: on the cylinder, with all periodic images around the ring and mirror images beyond the ends; otherwise on
    the open plane, for sources narrow against the sheet. Second order in the cell size.
    """
    if variant not in get_args(Variant):
        raise ValueError(f"variant = {variant!r} is unknown; choose one of {', '.join(get_args(Variant))}")
    if closed and variant in ("unsquared", "midpoint"):
        raise ValueError(f"variant = {variant!r} has no sum over images; use closed = False")
    n_z, n_theta = source.shape
    if closed:
        # The mirrored sheet after the sheet: an even field of twice the length, periodic in both directions.
        field = np.concatenate([source, source[::-1]])
        rows, columns = 2 * n_z, n_theta
        kernel = _closed_kernel(rows, columns, problem)
    else:
        field = source
        rows, columns = 2 * n_z, 2 * n_theta
        kernel = _open_kernel(rows, columns, problem, variant)
    spectrum = scipy.fft.rfft2(field, (rows, columns)) * scipy.fft.rfft2(kernel)
    rest = scipy.fft.irfft2(spectrum, (rows, columns))[:n_z, :n_theta]
    return np.asarray(local_share(problem, variant, columns if closed else None) * source + rest)


def local_share(problem: KernelProblem, variant: Variant = "corrected", columns: int | None = None) -> float:
    """Factor of D at the cell itself, Eq. (7); on a ring of `columns` with its own periodic images."""
    g = problem.conductivities
    share = (g.outer_axial if variant == "outer_share" else g.inner_axial) / (g.inner_axial + g.outer_axial)
    dx, dy = problem.scaled_sizes
    if columns is None:
        ratio = dy / dx
    else:
        ratio = math.tanh(0.5 * math.pi * dy / (columns * dx)) / math.tan(0.5 * math.pi / columns)
    if variant == "inverted_root":
        ratio *= problem.total_axial / problem.total_around
    return share - 2.0 * problem.anisotropy / (1.0 if variant == "no_pi" else math.pi) * math.atan(ratio)


def _corner_difference(values: Floats) -> Floats:
    return np.asarray(values[1:, 1:] - values[1:, :-1] - values[:-1, 1:] + values[:-1, :-1])


def _open_kernel(rows: int, columns: int, problem: KernelProblem, variant: Variant) -> Floats:
    """Kernel of (8) for the offsets 0 ... n - 1, -n ... -1 in both directions, without the cell itself."""
    dx, dy = problem.scaled_sizes
    row_offsets = np.arange(-(rows // 2), rows // 2)
    column_offsets = np.arange(-(columns // 2), columns // 2)
    if variant in ("unsquared", "midpoint"):
        x, y = dx * column_offsets[None, :], dy * row_offsets[:, None]
        square = x * x + y * y
        square[rows // 2, columns // 2] = 1.0
        kernel = (x * x - y * y) / (square if variant == "unsquared" else square * square) * dx * dy
    else:
        x = dx * (np.append(column_offsets, columns // 2) - 0.5)[None, :]
        y = dy * (np.append(row_offsets, rows // 2) - 0.5)[:, None]
        kernel = -_corner_difference(np.arctan(y / x))
        middle = columns // 2
        kernel[:, middle] = _corner_difference(np.arctan(x[:, middle : middle + 2] / y))[:, 0]
    kernel[rows // 2, columns // 2] = 0.0
    return np.asarray(np.fft.ifftshift(kernel) * problem.anisotropy / (2.0 * math.pi))


def _closed_kernel(rows: int, columns: int, problem: KernelProblem) -> Floats:
    """The same for the offsets 0 ... n - 1 on a ring, with every image around it and along z.

    The images around the ring turn arctan(y/x) into arctan(tanh Y/tan X), X = pi x/L and Y = pi y/L, because the sum of
    1/(x + iy)^2 over them is (pi/L)^2/sin^2(X + iY). Those along z then fall off exponentially.
    """
    dx, dy = problem.scaled_sizes
    scale = math.pi / (columns * dx)
    tangent = np.tan(scale * dx * (np.arange(columns + 1) - 0.5))[None, :]
    kernel = np.zeros((rows, columns))
    images = math.ceil(20.0 / (scale * rows * dy)) + 1
    for image in range(-images, images + 1):
        height = np.tanh(scale * dy * (np.arange(rows + 1) + image * rows - 0.5))[:, None]
        kernel -= _corner_difference(np.arctan(height / tangent))
        straddling = _corner_difference(np.arctan(tangent[:, :2] / height))[:, 0]
        kernel[:, 0] += straddling + _corner_difference(np.arctan(height / tangent[:, :2]))[:, 0]
        if image == 0:
            kernel[0, 0] -= straddling[0]
    return kernel * problem.anisotropy / (2.0 * math.pi)
