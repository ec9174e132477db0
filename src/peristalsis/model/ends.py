"""The two ends of the segment: when the pellet passes them, and how far pellet and wall stand out over them.

A segment is held by two clamped rings and is open there, unless `wall.oral_end` or `wall.anal_end` closes it. The
rings bound the wall, not the pellet: contact is with the nodes between them, so a pellet passes a ring that is
narrower than itself, and beyond the ring there is no wall to touch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .model import Model
from .state import State

Floats = NDArray[np.float64]

ANALLY, ORALLY = "expelled", "expelled_orally"
"""How a pellet leaves, as status, event and reason to stop."""
BULGE = 0.25
"""Wall that stands out over an end by more than this share of the tube's radius is said."""


class Passages(NamedTuple):
    """Times [s] within one step, or None: at which the anal pole passes the anal end on its way out, at which the oral
    pole passes the oral end on its way out, and at which the centre does.
    """

    anal: float | None
    oral_pole: float | None
    oral: float | None


def passages(model: Model, before: State, after: State) -> Passages:
    """What the pellet passed in a step, linear within it.

    It is expelled when its leading pole reaches the anal end, as the paper's is. Orally it may come back for as long
    as its centre is inside, where the wall presses on both its halves; once that is out, all contact drives it out.
    """
    start, stop = before.pellet.position, after.pellet.position

    def when(goal: float) -> float | None:
        if stop == start:
            return before.step * model.dt_wall
        return (before.step + (goal - start) / (stop - start)) * model.dt_wall

    pole, goal = model.pellet.oral, model.grid.span - model.pellet.anal
    return Passages(
        when(goal) if start < goal <= stop and model.pellet.highest > goal else None,
        when(pole) if start >= pole > stop else None,
        when(0.0) if start > 0.0 >= stop else None,
    )


def bulges(axial: Floats, length: float) -> tuple[Floats, Floats]:
    """How far the wall stands out over the oral and over the anal end [cm], each (n_time,).

    axial: places of the wall nodes [cm], (n_time, n_z, n_theta). length: from end to end [cm].
    """
    over = axial.reshape(len(axial), -1)
    return np.maximum(-over.min(axis=1), 0.0), np.maximum(over.max(axis=1) - length, 0.0)
