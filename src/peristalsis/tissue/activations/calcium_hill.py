"""Activation of muscle by the calcium of its cells, at once: Hill's curve, Eq. (79).

Calcium is that of the cell model, in uM. A cell says in which unit its calcium is; where it is a number without a unit,
as in Plant's cell, `calcium_unit` says what 1 stands for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import inlined
from ..hill import hill

KIND = "activation"
NAME = "calcium_hill"
TITLE = "calcium of the cell by Hill's curve"
READS_CALCIUM = True

PARAMETERS = (
    number("half", 0.4, "uM", "calcium of half the full drive: an example, of the size of half-maximal force in smooth "
           "muscle, some 0.2 to 1 uM", tag="chosen", lowest=1e-6, highest=1e6),
    number("exponent", 4.0, "1", "steepness of Hill's curve: an example, one for each calcium that calmodulin binds",
           tag="chosen", lowest=0.1, highest=20.0),
    number("full", 40.0, "mV", "drive at full activation, as depolarisation beyond the threshold: an example, half of "
           "what the paper's spikes reach", tag="chosen", lowest=0.0, highest=1e4),
    number("calcium_unit", 1.0, "uM", "what a calcium of 1 stands for in a cell that gives it without a unit: an "
           "example", tag="chosen", lowest=1e-6, highest=1e6),
)  # fmt: skip


class ActivationConstants(NamedTuple):
    """The values of PARAMETERS, in their order."""

    half: float
    exponent: float
    full: float
    calcium_unit: float


@inlined
def drive(potential: float, calcium: float, states: np.ndarray, k: int, c: ActivationConstants) -> float:
    """Drive [mV] of a cell at a calcium [uM], Eq. (79)."""
    return c.full * hill(calcium, c.half, c.exponent)


def largest_drive(highest: float, c: ActivationConstants) -> float:
    """Largest drive [mV], at any potential."""
    return c.full
