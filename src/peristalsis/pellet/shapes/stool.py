"""The stool: a superellipse turned about the tube's axis, Eq. (75): between a spheroid and a cylinder with flat ends.

The foot of a point is looked for along the meridian by Newton's method between two bounds that always hold it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...declared import number
from ...numerics.compiled import compiled

KIND = "shape"
NAME = "stool"
TITLE = "stool: a superellipse, blunter than a spheroid"
PARAMETERS = (
    number("aspect", 1.8, "1", "half length over girth radius", lowest=0.2, highest=10.0),
    number("exponent", 3.0, "1", "of the superellipse; 2 is the spheroid, more is blunter", lowest=2.0, highest=10.0),
)

MOST = 100
"""Iterations: bisection alone would need 53."""
ROUNDING = 2.0**-51
"""Change of v at which the foot is found; v itself is known to 2^-53."""
SAMPLES = 64
DEEP = 0.97
"""Share of the girth below which a point, by its similar body, may have more than one foot."""


class ShapeConstants(NamedTuple):
    """Girth radius [cm]; half length over it; exponent."""

    radius: float
    aspect: float
    exponent: float


@compiled
def unpack_shape(numbers: np.ndarray) -> ShapeConstants:
    """The constants from an array that begins with them."""
    return ShapeConstants(numbers[0], numbers[1], numbers[2])


@compiled
def reach(rho: float, axial: float, shape: ShapeConstants) -> float:
    """Girth radius [cm] of the similar body through a point."""
    n, along = shape.exponent, abs(axial) / shape.aspect
    largest = max(rho, along)
    if largest == 0.0:
        return 0.0
    return largest * ((rho / largest) ** n + (along / largest) ** n) ** (1.0 / n)


@compiled
def _meridian(v: float, shape: ShapeConstants) -> tuple[float, float, float, float, float]:
    """(P, Q, slope_r, slope_z, speed) of Eq. (75) at v: P = x_rho/R, Q = x_zeta/b, gradient, and |dx/dv| [cm]."""
    girth, half, n = shape.radius, shape.aspect * shape.radius, shape.exponent
    p = 1.0 - v
    power_p, power_v = p ** (n - 1.0), v ** (n - 1.0)
    size = power_p * p + power_v * v
    scale = size ** (-1.0 / n)
    turning = (power_v - power_p) / size
    dr = -girth * scale * (1.0 + p * turning)
    dz = half * scale * (1.0 - v * turning)
    shrink = scale ** (n - 1.0)
    return p * scale, v * scale, power_p * shrink / girth, power_v * shrink / half, math.sqrt(dr * dr + dz * dz)


@compiled
def gap_and_normal(rho: float, axial: float, shape: ShapeConstants) -> tuple[float, float, float, float, float]:
    """(gap, n_rho, n_zeta, bend, hoop) at a point; see `sphere.gap_and_normal`.

    A point well inside may have several feet; the search for the nearest one starts from the best of SAMPLES.
    """
    girth, half, n = shape.radius, shape.aspect * shape.radius, shape.exponent
    z = abs(axial)
    low, high = 0.0, 1.0
    sum_of_both = rho / girth + z / half
    v = z / half / sum_of_both if sum_of_both > 0.0 else (1.0 if half < girth else 0.0)
    if reach(rho, axial, shape) < DEEP * girth:
        least = math.inf
        for k in range(SAMPLES + 1):
            P, Q, _, _, _ = _meridian(k / SAMPLES, shape)
            square = (rho - girth * P) ** 2 + (z - half * Q) ** 2
            if square < least:
                least, v = square, k / SAMPLES
        low, high = max(v - 1.0 / SAMPLES, 0.0), min(v + 1.0 / SAMPLES, 1.0)
    for _ in range(MOST):
        P, Q, slope_r, slope_z, speed = _meridian(v, shape)
        slope = math.sqrt(slope_r * slope_r + slope_z * slope_z)
        nr, nz = slope_r / slope, slope_z / slope
        off_r, off_z = rho - girth * P, z - half * Q
        along = nr * off_z - nz * off_r  # how far the foot lies further on along the meridian
        if along > 0.0:
            low = v
        elif along < 0.0:
            high = v
        else:
            break
        bending = (n - 1.0) * (P * Q) ** (n - 2.0) / ((girth * half) ** 2 * slope**3)
        stretched = 1.0 + (nr * off_r + nz * off_z) * bending
        change = along / (speed * stretched) if stretched > 0.0 else math.inf
        if abs(change) < ROUNDING:  # it may lie outside the bounds, by rounding: no reason to bisect again
            break
        following = v + change
        if not low < following < high:
            following = 0.5 * (low + high)
        if following == v or high - low < ROUNDING:
            break
        v = following
    P, Q, slope_r, slope_z, speed = _meridian(v, shape)
    slope = math.sqrt(slope_r * slope_r + slope_z * slope_z)
    nr, nz = slope_r / slope, slope_z / slope
    gap = (rho - girth * P) * nr + (z - half * Q) * nz
    bend = (girth * half) ** 2 * slope**3 / ((n - 1.0) * (P * Q) ** (n - 2.0))
    hoop = girth * girth * slope * P ** (2.0 - n)
    return gap, nr, math.copysign(nz, axial), bend + gap, hoop + gap


def poles(shape: ShapeConstants) -> tuple[float, float]:
    """Distances [cm] of the oral and of the anal pole from the centre."""
    return shape.aspect * shape.radius, shape.aspect * shape.radius


def volume(shape: ShapeConstants) -> float:
    """Volume [cm^3]: 2 pi R^2 b times the integral of (1 - s^n)^(2/n) from 0 to 1."""
    n = shape.exponent
    share = math.gamma(1.0 / n) * math.gamma(1.0 + 2.0 / n) / (n * math.gamma(1.0 + 3.0 / n))
    return 2.0 * math.pi * shape.aspect * shape.radius**3 * share


def profile(axial: NDArray[np.float64], shape: ShapeConstants) -> NDArray[np.float64]:
    """Radius [cm] of the cross-section at distances `axial` [cm] from the centre."""
    n = shape.exponent
    along = np.minimum(np.abs(axial) / (shape.aspect * shape.radius), 1.0)
    return np.asarray(shape.radius * (1.0 - along**n) ** (1.0 / n))


def resized(shape: ShapeConstants, radius: float) -> ShapeConstants:
    """The similar body of another girth radius [cm]."""
    return ShapeConstants(radius, shape.aspect, shape.exponent)


def refusal(shape: ShapeConstants) -> str:
    """Why there is no body of these numbers; empty if there is one."""
    return ""
