"""Numbers about the contact and the wall that are wanted after every step, in one compiled pass."""

from __future__ import annotations

from typing import NamedTuple

from .bookkeeping import touch
from .model import Model
from .state import State


class ContactSummary(NamedTuple):
    """Normal force [mN], largest contact pressure [mN/cm^2], contact edges and least radius and gap [cm].

    Edges are nan without contact, the gap is infinite without a pellet.
    """

    normal_force: float
    largest_pressure: float
    start: float
    end: float
    least_radius: float
    smallest_gap: float


def contact_summary(model: Model, state: State) -> ContactSummary:
    """The summary of an axisymmetric state."""
    radius = model.pellet.radius if model.pellet.present else 0.0
    return ContactSummary(
        *touch(state.wall.position, state.wall.contact, state.pellet.position, radius, model.packed[0])
    )
