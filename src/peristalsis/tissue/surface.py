"""Conduction on the whole surface: the operator of Eq. (30) along z and around the periodic ring, Eqs. (11), (37).

Fields are flattened (z, theta). A surface operator applies conduction to a potential; one is built for each layer and
wall step, since the stretches change from step to step.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from .conduction import SPECTRAL_FACTOR, fill_ghosts

Floats = NDArray[np.float64]

RING_ALLOWANCE = 0.05
"""Share of the rate along z that fluxes around the ring may add before they cost stages, Eq. (31): half the reserve."""


class Conductivities(NamedTuple):
    """Conductivities of a layer along z and around the ring, inside the cells and between them, in one unit.

    Only their ratios matter: the scale comes with the diffusivity along z.
    """

    inner_axial: float
    outer_axial: float
    inner_around: float
    outer_around: float

    @property
    def axial_share(self) -> float:
        """g_iz/(g_iz + g_oz): share of the potential gradient along z that the interstitium takes."""
        return self.inner_axial / (self.inner_axial + self.outer_axial)

    @property
    def effective_axial(self) -> float:
        """Series conductivity along z, Eq. (11)."""
        return self.inner_axial * self.outer_axial / (self.inner_axial + self.outer_axial)

    @property
    def effective_around(self) -> float:
        """Series conductivity around the ring."""
        return self.inner_around * self.outer_around / (self.inner_around + self.outer_around)

    @property
    def alike(self) -> Conductivities:
        """Media of equal anisotropy with the same series conductivities: what the pseudo-bidomain takes, Eq. (96)."""
        inner, outer = self.inner_axial, self.outer_axial
        around = self.effective_around / self.effective_axial
        return Conductivities(inner, outer, inner * around, outer * around)

    @property
    def mismatch(self) -> float:
        """k_z (g_is + g_os) - g_is: what drives the extracellular correction (37); zero with equal anisotropy."""
        if self.inner_axial * self.outer_around == self.inner_around * self.outer_axial:
            return 0.0
        return self.axial_share * (self.inner_around + self.outer_around) - self.inner_around


class SurfaceSizes(NamedTuple):
    """Size of a conduction cell along z and around the undeformed ring [cm]."""

    axial: float
    around: float


class SurfaceOperator(Protocol):
    """Conduction on a layer of shape (n_z, n_theta)."""

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along z and around the ring."""

    @property
    def ring_rate(self) -> float:
        """Bound on what fluxes around the ring add to the largest decay rate along z [1/ms]."""

    def apply(self, padded: Floats, rate: Floats, low: int, high: int) -> None:
        """Conduction of the potential, C_m^-1 M_vs L V, at the cells low...high - 1 into `rate` [mV/ms].

        padded: potential [mV] with two ghost rings a side, size (n_z + 4)*n_theta; its ghosts are filled here. rate:
        of all n_z*n_theta cells. low, high: whole rings; the rate of other cells is left as it is.
        """


@compiled
def _ring_fluxes(row: np.ndarray, coefficient: np.ndarray, factor: float, closed: np.ndarray, flux: np.ndarray) -> None:
    """Fluxes around one ring: those of the faces -3/2, -1/2, 1/2 ... n + 1/2 into flux[0 ... n + 2].

    closed: work of size n + 3, as flux.
    """
    n = row.size
    closed[0] = row[n - 1]
    closed[1 : n + 1] = row
    closed[n + 1] = row[0]
    closed[n + 2] = row[1 % n]
    for j in range(n):
        flux[j + 2] = factor * coefficient[j] * (closed[j] - closed[j + 3] + 27.0 * (closed[j + 2] - closed[j + 1]))
    flux[0] = flux[2 + (2 * n - 2) % n]
    flux[1] = flux[n + 1]
    flux[n + 2] = flux[2]


@compiled
def around_ring(potential: np.ndarray, coefficient: np.ndarray, factor: float, rate: np.ndarray) -> None:
    """factor * d/ds (coefficient dV/ds) at every cell into `rate`, both flattened, fourth order on the closed ring.

    coefficient: at the faces j + 1/2 over (24 ds)^2, shape (n_z, n_theta). What one cell gains its neighbour loses,
    so each ring's sum is kept; without variation around the ring the result is exactly zero.
    """
    n_z, n = coefficient.shape
    closed, flux = np.empty(n + 3), np.empty(n + 3)
    for i in range(n_z):
        _ring_fluxes(potential[i * n : (i + 1) * n], coefficient[i], factor, closed, flux)
        gain = rate[i * n : (i + 1) * n]
        for j in range(n):
            gain[j] = flux[j] - flux[j + 3] + 27.0 * (flux[j + 2] - flux[j + 1])


