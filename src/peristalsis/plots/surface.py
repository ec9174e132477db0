"""The deformed wall and the pellet as surfaces in space, frame by frame; no drawing here.

A wall of one column is revolved: its fields are the same on every facet. The tube's axis is z, in cm; the angle 0 is
at x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..names import FIELDS
from . import data

if TYPE_CHECKING:
    from ..results.result import Result

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

FACETS = 48
"""Columns that a wall of one column is revolved into."""
PLACES = ("radius", "angle", "axial_position")


@dataclass(frozen=True)
class Surface:
    """Points (n, 3) [cm], quads (k, 4) closed around the ring, and fields at the points by name with unit."""

    points: Floats
    quads: Indices
    fields: dict[str, Floats]


def columns(result: Result, facets: int) -> int:
    """Columns of the surface around the ring: those of the wall, or `facets` of a uniform one."""
    stored = data.stored(result, "radius").shape[-1]
    return facets if stored == 1 else stored


def wall(result: Result, frame: int, facets: int = FACETS) -> Surface:
    """The wall at a stored time with every stored field; those of the conduction cells are interpolated to nodes."""
    around = columns(result, facets)
    radius, angle, axial = (_spread(data.stored(result, name)[frame], around) for name in PLACES)
    if data.stored(result, "radius").shape[-1] == 1:
        angle = angle + 2.0 * np.pi * np.arange(around) / around
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), axial], axis=-1)
    fields = {}
    for output in FIELDS:
        if output.name not in result.arrays or output.name in PLACES[1:]:
            continue
        values = np.nan_to_num(np.asarray(result.arrays[output.name][frame], dtype=np.float64))
        if "z_cell" in output.dimensions:
            values = _at_nodes(values, data.values(result, "z_cell"), data.values(result, "z"))
        name = output.name if output.unit == "1" else f"{output.name} [{output.unit}]"
        fields[name] = np.ravel(_spread(values, around))
    return Surface(points.reshape(-1, 3), quads(*radius.shape), fields)


def quads(places: int, around: int) -> Indices:
    """Corners of the facets of a closed tube, seen from outside in positive turn, shape ((places - 1) around, 4)."""
    i, j = np.meshgrid(np.arange(places - 1), np.arange(around), indexing="ij")
    following = (j + 1) % around
    corners = [i * around + j, i * around + following, (i + 1) * around + following, (i + 1) * around + j]
    return np.stack(corners, axis=-1).reshape(-1, 4).astype(np.int64)


def pellet(result: Result, frame: int, rings: int = 24, around: int = 48) -> Surface:
    """The pellet at a stored time; its poles are facets of no height."""
    centre = float(data.at_frames(result, "pellet_position")[frame])
    speed = float(data.at_frames(result, "pellet_velocity")[frame])
    axial, radii = (field[:, None] for field in data.pellet_shape(result).outline(rings + 1))
    turn = 2.0 * np.pi * np.arange(around) / around
    x, y = radii * np.cos(turn), radii * np.sin(turn)
    z = centre + axial * np.ones_like(turn)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    velocity = np.zeros_like(points)
    velocity[:, 2] = speed
    return Surface(points, quads(rings + 1, around), {"velocity [cm/s]": velocity})


def _spread(values: Floats, around: int) -> Floats:
    """A field (n, m) on `around` columns: repeated where it is uniform, else linear around the closed ring."""
    values = np.asarray(values, dtype=np.float64)
    own = values.shape[1]
    if own == around:
        return values
    if own == 1:
        return np.repeat(values, around, axis=1)
    at = np.arange(around) * own / around
    low = np.floor(at).astype(np.int64)
    share = at - low
    return (1.0 - share) * values[:, low % own] + share * values[:, (low + 1) % own]


def _at_nodes(values: Floats, cells: Floats, nodes: Floats) -> Floats:
    """Cell values at the wall nodes, linear along the tube, constant beyond the first and last cell."""
    return np.stack([np.interp(nodes, cells, column) for column in values.T], axis=1)
