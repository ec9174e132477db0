"""The numbers of a summary, from the recorded arrays; docs/conventions.md has what each of them means."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .._version import __version__
from ..inputs.build import diffusivity
from ..inputs.config import Configuration
from ..inputs.parts import SHIPPED
from ..inputs.preflight import foot_length
from ..inputs.shape import shape_of
from ..model.ends import bulges
from ..results.measures import FASTEST, largest, share_of, speed_of_passage
from ..results.result import json_ready
from ..results.waves import LOCAL, ORIGINS, RETROGRADE, SPONTANEOUS, STANDING
from .observers import Expulsion
from .upstrokes import LAYERS

SMALLEST_WORK = 1.0
"""Least work against which the balance of a run is measured [mN cm]: at rest there is nothing to compare with."""
SMALLEST_FORCE = 1.0
"""The same for the balance of axial momentum [mN]."""
MARGIN = 4.0
"""A wave that runs faster than this many times that of the undeformed cable is not conducted."""


def summarise(
    configuration: Configuration,
    arrays: Mapping[str, Any],
    status: str,
    error: str | None,
    expulsion: Expulsion,
    absolute_work: float,
    cost: Mapping[str, float],
) -> dict[str, Any]:
    """The numbers of --json from the recorded arrays; None, never a number, where one cannot be measured.

    docs/conventions.md has what each of them is and why it may be None. cost: seconds on the clock.
    """
    time = arrays["time_step"]
    simulated, steps = float(time[-1]), int(time.size - 1)
    work, momentum = largest(arrays["power_residual"]), largest(arrays["momentum_residual"])
    axial = max(largest(arrays[name]) or 0.0 for name in ("oral_reaction", "anal_reaction", "axial_force"))
    oral, anal = bulges(arrays["axial_position"], configuration.wall.span)
    summary = {
        "scenario": configuration.scenario,
        "reading": configuration.reading,
        "status": status,
        "error": error,
        "transit_s": expulsion.time,
        "oral_exit_s": expulsion.oral_time,
        **_of_pellet(configuration, arrays, expulsion),
        "max_lumen_pressure_kPa": _finite(arrays["lumen_pressure"].max()),
        **_of_wave(configuration, arrays),
        **_counts(arrays),
        "min_diameter_cm": _finite(arrays["min_diameter"].min()),
        "max_diameter_cm": _finite(2.0 * arrays["radius"].max()),
        "bulge_cm": {"oral": float(oral.max()), "anal": float(anal.max())},
        "power_residual": share_of(work, absolute_work, SMALLEST_WORK) if steps else None,
        "momentum_residual": share_of(momentum, axial, SMALLEST_FORCE),
        "simulated_s": simulated,
        "solver_wall_s": cost.get("solver_wall_s", 0.0),
        "compile_wall_s": cost.get("compile_wall_s", 0.0),
        "steps": steps,
        "version": __version__,
    }
    cleaned: dict[str, Any] = json_ready(summary)
    return cleaned


OF_PELLET = (
    "start_cm",
    "final_position_cm",
    "travel_cm",
    "mean_velocity_cm_s",
    "max_velocity_cm_s",
    "beyond_oral_end_cm",
    "max_axial_force_mN",
    "max_normal_force_mN",
    "max_contact_pressure_kPa",
    "max_end_reaction_mN",
)
"""Numbers that there are only with a pellet."""


def _of_pellet(configuration: Configuration, arrays: Mapping[str, Any], expulsion: Expulsion) -> dict[str, Any]:
    """Where the pellet was, how fast, and what acted on it; None without one."""
    if not configuration.pellet.enabled:
        return dict.fromkeys(OF_PELLET)
    time, position = arrays["time_step"], arrays["pellet_position"]
    left = expulsion.time if expulsion.time is not None else expulsion.oral_time
    until = float(time[-1]) if left is None else left
    end = position[-1] if left is None else np.interp(left, time, position)
    travel = float(end - position[0])
    beyond = shape_of(configuration).oral - float(position.min())
    numbers = (
        float(position[0]),
        float(position[-1]),
        travel,
        travel / until if until > 0.0 else None,
        float(arrays["pellet_velocity"].max()),
        max(beyond, 0.0),
        largest(arrays["axial_force"]),
        largest(arrays["normal_force"]),
        largest(arrays["max_contact_pressure"]),
        largest(arrays["end_reaction"]),
    )
    return dict(zip(OF_PELLET, numbers, strict=True))


OF_WAVE = (
    "wave_speed_cm_s",
    "wave_speed_reason",
    "wave_speed_residual_s",
    "wave_speed_residual",
    "wave_speed_cells",
)
"""Keys of a `measures.Speed`, in its order."""


def _of_wave(configuration: Configuration, arrays: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Speed of the first wave of each layer, and how well it is known or why it is not."""
    fastest = fastest_conduction(configuration)
    if fastest == 0.0:
        return dict.fromkeys(OF_WAVE, dict.fromkeys(LAYERS)) | {
            "wave_speed_reason": dict.fromkeys(LAYERS, "neither layer conducts")
        }
    found = {
        layer: speed_of_passage(
            arrays["z_cell"], arrays[f"activation_{layer}"][:, 0], configuration.wall.length, fastest
        )
        for layer in LAYERS
    }
    return {key: {layer: one[k] for layer, one in found.items()} for k, key in enumerate(OF_WAVE)}


def fastest_conduction(configuration: Configuration) -> float:
    """A speed [cm/s] that no conducted wave of this tissue reaches; one that is faster is no conduction.

    Several times the speed of its wave on the undeformed cable, which goes with the root of diffusivity times rate: the
    conductances that may be set, and the stretch of a wall, change it by less.
    """
    if any(cell.name != SHIPPED["cell"] for cell in configuration.cells().values()):
        return FASTEST  # the speeds were measured with Plant's cell
    if any(quantity == "conductivity" for region in configuration.regions for quantity, _ in region.factors):
        return FASTEST
    speeds = [
        diffusivity(configuration, layer, configuration.capacitance_of(name)) / foot_length(configuration, name)
        for name, layer in (("longitudinal", configuration.longitudinal), ("circular", configuration.circular))
        if layer.conduction
    ]
    return min(FASTEST, MARGIN * max(speeds, default=0.0))


def _finite(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None


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
