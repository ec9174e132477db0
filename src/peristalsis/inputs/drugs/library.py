"""Libraries of agents and interventions: the shipped one, and files of users laid over it.

A file may hold [[agents]], [[interventions]] and [targets.NAME] (see the head of `drugs.toml`); those of a user's file
come before the shipped ones, and a target of the same name replaces the shipped one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from ...errors import ConfigurationError, UnknownKeyError, shown, suggestion
from ...paths import located
from ...storing.disk import read_regular
from ...units import DIMENSIONLESS, QuantityError
from ...units import read as read_quantity
from .specification import BOUNDS, CONCENTRATION, TAGS

FOLDER = Path(__file__).parent
SHIPPED = "drugs"
LARGEST_FILE = 256 * 1024
LONGEST_TEXT = 400
TABLES = ("agents", "interventions", "targets")
OF_AGENT = ("agent", "target", "tissue", "ic50", "range", "slope", "maximum", "tag", "source")
OF_INTERVENTION = ("name", "parameters", "factor", "range", "tag", "source", "note")
OF_TARGET = ("channels", "note")


@dataclass(frozen=True, slots=True)
class Target:
    """A kind of channel: "cell.channel" for every cell model that has it, and what is to be known of that."""

    name: str
    channels: tuple[str, ...]
    note: str


@dataclass(frozen=True, slots=True)
class Agent:
    """What is known of an agent at one target in one preparation; numbers as in `Dose`."""

    name: str
    target: str
    tissue: str
    ic50: float
    range: tuple[float, float] | None
    slope: float
    slope_stated: bool
    maximum: float
    tag: str
    source: str


@dataclass(frozen=True, slots=True)
class Intervention:
    """A factor on parameters, with the one that is meant unless stated and the range that makes sense."""

    name: str
    parameters: tuple[str, ...]
    factor: float
    range: tuple[float, float]
    tag: str
    source: str
    note: str


@dataclass(frozen=True)
class Library:
    """Agents in the order in which they are preferred, interventions and targets by name."""

    agents: tuple[Agent, ...]
    interventions: Mapping[str, Intervention]
    targets: Mapping[str, Target]

    def names(self) -> tuple[str, ...]:
        """Of all agents, each once."""
        return tuple(dict.fromkeys(one.name for one in self.agents))

    def of(self, name: str, tissue: str | None = None) -> tuple[Agent, ...]:
        """What is taken for an agent: one entry a target, the first, or that of the preparation.

        Raises ConfigurationError for an agent or preparation that is not known.
        """
        known = {one.casefold(): one for one in self.names()}
        found = known.get(name.casefold())
        if found is None:
            raise UnknownKeyError(
                f"{shown(name)} is not an agent of the library; {suggestion(name, [*known.values()])}"
            )
        entries = [one for one in self.agents if one.name == found]
        if tissue is not None:
            tissues = list(dict.fromkeys(one.tissue for one in entries))
            entries = [one for one in entries if one.tissue.casefold() == tissue.casefold()]
            if not entries:
                raise ConfigurationError(
                    f"{found}: nothing is known of it in {shown(tissue)}, but in {' and in '.join(tissues)}; name "
                    "one of these, or none for the first"
                )
        first: dict[str, Agent] = {}
        for one in entries:
            first.setdefault(one.target, one)
        return tuple(first.values())

    def over(self, other: Library) -> Library:
        """This library laid over another."""
        targets = {**other.targets, **self.targets}
        return Library((*self.agents, *other.agents), {**other.interventions, **self.interventions}, targets)


@lru_cache(maxsize=1)
def shipped() -> Library:
    """The library of the package."""
    return _library((FOLDER / f"{SHIPPED}.toml").read_text("utf-8"), f"{SHIPPED}.toml", {})


def variants() -> tuple[str, ...]:
    """Names of the other shipped libraries, which are laid over the first like a file."""
    return tuple(sorted(file.stem for file in FOLDER.glob("*.toml") if file.stem != SHIPPED))


def library(source: str | PathLike[str] | None = None) -> Library:
    """The shipped library, under a file or one of `variants` if given. Raises ConfigurationError."""
    if source is None:
        return shipped()
    if str(source) in variants():
        text = (FOLDER / f"{source}.toml").read_text("utf-8")
    else:
        try:
            text = read_regular(located(source), LARGEST_FILE, follow=True).decode("utf-8-sig")
        except (OSError, ValueError) as error:
            cause = error.strerror if isinstance(error, OSError) else "it is not a text file of UTF-8"
            raise ConfigurationError(
                f"{shown(str(source))} cannot be read: {cause}; name a library file, or one of {', '.join(variants())}"
            ) from None
    return _library(text, shown(str(source)), shipped().targets).over(shipped())


def _library(text: str, where: str, targets: Mapping[str, Target]) -> Library:
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigurationError(f"{where} is not valid TOML: {shown(str(error), 120)}; correct it") from None
    _known(tables, TABLES, where)
    own = {name: _target(name, table, where) for name, table in _table(tables.get("targets", {}), where).items()}
    known = {**targets, **own}
    agents = tuple(
        _agent(table, f"{where}, agent {number}", known) for number, table in _listed(tables, "agents", where)
    )
    made = [_intervention(table, f"{where}, intervention {n}") for n, table in _listed(tables, "interventions", where)]
    return Library(agents, {one.name: one for one in made}, own)


def _listed(tables: Mapping[str, Any], key: str, where: str) -> Iterator[tuple[int, Mapping[str, Any]]]:
    listed = tables.get(key, [])
    if not isinstance(listed, list):
        raise ConfigurationError(f"{where}: {key} is not a list of tables; write [[{key}]] above each")
    return ((number, _table(one, f"{where}, {key} {number}")) for number, one in enumerate(listed, 1))


def _table(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ConfigurationError(f"{where}: {shown(value)} is not a table; give keys with values")
    return value


def _known(table: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in keys:
            raise UnknownKeyError(f"{where}: {shown(key)} is not a key here; {suggestion(key, keys)}")


def _target(name: str, value: object, where: str) -> Target:
    where = f"{where}, target {shown(name)}"
    table = _table(value, where)
    _known(table, OF_TARGET, where)
    return Target(name, channels_of(table.get("channels", []), where), text_of(table, "note", where, ""))


def _agent(table: Mapping[str, Any], where: str, targets: Mapping[str, Target]) -> Agent:
    _known(table, OF_AGENT, where)
    target = text_of(table, "target", where)
    if target not in targets:
        raise ConfigurationError(
            f"{where}: target = {shown(target)} is not known; {suggestion(target, targets)}, or add [targets.{target}]"
        )
    return Agent(
        text_of(table, "agent", where),
        target,
        text_of(table, "tissue", where),
        number_of(table, "ic50", where),
        range_of(table, where),
        number_of(table, "slope", where, 1.0),
        "slope" in table,
        number_of(table, "maximum", where, 0.0),
        tag_of(table, where),
        text_of(table, "source", where),
    )


def _intervention(table: Mapping[str, Any], where: str) -> Intervention:
    _known(table, OF_INTERVENTION, where)
    limits = table.get("range")
    numbers = [table.get("factor"), *(limits if isinstance(limits, list) else [])]
    if len(numbers) != 3 or not all(isinstance(one, int | float) and one > 0.0 for one in numbers):
        raise ConfigurationError(f"{where}: give factor = 0.5 and range = [0.1, 1.0], numbers above 0")
    factor, low, high = map(float, numbers)
    if not low <= factor <= high:
        raise ConfigurationError(f"{where}: factor = {factor:g} lies outside of its range, {low:g} to {high:g}")
    parameters = table.get("parameters")
    if not isinstance(parameters, list) or not parameters or not all(isinstance(one, str) for one in parameters):
        raise ConfigurationError(f"{where}: give parameters = ['pellet.viscous_friction'], the keys that it multiplies")
    name, note = text_of(table, "name", where), text_of(table, "note", where, "")
    tag, source = tag_of(table, where), text_of(table, "source", where)
    return Intervention(name, tuple(parameters), factor, (low, high), tag, source, note)


def text_of(table: Mapping[str, Any], key: str, where: str, default: str | None = None) -> str:
    """A line of text that a configuration file can hold as it is. Raises ConfigurationError."""
    value = table.get(key, default)
    if value is None:
        raise ConfigurationError(f"{where}: {key} is missing; give it, for example {key} = 'text'")
    if not isinstance(value, str) or (not value.strip() and key in table and default is None):
        raise ConfigurationError(f"{where}: {key} = {shown(value)} is no text; give a line of text")
    if len(value) > LONGEST_TEXT or not value.isprintable() or {'"', "\\"} & set(value):
        raise ConfigurationError(
            f'{where}: {key} = {shown(value)}: a line of at most {LONGEST_TEXT} characters without " and \\ is kept'
        )
    return value.strip()


def number_of(table: Mapping[str, Any], key: str, where: str, default: float | None = None) -> float:
    """A number within its bounds, concentrations in nM. Raises ConfigurationError."""
    if key not in table:
        if default is None:
            raise ConfigurationError(f"{where}: {key} is missing; give it, for example {key} = '10 nM'")
        return default
    return _bounded(table[key], key, f"{where}: {key}")


def _bounded(value: object, key: str, where: str) -> float:
    low, high = BOUNDS[key]
    unit = DIMENSIONLESS if key in ("slope", "maximum") else CONCENTRATION
    try:
        number = read_quantity(value, unit)
    except QuantityError as error:
        raise ConfigurationError(f"{where} = {shown(value)}: {error}") from None
    if not low <= number <= high:
        raise ConfigurationError(f"{where} = {shown(value)}: out of range; give a value of {low:g} to {high:g} {unit}")
    return number


def range_of(table: Mapping[str, Any], where: str) -> tuple[float, float] | None:
    """The range of an IC50 [nM], or None. Raises ConfigurationError."""
    if "range" not in table:
        return None
    given = table["range"]
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise ConfigurationError(f"{where}: range = {shown(given)}: give two concentrations, such as ['1 nM', '5 nM']")
    low, high = (_bounded(one, "ic50", f"{where}: range") for one in given)
    if low > high:
        raise ConfigurationError(f"{where}: range = {shown(given)} falls; put the smaller one first")
    return low, high


def tag_of(table: Mapping[str, Any], where: str) -> str:
    """One of TAGS. Raises ConfigurationError."""
    tag = text_of(table, "tag", where)
    if tag not in TAGS:
        raise ConfigurationError(f"{where}: tag = {shown(tag)}; {suggestion(tag, TAGS)}")
    return tag


def channels_of(given: object, where: str) -> tuple[str, ...]:
    """Names such as plant.slow_calcium. Raises ConfigurationError."""
    if not isinstance(given, list | tuple) or not all(isinstance(one, str) and one.count(".") == 1 for one in given):
        raise ConfigurationError(
            f"{where}: channels = {shown(given)}: give a list of cell.channel, such as ['plant.slow_calcium']"
        )
    return tuple(given)
