"""What a sheet is advanced with, in records: its arrays, what is brought to its cells, the steps, tables."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class SheetArrays(NamedTuple):
    """Potential [mV] (n,), gates (states, n), first and latest rise through the activation level [ms] (nan before).

    Flattened (z, theta). All four are written.
    """

    potential: Floats
    gates: Floats
    first_activation: Floats
    last_activation: Floats


class Brought(NamedTuple):
    """Stimulus current [uA/cm^2], inward positive, and extra conductance [mS/cm^2] of every cell, held over the call.

    The current of the conductance at 0 mV is part of the drive.
    """

    drive: Floats
    shunt: Floats


class Steps(NamedTuple):
    """n_steps of dt [ms] from `time` [ms] over rings of n_theta cells.

    exact: no tables, and no cell waits. level: rises through it [mV] are noted.
    """

    time: float
    dt: float
    n_steps: int
    n_theta: int
    exact: bool
    level: float


class Tables(NamedTuple):
    """Tables of the gates for a whole step and for half of one."""

    whole: Floats
    half: Floats


class Rates(NamedTuple):
    """What a rate is made of: conduction [mV/ms], the cell at its potential, and what is held over a step."""

    spread: Floats
    instant: Floats
    held: Floats


class Stages(NamedTuple):
    """Potentials [mV] at the start of a step, at the stage before, and at the one before that."""

    start: Floats
    last: Floats
    older: Floats
