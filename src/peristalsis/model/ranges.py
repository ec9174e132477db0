"""Whether numbers are within bounds, and where they are not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..wall.membrane import LARGEST_STRETCH, SMALLEST_STRETCH

Floats = NDArray[np.float64]


@compiled
def between(values: np.ndarray, low: float, high: float) -> bool:
    """Whether every value is a number strictly between the bounds."""
    good = 0
    for k in range(values.size):  # by index: such a loop runs on vector registers
        good += 1 if (values[k] > low) & (values[k] < high) else 0
    return good == values.size


def outside(values: Floats, low: float, high: float, places: Floats) -> str | None:
    """The first value that is not a number strictly between two bounds, with its place; None if there is none.

    values: (n, ...) along the tube. places: [cm], as many or, for half elements, about half as many.
    """
    if between(values.ravel(), low, high):
        return None
    good = (values > low) & (values < high)
    index = np.unravel_index(int(np.argmin(good)), good.shape)
    place = places[min(int(index[0] * places.size / values.shape[0]), places.size - 1)]
    return f"is {values[index]:.3g} at z = {place:.3g} cm,"


def stretches_outside(stretch: Floats, hoop: Floats, places: Floats) -> str | None:
    """The first stretch, along or around, that no wall can have, with its name and place; None if there is none."""
    for name, values in {"longitudinal stretch": stretch, "circumferential stretch": hoop}.items():
        bad = outside(values, SMALLEST_STRETCH, LARGEST_STRETCH, places)
        if bad is not None:
            return f"{name} {bad}"
    return None
