"""What the wall encloses: the volume of the lumen and its gradient, Eq. (18)."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from ..numerics.reductions import dot


@compiled
def lumen_volume(rho: np.ndarray, zeta: np.ndarray) -> float:
    """Volume [cm^3] inside a tube of frusta through the nodes (rho, zeta) [cm]."""
    n = rho.size
    areas, lengths = np.empty(n), np.empty(n)
    for e in range(n - 1):
        a = rho[e]
        b = rho[e + 1]
        areas[e] = a * a + a * b + b * b
        lengths[e] = zeta[e + 1] - zeta[e]
    return dot(areas, lengths, min(0, n), n - 1) * math.pi / 3.0
