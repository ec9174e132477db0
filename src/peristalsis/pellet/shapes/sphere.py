"""The sphere, Eq. (12): the shape in the slot `pellet.shapes.sphere` unless another is bound.

What a shape file says and defines is written in docs/shapes.md: the names and arguments are those below.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...declared import Declared
from ...numerics.compiled import compiled

KIND = "shape"
NAME = "sphere"
TITLE = "sphere"
PARAMETERS: tuple[Declared, ...] = ()


class ShapeConstants(NamedTuple):
    """Girth radius [cm], which every shape has first; then the PARAMETERS in their order."""

    radius: float


@compiled
def unpack_shape(numbers: np.ndarray) -> ShapeConstants:
    """The constants from an array that begins with them."""
    return ShapeConstants(numbers[0])


@compiled
def gap_and_normal(rho: float, axial: float, shape: ShapeConstants) -> tuple[float, float, float, float, float]:
    """(gap, n_rho, n_zeta, bend, hoop) at a point `rho` off the axis and `axial` from the centre [cm], Eq. (70).

    The normal points from the pellet to the wall. bend, hoop [cm]: radii of curvature, along the meridian and around
    the axis, of the surface at the same distance through the point, Eq. (71); infinite where that is straight.
    """
    distance = math.sqrt(rho * rho + axial * axial)
    gap = distance - shape.radius
    bend = gap + shape.radius
    return gap, rho / distance, axial / distance, bend, bend


@compiled
def gap_in_space(
    x: float, y: float, z: float, shape: ShapeConstants
) -> tuple[float, float, float, float, float, float]:
    """(gap, n_x, n_y, n_z, bend, hoop) at a point from the centre, Eq. (76).

    A shape may leave this out: then it follows from `gap_and_normal`. The sphere has no axis to lose digits at.
    """
    distance = math.sqrt(x * x + y * y + z * z)
    gap = distance - shape.radius
    bend = gap + shape.radius
    return gap, x / distance, y / distance, z / distance, bend, bend


@compiled
def reach(rho: float, axial: float, shape: ShapeConstants) -> float:
    """Girth radius [cm] of the similar body whose surface passes through a point, Eq. (72)."""
    return math.sqrt(rho * rho + axial * axial)


def poles(shape: ShapeConstants) -> tuple[float, float]:
    """Distances [cm] of the oral and of the anal pole from the centre."""
    return shape.radius, shape.radius


def volume(shape: ShapeConstants) -> float:
    """Volume [cm^3]."""
    return 4.0 / 3.0 * math.pi * shape.radius**3


def profile(axial: NDArray[np.float64], shape: ShapeConstants) -> NDArray[np.float64]:
    """Radius [cm] of the cross-section at distances `axial` [cm] from the centre, between the poles."""
    return np.sqrt(np.maximum(shape.radius**2 - axial**2, 0.0))


def resized(shape: ShapeConstants, radius: float) -> ShapeConstants:
    """The similar body of another girth radius [cm]."""
    return ShapeConstants(radius)


def refusal(shape: ShapeConstants) -> str:
    """Why there is no body of these numbers, in words that follow the name of the shape; empty if there is one."""
    return ""
