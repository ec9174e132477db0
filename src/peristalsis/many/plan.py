"""A batch as a file describes it: what all runs share, and either a grid of values or a list of points.

scenario = "baseline"                # optional, as are reading and changes
[changes]
run.duration = "3 s"
[grid]                               # every combination, or instead [[points]], each with its own values
pellet.viscous_friction = ["60 mN*s/cm", "120 mN*s/cm"]
reading = ["tight", "stretched"]
"""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

from .. import scenarios
from ..errors import ConfigurationError, ReadingNotFound, ScenarioNotFound, UnknownKeyError, shown, suggestion
from ..inputs.config import KEYS, read_toml
from .rows import Point

MOST_POINTS = 10_000
LARGEST_FILE = 1024 * 1024
"""Bytes of a batch file."""

TABLES = ("scenario", "reading", "changes", "grid", "points")
LONGEST_NAME = 120
"""Characters of the name of a point of a grid, which is made of its values."""
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,39}")


@dataclass(frozen=True)
class Plan:
    """The points of a batch in the order of the file, and the keys in which they differ."""

    points: tuple[Point, ...]
    keys: tuple[str, ...] = field(default=())


def read_plan(source: str | PathLike[str]) -> Plan:
    """The plan in a TOML file (a Path) or TOML text (a str). Raises ConfigurationError before anything is run.

    A name that no parameter, reading or scenario has spoils the file; values that are refused spoil their point only.
    """
    tables = read_toml(source, LARGEST_FILE)
    for name in tables:
        if name not in TABLES:
            raise ConfigurationError(f"{shown(name)} is no part of a batch; {suggestion(name, TABLES)}")
    base = flat_changes(tables.get("changes", {}), "changes")
    for name in ("scenario", "reading"):
        if name in tables:
            base[name] = tables[name]
    named = list(_points(tables))
    points = tuple(_point(name, {**base, **values}, values) for name, values in named)
    if points and all(point.configuration is None for point in points):
        raise ConfigurationError(f"every point of the batch is refused, the first one: {points[0].refusal}")
    return Plan(points, tuple(dict.fromkeys(key for _, values in named for key in values)))


def _points(tables: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and values of every point."""
    if ("grid" in tables) == ("points" in tables):
        raise ConfigurationError("a batch has either a table [grid] or tables [[points]]; give one of the two")
    if "grid" in tables:
        yield from _grid(flat_changes(tables["grid"], "grid"))
        return
    points = tables["points"]
    if not isinstance(points, list) or not points:
        raise ConfigurationError("points: not a list of tables; write [[points]] above each")
    _count(len(points))
    seen: set[str] = set()
    for number, point in enumerate(points, 1):
        values = flat_changes(point, f"points, number {number}")
        name = values.pop("name", "run")
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise ConfigurationError(
                f"points, number {number}, name = {shown(name)}: a name has lower-case letters, digits, - and _, at "
                "most 40; choose such a name"
            )
        if name != "run" and name in seen:
            raise ConfigurationError(f"points: the name {name} is given twice; keep one")
        seen.add(name)
        yield name, values


def _grid(axes: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    if not axes:
        raise ConfigurationError("grid: no parameter is varied; give at least one with a list of values")
    for key, values in axes.items():
        if not isinstance(values, list) or not values:
            raise ConfigurationError(f"grid: {shown(key)} = {shown(values)}: give a list of its values")
    _count(math.prod(len(values) for values in axes.values()))
    short = [key.rpartition(".")[2] for key in axes]
    labels = [key if short.count(last) > 1 else last for key, last in zip(axes, short, strict=True)]
    for chosen in itertools.product(*axes.values()):
        name = ", ".join(f"{label} = {as_text(value)}" for label, value in zip(labels, chosen, strict=True))
        yield (
            name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 3]}...",
            dict(zip(axes, chosen, strict=True)),
        )


def _count(points: int) -> None:
    if points > MOST_POINTS:
        raise ConfigurationError(f"the batch has {points} points, more than {MOST_POINTS}; divide it")


def _point(name: str, given: dict[str, Any], values: Mapping[str, Any]) -> Point:
    changes = dict(given)
    scenario, reading = changes.pop("scenario", None), changes.pop("reading", None)
    try:
        for key, value in (("scenario", scenario), ("reading", reading)):
            if not isinstance(value, str | None):
                raise UnknownKeyError(f"{key} = {shown(value)}: give a name as text")
        return Point(name, values, scenarios.configuration(scenario, reading=reading, changes=changes))
    except (UnknownKeyError, ReadingNotFound, ScenarioNotFound):
        raise
    except ConfigurationError as error:
        return Point(name, values, refusal=str(error))


def flat_changes(tree: Any, where: str) -> dict[str, Any]:
    """Dotted key to value of a table of tables; every key is one of a parameter."""
    if not isinstance(tree, Mapping):
        raise ConfigurationError(f"{where}: {shown(tree)} is not a table of parameters; give keys with values")
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        inner = {f"{name}.{key}": one for key, one in value.items()} if isinstance(value, Mapping) else {name: value}
        for key, one in inner.items():
            if key in flat:
                raise ConfigurationError(f"{where}: {key} is given twice; keep one")
            if key not in KEYS and not (key == "name" and where.startswith("points")):
                if where == "grid" and f"grid.{key}" in KEYS:
                    raise UnknownKeyError(
                        f"grid: {shown(key)} is not a parameter. The table [grid] of a batch lists parameters by their "
                        f"whole names, each with its values; for the parameter write there "
                        f'"grid.{key}" = [...], or in [changes] grid.{key} = ... for all points'
                    )
                raise UnknownKeyError(f"{where}: {shown(key)} is not a parameter; {suggestion(key, KEYS)}")
            flat[key] = one
    return flat


def as_text(value: Any) -> str:
    """A value as one cell of a table."""
    if isinstance(value, str):
        return value
    return json.dumps(value) if isinstance(value, bool | Sequence) else repr(value)
