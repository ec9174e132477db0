"""Numbers about the contact and the wall that are wanted after every step, in one compiled pass."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.surface import equivalent_radius
from ..numerics.compiled import compiled
from ..pellet.contact import smallest_gap
from .fields import column
from .model import Model
from .state import State
from .surface_fields import surface_contact


class ContactSummary(NamedTuple):
    """Normal force [mN], largest contact pressure [mN/cm^2], contact edges and least radius and gap [cm].

    Edges are nan without contact, the gap is infinite without a pellet. On the whole surface the radius of a ring is
    that of the circle with its area.
    """

    normal_force: float
    largest_pressure: float
    start: float
    end: float
    least_radius: float
    smallest_gap: float


def contact_summary(model: Model, state: State) -> ContactSummary:
    """The summary of a state."""
    wall = state.wall
    if model.grid.is_surface:
        found = surface_contact(wall, state.pellet, model.pellet.radius if model.pellet.present else None, model.wall)
        least = float(equivalent_radius(wall.position).min())
        return ContactSummary(
            found.normal_force, found.largest_pressure, found.start, found.end, least, found.smallest_gap
        )
    rho, zeta = column(wall.position, 0, 0), column(wall.position, 0, 2)
    normal, pressure, start, end, least = _summary(
        rho, zeta, column(wall.contact, 0), model.wall.radius, model.wall.element_size
    )
    gap = smallest_gap(rho, zeta, state.pellet.position, model.pellet.radius) if model.pellet.present else math.inf
    return ContactSummary(normal, pressure, start, end, least, gap)


@compiled
def _summary(
    rho: np.ndarray, zeta: np.ndarray, contact: np.ndarray, radius: float, element_size: float
) -> tuple[float, float, float, float, float]:
    normal = 0.0
    pressure = 0.0
    start = math.nan
    end = math.nan
    least = rho[0]
    for i in range(rho.size):
        least = min(least, rho[i])
        if contact[i] > 0.0:
            before = math.hypot(rho[i] - rho[i - 1], zeta[i] - zeta[i - 1])
            behind = math.hypot(rho[i + 1] - rho[i], zeta[i + 1] - zeta[i])
            stretch = 0.5 * (before + behind) / element_size
            pressure = max(pressure, contact[i] / (stretch * rho[i] / radius))
            normal += contact[i]
            if math.isnan(start):
                start = zeta[i]
            end = zeta[i]
    return normal * 2.0 * math.pi * radius * element_size, pressure, start, end, least