@compiled
def diffuse_surface(
    padded: np.ndarray, along: np.ndarray, around: np.ndarray, rate: np.ndarray, low: int, high: int
) -> None:
    """Divergence of the fluxes along z and around the ring, flattened, into `rate`; fills the ghosts of `padded`.

    padded: potential with two ghost rings a side, size (n_z + 4)*n_theta. along: at the inner z faces over (24 h)^2,
    (n_z - 1, n_theta). around: (n_z, n_theta) over (24 ds)^2. Only the rings low...high - 1 are done. Along z the
    arithmetic of `conduction.diffuse`, ring by ring, so that fluxes stay in cache.
    """
    n_z, n = around.shape
    fill_ghosts(padded, n)
    closed, ring = np.empty(n + 3), np.empty(n + 3)
    flux = np.zeros((4, n))  # faces i - 2 ... i + 1 of cell i, each in the row (face + 2) % 4
    for face in range(max(low - 2, -1), min(high, n_z) + 1):
        here = flux[(face + 2) % 4]
        if face < 0 or face == n_z - 1:
            here[:] = 0.0
        elif face == n_z:
            here[:] = -flux[(face + 4) % 4]
        else:
            base = face + 1
            for j in range(n):
                before, left = padded[base * n + j], padded[(base + 1) * n + j]
                right, after = padded[(base + 2) * n + j], padded[(base + 3) * n + j]
                here[j] = along[face, j] * (before - after + 27.0 * (right - left))
        if face == 0:
            flux[0] = -here
        i = face - 1
        if i < low:
            continue
        one, two, three = flux[i % 4], flux[(i + 1) % 4], flux[(i + 2) % 4]
        _ring_fluxes(padded[(i + 2) * n : (i + 3) * n], around[i], 1.0, closed, ring)
        gain = rate[i * n : (i + 1) * n]
        for j in range(n):
            axial = one[j] - here[j] + 27.0 * (three[j] - two[j])
            gain[j] = axial + (ring[j] - ring[j + 3] + 27.0 * (ring[j + 2] - ring[j + 1]))


class Monodomain:
    """Eq. (11) on the surface: one conductor, the inner one with the share of the gradient that it gets along z.

    With equal anisotropy this is exact, and the whole of conduction; otherwise `bidomain.Bidomain` corrects it.
    diffusivity: along z at stretch 1 [cm^2/s]. axial_stretch: at the inner z faces, (n_z - 1, n_theta).
    hoop_stretch: at the theta faces j + 1/2, (n_z, n_theta).
    """

    def __init__(
        self,
        diffusivity: float,
        conductivities: Conductivities,
        sizes: SurfaceSizes,
        axial_stretch: Floats,
        hoop_stretch: Floats,
    ) -> None:
        n_z, n_theta = hoop_stretch.shape
        if axial_stretch.shape != (n_z - 1, n_theta):
            raise ValueError(
                f"axial stretch of shape {axial_stretch.shape} beside a hoop stretch of shape {hoop_stretch.shape}: "
                f"({n_z - 1}, {n_theta}) is needed, one value for each inner face"
            )
        self._shape = (n_z, n_theta)
        self.conductivities = conductivities
        g = conductivities
        self._scale = diffusivity * 1e-3 / g.effective_axial
        self.along = (diffusivity * 1e-3 / (24.0 * sizes.axial) ** 2) / axial_stretch
        inner = (1.0 - g.axial_share) * g.inner_around
        self.around = (self._scale * inner / (24.0 * sizes.around) ** 2) / hoop_stretch
        shortest = float(axial_stretch.min()) if n_z > 1 else math.inf
        self._fastest = (
            4.0 * SPECTRAL_FACTOR / (sizes.axial**2 * shortest),
            4.0 * SPECTRAL_FACTOR / (sizes.around**2 * float(hoop_stretch.min())) if n_theta > 1 else 0.0,
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along z and around the ring."""
        return self._shape

    @property
    def ring_rate(self) -> float:
        """Bound on what fluxes around the ring add to the largest decay rate along z [1/ms].

        Conductors in series: the symbol (6) grows with either wave number and with either stretch's inverse, so its
        value at the largest of all bounds the whole.
        """
        g, (along, around) = self.conductivities, self._fastest
        inner = g.inner_axial * along + g.inner_around * around
        outer = g.outer_axial * along + g.outer_around * around
        if inner + outer == 0.0:
            return 0.0
        return self._scale * (inner * outer / (inner + outer) - g.effective_axial * along)

    def apply(self, padded: Floats, rate: Floats, low: int, high: int) -> None:
        """Conduction of the potential into `rate` [mV/ms]; see `SurfaceOperator`."""
        n_theta = self._shape[1]
        diffuse_surface(padded, self.along, self.around, rate, low // n_theta, high // n_theta)


def stability_rate(rate: float, ring_rate: float) -> float:
    """Decay rate [1/ms] for which an explicit step must have stages, Eq. (31).

    rate: of conduction along z with the currents, as on one column. ring_rate: `SurfaceOperator.ring_rate`. Stages
    are counted with a tenth in hand, and the ring may use up half of it: so a sheet whose columns are much
    wider than its cells are long takes exactly the steps of one column.
    """
    return max(rate, (rate + ring_rate) / (1.0 + RING_ALLOWANCE))
