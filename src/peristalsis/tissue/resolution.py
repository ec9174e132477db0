"""How much too slow a front runs on cells that are coarse for it: a measured law.

A front's speed on a grid depends on one number, the cell size over the length of its foot, D/c, since D and the cell
size enter conduction through D/h^2 alone. So one table serves both layers, both directions and every stretch.
"""

from __future__ import annotations

import math

import numpy as np

MEASURED_FOOT = 0.0873 / 4.2
"""Foot D/c of the calibrated wave [cm], at D = 0.0873 cm^2/s and tissue.kinetics_rate = 1/8."""
MEASURED_DIFFUSIVITY, MEASURED_RATE = 0.0873, 0.125

CELLS_PER_FOOT = (0.0, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
"""Cell sizes, over the length of the foot."""
RELATIVE_SPEED = (
    *(1.0, 0.9997, 0.9990, 0.9972, 0.9937, 0.9879, 0.9750, 0.9578, 0.9303, 0.9000),
    *(0.8528, 0.8062, 0.7338, 0.6699, 0.5662, 0.4876, 0.4265, 0.3375, 0.2738, 0.2187),
)
"""Speed of a plane front of the resting tissue on a ring of such cells, over the converged speed; dt = 0.25 ms."""
BLOCKED = 12.5
"""Cells of this many feet stop the front: it runs at 12 and not at 13, whatever the stimulus."""


def front_foot(diffusivity: float, kinetics_rate: float = MEASURED_RATE) -> float:
    """Length over which the foot of a front rises e-fold [cm], for an effective diffusivity [cm^2/s], stretch included.

    kinetics_rate: factor on the rates of the cells; speed and foot go with sqrt(D rate) and sqrt(D/rate).
    """
    return MEASURED_FOOT * math.sqrt(diffusivity / MEASURED_DIFFUSIVITY * MEASURED_RATE / kinetics_rate)


def relative_front_speed(cell_size: float, foot: float) -> float:
    """Speed on cells of this size [cm] over the converged speed; 0 where the front does not pass from cell to cell."""
    ratio = cell_size / foot
    if ratio >= BLOCKED:
        return 0.0
    return float(np.interp(ratio, CELLS_PER_FOOT, RELATIVE_SPEED))


def columns_for_speed(radius: float, foot: float, error: float = 0.01) -> int:
    """Columns around a tube of this radius [cm] with which a front around the ring is slow by no more than `error`."""
    coarsest = float(np.interp(1.0 - error, RELATIVE_SPEED[::-1], CELLS_PER_FOOT[::-1]))
    return math.ceil(2.0 * math.pi * radius / (coarsest * foot))
