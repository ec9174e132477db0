"""Run a scenario by name: the one function that most users call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

from . import scenarios
from .result import Result
from .simulation import Simulation


def run(
    scenario: str | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    reading: str | None = None,
    file: str | PathLike[str] | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Result:
    """Run a scenario (the file's own, or the baseline, if none is named) and return its result.

    changes: parameters by name, values as text with a unit ("120 mN*s/cm") or plain for numbers without unit.
    reading: tight, stretched or printed. file: a TOML configuration laid over the scenario. Raises
    ConfigurationError for bad input; a run that diverges or is interrupted returns its history with `status`.
    """
    configuration = scenarios.configuration(scenario, reading=reading, changes=changes, file=file)
    return Simulation(configuration, progress=progress).run()
