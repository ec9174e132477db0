"""What a stored result must be like to be one, whoever wrote it: looked at once, when it is read.

Hashes say that a file is as it was written; here it is seen whether what was written is a result: the outputs that the
package knows with their dimensions, lengths that fit one another and the configuration, numbers that a run can have,
and a summary with its keys. All functions raise ValueError with what is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..inputs.config import Configuration
from ..inputs.recording import ALWAYS, chosen, probe_names
from ..names import ACTIVATION, COORDINATES, EVENTS, OUTPUTS, PROBES, SCALARS, SHIPPED, WAVES

LARGEST = 1e15
"""No output of a run is larger, in its own unit."""
MOST_A_BYTE = 1100
"""Bytes that one byte of a file can hold after compression: deflate reaches 1032."""
TEXTS = tuple(output.name for output in (*EVENTS, *WAVES) if not output.unit)
WITHOUT_VALUE = {
    *(output.name for output in ACTIVATION),
    "event_place",
    "wave_speed",
    "pellet_position",
    "contact_start",
    "contact_end",
    "momentum_residual",
}
"""Outputs that are nan where there is nothing to tell."""
UNBOUNDED = {"smallest_gap"}
"""Outputs that are infinite where there is no pellet."""
LATER = (
    "step_parts",
    "steps_rejected",
    "theta_cell",
    "momentum_residual",
    "end_reaction",
    "dry_friction_limit",
    "threshold_longitudinal",
    "threshold_circular",
    *(output.name for output in PROBES if output.name.startswith("conductance_")),
)
"""Outputs that results of older versions do not have; one that is added to `names` is added here."""
NEEDED = tuple(
    name
    for name in (*(output.name for output in (*COORDINATES, *ACTIVATION, *SCALARS)), *ALWAYS)
    if name in SHIPPED and name not in LATER
)
MAY_BE_EMPTY = ("event", "wave", "probe")
"""Dimensions that may have no length; files leave out what is on them then."""
MOST_WORDS = 100_000
"""Characters of a text in a summary."""


def check_summary(summary: Any, scenario: str | None = None) -> None:
    """Whether this is the summary of a run."""
    if not isinstance(summary, Mapping):
        raise ValueError(f"its summary is {type(summary).__name__}, not a table")
    for key, kind in _SUMMARY.items():
        if key not in summary:
            raise ValueError(f"its summary lacks {key}")
        if not kind(summary[key]):
            raise ValueError(f"its summary has something else than a run's {key}")
    for key in _SOMETIMES:
        if not _or_none(_is_number)(summary.get(key)):
            raise ValueError(f"its summary has something else than a run's {key}")
    for key, value in summary.items():
        if not isinstance(key, str) or not _is_plain(value):
            raise ValueError(f"its summary has something else than numbers and words in {str(key)[:40]!r}")
    if scenario is not None and summary["scenario"] != scenario:
        raise ValueError("its summary is of another scenario than its configuration")


def check_record(summary: Any) -> None:
    """Whether this is the summary of a run that has no numbers."""
    if not isinstance(summary, Mapping) or not all(_is_text(summary.get(key)) for key in ("status", "error")):
        raise ValueError("its summary does not say how it ended and why")


def check_sizes(sizes: Mapping[str, int], image: bytes) -> None:
    """Whether the variables of a file, with these numbers of bytes, can be in it at all."""
    if sum(sizes.values()) > MOST_A_BYTE * len(image):
        largest = max(sizes, key=lambda name: sizes[name])
        raise ValueError(f"{largest} declares more numbers than the file can hold")


def check_shapes(shapes: Mapping[str, tuple[tuple[str, ...], tuple[int, ...]]], configuration: Configuration) -> None:
    """Whether outputs (name to dimensions and lengths) are those of a run of this configuration."""
    lengths: dict[str, int] = {}
    cells = configuration.cells()
    at_probes = [name for name in probe_names(cells) if name not in LATER]
    # Results of versions in which cells had the columns of the wall know one angle only.
    old = {} if "theta_cell" in shapes else {"theta_cell": "theta"}
    for name, (dimensions, shape) in shapes.items():
        if dimensions != tuple(old.get(one, one) for one in OUTPUTS[name].dimensions):
            raise ValueError(f"{name} has dimensions {', '.join(dimensions) or 'none'}")
        for dimension, length in zip(dimensions, shape, strict=True):
            if lengths.setdefault(dimension, length) != length:
                raise ValueError(f"{name} has another length than others along {dimension}")
    events = (output.name for output in EVENTS if "event" in lengths)
    for name in (*NEEDED, *at_probes, *chosen(configuration.output.fields, cells), *events):
        if name not in shapes:
            raise ValueError(f"it lacks {name}")
    grid = configuration.grid
    known = {"z": grid.n_z_wall + 1, "z_cell": grid.n_z, "probe": len(configuration.output.probes)}
    for dimension, length in known.items():
        if lengths[dimension] != length:
            raise ValueError(f"{dimension} has {lengths[dimension]} places, and its configuration {length}")
    for dimension, length in lengths.items():
        if length == 0 and dimension not in MAY_BE_EMPTY:
            raise ValueError(f"{dimension} has no length")


def check_numbers(arrays: Mapping[str, NDArray[Any]], pellet: bool) -> None:
    """Whether every output holds what a run, with a pellet or without, can have put there."""
    for name, values in arrays.items():
        if name in TEXTS:
            if values.dtype.kind not in "OUT" or not all(isinstance(text, str) for text in values.ravel()):
                raise ValueError(f"{name} is no text")
            continue
        if values.dtype.kind != "f":
            raise ValueError(f"{name} holds no numbers")
        sound = np.abs(values) <= LARGEST
        if name in WITHOUT_VALUE and not (pellet and name == "pellet_position"):
            sound |= np.isnan(values)
        if name in UNBOUNDED:
            sound |= np.isposinf(values)
        if not sound.all():
            raise ValueError(f"{name} holds {values[~sound].flat[0]:g}, which no run has")
    for name in ("time", "time_step", "z", "z_cell", "theta", "theta_cell"):
        if name in arrays and (np.diff(arrays[name]) <= 0.0).any():
            raise ValueError(f"{name} does not rise")


def _is_text(value: object) -> bool:
    return isinstance(value, str) and len(value) <= MOST_WORDS


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")


def _or_none(kind: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: value is None or kind(value)


def _is_plain(value: object) -> bool:
    if isinstance(value, Mapping):
        return all(isinstance(key, str) and _is_plain(inner) for key, inner in value.items())
    if isinstance(value, list | tuple):
        return all(_is_plain(inner) for inner in value)
    return value is None or isinstance(value, bool) or _is_text(value) or _is_number(value)


def _are_speeds(value: object) -> bool:
    return isinstance(value, Mapping) and all(_or_none(_is_number)(one) for one in value.values())


_SUMMARY: Mapping[str, Callable[[object], bool]] = {
    "scenario": _is_text,
    "reading": _is_text,
    "status": _is_text,
    "error": _or_none(_is_text),
    "transit_s": _or_none(_is_number),
    "start_cm": _or_none(_is_number),
    "final_position_cm": _or_none(_is_number),
    "travel_cm": _or_none(_is_number),
    "mean_velocity_cm_s": _or_none(_is_number),
    "max_velocity_cm_s": _or_none(_is_number),
    "max_axial_force_mN": _or_none(_is_number),
    "max_normal_force_mN": _or_none(_is_number),
    "max_lumen_pressure_kPa": _or_none(_is_number),
    "max_contact_pressure_kPa": _or_none(_is_number),
    "wave_speed_cm_s": _are_speeds,
    "min_diameter_cm": _or_none(_is_number),
    "power_residual": _or_none(_is_number),
    "simulated_s": _is_number,
    "steps": _is_number,
    "version": _is_text,
}
"""Keys that every summary has had so far, and what stands there."""
_SOMETIMES = ("momentum_residual", "solver_wall_s", "compile_wall_s")
"""Numbers that summaries of some versions have."""
