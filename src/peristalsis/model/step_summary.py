"""What is recorded after every step: work, momentum, contact and end reactions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .balance import Momentum, Work, momentum_from, work_from, work_of_step
from .bookkeeping import NUMBERS, numbers_of_step
from .constants import packed
from .contact_summary import ContactSummary, contact_summary
from .fields import end_reactions
from .model import Model
from .state import State


class StepSummary(NamedTuple):
    """Balances over a step, and contact, axial forces of both ends [mN] and slack share at its end."""

    work: Work
    momentum: Momentum
    contact: ContactSummary
    oral: float
    anal: float
    slack: float


def summary_of_step(model: Model, before: State, after: State) -> StepSummary:
    """`work_of_step`, `momentum_of_step`, `contact_summary` and `end_reactions`, of one column in one compiled call."""
    if model.grid.is_surface:
        ends = end_reactions(after.wall, model.wall, after.pressure)
        momentum = momentum_from(model, before, after, ends[1] - ends[0])
        return StepSummary(work_of_step(model, before, after), momentum, contact_summary(model, after), *ends)
    out = np.empty(NUMBERS)
    numbers_of_step(
        before.wall.arrays,
        after.wall.arrays,
        after.pressure,
        after.pellet.position,
        model.pellet.radius if model.pellet.present else 0.0,
        packed(model.wall),
        out,
    )
    numbers = out.tolist()
    work = work_from(model, before, after, numbers[:4], (numbers[4], numbers[5]))
    oral, anal, slack = numbers[6:9]
    momentum = momentum_from(model, before, after, anal - oral)
    return StepSummary(work, momentum, ContactSummary(*numbers[9:]), oral, anal, slack)
