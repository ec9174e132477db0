"""What is kept of a run of the bench: speed in the middle of the segment, isometric force, order of events."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...many.rows import CODE
from ...results.measures import speed_between
from ...results.result import json_ready
from ..measure import thinned
from ..metrics import Metric

if TYPE_CHECKING:
    from ...results.result import Result
    from ...running.simulation import Simulation

Floats = NDArray[np.float64]

MIDDLE = 1.5
"""Half of the stretch in the middle of the segment over which speed is taken [cm]."""
DILATED = 1.01
"""Radius over that of the resting tube from which wall counts as dilated."""
HYPERPOLARISED = 0.1
"""By how much below rest circular muscle counts as relaxed [mV]."""
CONTRACTS = 0.05
"""Share of the largest active tension from which circular muscle contracts."""

METRICS: Mapping[str, Metric] = MappingProxyType(
    {
        metric.name: metric
        for metric in (
            Metric("transit_s", "s", "time at which the leading pole reaches the anal end; undefined if it does not"),
            Metric("travel_cm", "cm", "displacement of the centre until then, or until the end of the run"),
            Metric(
                "middle_speed_mm_s",
                "mm/s",
                "mean speed over the middle 3 cm of the segment; of a pellet that does not pass them, over the time "
                "that is left to it there; of one that does not come so far, over the whole run",
            ),
            Metric("peak_force_mN", "mN", "largest axial force of the wall on the pellet"),
            Metric("isometric_force_mN", "mN", "mean axial force on a held pellet, over the second half of the run"),
            Metric("contact_kPa", "kPa", "largest contact pressure while the pellet is in the middle 3 cm"),
            Metric(
                "relaxed_first",
                "1",
                "share of the middle 3 cm of wall whose circular muscle is hyperpolarised by 0.1 mV before contracting",
            ),
            Metric(
                "dilated_first",
                "1",
                "share of the middle 3 cm of wall that is wider by 1 % than at rest before its muscle contracts",
            ),
        )
    }
)


def measure(simulation: Simulation, result: Result) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Numbers by `METRICS` and thinned arrays of a run of a pellet."""
    arrays, configuration = result.arrays, result.configuration
    time, place, force = arrays["time_step"], arrays["pellet_position"], arrays["axial_force"]
    middle = 0.5 * configuration.wall.span + MIDDLE * np.array([-1.0, 1.0])
    held = configuration.pellet.held
    inside = (place >= middle[0]) & (place <= middle[1])
    relaxed, dilated = order_of_events(arrays, (float(middle[0]), float(middle[1])))
    numbers: dict[str, Any] = {
        "transit_s": result.summary["transit_s"],
        "travel_cm": result.summary["travel_cm"],
        "simulated_s": result.summary["simulated_s"],
        "middle_speed_mm_s": 0.0 if held else 10.0 * speed_between(time, place, float(middle[0]), float(middle[1])),
        "peak_force_mN": float(force.max()),
        "isometric_force_mN": float(force[time >= 0.5 * time[-1]].mean()) if held else None,
        "contact_kPa": float(arrays["max_contact_pressure"][inside].max()) if inside.any() else None,
        "relaxed_first": relaxed,
        "dilated_first": dilated,
        "ratio": configuration.pellet.radius / configuration.wall.radius,
        "remarks": list(result.remarks),
        "sources": CODE,
    }
    cleaned: dict[str, Any] = json_ready(numbers)
    return cleaned, thinned(result)


def order_of_events(
    arrays: Mapping[str, NDArray[Any]], between: tuple[float, float]
) -> tuple[float | None, float | None]:
    """Shares of the wall between two z [cm] that relax, and that dilate, before they contract.

    None where nothing contracts there.
    """
    z = arrays["z"]
    active = arrays["active_tension_circumferential"][:, :, 0]
    where = (z >= between[0]) & (z <= between[1])
    contracts = first_frame(active > CONTRACTS * max(float(active.max()), 1e-12))
    where &= contracts < len(active)
    if not where.any() or active.max() <= 0.0:
        return None, None
    radius = arrays["radius"][:, :, 0]
    rest = float(np.median(radius[0]))
    potential = arrays["potential_circular"][:, :, 0]
    relaxed = first_frame(potential < np.median(potential[0]) - HYPERPOLARISED)
    at_nodes = np.interp(z, arrays["z_cell"], relaxed.astype(np.float64))
    dilates = first_frame(radius > DILATED * rest)
    return (
        float((at_nodes[where] < contracts[where]).mean()),
        float((dilates[where] < contracts[where]).mean()),
    )


def first_frame(happens: NDArray[np.bool_]) -> NDArray[np.int64]:
    """First frame in which it happens at each place, (n_z,); the number of frames where it never does."""
    return np.where(happens.any(axis=0), happens.argmax(axis=0), len(happens))
