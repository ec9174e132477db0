"""The spheroid: an ellipse turned about the tube's axis, Eq. (73).

The foot of a point is found by Newton's method on a convex, falling function from a start on its rising side: the
iterates rise to the root and cannot miss it, wherever the point is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...declared import number
from ...numerics.compiled import compiled

KIND = "shape"
NAME = "spheroid"
TITLE = "spheroid: half length over girth radius"
PARAMETERS = (number("aspect", 1.5, "1", "half length over girth radius; 1 is the sphere", lowest=0.2, highest=10.0),)

MOST = 200
"""Iterations of Newton's method; the farthest start, deep inside on the long axis, takes about 90."""


class ShapeConstants(NamedTuple):
    """Girth radius [cm]; half length over it."""

    radius: float
    aspect: float


@compiled
def unpack_shape(numbers: np.ndarray) -> ShapeConstants:
    """The constants from an array that begins with them."""
    return ShapeConstants(numbers[0], numbers[1])


@compiled
def _multiplier(long: float, short: float, focal: float, along: float, across: float) -> float:
    """t + short^2 of Eq. (73) for semi-axes long > short, focal = long^2 - short^2, and a point (along, across) >= 0.

    Counted from the pole of the function, so that nothing cancels where a point lies near the long axis.
    """
    t = max(long * along - focal, short * across)
    for _ in range(MOST):
        u, v = long * along / (t + focal), short * across / t
        excess = u * u + v * v - 1.0
        slope = u * u / (t + focal) + v * v / t
        if not (excess > 0.0 and slope > 0.0):
            break
        following = t + 0.5 * excess / slope
        if not following > t:
            break
        t = following
    return t


@compiled
def _foot(rho: float, axial: float, shape: ShapeConstants) -> tuple[float, float]:
    """Nearest point of the ellipse to (rho, |axial|), both at least 0."""
    girth, half = shape.radius, shape.aspect * shape.radius
    long, short = max(girth, half), min(girth, half)
    along, across = (rho, axial) if girth >= half else (axial, rho)
    focal = long * long - short * short
    if across == 0.0 and long * along < focal:  # on the long axis, within the centres of curvature of its ends
        share = long * along / focal
        on_long, on_short = long * share, short * math.sqrt(1.0 - share * share)
    elif along == 0.0 and across == 0.0:
        on_long, on_short = 0.0, short
    else:
        t = _multiplier(long, short, focal, along, across)
        on_long, on_short = long * long * along / (t + focal), short * short * across / t
    return (on_long, on_short) if girth >= half else (on_short, on_long)


@compiled
def gap_and_normal(rho: float, axial: float, shape: ShapeConstants) -> tuple[float, float, float, float, float]:
    """(gap, n_rho, n_zeta, bend, hoop) at a point; see `sphere.gap_and_normal`."""
    girth, half = shape.radius, shape.aspect * shape.radius
    foot_r, foot_z = _foot(rho, abs(axial), shape)
    slope_r, slope_z = foot_r / (girth * girth), foot_z / (half * half)
    slope = math.sqrt(slope_r * slope_r + slope_z * slope_z)
    nr, nz = slope_r / slope, slope_z / slope
    gap = (rho - foot_r) * nr + (abs(axial) - foot_z) * nz
    bend = girth * girth * half * half * slope * slope * slope
    hoop = girth * girth * slope
    return gap, nr, math.copysign(nz, axial), bend + gap, hoop + gap


@compiled
def reach(rho: float, axial: float, shape: ShapeConstants) -> float:
    """Girth radius [cm] of the similar body through a point."""
    along = axial / shape.aspect
    return math.sqrt(rho * rho + along * along)


def poles(shape: ShapeConstants) -> tuple[float, float]:
    """Distances [cm] of the oral and of the anal pole from the centre."""
    return shape.aspect * shape.radius, shape.aspect * shape.radius


def volume(shape: ShapeConstants) -> float:
    """Volume [cm^3]."""
    return 4.0 / 3.0 * math.pi * shape.aspect * shape.radius**3


def profile(axial: NDArray[np.float64], shape: ShapeConstants) -> NDArray[np.float64]:
    """Radius [cm] of the cross-section at distances `axial` [cm] from the centre."""
    return shape.radius * np.sqrt(np.maximum(1.0 - (axial / (shape.aspect * shape.radius)) ** 2, 0.0))


def resized(shape: ShapeConstants, radius: float) -> ShapeConstants:
    """The similar body of another girth radius [cm]."""
    return ShapeConstants(radius, shape.aspect)


def refusal(shape: ShapeConstants) -> str:
    """Why there is no body of these numbers; empty if there is one."""
    return ""
