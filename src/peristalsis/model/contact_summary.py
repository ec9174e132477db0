"""Numbers about the contact and the wall that are wanted after every step, in one compiled pass."""

from __future__ import annotations

from typing import NamedTuple

from ..geometry.surface import equivalent_radius
from .bookkeeping import touch
from .constants import packed
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
    radius = model.pellet.radius if model.pellet.present else 0.0
    numbers = touch(wall.arrays, state.pellet.position, radius, packed(model.wall))
    return ContactSummary(*numbers)
