"""What everything here is about: a quantity over place and time, measured or simulated, and tracks of pellets.

A map holds numbers of shape (n_time, n_place) at rising times [s] and rising places [mm], the oral end first; a gap is
nan. Its unit is that of its quantity: diameters in mm, pressures in mmHg, stretches and strains without. Nothing of a
map can be changed: what is done to it gives another one, with a line more in its history.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import units
from ..errors import ConfigurationError, shown, suggestion

Floats = NDArray[np.float64]
Numbers = NDArray[Any]
"""Of float64, or of float32 where the recording has no more digits than that."""

MOST_VALUES = 150_000_000
"""Numbers of a map: two hours at 25 Hz and 800 places; 1.2 GB in double precision."""
EVEN = 0.01
"""Share of a step by which the steps of an even axis may differ."""


class Quantity(NamedTuple):
    """What a map shows: its unit, what an axis says, and which way a contraction goes (-1: down)."""

    unit: str
    label: str
    contraction: int


QUANTITIES = {
    "diameter": Quantity("mm", "inner diameter", -1),
    "pressure": Quantity("mmHg", "pressure", 1),
    "stretch": Quantity("1", "longitudinal stretch", -1),
    "strain": Quantity("1", "strain", -1),
}


@dataclass(frozen=True, eq=False, repr=False)
class Map:
    """A quantity over time and place; see the module for shapes and units.

    values: (n_time, n_place). time [s] and place [mm] rise; place counts from the oral end. name: what it is called in
    pictures. history: what was done to it, a line each, beginning with where it is from. Raises ConfigurationError
    where these do not fit together.
    """

    values: Numbers
    time: Floats
    place: Floats
    quantity: str
    name: str = "map"
    history: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.dtype != np.float32:
            values = np.asarray(values, dtype=np.float64)
        if values.flags.writeable:  # what the caller keeps may change; what is locked already is not copied
            values = values.copy()
        time, place = np.array(self.time, dtype=np.float64), np.array(self.place, dtype=np.float64)
        if self.quantity not in QUANTITIES:
            raise ConfigurationError(
                f"quantity {shown(self.quantity)} is not known; {suggestion(str(self.quantity), QUANTITIES)}"
            )
        if values.ndim != 2 or values.shape != (time.size, place.size) or not values.size:
            raise ConfigurationError(
                f"{self.name}: values of shape {values.shape} do not fit {time.size} times and {place.size} places; "
                "give one row a time and one column a place"
            )
        if values.size > MOST_VALUES:
            raise ConfigurationError(
                f"{self.name} has {values.size} numbers, more than {MOST_VALUES}; read a part of it, or thin it out"
            )
        for axis, what in ((time, "times"), (place, "places")):
            check_axis(axis, what, self.name)
        if np.isinf(values).any():
            raise ConfigurationError(f"{self.name} holds infinite numbers; write gaps as nan or leave them empty")
        if not np.isfinite(values).any():
            raise ConfigurationError(f"{self.name} holds no number, only gaps; check what was read")
        for key, array in (("values", values), ("time", time), ("place", place)):
            own = array.view()
            own.setflags(write=False)
            object.__setattr__(self, key, own)
        object.__setattr__(self, "history", tuple(self.history))

    @property
    def unit(self) -> str:
        """Of the values."""
        return QUANTITIES[self.quantity].unit

    @property
    def label(self) -> str:
        """What an axis of the values says, with the unit."""
        known = QUANTITIES[self.quantity]
        return known.label if known.unit == "1" else f"{known.label} ({known.unit})"

    @property
    def gaps(self) -> float:
        """Share of the values that are missing."""
        return float(np.isnan(self.values).mean())

    @property
    def duration(self) -> float:
        """From the first to the last time [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def length(self) -> float:
        """From the first to the last place [mm]."""
        return float(self.place[-1] - self.place[0])

    @property
    def even_places(self) -> bool:
        """Whether the places are evenly spaced, as pixels are and channels of a catheter need not be."""
        return is_even(self.place)

    def time_step(self) -> float:
        """Time between two rows [s]. Raises ConfigurationError if it is not one and the same."""
        return _step(self.time, "times", "resample it first (treatment.resampled, --resample)", self.name)

    def place_step(self) -> float:
        """Distance of two columns [mm]. Raises ConfigurationError if it is not one and the same."""
        return _step(self.place, "places", "resample it first (treatment.resampled)", self.name)

    def done(self, line: str, **changes: Any) -> Map:
        """The same map with these changes, and a line more in its history."""
        return replace(self, history=(*self.history, line), **changes)

    def part(self, times: tuple[float, float] | None = None, places: tuple[float, float] | None = None) -> Map:
        """The part between two times [s] and two places [mm], both included."""
        rows = self._within(self.time, times, "times", "s")
        columns = self._within(self.place, places, "places", "mm")
        line = f"part: {_span(self.time[rows], 's')}, {_span(self.place[columns], 'mm')}"
        return self.done(line, values=self.values[rows, columns], time=self.time[rows], place=self.place[columns])

    def at(self, place: float) -> Numbers:
        """The course at a place [mm], linear between the two columns beside it; a gap in either is one."""
        if not self.place[0] <= place <= self.place[-1]:
            raise ConfigurationError(
                f"place = {place:g} mm is outside of {self.name}, which goes from {self.place[0]:g} to "
                f"{self.place[-1]:g} mm; choose one within"
            )
        right = int(np.clip(np.searchsorted(self.place, place), 1, max(1, self.place.size - 1)))
        if self.place.size == 1:
            return self.values[:, 0]
        share = (place - self.place[right - 1]) / (self.place[right] - self.place[right - 1])
        if share in (0.0, 1.0):
            return self.values[:, right - 1 + int(share)]
        return (1.0 - share) * self.values[:, right - 1] + share * self.values[:, right]

    def fingerprint(self) -> str:
        """SHA-256 of quantity, axes and values: equal maps have one, however they were stored."""
        digest = hashlib.sha256(f"{self.quantity} {self.values.shape}".encode())
        for array in (self.time, self.place, self.values):
            numbers = np.ascontiguousarray(array, dtype="<f8")
            digest.update(np.where(np.isnan(numbers), np.nan, numbers).tobytes())
        return digest.hexdigest()

    def __repr__(self) -> str:
        low, high = float(np.nanmin(self.values)), float(np.nanmax(self.values))
        head = f"<map {self.name}: {self.quantity} {low:.4g} to {high:.4g} {self.unit if self.unit != '1' else ''}"
        rows, columns = self.values.shape
        lines = [
            f"{head.rstrip()}>",
            f"  {rows} times over {self.duration:.6g} s, {columns} places over {self.length:.5g} mm, oral end first",
            *([f"  gaps: {100.0 * self.gaps:.2g} %"] if self.gaps else []),
            *(f"  {line}" for line in self.history),
        ]
        return "\n".join(lines)

    def _within(self, axis: Floats, span: tuple[float, float] | None, what: str, unit: str) -> slice:
        if span is None:
            return slice(0, axis.size)
        first, last = np.searchsorted(axis, span[0], "left"), np.searchsorted(axis, span[1], "right")
        if first >= last:
            raise ConfigurationError(
                f"{what} {span[0]:g} to {span[1]:g} {unit}: {self.name} has none of these but "
                f"{axis[0]:g} to {axis[-1]:g} {unit}; choose a span within"
            )
        return slice(int(first), int(last))


@dataclass(frozen=True, eq=False)
class Track:
    """Where a pellet was: positions [mm] from the oral end at rising times [s]; diameter [mm] where it is known."""

    time: Floats
    position: Floats
    name: str = "pellet"
    diameter: float | None = None
    history: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time, position = np.array(self.time, dtype=np.float64), np.array(self.position, dtype=np.float64)
        if time.ndim != 1 or time.shape != position.shape or time.size < 2:
            raise ConfigurationError(f"track {shown(self.name)} needs as many positions as times, two or more of each")
        check_axis(time, "times", f"track {shown(self.name)}")
        if not np.isfinite(position).all():
            raise ConfigurationError(f"track {shown(self.name)} holds positions that are no numbers; leave them out")
        for key, array in (("time", time), ("position", position)):
            array.setflags(write=False)
            object.__setattr__(self, key, array)


def check_axis(axis: Floats, what: str, name: str) -> None:
    """Raise ConfigurationError unless an axis is finite and rises."""
    if not np.isfinite(axis).all():
        raise ConfigurationError(f"{name}: entry {_first(~np.isfinite(axis))} of the {what} is no number; give one")
    falls = np.diff(axis) <= 0.0
    if falls.any():
        at = _first(falls)
        raise ConfigurationError(
            f"{name}: the {what} do not rise at entry {at + 1} ({axis[at - 1]:g}, then {axis[at]:g}); put them in order"
        )


def is_even(axis: Floats) -> bool:
    """Whether the steps of an axis are one and the same."""
    steps = np.diff(axis)
    return bool(steps.size and (np.abs(steps - np.median(steps)) <= EVEN * np.median(steps)).all())


def factor(unit: str, wanted: str, where: str) -> float:
    """The factor from a unit to another. Raises ConfigurationError naming `where`."""
    try:
        found = units.factor(unit, wanted)
    except units.QuantityError as error:
        raise ConfigurationError(f"{where}: {error}") from None
    return float(found)


def locked(array: Numbers) -> Numbers:
    """The same array, which nobody may write to any more, so that a map need not copy it."""
    array.setflags(write=False)
    return array


def _step(axis: Floats, what: str, fix: str, name: str) -> float:
    if not is_even(axis):
        problem = "has one alone" if axis.size < 2 else "has steps of different length"
        raise ConfigurationError(f"{name}: the axis of {what} {problem}; {fix}")
    return float((axis[-1] - axis[0]) / (axis.size - 1))


def _first(wrong: NDArray[np.bool_]) -> int:
    return int(np.flatnonzero(wrong)[0]) + 1


def _span(axis: Floats, unit: str) -> str:
    return f"{axis[0]:g} to {axis[-1]:g} {unit}"
