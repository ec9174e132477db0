"""Fields derived from a wall on the whole surface; those for one column are in `fields` and `contact_summary`.

Nodes are in the frames of their columns (`geometry.surface`). The edge around the ring at index j leads from column j
to j + 1; what belongs to a node is the mean over its edges.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import equivalent_radius, rates_to_frames, to_frames
from ..numerics.compiled import compiled
from ..numerics.ring_blocks import pad
from ..pellet.constants import PelletConstants
from ..pellet.surface_contact import measure_contact, no_contact
from ..wall.constants import SurfaceConstants, WallConstants
from ..wall.membrane import PARTS, TOTAL_LONGITUDINAL, corner_tension
from ..wall.surface import measure_edges, new_edges
from ..wall.surface_regularisers import add_regulariser_forces, patch_shear
from .arrays import StrainedSurface
from .state import PelletState, WallState

Floats = NDArray[np.float64]


class Stretches(NamedTuple):
    """Stretches of the edges along z, (n_z_wall, n_theta), and around the ring, (n_z_wall + 1, n_theta)."""

    axial: Floats
    hoop: Floats


def padded_frames(position: Floats) -> Floats:
    """Nodes (n, m, 3) as padded places in the frames of their columns, (n, 3, m + 2)."""
    places = to_frames(position)
    out = np.empty((places.shape[0], 3, places.shape[2] + 2))
    pad(places, out)
    return out


def surface_stretches(position: Floats, constants: WallConstants) -> Stretches:
    """Stretches of all edges at nodes (n, m, 3) as (rho, vartheta, zeta). Raises ValueError out of range."""
    n, m, _ = position.shape
    edges = new_edges(n, m)
    if not measure_edges(padded_frames(position), constants, edges):
        raise ValueError("a stretch of the wall is out of range")
    return Stretches(edges.stretch[:, 1:-1].copy(), edges.hoop[:, 1:-1].copy())


def strained_surface(wall: WallState, constants: WallConstants) -> StrainedSurface:
    """What the tensions of a state follow from. Raises ValueError out of range."""
    found = surface_stretches(wall.position, constants)
    return StrainedSurface(found.axial, found.hoop, wall.stretch_rate, wall.hoop_rate, wall.drive)


def around_to_nodes(field: Floats) -> Floats:
    """Values of the edges around the ring, [..., j] from column j to j + 1, as means at the columns."""
    return 0.5 * (field + np.roll(field, 1, axis=-1))


def surface_corner_tensions(wall: WallState, constants: WallConstants) -> Floats:
    """Parts of the tension [mN/cm], (n_z_wall, 2, n_theta, 8), means over the two edges around at each corner."""
    found = strained_surface(wall, constants)
    elements, columns = found.axial.shape
    out = np.empty((elements, 2, columns, PARTS))
    _corners(found, constants, out)
    return out


@compiled
def corner_of_surface(
    wall: StrainedSurface, e: int, end: int, j: int, k: int, c: WallConstants, out: np.ndarray
) -> None:
    """Parts of the tension at an end (0 or 1) of element e of column j, with the edge k around the ring, into `out`."""
    corner_tension(
        wall.axial[e, j],
        wall.hoop[e + end, k],
        wall.axial_rate[e, j],
        wall.hoop_rate[e + end, k],
        wall.drive[0, 2 * e + end, j],
        wall.drive[1, 2 * e + end, j],
        c,
        out,
    )


@compiled
def _corners(wall: StrainedSurface, c: WallConstants, out: np.ndarray) -> None:
    one = np.empty(PARTS)
    m = wall.axial.shape[1]
    out[:] = 0.0
    for e in range(wall.axial.shape[0]):
        for end in range(2):
            for j in range(m):
                for k in (j - 1 if j > 0 else m - 1, j):
                    corner_of_surface(wall, e, end, j, k, c, one)
                    for part in range(PARTS):
                        out[e, end, j, part] += 0.5 * one[part]


def surface_end_reactions(wall: WallState, c: WallConstants, pressure: float) -> tuple[float, float]:
    """Axial force through wall and lumen at both ends [mN], tension positive; as `fields.end_reactions`."""
    found = strained_surface(wall, c)
    arc = 2.0 * math.pi * c.radius / found.axial.shape[1]
    radius = equivalent_radius(wall.position)
    forces = []
    for element, outer in ((0, (0, 1, 2)), (-1, (-3, -2, -1))):
        step = np.diff(wall.position[:, :, 2], axis=0)[element]
        row = element % found.axial.shape[0]
        nominal = np.empty(found.axial.shape[1])
        _nominal(found, row, c, nominal)
        tension = nominal * step / (found.axial[element] * c.element_size)
        bent, bending = (field[list(outer), :, 2].T @ (1.0, -2.0, 1.0) for field in (wall.position, wall.velocity))
        sign = -1.0 if element == 0 else 1.0
        tension = tension + sign * (c.bending_stiffness * bent + c.bending_viscosity * bending) / c.element_size**3
        a, b = (radius[0], radius[1]) if element == 0 else (radius[-2], radius[-1])
        forces.append(float(arc * tension.sum()) - pressure * math.pi / 3.0 * float(a * a + a * b + b * b))
    return forces[0], forces[1]


@compiled
def _nominal(wall: StrainedSurface, e: int, c: WallConstants, out: np.ndarray) -> None:
    """N_l of row e of elements, mean of its corners [mN/cm], into `out` (n_theta,), Eq. (35)."""
    one = np.empty(PARTS)
    m = wall.axial.shape[1]
    for j in range(m):
        out[j] = 0.0
        for end in range(2):
            for k in (j - 1 if j > 0 else m - 1, j):
                corner_of_surface(wall, e, end, j, k, c, one)
                across = wall.hoop[e + end, k] if c.published else 1.0
                out[j] += 0.25 * one[TOTAL_LONGITUDINAL] * across


class SurfaceContact(NamedTuple):
    """What `contact_summary.ContactSummary` says, of a surface."""

    normal_force: float
    largest_pressure: float
    start: float
    end: float
    smallest_gap: float


def surface_contact(
    wall: WallState, pellet: PelletState, body: PelletConstants, constants: WallConstants
) -> SurfaceContact:
    """Normal force, pressure [mN/cm^2], edges of the contact and smallest gap [cm]."""
    n, m, _ = wall.position.shape
    area = 2.0 * math.pi * constants.radius / m * constants.element_size
    touching = wall.contact > 0.0
    places = wall.position[:, :, 2][touching]
    pressure = surface_contact_pressure(wall, constants)
    gap = math.inf
    if body.present:
        found = no_contact(n, m)
        x, y = pellet.across
        measure_contact(
            to_frames(wall.position),
            wall.contact,
            x,
            y,
            pellet.position,
            body.shape,
            found,
        )
        gap = float(found.gap[1:-1].min())
    return SurfaceContact(
        float(wall.contact.sum()) * area,
        float(pressure.max()),
        float(places.min()) if places.size else math.nan,
        float(places.max()) if places.size else math.nan,
        gap,
    )


def surface_contact_pressure(wall: WallState, constants: WallConstants) -> Floats:
    """Contact pressure on the deformed wall [mN/cm^2], (n_z_wall + 1, n_theta): Q / (lambda_l lambda_c)."""
    found = surface_stretches(wall.position, constants)
    along = np.empty_like(found.hoop)
    along[1:-1] = 0.5 * (found.axial[1:] + found.axial[:-1])
    along[0], along[-1] = found.axial[0], found.axial[-1]
    return np.asarray(wall.contact / (along * around_to_nodes(found.hoop)))


def regulariser_forces(wall: WallState, c: WallConstants, s: SurfaceConstants) -> tuple[Floats, Floats]:
    """Elastic and viscous forces of bending, foundation and shear on the nodes [mN], (n, 3, m), at a state."""
    n, m, _ = wall.position.shape
    padded = padded_frames(wall.position)
    places = np.ascontiguousarray(padded[:, :, 1:-1])
    arc = 2.0 * math.pi * c.radius / m
    elastic, whole = np.zeros_like(places), np.zeros_like(places)
    none = np.zeros((n - 1, m))
    still = np.zeros_like(padded)
    add_regulariser_forces(padded, places, still, none, 0.0, c, s, elastic)
    moving = padded_velocity(wall)
    ahead, behind, now = np.empty_like(none), np.empty_like(none), np.empty_like(none)
    patch_shear(padded + moving, c, ahead)
    patch_shear(padded - moving, c, behind)
    patch_shear(padded, c, now)
    rate = 0.5 * (ahead - behind)  # exact: the shear is quadratic in the places
    add_regulariser_forces(padded, places, moving, now - rate, 1.0, c, s, whole)
    return arc * elastic, arc * (whole - elastic)


def padded_velocity(wall: WallState) -> Floats:
    """Velocity of the nodes in the frames of their columns, padded, (n, 3, m + 2) [cm/s]."""
    velocity = rates_to_frames(wall.position, wall.velocity)
    out = np.empty((velocity.shape[0], 3, velocity.shape[2] + 2))
    pad(velocity, out)
    return out
