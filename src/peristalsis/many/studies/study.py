"""A study as its file describes it: what all runs share, what is varied by which design, and what is asked of them.

scenario = "baseline"                # optional, as are reading, changes and outputs
outputs = ["transit_s", "max_axial_force_mN"]
[changes]
run.duration = "3 s"
[design]
kind = "sobol"                       # or grid, list, random, latin_hypercube
samples = 64
seed = 1
[parameters.pellet]
viscous_friction = { from = "60 mN*s/cm", to = "240 mN*s/cm", scale = "log" }
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

from ... import scenarios
from ...errors import ConfigurationError, ReadingNotFound, ScenarioNotFound, UnknownKeyError, shown, suggestion
from ...inputs.config import Configuration, read_toml
from ..plan import flat_changes
from ..rows import Point
from . import outputs as known_outputs
from .designs import DRAWN, KINDS, Design
from .variables import Variable, read_variables

LARGEST_FILE = 1024 * 1024
"""Bytes of a study file."""
TABLES = ("scenario", "reading", "changes", "outputs", "design", "parameters", "points")


@dataclass(frozen=True)
class Study:
    """What is run: the shared base, the variables with their design, and the outputs that are tabulated.

    more: tables that only one kind of study has, such as `map` or `accept`.
    """

    base: Mapping[str, Any]
    variables: tuple[Variable, ...]
    design: Design
    outputs: tuple[str, ...] = known_outputs.STANDARD
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables, in order."""
        return tuple(one.name for one in self.variables)

    def configuration(self) -> Configuration:
        """What every run starts from: what factors are of."""
        return _configuration(self.base)

    def points(self, combinations: list[dict[str, Any]] | None = None) -> list[Point]:
        """A point of the engine for every combination (those of the design unless given); values may be refused."""
        base = self.configuration()
        chosen = self.design.combinations(self.variables) if combinations is None else combinations
        return [self._point(number, values, base) for number, values in enumerate(chosen, 1)]

    def _point(self, number: int, values: Mapping[str, Any], base: Configuration) -> Point:
        changes: dict[str, Any] = {}
        try:
            for variable in self.variables:
                if variable.name in values:
                    changes |= variable.changes(values[variable.name], base)
            return Point(str(number), values, _configuration({**self.base, **changes}))
        except (UnknownKeyError, ReadingNotFound, ScenarioNotFound):
            raise
        except ConfigurationError as error:
            return Point(str(number), values, refusal=str(error))

    def with_changes(self, changes: Mapping[str, Any]) -> Study:
        """The same with other values in what all runs share."""
        return replace(self, base={**self.base, **changes})


def _configuration(given: Mapping[str, Any]) -> Configuration:
    changes = dict(given)
    scenario, reading = changes.pop("scenario", None), changes.pop("reading", None)
    return scenarios.configuration(scenario, reading=reading, changes=changes)


def read_study(source: str | PathLike[str], more: tuple[str, ...] = (), designs: tuple[str, ...] = KINDS) -> Study:
    """The study in a TOML file (a Path) or TOML text (a str).

    more: names of further tables that this kind of study may have. designs: kinds that it may have, the first where
    the file names none. Raises ConfigurationError before anything is run.
    """
    tables = read_toml(source, LARGEST_FILE)
    for name in tables:
        if name not in TABLES and name not in more:
            raise ConfigurationError(f"{shown(name)} is no part of this study; {suggestion(name, [*TABLES, *more])}")
    base = flat_changes(tables.get("changes", {}), "changes")
    for name in ("scenario", "reading"):
        if name in tables:
            if not isinstance(tables[name], str):
                raise ConfigurationError(f"{name} = {shown(tables[name])}: give a name as text")
            base[name] = tables[name]
    parameters = tables.get("parameters")
    if not isinstance(parameters, Mapping):
        raise ConfigurationError("a study has a table [parameters] of what is varied; give one")
    study = Study(
        base,
        read_variables(parameters),
        _design(tables.get("design", {}), designs),
        _outputs(tables.get("outputs", list(known_outputs.STANDARD))),
        {name: tables[name] for name in more if name in tables},
    )
    study.configuration()  # what all runs share must be right by itself
    return study


def _outputs(given: Any) -> tuple[str, ...]:
    if not isinstance(given, list) or not given or not all(isinstance(one, str) for one in given):
        raise ConfigurationError(f"outputs = {shown(given)}: give a list of names")
    return known_outputs.checked(given)


def _design(given: Any, kinds: tuple[str, ...]) -> Design:
    if not isinstance(given, Mapping):
        raise ConfigurationError(f"design = {shown(given)}: give a table with kind, and samples and seed if it draws")
    for word in given:
        if word not in ("kind", "samples", "seed"):
            raise ConfigurationError(
                f"design: {shown(word)} is not known there; {suggestion(word, ('kind', 'samples', 'seed'))}"
            )
    kind = given.get("kind", kinds[0])
    if kind not in kinds:
        raise ConfigurationError(f"design: kind = {shown(kind)}; {suggestion(str(kind), kinds)}")
    samples, seed = given.get("samples"), given.get("seed", 0)
    if kind in DRAWN and (isinstance(samples, bool) or not isinstance(samples, int) or samples < 1):
        raise ConfigurationError(f"design: samples = {shown(samples)}: a {kind} design needs their number, from 1")
    if kind not in DRAWN and samples is not None:
        raise ConfigurationError(f"design: a {kind} has as many points as its values give; leave samples out")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise ConfigurationError(f"design: seed = {shown(seed)}: give a whole number from 0")
    return Design(kind, samples, seed)


def located_study(
    source: Study | str | PathLike[str], more: tuple[str, ...] = (), reading: str | None = None, **how: Any
) -> Study:
    """A study as it is, or the one of a file; under another reading if one is given.

    Raises ConfigurationError where the study itself varies the reading, ReadingNotFound.
    """
    found = source if isinstance(source, Study) else read_study(Path(source), more, **how)
    if reading is None:
        return found
    if any("reading" in one.keys for one in found.variables):
        raise ConfigurationError(f"reading = {shown(reading)}: this study varies the reading itself; leave one out")
    changed = found.with_changes({"reading": reading})
    changed.configuration()
    return changed
