"""Every number the package ships, with its unit, its tag and its source.

One TOML file per source: ``[source]`` says what is cited, each further table is one parameter.
``readings.toml`` holds the named readings: sets of numbers where the paper contradicts itself. A preparation
is a file of its own: the numbers of a gut that was measured, which a scenario lays over the others.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args

from peristalsis.errors import ReadingNotFound, shown, suggestion

Tag = Literal["printed", "corrected", "sourced", "chosen", "calibrated", "fitted"]
Value = float | int | bool | str | tuple[float, ...] | tuple[str, ...]

_FOLDER = Path(__file__).parent
_FILES = ("al_qatrawi_miftahof", "plant_1981", "tong_fung_1976", "chosen")
_PREPARATIONS = ("guinea_pig_distal_colon", "rabbit_progressive_wave")


@dataclass(frozen=True, slots=True)
class Parameter:
    """One shipped value.

    `unit` is "1" for dimensionless numbers and empty for switches and names.  `printed` is what the paper
    prints where its unit or its value was in doubt, and empty otherwise. `low` and `high` bound what the source lets it
    be, in its unit, and are None where it says nothing.
    """

    key: str
    value: Value
    unit: str
    tag: Tag
    source: str
    description: str
    printed: str = ""
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class Source:
    """What is cited, and the parameters taken from it."""

    name: str
    short: str
    citation: str
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True, slots=True)
class Preparation:
    """A measured gut: its name, title, what was fitted on what, and its numbers.

    citation: all that its numbers are from. fitted: keys of those that were fitted.
    """

    name: str
    short: str
    title: str
    citation: str
    fitted_on: str
    parameters: Mapping[str, Parameter]

    @property
    def fitted(self) -> tuple[str, ...]:
        """Keys of the numbers that were calibrated."""
        return tuple(key for key, about in self.parameters.items() if about.tag == "calibrated")

    def changes(self) -> dict[str, Any]:
        """Its numbers as they would stand in a configuration file."""
        return {key: written(about) for key, about in self.parameters.items()}


def written(about: Parameter) -> Any:
    """The value of a parameter as it would stand in a configuration file."""
    value = about.value
    if about.unit in ("", "1") or isinstance(value, bool | str):
        return value
    if isinstance(value, tuple):
        return [f"{item!r} {about.unit}" for item in value]
    return f"{value!r} {about.unit}"


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read the numbers of the paper that contradict each other."""

    name: str
    why: str
    parameters: Mapping[str, Parameter]


def shipped(reading: str = "tight") -> Mapping[str, Parameter]:
    """All parameters by key, under one reading of the paper."""
    if reading not in READINGS:
        raise ReadingNotFound(f"reading = {shown(reading)}: no such reading; {suggestion(reading, READINGS)}")
    return _shipped(reading)


@lru_cache(maxsize=8)
def _shipped(reading: str) -> Mapping[str, Parameter]:
    merged: dict[str, Parameter] = {}
    for source in SOURCES.values():
        merged.update(source.parameters)
    merged.update(READINGS[reading].parameters)
    return MappingProxyType(merged)


def _load_source(name: str) -> Source:
    tables = _tables(name)
    about = tables.pop("source")
    parameters = {key: _parameter(name, key, table, about["short"]) for key, table in tables.items()}
    return Source(name, about["short"], about["citation"], MappingProxyType(parameters))


def _load_readings(sources: Mapping[str, Source]) -> dict[str, Reading]:
    readings = {}
    for name, table in _tables("readings").items():
        why = table.pop("why")
        parameters = {}
        for key, entry in table.items():
            if "from" in entry:  # the number is written once, in the file of its source
                parameters[key] = sources[entry["from"]].parameters[key]
            else:
                parameters[key] = _parameter("readings", key, entry, f"reading '{name}'")
        readings[name] = Reading(name, why, MappingProxyType(parameters))
    return readings


def _load_preparation(name: str) -> Preparation:
    tables = _tables(name)
    about = tables.pop("preparation")
    known = shipped()
    parameters = {}
    for key, table in tables.items():
        if key not in known:
            raise ValueError(f"{name}.toml: {key} is no parameter of the package")
        low, high = table.get("range", (None, None))
        one = _parameter(name, key, {"description": known[key].description, **table}, about["short"])
        if isinstance(one.value, float | int) and low is not None and not low <= one.value <= high:
            raise ValueError(f"{name}.toml: {key} = {one.value} is not within its range {low}...{high}")
        parameters[key] = replace(one, low=low, high=high)
    return Preparation(
        name, about["short"], about["title"], about["citation"], about["fitted_on"], MappingProxyType(parameters)
    )


def _tables(name: str) -> dict[str, Any]:
    with (_FOLDER / f"{name}.toml").open("rb") as file:
        return tomllib.load(file)


def _parameter(file: str, key: str, table: dict[str, Any], cited: str) -> Parameter:
    value = table["value"]
    tag = table["tag"]
    if tag not in get_args(Tag):
        raise ValueError(f"{file}.toml: {key} has tag {shown(tag)}; {suggestion(str(tag), get_args(Tag))}")
    return Parameter(
        key=key,
        value=_items(value) if isinstance(value, list) else value,
        unit=table.get("unit", ""),
        tag=tag,
        source=f"{cited}: {table['source']}",
        description=table["description"],
        printed=table.get("printed", ""),
    )


def _items(values: list[Any]) -> tuple[float, ...] | tuple[str, ...]:
    if all(isinstance(item, str) for item in values):
        return tuple(values)
    return tuple(float(item) for item in values)


def _disjoint(sources: Mapping[str, Source]) -> Mapping[str, Source]:
    owner: dict[str, str] = {}
    for source in sources.values():
        for key in source.parameters:
            if key in owner:
                raise ValueError(f"{key} is given by {owner[key]}.toml and by {source.name}.toml; keep one")
            owner[key] = source.name
    return MappingProxyType(dict(sources))


SOURCES: Mapping[str, Source] = _disjoint({name: _load_source(name) for name in _FILES})
READINGS: Mapping[str, Reading] = MappingProxyType(_load_readings(SOURCES))
PARAMETERS: Mapping[str, Parameter] = shipped()
PREPARATIONS: Mapping[str, Preparation] = MappingProxyType({name: _load_preparation(name) for name in _PREPARATIONS})
