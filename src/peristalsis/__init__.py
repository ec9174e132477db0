"""Electromechanical model of colonic propulsion: waves in two muscle layers, a soft wall, a pellet.

>>> import peristalsis as ps
>>> result = ps.run("baseline", {"pellet.viscous_friction": "120 mN*s/cm"})
>>> result.summary["transit_s"], result.dataset, result.plot.diameter_map()
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._version import __version__

if TYPE_CHECKING:
    from .declared import number
    from .errors import PeristalsisError
    from .inputs.config import Configuration
    from .many.batch import batch
    from .many.dose_response import dose_response
    from .many.fitting import fit
    from .many.passes import passes
    from .many.studies.cohort import cohort
    from .many.studies.sensitivity import sensitivity
    from .many.studies.stall_map import stall_map
    from .many.studies.sweep import sweep
    from .names import Output
    from .plugins import register
    from .results.result import Result, load
    from .running.runner import run
    from .running.simulation import Simulation
    from .scenarios import Scenario, configuration
    from .scenarios import names as scenario_names

__all__ = [
    "Configuration",
    "Output",
    "PeristalsisError",
    "Result",
    "Scenario",
    "Simulation",
    "__version__",
    "batch",
    "cohort",
    "configuration",
    "dose_response",
    "fit",
    "load",
    "number",
    "passes",
    "register",
    "run",
    "scenario_names",
    "sensitivity",
    "stall_map",
    "sweep",
]

_HOMES = {
    "Configuration": ("inputs.config", "Configuration"),
    "Output": ("names", "Output"),
    "PeristalsisError": ("errors", "PeristalsisError"),
    "Result": ("results.result", "Result"),
    "Scenario": ("scenarios", "Scenario"),
    "Simulation": ("running.simulation", "Simulation"),
    "batch": ("many.batch", "batch"),
    "cohort": ("many.studies.cohort", "cohort"),
    "configuration": ("scenarios", "configuration"),
    "dose_response": ("many.dose_response", "dose_response"),
    "fit": ("many.fitting", "fit"),
    "load": ("results.result", "load"),
    "number": ("declared", "number"),
    "passes": ("many.passes", "passes"),
    "register": ("plugins", "register"),
    "run": ("running.runner", "run"),
    "scenario_names": ("scenarios", "names"),
    "sensitivity": ("many.studies.sensitivity", "sensitivity"),
    "stall_map": ("many.studies.stall_map", "stall_map"),
    "sweep": ("many.studies.sweep", "sweep"),
}


def __getattr__(name: str) -> Any:
    """Import the public names on first use: `import peristalsis` stays fast."""
    if name not in _HOMES:
        raise AttributeError(f"module 'peristalsis' has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(importlib.import_module(f".{module}", __name__), attribute)


def __dir__() -> list[str]:
    return sorted(__all__)
