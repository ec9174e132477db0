"""The longitudinal layer as a bidomain of unequal anisotropy: the elliptic problem of Eqs. (6), (37), (38).

Written for the correction u = phi_e/(1 - k) + k V/(1 - k), k = g_iz/(g_iz + g_oz), which is driven by variation around
the ring alone. Without any it vanishes exactly, and the sheet is the cable of Eq. (6) to the last bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..numerics.cylinder import CylinderSolver
from .surface import (
    Conductivities,
    Monodomain,
    SurfaceOperator,
    SurfaceSizes,
    around_ring,
    diffuse_surface,
)

Floats = NDArray[np.float64]

TOLERANCE = 1e-8
"""Residual of the elliptic problem over its right-hand side, 2-norms, at which the iteration ends."""
MOST_ITERATIONS = 300
KEPT_SOLUTIONS = 6
"""Past solutions that make the first guess of the next; when they are complete, only the last is kept."""

ROUNDING = 4.0 * 2.0**-52
"""Right-hand sides below what this relative change of the potential would make are rounding, and count as zero."""
LARGEST_RING_WEIGHT = 56.0**2
"""Largest eigenvalue of the ring's stencil times (24 ds)^2."""


class Elliptic(NamedTuple):
    """How the elliptic problem of a layer is solved: to this residual, or not at all (pseudo-bidomain, Eq. (96))."""

    tolerance: float = TOLERANCE
    pseudo: bool = False


FULL = Elliptic()


class EllipticError(ArithmeticError):
    """The elliptic problem has no solution, or none was found."""


@compiled
def _dot(a: np.ndarray, b: np.ndarray) -> float:
    """Sum of products in a fixed order, by eight partial sums."""
    partial = np.zeros(8)
    whole = a.size - a.size % 8
    for k in range(0, whole, 8):
        for lane in range(8):
            partial[lane] += a[k + lane] * b[k + lane]
    total = 0.0
    for lane in range(8):
        total += partial[lane]
    for k in range(whole, a.size):
        total += a[k] * b[k]
    return total


@compiled
def _move(solution: np.ndarray, residual: np.ndarray, direction: np.ndarray, image: np.ndarray, length: float) -> None:
    """Move the solution along a direction, and the residual with it by the direction's image."""
    for k in range(solution.size):
        solution[k] += length * direction[k]
        residual[k] -= length * image[k]


@compiled
def _turn(inside: np.ndarray, ahead: np.ndarray, share: float) -> None:
    """The next search direction: the preconditioned residual plus a share of the last direction."""
    for k in range(inside.size):
        inside[k] = ahead[k] + share * inside[k]


@compiled
def _without(rest: np.ndarray, image: np.ndarray, old: np.ndarray, its_image: np.ndarray, share: float) -> None:
    """Take a share of an old direction, and of its image, off a new one."""
    for k in range(rest.size):
        rest[k] -= share * old[k]
        image[k] -= share * its_image[k]


class _FirstGuess:
    """The best combination of past solutions as a first guess.

    Source: P. F. Fischer, Comput. Methods Appl. Mech. Engrg. 163 (1998) 193-204. Directions are kept orthonormal in the
    energy of the operator, with their images.
    """

    def __init__(self) -> None:
        self._directions: list[Floats] = []
        self._images: list[Floats] = []

    def guess(self, right: Floats) -> tuple[Floats, Floats]:
        """Guess and residual for a right-hand side."""
        solution, residual = np.zeros_like(right), right.copy()
        for direction, image in zip(self._directions, self._images, strict=True):
            _move(solution, residual, direction, image, _dot(direction, right))
        return solution, residual

    def keep(self, solution: Floats, image: Floats) -> None:
        """Take a new solution, and its image under the operator, into account."""
        if len(self._directions) == KEPT_SOLUTIONS:
            self._directions.clear()
            self._images.clear()
        rest, image = solution.copy(), image.copy()
        whole = _dot(rest, image)
        for old, its_image in zip(self._directions, self._images, strict=True):
            share = _dot(its_image, solution)
            _without(rest, image, old, its_image, share)
        energy = _dot(rest, image)
        if energy > 1e-20 * whole > 0.0:
            norm = 1.0 / math.sqrt(energy)
            rest *= norm
            image *= norm
            self._directions.append(rest)
            self._images.append(image)


