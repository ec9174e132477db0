"""The stretch of the wall in a step to come, carried on with the wave, Eq. (105).

Behind a front the wall shortens within a few hundredths of a second to a third, while the front passes two or three
elements in a step. Rates know nothing of the elements that the front has yet to reach. In the frame of the wave little
changes, so near a front the stretch is that of now, moved on with the front.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled

BEHIND, AHEAD = 0.06, 0.01
"""How far behind and ahead of a front the stretch goes with it, over its speed [s]."""
APART = 10
"""Cells over which the speed of a front is read."""
LATELY = 0.025
"""Time since a cell was activated within which it can be that at the front [s]."""
BROKEN = 0.05
"""Time between the activations of neighbours beyond which they do not belong to one front [s]."""
FASTEST = 0.1
"""Way of a front in a step beyond which it is nowhere like a wave that travels [cm]."""


@compiled
def carry_with_wave(
    now: np.ndarray, activation: np.ndarray, cell_size: float, element_size: float, span: float, time: float, out: np.ndarray
) -> None:
    """Put in `out`, near fronts, the stretch of the elements moved on with them.

    now: of the elements, (n_z_wall,). activation: last rise of the cells [s], (n_z,). out: (n_z_wall, shares), for the
    middles of equal shares of the step of `span` [s] from `time` [s].
    """
    n, elements, shares = activation.size, now.size, out.shape[1]
    for i in range(n):
        if not time - activation[i] <= LATELY:
            continue
        for way in (-1, 1):
            ahead, behind = i + way, i - way * APART
            if ahead < 0 or ahead >= n or behind < 0 or behind >= n:
                continue
            if activation[i] - activation[ahead] <= BROKEN:  # not beyond the front; false where nan
                continue
            taken = activation[i] - activation[behind]
            if not (0.0 < taken < BROKEN):
                continue
            speed = APART * cell_size / taken
            if speed * span > FASTEST:
                continue
            front = (i + 0.5) * cell_size + way * speed * (time - activation[i])
            ends = front - way * speed * BEHIND, front + way * speed * (span + AHEAD)
            first = max(int(math.ceil(min(ends) / element_size - 0.5)), 0)
            last = min(int(math.floor(max(ends) / element_size - 0.5)), elements - 1)
            for s in range(shares):
                shift = way * speed * span * (s + 0.5) / shares / element_size
                for e in range(first, last + 1):
                    out[e, s] = _between(now, e - shift)


@compiled
def _between(values: np.ndarray, place: float) -> float:
    """Value at a place between whole numbers, cubic, and never beyond its two neighbours; constant beyond the ends."""
    last = values.size - 1
    place = min(max(place, 0.0), float(last))
    k = min(int(place), last - 1)
    x = place - k
    b, c = values[k], values[k + 1]
    a, d = values[max(k - 1, 0)], values[min(k + 2, last)]
    found = b + 0.5 * x * (c - a + x * (2.0 * a - 5.0 * b + 4.0 * c - d + x * (3.0 * (b - c) + d - a)))
    return min(max(found, min(b, c)), max(b, c))
