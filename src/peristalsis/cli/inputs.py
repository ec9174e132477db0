"""The configuration that the options of a command describe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ConfigurationError, shown

if TYPE_CHECKING:
    from ..inputs.config import Configuration


INTEGRATOR = "solver.integrator"


@dataclass(frozen=True)
class Input:
    """The options that make up a configuration."""

    name: str | None
    reading: str | None = None
    settings: Sequence[str] = ()
    file: str | None = None
    integrator: str | None = None
    drugs: Sequence[str] = ()
    library: str | None = None

    def configuration(self) -> Configuration:
        """The checked configuration; ConfigurationError otherwise."""
        from .. import scenarios

        if self.name is None and self.file is None:
            raise ConfigurationError("no scenario is named; name one (see peristalsis list) or give --config FILE")
        changes = read_settings(self.settings)
        if self.reading is not None and "reading" in changes:
            raise ConfigurationError(f"reading = {shown(changes['reading'])}: --reading is given as well; keep one")
        if self.integrator is not None:
            if INTEGRATOR in changes:
                raise ConfigurationError(f"{INTEGRATOR} is set by --set and --integrator is given as well; keep one")
            changes[INTEGRATOR] = self.integrator
        file = None if self.file is None else Path(self.file)
        configuration = scenarios.configuration(self.name, reading=self.reading, changes=changes, file=file)
        return under_drugs(configuration, self.drugs, self.library)


def under_drugs(configuration: Configuration, lines: Sequence[str], library: str | None) -> Configuration:
    """A configuration under the agents and interventions of all --drug options, beside those that it has."""
    from ..inputs.drugs import changes_by

    if library is not None and not lines:
        raise ConfigurationError(f"--drugs {shown(library)}: a library without an agent from it; give --drug as well")
    return configuration.with_changes(changes_by(lines, configuration, library)) if lines else configuration


def read_settings(settings: Sequence[str]) -> dict[str, str]:
    """The changes of all --set options, each "key=value"."""
    changes: dict[str, str] = {}
    for setting in settings:
        key, sign, value = (part.strip() for part in setting.partition("="))
        if not sign:
            raise ConfigurationError(
                f"--set {shown(setting)}: there is no '='; write key=value, for example "
                "--set 'pellet.viscous_friction=120 mN*s/cm'"
            )
        if key == "scenario":
            raise ConfigurationError(f"--set {shown(setting)}: the scenario is the argument NAME; leave this out")
        if key in changes:
            raise ConfigurationError(f"{shown(key)} is given twice by --set; keep one")
        changes[key] = value
    return changes
