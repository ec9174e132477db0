"""Constants of pellet and friction. The records know no shape: a shape brings its own (`shapes`)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple


class Resistance(NamedTuple):
    """What `PelletConstants` has of a load, Eq. (123), and of dry friction that falls with speed, Eq. (125)."""

    pull: float = 0.0
    pull_stiffness: float = 0.0
    pull_from: float = 0.0
    fast_share: float = 1.0
    fall_speed: float = 1.0


FREE = Resistance()
"""No load, and dry friction that does not fall with speed."""


class PelletConstants(NamedTuple):
    """Pellet and friction: cm, mN, s; made by `body.pellet_of`, which fills in what follows from the shape.

    shape: the `ShapeConstants` of the shape's file. frame: w is 0 for friction at rest, 1 against the moving wall,
    Eq. (27). volume, oral, anal: volume, and distances of the poles from the centre. tangential: a part of the reaction
    on the wall lies in its tangent plane, that of Eq. (51); else all of it is axial. lowest, highest: between which the
    centre stays [cm], Eq. (60); infinite where the segment's end is open, both the start for a pellet held there. pull
    [mN], pull_stiffness [mN/cm], pull_from [cm]: of the load, Eq. (123). fast_share, fall_speed [cm/s]: of dry friction
    that falls with speed, Eq. (125). sliding: whether the pellet slid when the step began.
    """

    present: bool
    shape: Any
    viscous: float
    dry: float
    frame: float
    volume: float
    oral: float
    anal: float
    tangential: bool = False
    lowest: float = -math.inf
    highest: float = math.inf
    pull: float = 0.0
    pull_stiffness: float = 0.0
    pull_from: float = 0.0
    fast_share: float = 1.0
    fall_speed: float = 1.0
    sliding: bool = False

    @property
    def radius(self) -> float:
        """Girth radius [cm]."""
        return float(self.shape.radius)


PELLET_VISCOUS, PELLET_DRY, PELLET_SLIDING = -15, -14, -1
"""Places of three of the packed numbers of `PelletConstants`, from their end: the shape has as many as it needs."""
