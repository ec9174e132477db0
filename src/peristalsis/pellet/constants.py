"""Constants of pellet and friction. The records know no shape: a shape brings its own (`shapes`)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple


class PelletConstants(NamedTuple):
    """Pellet and friction: cm, mN, s; made by `body.pellet_of`, which fills in what follows from the shape.

    shape: the `ShapeConstants` of the shape's file. frame: w is 0 for friction at rest, 1 against the moving wall,
    Eq. (27). volume, oral, anal: volume, and distances of the poles from the centre. tangential: a part of the reaction
    on the wall lies in its tangent plane, that of Eq. (51); else all of it is axial. lowest, highest: between which the
    centre stays [cm], Eq. (60); infinite where the segment's end is open.
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

    @property
    def radius(self) -> float:
        """Girth radius [cm]."""
        return float(self.shape.radius)


PELLET_DRY = -8
"""Place of `dry` among the packed numbers of `PelletConstants`, from their end: the shape has as many as it needs."""
