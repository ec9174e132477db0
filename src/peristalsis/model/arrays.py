"""The arrays of a state as compiled calls take them: in one tuple, and in a file that imports no physics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class WallArrays(NamedTuple):
    """The arrays of a `WallState`, shapes and units as there."""

    position: Floats
    position_before: Floats
    velocity: Floats
    velocity_before: Floats
    contact: Floats
    stretch_rate: Floats
    hoop_rate: Floats
    drive: Floats


class StrainedSurface(NamedTuple):
    """What the tensions of a wall on the whole surface follow from.

    axial, hoop: stretches of the edges along z (n - 1, m) and around the ring (n, m); their rates and the drives in the
    shapes of `WallState`.
    """

    axial: Floats
    hoop: Floats
    axial_rate: Floats
    hoop_rate: Floats
    drive: Floats


class NewWall(NamedTuple):
    """The arrays of the `WallState` after a step, to be written by a compiled call."""

    position: Floats
    velocity: Floats
    contact: Floats
    stretch_rate: Floats
    hoop_rate: Floats
