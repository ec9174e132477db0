"""What is recorded after every step: work, momentum, contact and end reactions."""

from __future__ import annotations

from ..pellet.body import require_shape
from .balance import Momentum, Work, momentum_from
from .bookkeeping import ContactSummary
from .fields import end_reactions
from .model import Model
from .scheme import StepSummary
from .schemes.choice import scheme_of
from .state import State

__all__ = ["StepSummary", "contact_summary", "momentum_of_step", "summary_of_step", "work_of_step"]


def summary_of_step(model: Model, before: State, after: State) -> StepSummary:
    """All of it; of one column in one compiled call."""
    require_shape(model.pellet)
    return scheme_of(model).summary(model, before, after)


def work_of_step(model: Model, before: State, after: State) -> Work:
    """Trapezoidal work of every term between two states a step apart, Eq. (29)."""
    return scheme_of(model).work(model, before, after)


def momentum_of_step(model: Model, before: State, after: State) -> Momentum:
    """Axial momentum at the end of the step, Eq. (52)."""
    oral, anal, _ = end_reactions(after.wall, model.wall, after.pressure)
    return momentum_from(model, before, after, anal - oral)


def contact_summary(model: Model, state: State) -> ContactSummary:
    """Numbers about the contact of a state."""
    require_shape(model.pellet)
    return scheme_of(model).contact(model, state)
