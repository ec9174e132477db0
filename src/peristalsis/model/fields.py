"""Fields derived from a state: stretches, tensions, contact pressure at the wall nodes, and end reactions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..wall.constants import WallConstants
from ..wall.membrane import TOTAL_CIRCULAR, TOTAL_LONGITUDINAL, element_stretch, wall_tension
from .bookkeeping import EndReactions, reactions
from .constants import packed
from .state import WallState
from .surface_fields import (
    around_to_nodes,
    surface_contact_pressure,
    surface_corner_tensions,
    surface_end_reactions,
    surface_stretches,
)

Floats = NDArray[np.float64]


def column(array: Floats, j: int, component: int | None = None) -> Floats:
    """Contiguous copy of column j of a wall field, of one component where there are three."""
    return np.ascontiguousarray(array[:, j] if component is None else array[:, j, component])


def stretch_of_elements(position: Floats, element_size: float) -> Floats:
    """Longitudinal stretch of the elements, shape (n_z_wall, n_theta), from positions (n_z_wall + 1, n_theta, 3)."""
    out = np.empty((position.shape[0] - 1, position.shape[1]))
    for j in range(position.shape[1]):
        one = np.empty(out.shape[0])
        element_stretch(column(position, j, 0), column(position, j, 2), element_size, one)
        out[:, j] = one
    return out


def nodal(elements: Floats) -> Floats:
    """Element values (n, ...) as means at the n + 1 nodes; the end nodes take their only element."""
    out = np.empty((elements.shape[0] + 1, *elements.shape[1:]))
    out[1:-1] = 0.5 * (elements[1:] + elements[:-1])
    out[0], out[-1] = elements[0], elements[-1]
    return out


def corner_tensions(wall: WallState, constants: WallConstants) -> Floats:
    """All parts of the tension at the corners of the elements [mN/cm], shape (n_z_wall, 2, n_theta, 8)."""
    elements, columns = wall.stretch_rate.shape
    if columns > 1:
        return surface_corner_tensions(wall, constants)
    out = np.empty((elements, 2, columns, 8))
    for j in range(columns):
        one = np.empty((elements, 2, 8))
        wall_tension(
            column(wall.position, j, 0),
            column(wall.position, j, 2),
            column(wall.stretch_rate, j),
            column(wall.hoop_rate, j),
            np.ascontiguousarray(wall.drive[0, :, j]),
            np.ascontiguousarray(wall.drive[1, :, j]),
            constants,
            one,
        )
        out[:, :, j] = one
    return out


def nodal_tensions(corners: Floats) -> Floats:
    """Corner tensions as means at the nodes, shape (n_z_wall + 1, n_theta, 8)."""
    out = np.empty((corners.shape[0] + 1, *corners.shape[2:]))
    out[1:-1] = 0.5 * (corners[:-1, 1] + corners[1:, 0])
    out[0], out[-1] = corners[0, 0], corners[-1, 1]
    return out


def axial_tension_of_elements(wall: WallState, constants: WallConstants) -> Floats:
    """Total longitudinal tension of the elements [mN/cm], shape (n_z_wall, n_theta)."""
    return np.asarray(corner_tensions(wall, constants)[..., TOTAL_LONGITUDINAL].mean(axis=1))


def contact_pressure(wall: WallState, constants: WallConstants) -> Floats:
    """Contact pressure on the deformed wall [mN/cm^2], shape (n_z_wall + 1, n_theta): Q / (lambda_l lambda_c)."""
    if wall.contact.shape[1] > 1:
        return surface_contact_pressure(wall, constants)
    stretch = nodal(stretch_of_elements(wall.position, constants.element_size))
    return wall.contact / (stretch * wall.position[:, :, 0] / constants.radius)


def nodal_stretches(wall: WallState, constants: WallConstants) -> tuple[Floats, Floats]:
    """Longitudinal and circumferential stretch at the nodes, shape (n_z_wall + 1, n_theta)."""
    if wall.position.shape[1] > 1:
        found = surface_stretches(wall.position, constants)
        return nodal(found.axial), around_to_nodes(found.hoop)
    return nodal(stretch_of_elements(wall.position, constants.element_size)), wall.position[:, :, 0] / constants.radius


def end_reactions(wall: WallState, constants: WallConstants, pressure: float) -> EndReactions:
    """Axial force through wall and lumen at the oral and the anal end [mN], tension positive, and the slack share.

    The slack share is that of the corners where the longitudinal or the circumferential tension is not positive.

    The force on the first and last element corner along z, wall tension minus the pressure's share: on any free
    stretch without contact the sum is constant along z, so the difference of the ends is the pellet's force.
    """
    if wall.position.shape[1] > 1:
        corners = corner_tensions(wall, constants)
        slack = np.minimum(corners[..., TOTAL_LONGITUDINAL], corners[..., TOTAL_CIRCULAR]) <= constants.slack_blend
        oral, anal = surface_end_reactions(wall, constants, pressure)
        return EndReactions(oral=oral, anal=anal, slack=float(slack.mean()))
    found: EndReactions = reactions(wall.arrays, pressure, packed(constants))
    return found
