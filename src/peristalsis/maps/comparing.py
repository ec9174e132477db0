"""Two maps beside one another: brought to one grid, aligned in time, their difference and correlation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ConfigurationError
from .recording import Floats, Map, Numbers, locked


class Compared(NamedTuple):
    """Both maps on the grid that they share, the second moved by `shift` [s] (above 0: it was early).

    difference: of the second less the first, (n_time, n_place). correlation: Pearson's over all values that both have;
    rms: root mean square difference, in their unit; lag_correlation: the correlation over the shifts that were tried.
    """

    first: Map
    second: Map
    difference: Numbers
    shift: float
    correlation: float
    rms: float
    shifts: Floats
    lag_correlation: Floats


def compare(first: Map, second: Map, most: float = 0.0) -> Compared:
    """Compare two maps of one quantity where they overlap, on the coarser of their steps.

    most: shifts in time of up to this are tried [s], and that of the largest correlation is taken; 0, as it is by
    default, leaves both where they are. Raises ConfigurationError where they have no quantity, time or place in common.
    """
    if first.quantity != second.quantity:
        raise ConfigurationError(
            f"{first.name} is a map of {first.quantity} and {second.name} one of {second.quantity}; compare two of one"
        )
    time, place = grid(first, second, most)
    step, distance = _typical(time), _typical(place)
    one = on_grid(first, time, place)
    count = int(most / step + 1e-9)
    shifts = step * np.arange(-count, count + 1, dtype=np.float64)
    values = [_correlation(one, on_grid(second, time - shift, place)) for shift in shifts]
    correlations = np.array(values)
    known = np.isfinite(correlations)
    best = int(np.argmax(np.where(known, correlations, -2.0))) if known.any() else count
    shift = float(shifts[best])
    two = on_grid(second, time - shift, place)
    both = np.isfinite(one) & np.isfinite(two)
    if not both.any():
        raise ConfigurationError(
            f"{first.name} and {second.name} have no time and place in common without gaps; check both"
        )
    rms = float(np.sqrt(np.mean((two - one)[both] ** 2)))
    line = f"on the grid it shares with another: every {step:g} s and {distance:g} mm"
    return Compared(
        first.done(line, values=locked(one), time=time, place=place),
        second.done(f"{line}, {shift:g} s later", values=locked(two), time=time, place=place),
        two - one,
        shift,
        float(correlations[best]),
        rms,
        shifts,
        correlations,
    )


def grid(first: Map, second: Map, most: float = 0.0) -> tuple[Floats, Floats]:
    """Times [s] and places [mm] that two maps have in common, on the coarser of their steps.

    most: the second may be moved by this in time [s]. Raises ConfigurationError where they do not overlap.
    """
    places = _shared(first.place, second.place, "places", "mm", 0.0)
    times = _shared(first.time, second.time, "times", "s", most)
    found = []
    for (low, high), one, two in ((times, first.time, second.time), (places, first.place, second.place)):
        step = max(_typical(one), _typical(two))
        count = int((high - low) / step + 1e-9) + 1
        if count < 2:
            raise ConfigurationError(
                f"{first.name} and {second.name} share {high - low:g} of an axis with steps of {step:g}; record more"
            )
        found.append(low + step * np.arange(count, dtype=np.float64))
    return found[0], found[1]


def _shared(one: Floats, two: Floats, what: str, unit: str, slack: float) -> tuple[float, float]:
    low, high = max(one[0], two[0] - slack), min(one[-1], two[-1] + slack)
    if not low < high:
        raise ConfigurationError(
            f"the {what} {one[0]:g} to {one[-1]:g} {unit} and {two[0]:g} to {two[-1]:g} {unit} do not overlap; "
            "shift one of the maps, or cut it"
        )
    return float(low), float(high)


def _typical(axis: Floats) -> float:
    if axis.size < 2:
        raise ConfigurationError("a map of one time or one place cannot be compared; record more")
    return float(np.median(np.diff(axis)))


def on_grid(recorded: Map, time: Floats, place: Floats) -> Numbers:
    """Values of a map at other times and places, linear between its own; nan outside and beside gaps."""
    across = _linear(recorded.values.T, recorded.place, place).T
    return _linear(across, recorded.time, time)


def _linear(values: Numbers, axis: Floats, wanted: Floats) -> Numbers:
    right = np.clip(np.searchsorted(axis, wanted - 1e-9), 1, axis.size - 1)
    share = (wanted - axis[right - 1]) / (axis[right] - axis[right - 1])
    share = np.where(np.abs(share) < 1e-6, 0.0, np.where(np.abs(share - 1.0) < 1e-6, 1.0, share))[:, None]
    left_part, right_part = values[right - 1], values[right]
    found = np.where(
        share <= 0.0, left_part, np.where(share >= 1.0, right_part, (1 - share) * left_part + share * right_part)
    )
    outside = (wanted < axis[0] - 1e-9) | (wanted > axis[-1] + 1e-9)
    found[outside] = np.nan
    return np.asarray(found)


def _correlation(one: Numbers, two: Numbers) -> float:
    both = np.isfinite(one) & np.isfinite(two)
    if both.mean() < 0.25:  # a few columns of overlap correlate by chance
        return float("nan")
    a, b = one[both] - one[both].mean(), two[both] - two[both].mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0.0 else float("nan")


def side_by_side(numbers: dict[str, dict[str, float | int | None]], unit: str) -> list[tuple[str, ...]]:
    """Rows of a table: what is counted, and a column for each map; texts, - where there is none."""
    keys = list(next(iter(numbers.values())))
    rows = []
    for key in keys:
        label = f"{key} ({unit})" if key == "amplitude" else key
        cells = []
        for own in numbers.values():
            value = own.get(key)
            cells.append("-" if value is None else f"{value:d}" if isinstance(value, int) else f"{value:.4g}")
        rows.append((label, *cells))
    return rows
