"""The capsule: a cylinder with round caps, Eq. (74). Where they meet its curvature jumps; its normal does not."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...declared import number
from ...numerics.compiled import compiled

KIND = "shape"
NAME = "capsule"
TITLE = "capsule: a cylinder with hemispherical caps"
PARAMETERS = (number("length", 2.6, "cm", "length over all, from pole to pole", lowest=0.01, highest=100.0),)


class ShapeConstants(NamedTuple):
    """Girth radius, which is that of the caps; length over all [cm]."""

    radius: float
    length: float


@compiled
def unpack_shape(numbers: np.ndarray) -> ShapeConstants:
    """The constants from an array that begins with them."""
    return ShapeConstants(numbers[0], numbers[1])


@compiled
def gap_and_normal(rho: float, axial: float, shape: ShapeConstants) -> tuple[float, float, float, float, float]:
    """(gap, n_rho, n_zeta, bend, hoop) at a point; see `sphere.gap_and_normal`."""
    beyond = abs(axial) - (0.5 * shape.length - shape.radius)
    if beyond <= 0.0:
        return rho - shape.radius, 1.0, 0.0, math.inf, rho
    distance = math.sqrt(rho * rho + beyond * beyond)
    return distance - shape.radius, rho / distance, math.copysign(beyond / distance, axial), distance, distance


@compiled
def reach(rho: float, axial: float, shape: ShapeConstants) -> float:
    """Girth radius [cm] of the similar body through a point."""
    straight = 0.5 * shape.length / shape.radius - 1.0  # half of it, over the girth radius
    along = abs(axial)
    if along <= straight * rho:
        return rho
    # rho^2 + (along - straight*s)^2 = s^2, the smaller root where the caps stand on a cylinder, written without its 0/0
    square = rho * rho + along * along
    root = math.sqrt(max(square - (straight * rho) ** 2, 0.0))
    return square / (straight * along + root)


def poles(shape: ShapeConstants) -> tuple[float, float]:
    """Distances [cm] of the oral and of the anal pole from the centre."""
    return 0.5 * shape.length, 0.5 * shape.length


def volume(shape: ShapeConstants) -> float:
    """Volume [cm^3]."""
    straight = shape.length - 2.0 * shape.radius
    return math.pi * shape.radius**2 * straight + 4.0 / 3.0 * math.pi * shape.radius**3


def profile(axial: NDArray[np.float64], shape: ShapeConstants) -> NDArray[np.float64]:
    """Radius [cm] of the cross-section at distances `axial` [cm] from the centre."""
    beyond = np.maximum(np.abs(axial) - (0.5 * shape.length - shape.radius), 0.0)
    return np.sqrt(np.maximum(shape.radius**2 - beyond**2, 0.0))


def resized(shape: ShapeConstants, radius: float) -> ShapeConstants:
    """The similar body of another girth radius [cm]."""
    return ShapeConstants(radius, shape.length * (radius / shape.radius))


def refusal(shape: ShapeConstants) -> str:
    """Why there is no body of these numbers; empty if there is one."""
    if shape.length < 2.0 * shape.radius:
        return (
            f"a length of {shape.length:g} cm is less than twice the radius of its caps, {shape.radius:g} cm; "
            f"use a length of at least {2.0 * shape.radius:g} cm, or a smaller pellet.radius"
        )
    return ""
