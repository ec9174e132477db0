"""The experiments, one per file: what each changes in the baseline and what is expected of it.

A new scenario is a new module in this folder with ``SCENARIO = Scenario(...)``; nothing else has to be told.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

from peristalsis.errors import ConfigurationError, ScenarioNotFound, shown, suggestion
from peristalsis.inputs.config import Configuration, read_toml
from peristalsis.inputs.config.reading import keys_of_readings, reading_of
from peristalsis.inputs.parameters import PREPARATIONS, Parameter

BASELINE = "baseline"


@dataclass(frozen=True, slots=True)
class Scenario:
    """One experiment: changes to the shipped configuration, as they would stand in a file.

    preparation: name of the measured gut whose numbers it has, empty for those of the paper; `changes` hold them too.
    """

    name: str
    title: str
    description: str
    expected: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    preparation: str = ""


def names() -> tuple[str, ...]:
    """All scenarios, the baseline first."""
    return tuple(_registry())


def get(name: str) -> Scenario:
    """The scenario of this name."""
    known = _registry()
    if name not in known:
        raise ScenarioNotFound(f"scenario = {shown(name)}: no such scenario; {suggestion(name, known)}")
    return known[name]


def configuration(
    name: str | None = None,
    *,
    reading: str | None = None,
    changes: Mapping[Any, Any] | None = None,
    file: str | PathLike[str] | None = None,
) -> Configuration:
    """The configuration of a run, each layer over the one before: shipped, scenario, file, reading, changes.

    Without a name, the file's own scenario is meant, or the baseline.  `file` is a path.
    """
    from_file = {} if file is None else read_toml(Path(file))
    named_in_file = from_file.get("scenario")
    if name is not None and named_in_file not in (None, name):
        raise ConfigurationError(
            f"scenario = {shown(name)}: the file is of scenario {shown(named_in_file)}; name only one of them"
        )
    chosen = named_in_file if name is None else name
    if chosen is not None and not isinstance(chosen, str):
        raise ScenarioNotFound(f"scenario = {shown(chosen)}: give the name of a scenario as text")
    scenario = get(BASELINE if chosen is None else chosen)
    config = Configuration(scenario=scenario.name, **scenario.changes).overlaid(from_file)
    if reading is not None:
        # A reading brings its own radii; what the scenario is about comes back on top of them.
        brought = keys_of_readings(reading_of({"reading": reading}), config.reading)
        about = {key: value for key, value in scenario.changes.items() if key in brought}
        config = config.overlaid({"reading": reading, **about})
    return config.with_changes(changes) if changes else config


def unchanged(config: Configuration) -> Configuration:
    """The configuration of the same scenario and reading before any change by the user."""
    return configuration(config.scenario, reading=config.reading)


def given_by(name: str) -> Mapping[str, Parameter]:
    """What the preparation of a scenario says of its parameters; nothing where it has none."""
    preparation = get(name).preparation
    return PREPARATIONS[preparation].parameters if preparation else {}


_added: dict[str, Scenario] = {}


def register(scenario: Scenario) -> Scenario:
    """Add a scenario from outside the package, for this process. Raises ConfigurationError if it is none.

    Its changes are checked as a configuration at once.
    """
    if scenario.name in _registry() and _added.get(scenario.name) != scenario:
        raise ConfigurationError(f"scenario = {shown(scenario.name)}: there is one of this name; choose another")
    Configuration(scenario=scenario.name, **scenario.changes)
    _added[scenario.name] = scenario
    _registry.cache_clear()
    return scenario


def forget_all() -> None:
    """Take out what was registered."""
    _added.clear()
    _registry.cache_clear()


@lru_cache(maxsize=1)
def _registry() -> Mapping[str, Scenario]:
    found = dict(_added)
    for module in pkgutil.iter_modules(__path__):
        scenario = importlib.import_module(f"{__name__}.{module.name}").SCENARIO
        found[scenario.name] = scenario
    ordered = sorted(found, key=lambda name: (name != BASELINE, name))
    return MappingProxyType({name: found[name] for name in ordered})
