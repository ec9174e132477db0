"""Fields of factors on any grid of the surface: what a region is at given places and angles.

A shape says how deep inside a point lies: its distance along the undeformed surface from the nearest edge [cm],
negative outside. From that come sharp and smooth edges alike.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .shapes import Band, Box, Disc, Map, Stripes
from .specification import Region

Floats = NDArray[np.float64]


def _band(shape: Band, z: Floats, angle: Floats, radius: float) -> Floats:
    return np.minimum(z - shape.z_from, shape.z_to - z) + 0.0 * angle


def _box(shape: Box, z: Floats, angle: Floats, radius: float) -> Floats:
    along = np.minimum(z - shape.z_from, shape.z_to - z)
    if not shape.varies_around():
        return along + 0.0 * angle
    half = 0.5 * np.deg2rad(shape.extent)
    around = radius * (half - np.abs(_turned(angle - np.deg2rad(shape.angle_from) - half)))
    return np.minimum(along, around)


def _disc(shape: Disc, z: Floats, angle: Floats, radius: float) -> Floats:
    around = radius * _turned(angle - np.deg2rad(shape.angle))
    return np.asarray(shape.radius - np.hypot(z - shape.z, around))


def _stripes(shape: Stripes, z: Floats, angle: Floats, radius: float) -> Floats:
    spacing = 2.0 * np.pi / shape.number
    turned = angle - np.deg2rad(shape.phase)
    nearest = np.abs(turned - spacing * np.round(turned / spacing))
    return np.asarray(0.5 * shape.width - radius * nearest + 0.0 * z)


DEPTHS: dict[type, Callable[[Any, Floats, Floats, float], Floats]] = {
    Band: _band,
    Box: _box,
    Disc: _disc,
    Stripes: _stripes,
}
"""Shape to the function of (shape, z (n, 1) [cm], angle (1, m) [rad], tube radius [cm]) that gives its depth [cm]."""


def coverage(region: Region, z: Floats, angle: Floats, radius: float) -> Floats:
    """How much of the region is at each point, 0 outside to 1 inside, shape (z.size, angle.size).

    z: places along the undeformed tube [cm]; angle: around it [rad]; radius: of the undeformed tube [cm]. A point on
    a sharp edge is inside; a smooth edge is a half at the edge and fades by a cubic over its width.
    """
    depth = DEPTHS[type(region.shape)](region.shape, z[:, None], angle[None, :], radius)
    if region.edge == 0.0:
        # Angles come through a multiple of pi: a cell centre that is meant to lie on the edge must not fall outside.
        return np.asarray(depth >= -1e-12, dtype=np.float64)
    x = np.clip(depth / region.edge + 0.5, 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))


def reached(region: Region, z: Floats, angle: Floats, radius: float) -> bool:
    """Whether any of the points lies in the region; a map reaches everywhere."""
    return isinstance(region.shape, Map) or bool(coverage(region, z, angle, radius).any())


def factor_field(
    regions: tuple[Region, ...], layer: str, quantity: str, z: Floats, angle: Floats, radius: float
) -> Floats | None:
    """Product of the factors of all regions on a quantity of a layer, shape (z.size, angle.size); None if none has one.

    Arguments as for `coverage`. Inside a smooth edge a factor f counts as 1 + coverage (f - 1). The field is
    read-only and is kept, since a run with protocols asks for it at every step.
    """
    concerned = tuple(
        region for region in regions if region.layer in ("both", layer) and quantity in dict(region.factors)
    )
    if not concerned:
        return None
    place, turn = (np.ascontiguousarray(axis, dtype=np.float64).tobytes() for axis in (z, angle))
    return _field(concerned, quantity, place, turn, float(radius))


@lru_cache(maxsize=64)
def _field(regions: tuple[Region, ...], quantity: str, place: bytes, turn: bytes, radius: float) -> Floats:
    z, angle = np.frombuffer(place), np.frombuffer(turn)
    field = np.ones((z.size, angle.size))
    for region in regions:
        if isinstance(region.shape, Map):
            field *= _interpolated(region.shape, z, angle)
        else:
            field *= 1.0 + coverage(region, z, angle, radius) * (dict(region.factors)[quantity] - 1.0)
    field.flags.writeable = False
    return field


def _interpolated(shape: Map, z: Floats, angle: Floats) -> Floats:
    """The map at (z, angle): linear around the ring, which closes, then linear along the tube."""
    angles = np.deg2rad(shape.angle)
    rows = [np.interp(angle, angles, row, period=2.0 * np.pi) for row in shape.values]
    columns = np.stack(rows).T
    return np.stack([np.interp(z, shape.z, column) for column in columns], axis=1)


def _turned(angle: Floats) -> Floats:
    """Angles brought into [-pi, pi)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
