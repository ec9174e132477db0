"""Regions from the tables of a file, or from Python; what is wrong with them is one line."""

from __future__ import annotations

import csv
import errno
import operator
import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields
from itertools import pairwise
from numbers import Integral
from typing import Any

from ...errors import ConfigurationError, UnknownKeyError, shown, suggestion
from ...paths import located
from ...storing.disk import read_regular
from ...units import DIMENSIONLESS, QuantityError
from ...units import read as read_quantity
from .shapes import Map
from .specification import (
    CIRCULAR_ONLY,
    LARGEST_FACTOR,
    LAYERS,
    MOST_REGIONS,
    MOST_VALUES,
    SHAPES,
    WIDEST_EDGE,
    Region,
    quantities,
)

LARGEST_FILE = 1_000_000
"""Bytes of a CSV map."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,63}")
_EXAMPLE = (
    "write for example [[regions]] with name = 'patch', shape = 'band', z_from = '4 cm', z_to = '6 cm', active = 0.5"
)
_HEADER = "begin with a line such as 'z [cm] / angle [deg],0,90,180,270', then one line a place"


def read(given: object) -> tuple[Region, ...]:
    """The regions of a list of tables. Raises ConfigurationError naming region, cause and fix."""
    given = _listed(given)
    if not isinstance(given, list | tuple):
        raise ConfigurationError(f"regions = {shown(given)}: not a list of tables; {_EXAMPLE}")
    if len(given) > MOST_REGIONS:
        raise ConfigurationError(f"regions: {len(given)} are too many; give at most {MOST_REGIONS}")
    regions = tuple(_region(item, number) for number, item in enumerate(given, start=1))
    names = [region.name for region in regions]
    for name in names:
        if names.count(name) > 1:
            raise ConfigurationError(f"regions: {name} is the name of two of them; give each its own")
    size = sum(len(region.shape.z) * len(region.shape.angle) for region in regions if isinstance(region.shape, Map))
    if size > MOST_VALUES:
        raise ConfigurationError(f"regions: maps of {size} values are too large; keep to {MOST_VALUES} in all")
    return regions


def _region(given: object, number: int) -> Region:
    if isinstance(given, Region):
        return given
    if not isinstance(given, Mapping):
        raise ConfigurationError(f"regions, number {number} = {shown(given)}: not a table; {_EXAMPLE}")
    name = given.get("name")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ConfigurationError(
            f"regions, number {number}: name = {shown(name)} is not a name; use letters, digits, spaces, - and _"
        )
    where = f"regions: {name}"
    shape = _choice(given.get("shape"), SHAPES, f"{where}: shape")
    layer = _choice(given.get("layer", "both"), LAYERS, f"{where}: layer")
    own = {"file", "quantities", *_names(Map)} if shape == "map" else {"edge", *_names(SHAPES[shape]), *quantities()}
    for key in given:
        if key not in own | {"name", "layer", "shape"}:
            raise UnknownKeyError(f"{where}: {shown(key)} is no key of a {shape}; {_near(key, own)}")
    if shape == "map":
        region = Region(name, layer, _map(given, where), 0.0, _quantities(given.get("quantities"), where))
    else:
        edge = _bounded(given.get("edge", "0 cm"), "cm", {"ge": 0.0, "le": WIDEST_EDGE}, f"{where}: edge")
        kind: type[Any] = SHAPES[shape]
        values = {about.name: _number_of(given, about, where) for about in fields(kind)}
        region = Region(name, layer, kind(**values), edge, _factors(given, where))
    if not region.factors:
        raise ConfigurationError(f"{where}: it changes nothing; give a factor such as active = 0.5")
    for quantity, _ in region.factors:
        if quantity in CIRCULAR_ONLY and layer == "longitudinal":
            raise ConfigurationError(
                f"{where}: {quantity} belongs to the circular layer, and layer = longitudinal; use circular or both"
            )
    return region


def _near(key: object, known: Iterable[str]) -> str:
    if key == "chloride":
        return "the chloride conductance is called leak"
    return suggestion(key, sorted(known)) if isinstance(key, str) else "keys are text"


def _names(shape: type[Any]) -> set[str]:
    return {about.name for about in fields(shape)}


def _choice(value: object, known: Iterable[str], where: str) -> str:
    names = tuple(known)
    if not isinstance(value, str) or value not in names:
        fix = suggestion(value, names) if isinstance(value, str) else f"choose one of {', '.join(names)}"
        raise ConfigurationError(f"{where} = {shown(value)}: not one of {', '.join(names)}; {fix}")
    return value


def _number_of(given: Mapping[Any, Any], about: Field[Any], where: str) -> float | int:
    unit, bounds = about.metadata["unit"], about.metadata["bounds"]
    if about.name not in given:
        if about.default is not MISSING:
            default: float = about.default
            return default
        example = f"'1 {unit}'" if unit else "3"
        raise ConfigurationError(f"{where}: {about.name} is missing; give it, for example {about.name} = {example}")
    value, key = given[about.name], f"{where}: {about.name}"
    if unit:
        return _bounded(value, unit, bounds, key)
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise ConfigurationError(f"{key} = {shown(value)}: not a whole number; give one such as 3")
    return _within(operator.index(value), "", bounds, key)


def _bounded(value: object, unit: str, bounds: Mapping[str, float], key: str) -> float:
    try:
        number = read_quantity(value, unit)
    except QuantityError as error:
        raise ConfigurationError(f"{key} = {shown(value)}: {error}") from None
    return _within(number, unit, bounds, key)


def _within(number: Any, unit: str, bounds: Mapping[str, float], key: str) -> Any:
    low, high = bounds.get("ge", bounds.get("gt", -float("inf"))), bounds["le"]
    if low <= number <= high and not ("gt" in bounds and number == low):
        return number
    words = f"more than {low:g}" if "gt" in bounds else f"at least {low:g}"
    unit = "" if unit in ("", DIMENSIONLESS) else f" {unit}"
    raise ConfigurationError(
        f"{key} = {shown(number)}{unit}: out of range; give a value of {words} and at most {high:g}{unit}"
    )


def _factor(value: object, key: str) -> float:
    return _bounded(value, DIMENSIONLESS, {"ge": 0.0, "le": LARGEST_FACTOR}, key)


def _factors(given: Mapping[Any, Any], where: str) -> tuple[tuple[str, float], ...]:
    return tuple((name, _factor(given[name], f"{where}: {name}")) for name in quantities() if name in given)


def _quantities(given: object, where: str) -> tuple[tuple[str, float], ...]:
    """What a map multiplies, in the order of QUANTITIES."""
    listed = [given] if isinstance(given, str) else given
    if not isinstance(listed, list | tuple) or not listed:
        raise ConfigurationError(
            f"{where}: quantities = {shown(given)}: a map names what it multiplies; give for example ['active']"
        )
    for quantity in listed:
        _choice(quantity, quantities(), f"{where}: quantities")
    return tuple((name, 1.0) for name in quantities() if name in listed)


# --- maps -----------------------------------------------------------------------------------------


def _map(given: Mapping[Any, Any], where: str) -> Map:
    inline = [key for key in ("z", "angle", "values") if key in given]
    if "file" in given:
        if inline:
            raise ConfigurationError(f"{where}: file and {inline[0]} are both given; keep one of them")
        places: object
        angles: object
        rows: object
        places, angles, rows = _read_file(given["file"], where)
    elif len(inline) < 3:
        missing = next(key for key in ("z", "angle", "values") if key not in given)
        raise ConfigurationError(f"{where}: {missing} is missing; a map has a file, or z, angle and values")
    else:
        places, angles, rows = _listed(given["z"]), _listed(given["angle"]), _listed(given["values"])
    z = _axis(places, "cm", {"ge": 0.0, "le": 200.0}, f"{where}: z")
    angle = _axis(angles, "deg", {"ge": -360.0, "le": 360.0}, f"{where}: angle")
    if angle[-1] - angle[0] >= 360.0:
        raise ConfigurationError(
            f"{where}: angle spans {angle[-1] - angle[0]:g} deg; the ring closes by itself, so leave out the last one"
        )
    if not isinstance(rows, list | tuple) or len(rows) != len(z):
        count = len(rows) if isinstance(rows, list | tuple) else shown(rows)
        raise ConfigurationError(f"{where}: values has {count} rows and z {len(z)} places; give one row a place")
    if len(z) * len(angle) > MOST_VALUES:
        raise ConfigurationError(f"{where}: {len(z)} x {len(angle)} values are too many; keep to {MOST_VALUES}")
    table = []
    for number, row in enumerate(rows, start=1):
        listed = _listed(row)
        if not isinstance(listed, list | tuple) or len(listed) != len(angle):
            count = len(listed) if isinstance(listed, list | tuple) else shown(listed)
            raise ConfigurationError(
                f"{where}: row {number} has {count} values and angle {len(angle)}; give one value an angle"
            )
        table.append(tuple(_factor(value, f"{where}: values, row {number}") for value in listed))
    return Map(z, angle, tuple(table))


def _listed(value: object) -> object:
    """Arrays as nested lists; anything else as it is."""
    to_list = getattr(value, "tolist", None)
    return to_list() if callable(to_list) else value


def _axis(given: object, unit: str, bounds: Mapping[str, float], key: str) -> tuple[float, ...]:
    if not isinstance(given, list | tuple) or not given:
        raise ConfigurationError(f"{key} = {shown(given)}: not a list; give for example ['1 {unit}', '2 {unit}']")
    if len(given) > MOST_VALUES:
        raise ConfigurationError(f"{key}: {len(given)} values are too many; keep to {MOST_VALUES}")
    values = tuple(_bounded(value, unit, bounds, key) for value in given)
    if any(later <= earlier for earlier, later in pairwise(values)):
        raise ConfigurationError(f"{key}: the values do not rise; put them in order, each once")
    return values


def _read_file(given: object, where: str) -> tuple[list[str], list[str], list[list[float]]]:
    """Places and angles with their units, and the rows, of a CSV file."""
    if not isinstance(given, str):
        raise ConfigurationError(f"{where}: file = {shown(given)}: give the name of a CSV file as text")
    name, path = shown(given), located(given)
    try:
        content = read_regular(path, LARGEST_FILE, follow=True)
        lines = content.decode("utf-8-sig").splitlines()
        rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except (OSError, ValueError, csv.Error) as error:
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            raise ConfigurationError(f"{where}: {name} is larger than {LARGEST_FILE} bytes; thin it out") from None
        cause = error.strerror if isinstance(error, OSError) else "it is not a text file of UTF-8 CSV"
        raise ConfigurationError(f"{where}: {name} cannot be read: {cause}; check the file") from None
    units = re.findall(r"\[([^\[\]]{1,20})\]", rows[0][0]) if rows else []
    if len(rows) < 2 or len(rows[0]) < 2 or len(units) != 2:
        raise ConfigurationError(f"{where}: {name} has no header with both units, angles and places; {_HEADER}")
    values = []
    for number, row in enumerate(rows[1:], start=2):
        try:
            values.append([float(cell) for cell in row[1:]])
        except ValueError:
            raise ConfigurationError(f"{where}: {name}, line {number} holds no plain numbers; {_HEADER}") from None
    places = [f"{row[0].strip()} {units[0]}" for row in rows[1:]]
    return places, [f"{cell.strip()} {units[1]}" for cell in rows[0][1:]], values
