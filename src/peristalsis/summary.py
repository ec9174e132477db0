"""The numbers of a summary, from the recorded arrays; docs/conventions.md has what each of them means."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._version import __version__
from .config import Configuration
from .measures import speed_of_passage
from .result import json_ready
from .upstrokes import LAYERS
from .waves import LOCAL, ORIGINS, RETROGRADE, SPONTANEOUS, STANDING

Floats = NDArray[np.float64]

SMALLEST_WORK = 1.0
"""Least work against which the balance of a run is measured [mN cm]: at rest there is nothing to compare with."""
SMALLEST_FORCE = 1.0
"""The same for the balance of axial momentum [mN]."""


def summarise(
    configuration: Configuration,
    arrays: Mapping[str, Floats],
    status: str,
    error: str | None,
    transit: float | None,
    absolute_work: float,
    cost: Mapping[str, float],
) -> dict[str, Any]:
    """The numbers of --json from the recorded arrays; see docs/conventions for each of them."""
    pellet = configuration.pellet.enabled
    time = arrays["time_step"]
    simulated = float(time[-1])
    position = arrays["pellet_position"]
    travel = float(position[-1] - position[0]) if pellet else None
    until = transit if transit is not None else simulated
    if pellet and transit is not None:
        travel = float(np.interp(transit, time, position) - position[0])
    speeds = {
        layer: speed_of_passage(arrays["z_cell"], arrays[f"activation_{layer}"][:, 0], configuration.wall.length)
        for layer in LAYERS
    }
    residual = float(np.abs(arrays["power_residual"]).max()) / max(absolute_work, SMALLEST_WORK)
    axial = max(float(np.abs(arrays[name]).max()) for name in ("oral_reaction", "anal_reaction", "axial_force"))
    momentum = arrays["momentum_residual"][np.isfinite(arrays["momentum_residual"])]

    def peak(name: str) -> float | None:
        return float(np.nanmax(np.abs(arrays[name]))) if pellet else None

    summary = {
        "scenario": configuration.scenario,
        "reading": configuration.reading,
        "status": status,
        "error": error,
        "transit_s": transit,
        "start_cm": float(position[0]) if pellet else None,
        "final_position_cm": float(position[-1]) if pellet else None,
        "travel_cm": travel,
        "mean_velocity_cm_s": travel / until if travel is not None and until > 0.0 else None,
        "max_velocity_cm_s": float(arrays["pellet_velocity"].max()) if pellet else None,
        "max_axial_force_mN": peak("axial_force"),
        "max_normal_force_mN": peak("normal_force"),
        "max_lumen_pressure_kPa": float(arrays["lumen_pressure"].max()),
        "max_contact_pressure_kPa": peak("max_contact_pressure"),
        "wave_speed_cm_s": {layer: found.speed for layer, found in speeds.items()},
        "wave_speed_reason": {layer: found.reason for layer, found in speeds.items()},
        "wave_speed_residual_s": {layer: found.residual for layer, found in speeds.items()},
        "wave_speed_residual": {layer: found.share for layer, found in speeds.items()},
        "wave_speed_cells": {layer: found.cells for layer, found in speeds.items()},
        **_counts(arrays),
        "min_diameter_cm": float(arrays["min_diameter"].min()),
        "power_residual": residual,
        "momentum_residual": float(np.abs(momentum).max(initial=0.0)) / max(axial, SMALLEST_FORCE),
        "simulated_s": simulated,
        "solver_wall_s": cost.get("solver_wall_s", 0.0),
        "compile_wall_s": cost.get("compile_wall_s", 0.0),
        "steps": int(time.size - 1),
        "version": __version__,
    }
    cleaned: dict[str, Any] = json_ready(summary)
    return cleaned


def _counts(arrays: Mapping[str, Any]) -> dict[str, dict[str, int]]:
    """How many waves each layer had, and how many of them ran orally, stood, and began without a stimulus."""
    layer, direction, origin = (arrays[f"wave_{name}"] for name in ("layer", "direction", "origin"))
    travelled = direction != LOCAL
    kinds = {
        "waves": travelled,
        "waves_retrograde": direction == RETROGRADE,
        "waves_standing": direction == STANDING,
        "waves_spontaneous": travelled & (origin == ORIGINS[SPONTANEOUS]),
    }
    return {key: {one: int((chosen & (layer == one)).sum()) for one in LAYERS} for key, chosen in kinds.items()}
