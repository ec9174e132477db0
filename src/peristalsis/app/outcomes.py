"""What came of a run, as the few numbers that a page shows and lessons ask for."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..results.result import Result

NUMBERS = (
    ("transit_s", "Transit", "s"),
    ("travel_cm", "Travel of the pellet", "cm"),
    ("mean_velocity_cm_s", "Mean velocity", "cm/s"),
    ("max_velocity_cm_s", "Greatest velocity", "cm/s"),
    ("max_axial_force_mN", "Greatest push", "mN"),
    ("min_diameter_cm", "Smallest diameter", "cm"),
)
"""Key of the summary, label, unit."""
SQUEEZED = ("narrowest_behind_cm", "Narrowest place behind the centre", "cm")
"""The same of what no summary has."""

WORDS = {
    "expelled": "The pellet left at the anal end",
    "expelled_orally": "The pellet left at the oral end",
    "arrested": "The pellet has come to rest",
    "in_transit": "The pellet was still on its way",
    "finished": "The run came to its end",
    "diverged": "The run broke off",
    "interrupted": "The run was stopped",
}


def outcome(result: Result) -> dict[str, Any]:
    """Status in words, the numbers of `NUMBERS` that there are, and remarks; JSON takes all of it."""
    summary = result.summary
    numbers = [
        {"key": key, "label": label, "unit": unit, "value": float(summary[key])}
        for key, label, unit in NUMBERS
        if summary.get(key) is not None
    ]
    squeezed = narrowest_behind(result)
    if squeezed is not None:
        key, label, unit = SQUEEZED
        numbers.append({"key": key, "label": label, "unit": unit, "value": squeezed})
    return {
        "status": result.status,
        "words": WORDS.get(result.status, result.status.replace("_", " ")),
        "error": result.error,
        "numbers": numbers,
        "remarks": list(result.remarks),
    }


def narrowest_behind(result: Result) -> float | None:
    """How far oral of the pellet's centre the tube is narrowest when the pellet is fastest [cm]; None if it rests."""
    arrays = result.arrays
    velocity = arrays["pellet_velocity"]
    if not result.configuration.pellet.enabled or velocity.max() <= 0.0:
        return None
    moment = arrays["time_step"][int(np.argmax(velocity))]
    frame = int(np.argmin(np.abs(arrays["time"] - moment)))
    inside = arrays["radius"][frame, 1:-1, 0]  # the clamped ends are no contraction
    place = arrays["axial_position"][frame, 1 + int(np.argmin(inside)), 0]
    centre = np.interp(arrays["time"][frame], arrays["time_step"], arrays["pellet_position"])
    return round(float(centre - place), 3)
