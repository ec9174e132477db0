"""What is recorded after every step: work, momentum, contact and end reactions."""

from __future__ import annotations

from typing import NamedTuple

from ..pellet.body import require_shape
from .balance import Momentum, Work, momentum_from, work_from, work_of_step
from .bookkeeping import ContactSummary, EndReactions, StepNumbers, numbers_of_step
from .constants import packed
from .contact_summary import contact_summary
from .fields import end_reactions
from .model import Model
from .state import State


class StepSummary(NamedTuple):
    """Balances over a step, and contact, axial forces of both ends and slack share at its end."""

    work: Work
    momentum: Momentum
    contact: ContactSummary
    ends: EndReactions


def summary_of_step(model: Model, before: State, after: State) -> StepSummary:
    """`work_of_step`, `momentum_of_step`, `contact_summary` and `end_reactions`, of one column in one compiled call."""
    require_shape(model.pellet)
    if model.grid.is_surface:
        ends = end_reactions(after.wall, model.wall, after.pressure)
        momentum = momentum_from(model, before, after, ends.anal - ends.oral)
        return StepSummary(work_of_step(model, before, after), momentum, contact_summary(model, after), ends)
    numbers: StepNumbers = numbers_of_step(
        before.wall.arrays,
        after.wall.arrays,
        after.pressure,
        after.pellet.position,
        packed(model.pellet),
        packed(model.wall),
    )
    momentum = momentum_from(model, before, after, numbers.ends.anal - numbers.ends.oral)
    return StepSummary(work_from(model, before, after, numbers.work), momentum, numbers.contact, numbers.ends)
