"""Conduction between coarse cells made so much better that the front on them has its exact speed: a measured law.

A front is slow on cells that are coarse for it, by a share s(q) that depends on q, the cell size over the length of the
foot, alone (`resolution`). Better conduction by f makes the front faster and its foot longer, both as the root of f,
so f = s(q)^-2 puts it right on cells of q/s(q) feet, Eq. (85). As h goes to zero, f - 1 falls as h^4: limit and order
of the operator stay. What the step of conduction adds is in the law, by the step over the time scale of the kinetics.

Measured on Plant's cells with the shipped conductances (`verification.exact.front`), whatever the conductivity and the
rate of the kinetics. Fast calcium makes the foot shorter, and the law knows it (`shorter_foot`); what other channels do
to the foot, by a tenth of that, it does not.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from . import resolution
from .cells.plant import CHANNELS
from .resolution import MEASURED_RATE

Floats = NDArray[np.float64]

CELLS_PER_FOOT = (
    *(0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0),
    *(1.1, 1.2, 1.3, 1.4, 1.55, 1.7, 1.85, 2.0, 2.25, 2.5, 2.75, 3.0),
)
"""Cell sizes of the measurement, over the length of the foot."""
MEASURED_STEPS = (0.0, 0.25, 0.5, 1.0, 2.0)
"""Steps of conduction [ms] at tissue.kinetics_rate = 1/8; the first row was measured at 0.0625 ms."""
RELATIVE_SPEEDS = (
    (
        *(0.99969, 0.99893, 0.99714, 0.99361, 0.99104, 0.98788, 0.98414, 0.97985, 0.97503, 0.96974, 0.96401, 0.95790),
        *(0.94471, 0.93052, 0.91563, 0.90026, 0.87674, 0.85306, 0.82956, 0.80646, 0.76928, 0.73406, 0.70098, 0.67007),
    ),
    (
        *(0.99972, 0.99897, 0.99721, 0.99365, 0.99106, 0.98788, 0.98411, 0.97979, 0.97495, 0.96963, 0.96387, 0.95774),
        *(0.94451, 0.93028, 0.91536, 0.89997, 0.87643, 0.85275, 0.82925, 0.80617, 0.76900, 0.73381, 0.70076, 0.66988),
    ),
    (
        *(0.99977, 0.99904, 0.99722, 0.99364, 0.99109, 0.98784, 0.98402, 0.97962, 0.97470, 0.96930, 0.96347, 0.95726),
        *(0.94391, 0.92958, 0.91458, 0.89914, 0.87555, 0.85186, 0.82837, 0.80531, 0.76821, 0.73309, 0.70012, 0.66931),
    ),
    (
        *(0.99980, 0.99904, 0.99716, 0.99336, 0.99061, 0.98728, 0.98337, 0.97890, 0.97390, 0.96842, 0.96196, 0.95558),
        *(0.94189, 0.92726, 0.91200, 0.89638, 0.87263, 0.84887, 0.82541, 0.80243, 0.76554, 0.73067, 0.69795, 0.66738),
    ),
    (
        *(0.99887, 0.99748, 0.99647, 0.99283, 0.99001, 0.98633, 0.98186, 0.97812, 0.97128, 0.96507, 0.95865, 0.95198),
        *(0.93781, 0.92333, 0.90796, 0.89213, 0.86850, 0.84404, 0.81747, 0.79467, 0.75813, 0.72380, 0.69166, 0.66180),
    ),
)
"""Speed on such cells with such steps, over the speed of the front in the limit."""
BEYOND = tuple(cells for cells in resolution.CELLS_PER_FOOT if cells > CELLS_PER_FOOT[-1])
"""Coarser cells still, as columns around a tube are: there the law of `resolution` goes on, whatever the step."""
MEASURED_FAST_CALCIUM = 4.0
"""Conductance of the fast calcium channels of the measured tissue [mS/cm^2]."""
FASTER = 0.52
"""Power of the fast calcium conductance with which the front's speed goes: 0.516 to 0.534 from half to twice it."""
COARSEST = resolution.CELLS_PER_FOOT[-1] / resolution.RELATIVE_SPEED[-1]
"""Cells, in feet, up to which the law goes; coarser ones get what these get."""
SPACING = 0.01
"""Of the table, in feet."""


