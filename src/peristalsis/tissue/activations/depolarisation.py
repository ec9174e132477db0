"""The paper's activation of muscle, Eq. (19): depolarisation beyond a threshold, at once.

Its constant is the configuration's `longitudinal.threshold` or `circular.threshold`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...numerics.compiled import inlined

KIND = "activation"
NAME = "depolarisation"
TITLE = "depolarisation beyond a threshold (the paper's)"


class ActivationConstants(NamedTuple):
    """Threshold of Eq. (19) [mV]."""

    threshold: float


@inlined
def drive(potential: float, calcium: float, states: np.ndarray, k: int, c: ActivationConstants) -> float:
    """phi+ [mV] of a cell at a potential [mV], Eq. (19)."""
    return max(potential - c.threshold, 0.0)


def largest_drive(highest: float, c: ActivationConstants) -> float:
    """Largest drive [mV] of cells whose potential stays below `highest` [mV]."""
    return max(highest - c.threshold, 0.0)
