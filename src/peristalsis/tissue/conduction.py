"""Conduction along z on the stretched wall: the fourth-order conservative operator, Eq. (30)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import INDEX, compiled

Floats = NDArray[np.float64]

GHOSTS = 2
SPECTRAL_FACTOR = 49.0 / 36.0
"""Largest eigenvalue of the fourth-order operator over that of the three-point one."""


def largest_eigenvalue(diffusivity: float, cell_size: float) -> float:
    """Bound on the decay rate of the discrete operator [1/s], for diffusivity [cm^2/s] and cell size [cm]."""
    return SPECTRAL_FACTOR * 4.0 * diffusivity / cell_size**2


@compiled
def fill_ghosts(padded: np.ndarray, n_theta: int) -> None:
    """Mirror the potential over both ends (no flux): two ghost rings a side of `padded`, flattened (z, theta)."""
    size = padded.size
    for j in range(n_theta):
        padded[n_theta + j] = padded[2 * n_theta + j]
        padded[j] = padded[3 * n_theta + j]
        padded[size - 2 * n_theta + j] = padded[size - 3 * n_theta + j]
        padded[size - n_theta + j] = padded[size - 4 * n_theta + j]


@compiled
def diffuse(padded: np.ndarray, coefficient: np.ndarray, flux: np.ndarray, rate: np.ndarray, n_theta: int) -> None:
    """d/dz (coefficient dV/dz) at every cell, into `rate`.

    padded: potential with two filled ghost rings a side, size (n_z + 4)*n_theta. coefficient: at inner faces over
    (24 h)^2, size (n_z - 1)*n_theta. flux: work of size (n_z + 3)*n_theta: inner faces with two more a side.
    The ends are closed: their flux is zero, the flux beyond is mirrored odd, so the sum of `rate` vanishes.
    """
    diffuse_rings(padded, coefficient, flux, rate, n_theta, min(0, rate.size), rate.size)


@compiled
def diffuse_rings(
    padded: np.ndarray,
    coefficient: np.ndarray,
    flux: np.ndarray,
    rate: np.ndarray,
    n_theta: int,
    low: int,
    high: int,
) -> None:
    """`diffuse` at the cells low...high - 1, which are whole rings."""
    low, high, n_theta = low & INDEX, high & INDEX, n_theta & INDEX
    inner = coefficient.size
    first = 2 * n_theta
    for k in range(max(low - first, 0) & INDEX, min(high + n_theta, inner) & INDEX):
        flux[first + k] = coefficient[k] * (
            padded[k + n_theta] - padded[k + 4 * n_theta] + 27.0 * (padded[k + 3 * n_theta] - padded[k + 2 * n_theta])
        )
    end = first + inner
    for j in range(n_theta):
        flux[n_theta + j] = 0.0
        flux[j] = -flux[2 * n_theta + j]
        flux[end + j] = 0.0
        flux[end + n_theta + j] = -flux[end - n_theta + j]
    for k in range(low, high):
        rate[k] = flux[k] - flux[k + 3 * n_theta] + 27.0 * (flux[k + 2 * n_theta] - flux[k + n_theta])
