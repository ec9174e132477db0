"""Measures of waves, defined on plain arrays: a number, or None with the reason why there is none."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FAST_PART = (3.0, 8.0)
"""Stretch of the undeformed tube over which wave speeds are measured [cm]."""


def wave_speed(z: Floats, activation: Floats) -> float | None:
    """Speed of the first wave [cm/s]: slope of place over activation time between 3 and 8 cm; None if none passed.

    z: cells [cm], (n_z,); activation: first activation times [s], (n_z,), nan where there was none.
    """
    part = (z > FAST_PART[0]) & (z < FAST_PART[1])
    if part.sum() < 3 or not np.isfinite(activation[part]).all():
        return None
    slowness = float(np.polyfit(z[part], activation[part], 1)[0])
    return 1.0 / slowness if slowness != 0.0 else None
