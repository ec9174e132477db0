"""Stimuli at listed times: each a line of text, or a row of a CSV file.

    longitudinal: 2 uA/cm^2 at 0.5 s for 50 ms over 0 cm to 0.3 cm
    circular: -1 uA/cm^2 at 2 s for 0.2 s over 4 cm to 6 cm around 90 deg by 45 deg

A stimulus is a current into the cells of a layer (inward positive) from a time on, for a time, over a stretch of the
undeformed tube, all around it unless an angle and the sector centred there are named. A file has one row a stimulus;
its first line names the columns with their units, such as
"onset [ms],duration [ms],strength [uA/cm^2],place [cm],width [cm],layer".
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from pathlib import Path

from .. import units
from ..errors import ConfigurationError, shown, suggestion
from ..paths import located
from . import tables

MOST_STIMULI = 100_000
MOST_WRITTEN = 1000
"""Stimuli that are written out in a configuration, one line each; more are kept by their content (`tables`)."""
LARGEST_FILE = 16_000_000
"""Bytes of a CSV file of stimuli."""
LONGEST_LINE = 400
LAYERS = ("longitudinal", "circular")
NUMBERS = ("onset", "duration", "strength", "low", "high", "angle", "sector")
STRENGTH = "uA/cm^2"
BOUNDS = {
    "onset": ("s", 0.0, 1e5),
    "duration": ("s", 0.0, 1e5),
    "strength": (STRENGTH, -1000.0, 1000.0),
    "place": ("cm", 0.0, 200.0),
    "width": ("cm", 0.0, 200.0),
    "angle": ("deg", -360.0, 360.0),
    "sector": ("deg", 0.0, 360.0),
}
"""Unit and bounds of what a stimulus is made of; durations, widths and sectors are more than 0."""
POSITIVE = ("duration", "width", "sector")
COLUMNS = ("onset", "duration", "strength", "place", "width", "layer", "angle", "sector")
NEEDED = COLUMNS[:4]

_EXAMPLE = "write for example 'longitudinal: 2 uA/cm^2 at 0.5 s for 50 ms over 0 cm to 0.3 cm'"
_HEADER = "begin with a line such as 'onset [s],duration [s],strength [uA/cm^2],place [cm]'"


@dataclass(frozen=True, slots=True)
class Stimulus:
    """A current [uA/cm^2] on a layer from `onset` on, for `duration` [s], over z in [low, high] [cm].

    Around the tube it covers `sector` centred at `angle` [deg].
    """

    layer: str
    onset: float
    duration: float
    strength: float
    low: float
    high: float
    angle: float = 0.0
    sector: float = 360.0

    def text(self) -> str:
        """The line of text that `read` reads back identically."""
        quantity = units.format_quantity
        line = (
            f"{self.layer}: {quantity(self.strength, STRENGTH)} at {quantity(self.onset, 's')} for "
            f"{quantity(self.duration, 's')} over {quantity(self.low, 'cm')} to {quantity(self.high, 'cm')}"
        )
        if (self.angle, self.sector) == (0.0, 360.0):
            return line
        return f"{line} around {quantity(self.angle, 'deg')} by {quantity(self.sector, 'deg')}"


def texts(stimuli: Sequence[Stimulus]) -> list[str]:
    """The lines of text that `read` reads back identically: one a stimulus, or the name of a table of many."""
    if len(stimuli) <= MOST_WRITTEN:
        return [one.text() for one in stimuli]
    return [f"table {_kept(tuple(stimuli))}"]


@lru_cache(maxsize=4)
def _kept(stimuli: tuple[Stimulus, ...]) -> str:
    import numpy as np

    rows = [(LAYERS.index(one.layer), *(getattr(one, name) for name in NUMBERS)) for one in stimuli]
    return tables.hold_list(np.array(rows, dtype=np.float64))


def _of_list(path: Path) -> list[Stimulus] | None:
    """The stimuli of a table that is kept by its content; None for another file."""
    rows = tables.list_of(path)
    if rows is None:
        return None
    found = [Stimulus(LAYERS[layer == 1.0], *numbers) for layer, *numbers in rows.tolist()]
    for number, one in enumerate(found, 1):
        numbers = {name: getattr(one, name) for name in ("onset", "duration", "strength", "angle", "sector")}
        for name, value in {**numbers, "place": one.low, "width": one.high - one.low}.items():
            _check(name, value, f"stimuli, {path.name[:20]}..., number {number}", repr(value))
    return found


def read(given: object, width: float) -> tuple[Stimulus, ...]:
    """Stimuli of a list of lines of text and of files, as {"file": "name.csv"} or "table name.csv".

    width: of a stimulus in a file without such a column [cm]. Raises ConfigurationError naming what is wrong.
    """
    items = [given] if isinstance(given, str | Mapping) else given
    if not isinstance(items, list | tuple):
        raise ConfigurationError(f"stimuli = {shown(given)}: not a list of lines of text; {_EXAMPLE}")
    found: list[Stimulus] = []
    for item in items[: MOST_STIMULI + 1]:
        if isinstance(item, Mapping):
            if item.keys() != {"file"} or not isinstance(item["file"], str):
                raise ConfigurationError(f"stimuli = {shown(dict(item))}: a table has the key file alone, a CSV's name")
            found += _of_file(located(item["file"]), width)
        elif isinstance(item, str) and item.strip().startswith("table "):
            path = located(item.strip().removeprefix("table ").strip())
            found += _of_list(path) or _of_file(path, width)
        else:
            found.append(_of_line(item))
    if len(found) > MOST_STIMULI:
        raise ConfigurationError(f"stimuli: more than {MOST_STIMULI}; give fewer, or a pacemaker.kind = periodic")
    return tuple(found)


def _of_line(line: object) -> Stimulus:
    if not isinstance(line, str) or len(line) > LONGEST_LINE:
        raise ConfigurationError(f"stimuli = {shown(line)}: not a line of text; {_EXAMPLE}")
    layer, colon, rest = line.partition(":")
    parts, words = [], [" at ", " for ", " over ", " to "]
    if " around " in rest:
        words += [" around ", " by "]
    for word in words:
        part, found, rest = rest.partition(word)
        if not (colon and found):
            raise ConfigurationError(f"stimuli = {shown(line)}: there is no '{word.strip()}' in its place; {_EXAMPLE}")
        parts.append(part.strip())
    parts.append(rest.strip())
    where = f"stimuli, {shown(line)}"
    strength, onset, duration, low, high = (
        _number(name, text, where)
        for name, text in zip(("strength", "onset", "duration", "place", "place"), parts[:5], strict=True)
    )
    if not low < high:
        raise ConfigurationError(f"{where}: from {low:g} cm to {high:g} cm is no stretch; give the oral place first")
    around = [_number(name, text, where) for name, text in zip(("angle", "sector"), parts[5:], strict=False)]
    return Stimulus(_layer(layer.strip(), where), onset, duration, strength, low, high, *around)


def _number(name: str, text: str, where: str) -> float:
    unit = BOUNDS[name][0]
    value = units.parse(text, unit, f"{where}: {name}")
    _check(name, value, where, text)
    return value


def _check(name: str, value: float, where: str, text: str) -> None:
    unit, low, high = BOUNDS[name]
    if not low <= value <= high or (name in POSITIVE and value == 0.0):
        least = f"more than {low:g}" if name in POSITIVE else f"at least {low:g}"
        raise ConfigurationError(f"{where}: {name} = {text} is out of range; give {least} and at most {high:g} {unit}")


def _layer(text: str, where: str) -> str:
    if text not in LAYERS:
        raise ConfigurationError(f"{where}: {shown(text)} is not a layer; {suggestion(text, LAYERS)}")
    return text


def _of_file(path: Path, width: float) -> list[Stimulus]:
    name = shown(str(path))
    try:
        if not path.is_file() and path.exists():
            raise ConfigurationError(f"stimuli: {name} is not a regular file; give the name of a CSV file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise ConfigurationError(f"stimuli: {name} is larger than {LARGEST_FILE} bytes; thin it out")
        text = io.StringIO(content.decode("utf-8-sig"), newline="")
        rows = [row for row in csv.reader(text) if any(cell.strip() for cell in row)]
    except (OSError, ValueError, csv.Error) as error:
        cause = error.strerror if isinstance(error, OSError) else "it is not a text file of UTF-8 CSV"
        raise ConfigurationError(f"stimuli: {name} cannot be read: {cause}; check the file") from None
    if len(rows) < 2:
        raise ConfigurationError(f"stimuli: {name} has no rows below a header; {_HEADER}")
    header = _columns(rows[0], name)
    return [_of_row(row, header, f"stimuli: {name}, row {number}", width) for number, row in enumerate(rows[1:], 1)]


def _columns(cells: list[str], name: str) -> list[tuple[str, str]]:
    """Name and unit of every column; the unit of `layer` is empty."""
    found: list[tuple[str, str]] = []
    for cell in cells:
        split = re.fullmatch(r"\s*([A-Za-z_]{1,40})\s*(?:\[([^\[\]]{1,40})\])?\s*", cell)
        if split is None or split.group(1) not in COLUMNS:
            known = suggestion(split.group(1) if split else cell, COLUMNS)
            raise ConfigurationError(f"stimuli: {name}: {shown(cell)} is no column of a stimulus; {known}")
        column, unit = split.group(1), split.group(2) or ""
        if column != "layer" and not unit:
            raise ConfigurationError(f"stimuli: {name}: column {column} has no unit; {_HEADER}")
        if column in [other for other, _ in found]:
            raise ConfigurationError(f"stimuli: {name}: column {column} is there twice; keep one")
        found.append((column, unit))
    for column in NEEDED:
        if column not in [other for other, _ in found]:
            raise ConfigurationError(f"stimuli: {name}: column {column} is missing; {_HEADER}")
    return found


def _of_cell(column: str, cell: str, unit: str, where: str) -> float:
    """A number of a row: as `_number` reads it, in a tenth of the time where the cell is plain."""
    if units.is_plain(cell):
        try:
            factor = _factor(unit, BOUNDS[column][0])
            value = float(cell)
            if value != 0.0 and factor != 1:  # exponents beyond those of a float are not for exact arithmetic
                value = float(Fraction(cell) * factor) if math.isfinite(value) else math.inf
        except (OverflowError, units.QuantityError):
            return _number(column, f"{cell} {unit}", where)
        _check(column, value, where, f"{cell} {unit}")
        return value + 0.0
    return _number(column, f"{cell} {unit}", where)


@lru_cache(maxsize=32)
def _factor(given: str, unit: str) -> Fraction:
    return units.factor(given, unit)


def _of_row(row: list[str], header: list[tuple[str, str]], where: str, width: float) -> Stimulus:
    if len(row) != len(header):
        raise ConfigurationError(f"{where} has {len(row)} cells and the header {len(header)}; give one a column")
    cells = {column: cell.strip() for (column, _), cell in zip(header, row, strict=True)}
    numbers = {column: _of_cell(column, cells[column], unit, where) for column, unit in header if column != "layer"}
    low = numbers["place"]
    return Stimulus(
        _layer(cells.get("layer", LAYERS[0]), where),
        numbers["onset"],
        numbers["duration"],
        numbers["strength"],
        low,
        low + numbers.get("width", width),
        numbers.get("angle", 0.0),
        numbers.get("sector", 360.0),
    )
