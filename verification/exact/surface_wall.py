"""The wall on the whole surface for tests: states, forces, an energy fit for complex steps, sparse tangents."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from peristalsis.geometry.surface import add_volume_tangent, column_angles, volume_gradient
from peristalsis.model.model import Model
from peristalsis.model.state import WallState
from peristalsis.numerics.ring_blocks import RingOperator, bending_weight, multiply, pad
from peristalsis.wall.constants import SurfaceConstants, WallConstants
from peristalsis.wall.surface import add_edge_forces, add_edge_tangent, load_edges, measure_edges, new_edges
from peristalsis.wall.surface_regularisers import (
    add_regulariser_forces,
    add_shear_tangent,
    bending_along,
    bending_around,
)

from .wall import energy

Floats = NDArray[np.float64]

BARE = SurfaceConstants(0.0, 0.0, 0.0, 0.0)
"""No regularisers around the ring."""


def padded(places: Floats) -> Floats:
    """A field (n, 3, m) with its neighbours repeated."""
    out = np.empty((*places.shape[:2], places.shape[2] + 2))
    pad(places, out)
    return out


def uniform(rho: Floats, zeta: Floats, columns: int) -> Floats:
    """The ring-uniform surface through the nodes of an axisymmetric wall, (n, 3, columns)."""
    places = np.zeros((rho.size, 3, columns))
    places[:, 0], places[:, 2] = rho[:, None], zeta[:, None]
    return places


def crumpled(rows: int, columns: int, seed: int, size: float = 0.02) -> Floats:
    """A tube of 0.9 cm radius and 0.15 cm rows with every node put elsewhere by `size` cm."""
    places = uniform(np.full(rows, 0.9), np.asarray(0.15 * np.arange(rows), dtype=np.float64), columns)
    return places + size * np.random.default_rng(seed).normal(size=places.shape)


@dataclass(frozen=True)
class Known:
    """What the forces of the wall depend on besides the nodes: histories, drives, constants and pressure."""

    wall: WallConstants
    stretch_history: Floats
    hoop_history: Floats
    shear_history: Floats
    history: Floats
    drive: Floats
    surface: SurfaceConstants = BARE
    slope: float = 0.0
    pressure: float = 0.0


def at_rest(places: Floats, wall: WallConstants, **changes: Any) -> Known:
    """Nothing moves, nothing pulls."""
    n, _, m = places.shape
    known = Known(wall, np.ones((n - 1, m)), np.ones((n, m)), np.zeros((n - 1, m)), places, np.zeros((2, 2 * n - 2, m)))
    return replace(known, **changes)


def in_motion(places: Floats, wall: WallConstants, seed: int, **changes: Any) -> Known:
    """Random histories and drives, at a rate of 200/s."""
    n, _, m = places.shape
    rng = np.random.default_rng(seed)
    known = Known(
        wall,
        rng.uniform(0.8, 1.2, (n - 1, m)),
        rng.uniform(0.8, 1.2, (n, m)),
        0.1 * rng.normal(size=(n - 1, m)),
        places + 0.01 * rng.normal(size=places.shape),
        rng.uniform(0.0, 0.5, (2, 2 * n - 2, m)),
        slope=200.0,
    )
    return replace(known, **changes)


def forces(places: Floats, known: Known) -> Floats:
    """Residual (n, 3, m) of the wall per arc [mN/cm], all rows."""
    edges, around = new_edges(places.shape[0], places.shape[2]), padded(places)
    assert measure_edges(around, known.wall, edges)
    assert load_edges(edges, known.stretch_history, known.hoop_history, known.slope, known.drive, known.wall)
    residual, gradient = np.zeros_like(places), np.empty_like(places)
    add_edge_forces(edges, residual)
    moved = padded(places - known.history)
    add_regulariser_forces(around, places, moved, known.shear_history, known.slope, known.wall, known.surface, residual)
    volume_gradient(around, 1.0 / arc(known.wall, places.shape[2]), gradient)
    return residual - known.pressure * gradient


def tangent(places: Floats, known: Known) -> RingOperator:
    """Derivative of `forces` in the inner rows."""
    n, _, m = places.shape
    edges, around, blocks = new_edges(n, m), padded(places), np.zeros((n, 9, 3, 3, m))
    assert measure_edges(around, known.wall, edges)
    assert load_edges(edges, known.stretch_history, known.hoop_history, known.slope, known.drive, known.wall)
    add_edge_tangent(edges, blocks)
    add_shear_tangent(around, known.shear_history, known.slope, known.wall, known.surface, blocks)
    add_volume_tangent(around, -known.pressure / arc(known.wall, m), blocks)
    return RingOperator(
        blocks,
        bending_along(known.wall, known.slope),
        bending_around(known.wall, known.surface, known.slope, m),
        known.surface.foundation * known.wall.element_size,
    )


def arc(wall: WallConstants, columns: int) -> float:
    """Undeformed arc between columns [cm]."""
    return 2.0 * np.pi * wall.radius / columns


def times(operator: RingOperator, field: Floats) -> Floats:
    """Operator times a field whose end rows are zero."""
    out = np.empty_like(field)
    multiply(operator, field, 0, field.shape[0], np.empty((*field.shape[:2], field.shape[2] + 2)), out)
    return out


def in_room(places: NDArray[Any]) -> NDArray[Any]:
    """Fields in frames of columns, (n, 3, m), in Cartesian axes of the room: those of column 0."""
    turn = column_angles(places.shape[2])
    x, y = places[:, 0], places[:, 1]
    return np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, places[:, 2]], axis=1)


def in_frames(room: NDArray[Any]) -> NDArray[Any]:
    """The inverse of `in_room`."""
    turn = column_angles(room.shape[2])
    x, y = room[:, 0], room[:, 1]
    return np.stack([np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x, room[:, 2]], axis=1)


def discrete_energy(places: NDArray[Any], wall: WallConstants, surface: SurfaceConstants) -> Any:
    """Stored energy per arc of real or complex places in frames, from edges in the room; written anew."""
    room, h, m = in_room(places), wall.element_size, places.shape[2]
    along = np.diff(room, axis=0)
    around = np.roll(room, -1, axis=2) - room
    stretch = np.sqrt((along**2).sum(axis=1)) / h
    hoop = np.sqrt((around**2).sum(axis=1)) / (2.0 * wall.radius * np.sin(np.pi / m))
    total: Any = 0.0
    for end in (0, 1):
        here = hoop[end : end + stretch.shape[0]]
        for ring in (here, np.roll(here, 1, axis=1)):
            total = total + 0.25 * h * energy(stretch, ring, wall.passive).sum()
    second = places[:-2] - 2.0 * places[1:-1] + places[2:]
    total = total + 0.5 * wall.bending_stiffness / h**3 * (second**2).sum()
    inner = places[1:-1]
    bent = np.roll(inner, 1, axis=2) - 2.0 * inner + np.roll(inner, -1, axis=2)
    total = total + 0.5 * surface.bending_stiffness_around * h / arc(wall, m) ** 4 * (bent**2).sum()
    centre = room[1:-1, :2].mean(axis=2)
    return total + 0.5 * surface.foundation * h * m * (centre**2).sum()


def sparse(operator: RingOperator) -> sp.csc_matrix:
    """The operator over the inner rows as a sparse matrix, without its tether."""
    n, m = operator.blocks.shape[0], operator.blocks.shape[4]
    j = np.arange(m)
    rows, columns, values = [], [], []

    def put(i: int, a: int, r: int, b: int, k: NDArray[Any], value: Any) -> None:
        rows.append(((i - 1) * 3 + a) * m + j)
        columns.append(((r - 1) * 3 + b) * m + k)
        values.append(np.broadcast_to(value, m))

    for i in range(1, n - 1):
        for q in range(9):
            r = i + q // 3 - 1
            if 1 <= r <= n - 2:
                for a in range(3):
                    for b in range(3):
                        put(i, a, r, b, (j + q % 3 - 1) % m, operator.blocks[i, q, a, b])
        for r in range(max(1, i - 2), min(n - 2, i + 2) + 1):
            for a in range(3):
                put(i, a, r, a, j, operator.bend_along * bending_weight(i, r, n))
        for shift, weight in ((-2, 1.0), (-1, -4.0), (0, 6.0), (1, -4.0), (2, 1.0)):
            for a in range(3):
                put(i, a, i, a, (j + shift) % m, weight * operator.bend_around)
    size = (n - 2) * 3 * m
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.csc_matrix(entries, shape=(size, size))


def widened(wall: WallState, columns: int) -> WallState:
    """The axisymmetric wall repeated in so many columns."""

    def repeat(array: Floats) -> Floats:
        return np.repeat(array, columns, axis=2 if array is wall.drive else 1)

    def turned(array: Floats) -> Floats:
        out = repeat(array)
        out[:, :, 1] = column_angles(columns)
        return out

    return WallState(
        position=turned(wall.position),
        position_before=turned(wall.position_before),
        velocity=repeat(wall.velocity),
        velocity_before=repeat(wall.velocity_before),
        contact=repeat(wall.contact),
        stretch_rate=repeat(wall.stretch_rate),
        hoop_rate=repeat(wall.hoop_rate),
        drive=repeat(wall.drive),
        step_before=wall.step_before,
    )


def travelling_drive(model: Model, time: float, columns: int) -> Floats:
    """Two smooth pulses [mV] that run anally at 4.2 cm/s, the circular one 1 cm behind; (2, 2 n_z_wall, columns)."""
    halves = 2 * model.grid.n_z_wall
    z = (np.arange(halves) + 0.5) * 0.5 * model.grid.element_size

    def pulse(centre: float) -> Floats:
        return np.where(np.abs(z - centre) < 0.8, np.cos(np.pi * (z - centre) / 1.6) ** 2, 0.0)

    both = np.stack([40.0 * pulse(4.2 * time + 0.2), 35.0 * pulse(4.2 * time - 0.8)])
    return np.repeat(both[:, :, None], columns, axis=2)
