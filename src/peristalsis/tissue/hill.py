"""Hill's curve of calcium, Eq. (79), for what it activates."""

from __future__ import annotations

import math

from ..numerics.compiled import inlined


@inlined
def hill(calcium: float, half: float, exponent: float) -> float:
    """Share between 0 and 1 that is active; one half at `half`, in whose unit calcium is. Nothing below 0."""
    share = max(calcium, 0.0) / half
    if share > 1.0:  # so that no power overflows
        return 1.0 / (1.0 + math.pow(1.0 / share, exponent))
    power = math.pow(share, exponent)
    return power / (1.0 + power)
