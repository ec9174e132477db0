"""What a user states of a file that does not say it itself: units, places, the oral end, the scale of a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigurationError, shown, suggestion
from .recording import QUANTITIES, Floats, Map, Numbers, factor, locked

ENDS = ("first", "last")
DIRECTIONS = ("right", "down")
OF_SOME_FILES = {
    **{
        key: f" (--{key.replace('_', '-')})"
        for key in ("positions", "variable", "mm_per_px", "s_per_px", "grey", "time")
    },
    **dict.fromkeys(("gap", "time_unit", "place_unit"), ""),
}
"""What may be stated of files of some kinds only, with its option in a command line."""


@dataclass(frozen=True)
class Stated:
    """What `read` may be told of a file; a file that says otherwise is overruled, and the history says so.

    quantity, unit: of the values. oral: whether the first or the last place of the file is the oral end. positions:
    places of the channels [mm]. variable: which array of a file with several. time_unit, place_unit: of axes without.
    mm_per_px, s_per_px, grey, gap, time: of a picture: its scale, two grey values with their meanings, the grey value
    that is a gap, and whether time runs right or down. name: what the map is called.
    """

    quantity: str | None = None
    unit: str | None = None
    oral: str = "first"
    positions: Sequence[float] | None = None
    variable: str | None = None
    time_unit: str | None = None
    place_unit: str | None = None
    mm_per_px: float | None = None
    s_per_px: float | None = None
    grey: tuple[tuple[float, float], tuple[float, float]] | None = None
    gap: int | None = None
    time: str | None = None
    name: str | None = None

    def __post_init__(self) -> None:
        if self.oral not in ENDS:
            raise ConfigurationError(
                f"oral = {shown(self.oral)}: the oral end is the first or the last place; say which"
            )
        if self.time is not None and self.time not in DIRECTIONS:
            raise ConfigurationError(f"time = {shown(self.time)}: time runs right or down in a picture; say which")
        if self.quantity is not None and self.quantity not in QUANTITIES:
            raise ConfigurationError(
                f"quantity = {shown(self.quantity)} is not known; {suggestion(self.quantity, QUANTITIES)}"
            )
        for key in ("mm_per_px", "s_per_px"):
            value = getattr(self, key)
            if value is not None and not 0.0 < value < 1e6:
                raise ConfigurationError(f"{key} = {shown(value)} is no scale; give a number above 0")


def stated(given: dict[str, Any]) -> Stated:
    """What was given by name. Raises ConfigurationError for a name that is none."""
    known = [one.name for one in fields(Stated)]
    for key in given:
        if key not in known:
            raise ConfigurationError(f"read has no option {shown(key)}; {suggestion(key, known)}")
    return Stated(**given)


def finished(
    path: Path,
    values: Numbers,
    time: Floats,
    place: Floats,
    found: tuple[str | None, str | None],
    said: Stated,
    history: Sequence[str] = (),
    used: Sequence[str] = (),
) -> Map:
    """The map of what a reader found: quantity settled, the oral end first, values in the unit of the quantity.

    values: (n_time, n_place). time [s], place [mm], as in the file. found: quantity and unit that the file states.
    used: which of `OF_SOME_FILES` a file of this kind has a use for; the history says so of others that were given.
    Raises ConfigurationError if neither file nor user states quantity and unit.
    """
    name = said.name or path.stem
    quantity, unit = said.quantity or found[0], said.unit or found[1]
    if quantity is None:
        raise ConfigurationError(
            f"{shown(str(path))} does not say what its numbers are; say quantity = diameter (--quantity), one of "
            f"{', '.join(QUANTITIES)}"
        )
    wanted = QUANTITIES[quantity].unit if quantity in QUANTITIES else "1"
    if unit is None and wanted != "1":
        raise ConfigurationError(
            f"{shown(str(path))} does not say the unit of its numbers; say unit = {wanted} (--unit), for example"
        )
    lines = [*history] or [f"read from {path.name}"]
    lines += [
        f"{key}{option}, as stated, has no meaning for this file: not used"
        for key, option in OF_SOME_FILES.items()
        if key not in used and getattr(said, key) is not None
    ]
    if said.unit is not None and found[1] is not None and said.unit != found[1]:
        lines.append(f"unit {said.unit}, as stated, in place of {found[1]} of the file")
    if unit is not None and unit != wanted:
        by = factor(unit, wanted, f"{shown(str(path))}, unit of the values")
        values = values * values.dtype.type(by) if values.dtype == np.float32 else values * by
        lines.append(f"values in {wanted}: {by:.9g} times those in {unit}")
    if place.size > 1 and (np.diff(place) < 0.0).all():
        values, place = values[:, ::-1], place[::-1]
        lines.append("columns in the order of their places")
    if said.oral == "last":
        values, place = values[:, ::-1], (place[0] + place[-1] - place)[::-1]
        lines.append("turned around: the oral end was last")
    return Map(locked(values), time, place, quantity, name, tuple(lines))
