"""What the wall encloses: the volume of the lumen and its gradient, Eq. (18)."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled


@compiled
def lumen_volume(rho: np.ndarray, zeta: np.ndarray) -> float:
    """Volume [cm^3] inside a tube of frusta through the nodes (rho, zeta) [cm]."""
    total = 0.0
    for e in range(rho.size - 1):
        a = rho[e]
        b = rho[e + 1]
        total += (a * a + a * b + b * b) * (zeta[e + 1] - zeta[e])
    return total * math.pi / 3.0
