"""Numbers about the contact and the wall that are wanted after every step, in one compiled pass."""

from __future__ import annotations

from ..geometry.surface import equivalent_radius
from ..pellet.body import require_shape
from .bookkeeping import ContactSummary, touch
from .constants import packed
from .model import Model
from .state import State
from .surface_fields import surface_contact


def contact_summary(model: Model, state: State) -> ContactSummary:
    """The summary of a state."""
    require_shape(model.pellet)
    wall = state.wall
    if model.grid.is_surface:
        found = surface_contact(wall, state.pellet, model.pellet, model.wall)
        least = float(equivalent_radius(wall.position).min())
        return ContactSummary(
            normal_force=found.normal_force,
            largest_pressure=found.largest_pressure,
            start=found.start,
            end=found.end,
            least_radius=least,
            smallest_gap=found.smallest_gap,
        )
    found_in_column: ContactSummary = touch(
        wall.arrays, state.pellet.position, packed(model.pellet), packed(model.wall)
    )
    return found_in_column
