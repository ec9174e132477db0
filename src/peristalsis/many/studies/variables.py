"""What a study varies: a name, the parameters behind it, and their values, range or distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import units
from ...errors import ConfigurationError, UnknownKeyError, shown, suggestion
from ...inputs.config import FIELDS, KEYS, Configuration
from .distributions import DISTRIBUTIONS, Distribution

Floats = NDArray[np.float64]

WORDS = ("keys", "relative", "values", "from", "to", "scale", "count", "distribution", "source")
"""What a table of a parameter may hold besides the numbers of its distribution."""
NUMBERS = ("mean", "deviation", "median", "spread")
CHOICES = ("scenario", "reading")
"""What can be varied without being a parameter."""


@dataclass(frozen=True)
class Variable:
    """One quantity of a study.

    keys: parameters that get the same value. unit: of numbers, 1 for factors. relative: numbers are factors of what
    each parameter is otherwise. values: those listed, or none. distribution: of numbers, or None where values are
    listed. count: levels of a range on a grid. source: where the distribution comes from.
    """

    name: str
    keys: tuple[str, ...]
    unit: str = units.DIMENSIONLESS
    relative: bool = False
    values: tuple[Any, ...] = ()
    distribution: Distribution | None = None
    count: int | None = None
    source: str = ""

    @property
    def label(self) -> str:
        """The name with its unit."""
        unit = "times" if self.relative else self.unit
        return self.name if unit == units.DIMENSIONLESS else f"{self.name} [{unit}]"

    def levels(self, count: int | None = None) -> tuple[Any, ...]:
        """The values on a grid: those listed, or so many from end to end of the range, evenly on its scale.

        Raises ConfigurationError for a distribution without ends, and for a range without a count.
        """
        if self.distribution is None:
            return self.values
        wanted = count or self.count
        if wanted is None:
            raise ConfigurationError(f"{self.name}: a grid needs the number of levels; give count = 5, or values")
        return tuple(float(one) for one in self.distribution.levels(wanted, self.name))

    def drawn(self, shares: Floats) -> list[Any]:
        """The values at shares in [0, 1) of the distribution; of listed values, all are equally likely."""
        if self.distribution is None:
            return [self.values[min(int(share * len(self.values)), len(self.values) - 1)] for share in shares]
        return [float(one) for one in self.distribution.quantiles(np.asarray(shares))]

    def changes(self, value: Any, base: Configuration) -> dict[str, Any]:
        """The parameters with this value, as they would stand in a file. base: what factors are of."""
        if not isinstance(value, float):
            return dict.fromkeys(self.keys, value)
        found: dict[str, Any] = {}
        for key in self.keys:
            number = value * float(_number(base, key)) if self.relative else value
            field = FIELDS[key]
            if field.kind == "integer":
                found[key] = round(number)
            else:
                found[key] = number if field.unit == units.DIMENSIONLESS else f"{number!r} {field.unit}"
        return found


def _number(base: Configuration, key: str) -> float:
    value = base.flat()[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigurationError(f"{key} = {shown(value)} is no number; relative = true is for numbers")
    return value


def read_variables(tree: Mapping[str, Any]) -> tuple[Variable, ...]:
    """The variables of a table [parameters]; the name of one is a parameter, or it lists its parameters as keys."""
    found = tuple(_variable(name, table) for name, table in _tables(tree, ""))
    if not found:
        raise ConfigurationError("parameters: nothing is varied; give at least one with values or a range")
    names = [one.name for one in found]
    keys = [key for one in found for key in one.keys]
    for listed in (names, keys):
        for one in listed:
            if listed.count(one) > 1:
                raise ConfigurationError(f"parameters: {one} is varied twice; keep one")
    return found


def _tables(tree: Mapping[str, Any], head: str) -> list[tuple[str, Any]]:
    """Name and table of every variable; `pellet.radius = ...` and `"pellet.radius" = ...` are the same."""
    found: list[tuple[str, Any]] = []
    for name, inner in tree.items():
        whole = f"{head}.{name}" if head else name
        nested = isinstance(inner, Mapping) and inner and all(isinstance(one, Mapping | list) for one in inner.values())
        if nested and not set(inner) & {"keys", "values"}:
            found += _tables(inner, whole)
        else:
            found.append((whole, inner))
    return found


def _variable(name: str, table: Any) -> Variable:
    if isinstance(table, list):
        table = {"values": table}
    if not isinstance(table, Mapping):
        raise ConfigurationError(f"parameters: {name} = {shown(table)}: give a list of values or a table with a range")
    for word in table:
        if word not in WORDS and word not in NUMBERS:
            raise ConfigurationError(
                f"parameters: {name}: {shown(word)} is not known there; {suggestion(word, [*WORDS, *NUMBERS])}"
            )
    keys = _keys(name, table)
    relative = table.get("relative", False)
    if not isinstance(relative, bool):
        raise ConfigurationError(f"parameters: {name}: relative = {shown(relative)}: give true or false")
    unit = units.DIMENSIONLESS if relative else _unit(name, keys)
    source = table.get("source", "")
    if not isinstance(source, str):
        raise ConfigurationError(f"parameters: {name}: source = {shown(source)}: give text")
    if "values" in table:
        surplus = sorted(set(table) - {"keys", "values", "relative", "source"})
        if surplus:
            raise ConfigurationError(f"parameters: {name} has values and {surplus[0]}; keep one of them")
        return Variable(name, keys, unit, relative, _values(name, table["values"], keys, unit, relative), source=source)
    count = table.get("count")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or count < 1):
        raise ConfigurationError(f"parameters: {name}: count = {shown(count)}: give a number of levels from 1")
    return Variable(name, keys, unit, relative, (), _distribution(name, table, unit), count, source)


def _keys(name: str, table: Mapping[str, Any]) -> tuple[str, ...]:
    given = table.get("keys", [name])
    keys = [given] if isinstance(given, str) else given
    if not isinstance(keys, list) or not keys or not all(isinstance(key, str) for key in keys):
        raise ConfigurationError(f"parameters: {name}: keys = {shown(given)}: give a list of parameters")
    for key in keys:
        if key not in KEYS and key not in CHOICES:
            more = "" if "keys" in table else "; a name of your own needs keys = [...]"
            raise UnknownKeyError(f"parameters: {shown(key)} is not a parameter; {suggestion(key, KEYS)}{more}")
    return tuple(keys)


def _unit(name: str, keys: Sequence[str]) -> str:
    found = {FIELDS[key].unit if key in FIELDS else units.DIMENSIONLESS for key in keys}
    if len(found) > 1:
        raise ConfigurationError(
            f"parameters: {name} ties parameters in {' and '.join(sorted(found))}; tie them with relative = true"
        )
    return found.pop()


def _values(name: str, given: Any, keys: Sequence[str], unit: str, relative: bool) -> tuple[Any, ...]:
    if not isinstance(given, list) or not given:
        raise ConfigurationError(f"parameters: {name}: values = {shown(given)}: give a list of them")
    number = relative or all(key in FIELDS and FIELDS[key].kind in ("number", "integer") for key in keys)
    found = tuple(units.parse(one, unit, f"parameters: {name}") if number else one for one in given)
    if len(set(map(repr, found))) < len(found):
        raise ConfigurationError(f"parameters: {name}: a value is listed twice; keep one")
    return found


def _distribution(name: str, table: Mapping[str, Any], unit: str) -> Distribution:
    """The distribution of a table; one that has only ends is uniform on its scale."""
    scale = table.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise ConfigurationError(f"parameters: {name}: scale = {shown(scale)}: choose linear or log")
    kind = table.get("distribution", "loguniform" if scale == "log" else "uniform")
    if kind not in DISTRIBUTIONS:
        raise ConfigurationError(
            f"parameters: {name}: distribution = {shown(kind)}; {suggestion(str(kind), DISTRIBUTIONS)}"
        )
    if "scale" in table and "distribution" in table:
        raise ConfigurationError(f"parameters: {name}: a distribution has its scale; leave scale out")
    numbers: dict[str, float] = {}
    for word in ("from", "to", *NUMBERS):
        if word in table:
            numbers[word] = units.parse(
                table[word], units.DIMENSIONLESS if word == "spread" else unit, f"{name}.{word}"
            )
    made = Distribution(kind, **{"low" if k == "from" else "high" if k == "to" else k: v for k, v in numbers.items()})
    made.check(f"parameters: {name}")
    if not all(math.isfinite(one) for one in numbers.values()):
        raise ConfigurationError(f"parameters: {name}: a number is not finite; give finite ones")
    return made