def _varies(coefficient: Floats) -> bool:
    return bool(np.any(coefficient != coefficient[:, :1]))


class Bidomain:
    """Eqs. (6) to (10) on the surface; arguments as for `surface.Monodomain`.

    Build one for each wall step: what is factored, and the past solutions that make the next first guess, belong to
    its stretches, and no solution is carried from step to step unseen by the state.
    tolerance: of the conjugate gradients, needed only where a stretch varies around the ring.
    """

    def __init__(
        self,
        diffusivity: float,
        conductivities: Conductivities,
        sizes: SurfaceSizes,
        axial_stretch: Floats,
        hoop_stretch: Floats,
        tolerance: float = TOLERANCE,
    ) -> None:
        g = self.conductivities = conductivities
        self._monodomain = Monodomain(diffusivity, g, sizes, axial_stretch, hoop_stretch)
        self.along, self.around = self._monodomain.along, self._monodomain.around
        # Everything below is divided by (g_iz + g_oz)/effective_axial, so that `along` serves both operators.
        axial = (g.inner_axial + g.outer_axial) / g.effective_axial
        inner = (1.0 - g.axial_share) * g.inner_around
        self._around_both = self.around * ((g.inner_around + g.outer_around) / inner / axial)
        self._drive_factor = g.mismatch / ((1.0 - g.axial_share) * inner * axial)
        self._scale = 1.0 / axial
        self._tolerance = tolerance
        self._uniform = not (_varies(self.along) or _varies(self._around_both))
        self._solver: CylinderSolver | None = None
        n_z, n_theta = self.shape
        self._first = 2 * n_theta
        self._sum = np.zeros((n_z + 4) * n_theta)
        self._search = np.zeros((n_z + 4) * n_theta)
        self._first_guess = _FirstGuess()
        self.solves = 0
        """Banded solves over all modes so far."""

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along z and around the ring."""
        return self._monodomain.shape

    @property
    def ring_rate(self) -> float:
        """Bound on what fluxes around the ring add to the largest decay rate along z [1/ms]."""
        return self._monodomain.ring_rate

    def apply(self, padded: Floats, rate: Floats, low: int, high: int) -> None:
        """Conduction of the potential into `rate` [mV/ms]; see `surface.SurfaceOperator`. Raises EllipticError."""
        inside = self._inside(padded)
        correction = self.correction(inside)
        if correction is None:
            self._monodomain.apply(padded, rate, low, high)
            return
        np.add(inside, correction, out=self._inside(self._sum))
        self._monodomain.apply(self._sum, rate, low, high)

    def correction(self, potential: Floats) -> Floats | None:
        """u of Eq. (37) [mV] for a flattened potential, mean zero; None where it vanishes."""
        factor = self._drive_factor
        if factor == 0.0:
            return None
        drive = np.empty(potential.size)
        around_ring(potential, self.around, factor, drive)
        largest = float(np.abs(drive).max())
        weight = abs(factor) * float(self.around.max()) * LARGEST_RING_WEIGHT
        if largest <= ROUNDING * weight * float(np.abs(potential).max()):
            return None
        if self._uniform:
            self.solves += 1
            return -self._direct().solve(drive.reshape(self.shape), with_mean=False).ravel()
        return self._conjugate_gradients(-drive)

    def extracellular(self, potential: Floats, applied: Floats | None = None) -> Floats:
        """Extracellular potential phi_e [mV], shape (n_z, n_theta), with zero mean over the surface.

        potential: V [mV], that shape. applied: current put into the interstitium over the capacitance [mV/ms], that
        shape; what goes in must come out again, or no phi_e exists: EllipticError.
        """
        share = self.conductivities.axial_share
        flat = np.ascontiguousarray(potential, dtype=np.float64).ravel()
        found = -share * flat
        correction = self.correction(flat)
        if correction is not None:
            found += (1.0 - share) * correction
        if applied is not None:
            found += self._answer_to(applied)
        return (found - found.mean()).reshape(self.shape)

    def _answer_to(self, applied: Floats) -> Floats:
        """Extracellular potential of an applied current alone [mV], flattened."""
        current = self._scale * np.ascontiguousarray(applied, dtype=np.float64).ravel()
        total, size = math.fsum(current), math.fsum(np.abs(current))
        if abs(total) > 1e-12 * size:
            raise EllipticError(
                f"the applied extracellular current sums to {total / size:.3g} of its size over the surface: what is "
                "put into a sealed sheet must be taken out again; balance it"
            )
        if size == 0.0:
            return current
        if self._uniform:
            self.solves += 1
            return self._direct().solve(current.reshape(self.shape)).ravel()
        return self._conjugate_gradients(current)

    def _inside(self, padded: Floats) -> Floats:
        return padded[self._first : padded.size - self._first]

    def _direct(self) -> CylinderSolver:
        """Solver of the operator averaged around the ring: the operator itself where stretches do not vary."""
        if self._solver is None:
            along, around = self.along.mean(axis=1), self._around_both.mean(axis=1)
            if self._uniform:
                along, around = self.along[:, 0], self._around_both[:, 0]
            self._solver = CylinderSolver(np.ascontiguousarray(along), np.ascontiguousarray(around), self.shape[1])
        return self._solver

    def _conjugate_gradients(self, right: Floats) -> Floats:
        """Solve minus the operator of both media = right, flattened and of zero mean."""
        solver = self._direct()
        solution, residual = self._first_guess.guess(right)
        inside = self._inside(self._search)
        image = np.empty_like(right)
        limit = self._tolerance * math.sqrt(_dot(right, right))
        product = 1.0
        for iteration in range(MOST_ITERATIONS):
            if math.sqrt(_dot(residual, residual)) <= limit:
                solution -= solution.mean()
                self._first_guess.keep(solution, right - residual)
                return solution
            ahead = solver.solve(residual.reshape(self.shape)).ravel()
            self.solves += 1
            before, product = product, _dot(residual, ahead)
            _turn(inside, ahead, product / before if iteration > 0 else 0.0)
            diffuse_surface(self._search, self.along, self._around_both, image, 0, self.shape[0])
            np.negative(image, out=image)
            _move(solution, residual, inside, image, product / _dot(inside, image))
        raise EllipticError(
            f"the elliptic problem of the longitudinal layer did not reach a residual of {self._tolerance:g} in "
            f"{MOST_ITERATIONS} iterations: the stretch varies too much around the ring, or is not finite"
        )


def surface_operator(
    diffusivity: float,
    conductivities: Conductivities,
    sizes: SurfaceSizes,
    axial_stretch: Floats,
    hoop_stretch: Floats,
    elliptic: Elliptic = FULL,
) -> SurfaceOperator:
    """The operator of a layer: Eq. (11) with equal anisotropy, where (6) reduces to it, and the bidomain otherwise.

    elliptic: how the bidomain is solved, or that the monodomain of the same series conductivities takes its place.
    """
    if conductivities.mismatch == 0.0:
        return Monodomain(diffusivity, conductivities, sizes, axial_stretch, hoop_stretch)
    if elliptic.pseudo:
        return Monodomain(diffusivity, conductivities.alike, sizes, axial_stretch, hoop_stretch)
    return Bidomain(diffusivity, conductivities, sizes, axial_stretch, hoop_stretch, elliptic.tolerance)
