"""The surface cut open and laid flat: fields over place and angle, fronts and their velocities; no drawing here.

A wall of one column is uniform around the ring and is shown as such. Columns are those of the stored array, centred
at 2 pi j / n, so that wall and conduction may have different numbers of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..names import OUTPUTS
from . import data

if TYPE_CHECKING:
    from ..results.result import Result

Floats = NDArray[np.float64]

FASTEST = 50.0
"""A front that seems faster [cm/s] is no front: cells next to one another were started at the same time."""


def field(result: Result, name: str, frame: int | None = None, unit: str | None = None) -> Floats:
    """An output over (place, angle), of one stored time where it has any: shape (n_z, n_theta), all columns."""
    output = OUTPUTS[name]
    array = np.asarray(data.stored(result, name), dtype=np.float64)
    if frame is not None:
        array = array[frame]
    return array if unit is None or unit == output.unit else array * data.FACTORS[output.unit, unit]


def is_uniform(array: Floats) -> bool:
    """Whether a field has one column only, and so is uniform around the ring."""
    return array.shape[-1] == 1


def angles(columns: int) -> Floats:
    """Angles of the columns and of the first once more [deg], 0 to 360."""
    return np.linspace(0.0, 360.0, max(columns, 1) + 1)


def closed(array: Floats) -> Floats:
    """A field with its first column once more at the end: the ring, closed."""
    return np.concatenate([array, array[..., :1]], axis=-1)


def front_velocity(
    times: Floats, spacing: float, radius: float, places: NDArray[np.int64], columns: NDArray[np.int64], reach: int
) -> tuple[Floats, Floats]:
    """Velocity of a front along the tube and around it [cm/s] at chosen cells, each (places.size, columns.size).

    times: activation [s], (n_z, n_theta), nan where there was none. spacing: of the cells along the tube [cm];
    radius: of the undeformed tube [cm]. reach: cells to either side over which the slope is taken, and as far around
    the ring. The slope of time is grad T, the velocity grad T / |grad T|^2; nan where it is not defined.
    """
    n, m = times.shape
    low, high = np.maximum(places - reach, 0), np.minimum(places + reach, n - 1)
    along = (times[high][:, columns] - times[low][:, columns]) / ((high - low) * spacing)[:, None]
    around = np.zeros_like(along)
    arc = 2.0 * np.pi * radius / m
    if m > 2:
        step = int(np.clip(round(reach * spacing / arc), 1, (m - 1) // 2))
        later, earlier = times[places][:, (columns + step) % m], times[places][:, (columns - step) % m]
        around = (later - earlier) / (2.0 * step * arc)
    squared = along**2 + around**2
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(squared > FASTEST**-2, 1.0 / squared, np.nan)
    return along * speed, around * speed


def even(least: float, most: float, about: int) -> Floats:
    """Round values between two times, about as many as asked for."""
    if not most > least:
        return np.empty(0)
    raw = (most - least) / about
    size = 10.0 ** np.floor(np.log10(raw))
    step = size * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * size >= raw * 0.999)
    levels = step * np.arange(np.ceil(least / step), np.floor(most / step) + 1)
    return np.asarray(levels[(levels > least) & (levels < most)])
