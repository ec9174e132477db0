"""How much too slow a front runs on cells that are coarse for it: a measured law, for warnings and for a correction.

A front's speed on a grid depends on one number, the cell size over the length of its foot, D/c, since D and the cell
size enter conduction through D/h^2 alone. So one table serves both layers, both directions and every stretch.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]

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
SPACING = 0.01
"""Of the table of the correction [feet]."""
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


@cache
def excess_conduction() -> Floats:
    """(f - 1)/q^4 at q = 0, SPACING, 2 SPACING ...: f of Eq. (95), on cells of q feet; to the end of the measured law.

    A factor f makes front and foot faster and longer by its root, so f = 1/c^2 at q = p/c, p and c of the table above.
    Between its entries f - 1 is a power of q; below them the fourth, the order of the differences.
    """
    speed = np.array(RELATIVE_SPEED[1:])
    sizes = np.array(CELLS_PER_FOOT[1:]) / speed
    places = SPACING * np.arange(math.floor(sizes[-1] / SPACING) + 1)
    law = np.log((1.0 / speed**2 - 1.0) / sizes**4)
    table = np.exp(np.interp(np.log(np.maximum(places, sizes[0])), np.log(sizes), law))
    table.setflags(write=False)
    return table


@compiled
def _raise(resistance: np.ndarray, feet: float, excess: np.ndarray, spacing: float, out: np.ndarray) -> None:
    """`raised_resistance` of flat arrays."""
    end = spacing * (excess.size - 1)
    for k in range(resistance.size):
        size = min(feet * math.sqrt(resistance[k]), end)
        place = size / spacing
        i = min(int(place), excess.size - 2)
        found = excess[i] + (place - i) * (excess[i + 1] - excess[i])
        out[k] = resistance[k] / (1.0 + size**4 * found)


def raised_resistance(resistance: Floats, feet: float) -> Floats:
    """Resistance of faces to conduction with which a front on cells that are coarse for it has its exact speed, (95).

    resistance: stretch over the factor on conductivity; infinite where a face does not conduct. feet: size of a cell
    over the foot of a front where that is 1. Cells coarser than the measured ones get what the coarsest of those get.
    """
    out = np.empty(resistance.shape)
    _raise(np.ravel(resistance), feet, excess_conduction(), SPACING, out.reshape(-1))
    return out
