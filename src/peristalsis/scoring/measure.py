"""The numbers and curves that are kept of a run: every metric of `metrics`, and what figures need."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..inputs.shape import shape_of
from ..many.rows import CODE
from ..results import quantities
from ..results.result import json_ready
from . import metrics

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.simulation import Simulation

Floats = NDArray[np.float64]

FRAMES, PLACES, TIMES = 60, 201, 500
"""Most stored frames of a field, places along the wall, and times of a curve."""

FIELDS = (
    "radius",
    "axial_position",
    "stretch_longitudinal",
    "stretch_circumferential",
    "tension_longitudinal",
    "tension_circumferential",
    "active_tension_longitudinal",
    "active_tension_circumferential",
    "contact_pressure",
)
CURVES = ("pellet_position", "pellet_velocity", "axial_force", "normal_force", "lumen_pressure", "slack_share")


def measure(simulation: Simulation, result: Result) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Numbers (metrics, and part of the summary) and arrays (curves and thinned fields) of a run."""
    arrays = result.arrays
    numbers: dict[str, Any] = {
        "transit_s": result.summary["transit_s"],
        "travel_cm": result.summary["travel_cm"],
        "mean_velocity_cm_s": result.summary["mean_velocity_cm_s"],
        "simulated_s": result.summary["simulated_s"],
        "max_axial_force_mN": result.summary["max_axial_force_mN"],
        "max_lumen_pressure_kPa": result.summary["max_lumen_pressure_kPa"],
        "min_diameter_cm": result.summary["min_diameter_cm"],
        "wave_speed_cm_s": result.summary["wave_speed_cm_s"],
        "remarks": list(result.remarks),
        "solver_wall_s": result.summary["solver_wall_s"],
        "sources": CODE,
        "pulses": int(np.sum(arrays["event_kind"] == "pacemaker")),
        "discharges": int(np.sum(arrays["event_kind"] == "receptors")),
        "end_displacement_cm": end_displacement(arrays["axial_position"], arrays["radius"]),
        "anal_active_share": anal_active_share(
            arrays["z"], arrays["active_tension_longitudinal"], arrays["active_tension_circumferential"]
        ),
    }
    if result.configuration.pellet.enabled:
        numbers |= _of_pellet(simulation, result)
    cleaned: dict[str, Any] = json_ready(numbers)
    return cleaned, thinned(result)


def _of_pellet(simulation: Simulation, result: Result) -> dict[str, Any]:
    arrays = result.arrays
    time, position = arrays["time_step"], arrays["pellet_position"]
    way = (metrics.WINDOW,)
    frames = arrays["time"]
    centre = np.interp(frames, time, position)
    rise, setback = force_course(
        centre, circular_force(arrays["z"], arrays["active_tension_circumferential"], arrays["stretch_longitudinal"])
    )
    radius, axial = arrays["radius"][:, :, 0], arrays["axial_position"][:, :, 0]
    pellet = result.configuration.pellet.radius
    upstream = quantities.content_upstream(radius, axial, centre, shape_of(result.configuration).volume_oral_of)
    free = simulation.model.free_radius
    return {
        "irregularity": quantities.irregularity(
            time, position, metrics.VELOCITY_BIN, *way, least_travel=metrics.LEAST_TRAVEL
        ),
        "stops": quantities.stops(time, position, metrics.STOP_SPEED, metrics.STOP_TIME, *way),
        "reversals": quantities.reversals(position, metrics.REVERSAL),
        "libration_cm": quantities.libration(position, metrics.LEAST_SWING),
        "drift_cm": abs(float(position[-1] - position[0])),
        "mixing": quantities.mixing(frames, upstream, metrics.TRACERS, metrics.MIXING_CELLS),
        "circular_force_rise": rise,
        "circular_force_setback": setback,
        "inflated_ratio": pellet / float(free[free.size // 2]),
    }


def circular_force(z: Floats, tension: Floats, stretch: Floats) -> Floats:
    """Active circular tension summed along the deformed wall [mN], (n_time,). Fields: (n_time, n_z, n_theta)."""
    return np.asarray(np.trapezoid(tension[:, :, 0] * stretch[:, :, 0], z, axis=1))


def force_course(position: Floats, force: Floats) -> tuple[float | None, float | None]:
    """Rise from 5 to 95 % of the travel, and the largest setback on the way over the maximum; see `metrics`."""
    part = quantities.on_its_way(position, metrics.WINDOW)
    if part is None or position.max() - position[0] < metrics.LEAST_TRAVEL or force[part].max() <= 0.0:
        return None, None
    course = force[part]
    setback = float((np.maximum.accumulate(course) - course).max() / course.max())
    return (float(course[-1] / course[0]) if course[0] > 0.0 else None), setback


def end_displacement(axial: Floats, radius: Floats) -> float:
    """Largest displacement of the two end nodes since t = 0 [cm]. Fields: (n_time, n_z, n_theta)."""
    moved = [float(np.abs(field[:, [0, -1]] - field[:1, [0, -1]]).max()) for field in (axial, radius)]
    return max(moved)


def anal_active_share(z: Floats, longitudinal: Floats, circular: Floats) -> float | None:
    """Largest active tension near the anal end over the largest anywhere; None where no muscle pulls."""
    largest = max(float(longitudinal.max()), float(circular.max()))
    if largest <= 0.0:
        return None
    zone = z > z[-1] - metrics.ANAL_ZONE
    return max(float(longitudinal[:, zone].max()), float(circular[:, zone].max())) / largest


def thinned(result: Result) -> dict[str, NDArray[Any]]:
    """Curves and fields of a run at fewer times and places, in single precision."""
    arrays = result.arrays
    steps = _spread(len(arrays["time_step"]), TIMES)
    frames = _spread(len(arrays["time"]), FRAMES)
    places = _spread(len(arrays["z"]), PLACES)
    kept: dict[str, NDArray[Any]] = {
        "time_step": arrays["time_step"][steps],
        "time": arrays["time"][frames],
        "z": arrays["z"][places],
        "circular_force": np.interp(
            arrays["time_step"][steps],
            arrays["time"],
            circular_force(arrays["z"], arrays["active_tension_circumferential"], arrays["stretch_longitudinal"]),
        ),
    }
    kept |= {name: arrays[name][steps] for name in CURVES}
    kept |= {name: arrays[name][frames][:, places, 0] for name in FIELDS}
    return {name: values.astype(np.float32) for name, values in kept.items()}


def _spread(count: int, most: int) -> NDArray[np.int64]:
    """Indices of at most `most` of `count` items, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