@lru_cache(maxsize=64)
def correction_table(dt: float, kinetics_rate: float = MEASURED_RATE) -> Floats:
    """Factors f on conduction for cells of 0, SPACING, 2 SPACING... feet, up to COARSEST; not to be written to.

    dt: step of conduction [ms]; steps longer than the measured ones get what the longest gets.
    """
    places = SPACING * np.arange(math.floor(COARSEST / SPACING) + 1)
    scaled = min(dt * kinetics_rate / MEASURED_RATE, MEASURED_STEPS[-1])
    known = dict(zip(resolution.CELLS_PER_FOOT, resolution.RELATIVE_SPEED, strict=True))
    rows = []
    for speeds in RELATIVE_SPEEDS:
        further = [known[cells] / known[CELLS_PER_FOOT[-1]] * speeds[-1] for cells in BEYOND]
        slow = np.array([*speeds, *further])
        sizes = np.array([*CELLS_PER_FOOT, *BEYOND]) / slow
        # Between its entries f - 1 is a power of the size; below them the fourth, the order of the differences.
        law = np.log((slow**-2 - 1.0) / sizes**4)
        within = np.minimum(places, sizes[-1])
        rows.append(within**4 * np.exp(np.interp(np.log(np.maximum(within, sizes[0])), np.log(sizes), law)))
    # Errors of the step go with its square.
    squares = np.square(MEASURED_STEPS)
    above = min(int(np.searchsorted(squares, scaled**2, side="right")), len(rows) - 1)
    share = (scaled**2 - squares[above - 1]) / (squares[above] - squares[above - 1])
    table = np.asarray(1.0 + (1.0 - share) * rows[above - 1] + share * rows[above], dtype=np.float64)
    table.flags.writeable = False
    return table


def shorter_foot(conductances: Floats) -> float:
    """By how much the foot of a front is shorter than in the measured tissue, for conductances (channels, n) [mS/cm^2].

    Fast calcium makes the front, whose speed goes with the power FASTER of it and whose foot with the inverse; the
    other channels change it by a tenth of that. Of tissue that varies, the median counts.
    """
    fast = float(np.median(conductances[CHANNELS.index("fast_calcium")]))
    return (fast / MEASURED_FAST_CALCIUM) ** FASTER if fast > 0.0 else 1.0


def correction(cells_per_foot: float, table: Floats) -> float:
    """Factor on the conduction between cells of so many feet."""
    return float(_factor(cells_per_foot / SPACING, table))


@compiled
def _factor(place: float, table: np.ndarray) -> float:
    """The table at a place between its entries, and its last entry beyond them."""
    last = table.size - 1
    k = min(int(min(place, float(last))), last - 1)
    share = min(place - k, 1.0)
    return table[k] + share * (table[k + 1] - table[k])


@compiled
def correct_front(
    cells_per_foot: float, spacing: float, table: np.ndarray, scale: float, coefficient: np.ndarray
) -> None:
    """Multiply the conduction of every face by the factor for its cells, Eq. (85), in place.

    cells_per_foot: at coefficient = scale, where the stretch is 1; better conduction makes the foot longer. table:
    factors for 0, spacing, 2 spacing... cells per foot.
    """
    per_spacing = cells_per_foot / spacing
    for t in range(coefficient.shape[0]):
        for j in range(coefficient.shape[1]):
            if coefficient[t, j] > 0.0:
                coefficient[t, j] *= _factor(per_spacing * math.sqrt(scale / coefficient[t, j]), table)


def raised_resistance(resistance: Floats, cells_per_foot: float, table: Floats) -> Floats:
    """Resistance of faces to conduction as the correction leaves it, Eq. (85), of any shape.

    resistance: stretch over the factor on conductivity; infinite where a face does not conduct. cells_per_foot: where
    that is 1. table: `correction_table`.
    """
    with np.errstate(divide="ignore"):
        conduction = 1.0 / resistance
        correct_front(cells_per_foot, SPACING, table, 1.0, conduction.reshape(-1, 1))
        return np.asarray(1.0 / conduction)
