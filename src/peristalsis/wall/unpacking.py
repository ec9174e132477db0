"""The wall's constants from a flat array of numbers (`model.constants.packed`), with as many as its laws have."""

from __future__ import annotations

import numpy as np

from ..numerics.compiled import compiled
from .active import NUMBERS as OF_MUSCLE
from .active import unpack_active
from .constants import WallConstants
from .passive import NUMBERS as OF_LAW
from .passive import unpack_passive

OWN = WallConstants._fields.index("passive")
"""Numbers before those of the laws."""


@compiled
def unpack_wall(p: np.ndarray) -> WallConstants:
    """The wall's constants from what `packed` made of them."""
    return WallConstants(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10] != 0.0,
        unpack_passive(p, OWN),
        unpack_active(p, OWN + OF_LAW),
        unpack_active(p, OWN + OF_LAW + OF_MUSCLE),
    )  # fmt: skip
