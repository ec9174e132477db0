"""What a study keeps of every run: all numbers of its summary, how the pellet went, and a few thinned curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError, suggestion
from ...names import CERTAIN
from ...results import quantities
from ...results.result import CLOCK, json_ready
from ..comparing import NUMBERS
from ..rows import CODE

if TYPE_CHECKING:
    from ...results.result import Result
    from ...running.simulation import Simulation

KIND = "study-1"
"""Of what is kept here; another number where that changes."""
POINTS = 400
"""Most times of a kept curve."""
CURVES = ("pellet_position", "axial_force", "normal_force", "max_contact_pressure", "lumen_pressure")
MOTION = {"irregularity": "1", "stops": "1", "reversals": "1", "libration_cm": "cm"}
"""How the pellet went, as `results.quantities` defines it, with units."""
STANDARD = ("transit_s", "mean_velocity_cm_s", "max_axial_force_mN", "final_position_cm")
"""Outputs of a study that names none."""
LABELS = {one.key: f"{one.label} ({one.unit})" if one.unit != "1" else one.label for one in NUMBERS} | {
    name: name.removesuffix(f"_{unit}").replace("_", " ") + (f" ({unit})" if unit != "1" else "")
    for name, unit in MOTION.items()
}
"""Outputs in words, with units, for pictures."""
ALWAYS = ("final_position_cm", "travel_cm", "mean_velocity_cm_s")
"""Outputs that every finished run with a pellet has."""


def measure(simulation: Simulation, result: Result) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Numbers, flat and with dotted keys, and curves over `time_step` of a run."""
    summary = {key: value for key, value in result.summary.items() if key not in ("status", "error", CERTAIN)}
    numbers = _flat(summary) | {"remarks": list(result.remarks), "code": CODE}
    if result.configuration.pellet.enabled:
        numbers |= _motion(result)
    steps = np.unique(np.linspace(0, len(result.arrays["time_step"]) - 1, POINTS).round().astype(np.int64))
    curves = {"time_step": result.arrays["time_step"][steps]}
    curves |= {name: result.arrays[name][steps] for name in CURVES if name in result.arrays}
    cleaned: dict[str, Any] = json_ready(numbers)
    return cleaned, {name: values.astype(np.float32) for name, values in curves.items()}


def _motion(result: Result) -> dict[str, Any]:
    time, position = result.arrays["time_step"], result.arrays["pellet_position"]
    return {
        "irregularity": quantities.irregularity(time, position),
        "stops": quantities.stops(time, position),
        "reversals": quantities.reversals(position),
        "libration_cm": quantities.libration(position),
    }


def _flat(tree: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            found |= {f"{name}.{inner}": one for inner, one in _flat(value).items()}
        else:
            found[name] = value
    return found


def known() -> tuple[str, ...]:
    """Names of all outputs that a study can list."""
    listed = [one.key for one in NUMBERS if one.key not in CLOCK]
    return tuple(dict.fromkeys([*listed, *MOTION, *(f"{name}.{layer}" for name in _COUNTS for layer in _LAYERS)]))


_COUNTS = ("waves", "waves_retrograde", "waves_standing", "waves_spontaneous")
_LAYERS = ("longitudinal", "circular")


def checked(names: Iterable[str]) -> tuple[str, ...]:
    """The same names. Raises ConfigurationError for one that no run has."""
    found = tuple(names)
    for name in found:
        if name not in known():
            raise ConfigurationError(f"outputs: {name} is no output of a study; {suggestion(name, known())}")
    return found


def number(row: Mapping[str, Any], name: str) -> float | None:
    """An output as a number; None where the run has none."""
    value = row.get(name)
    return None if value is None or isinstance(value, str | list) else float(value)
