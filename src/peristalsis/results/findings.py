"""What a finished run has to say about its own numbers: one sentence for each that should not be taken as it stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..inputs.config import Configuration
from ..model.ends import BULGE, bulges

LARGEST_POWER_RESIDUAL = 1e-3
"""Share of the absolute work that the balance of power, Eq. (29), may leave over without a remark."""
LARGEST_MOMENTUM_RESIDUAL = 1e-3
"""Share of the largest axial force that the balance of axial momentum, Eq. (52), may leave over without one."""
LARGEST_NORMAL_FORCE = 1e5
"""Sum of contact forces on a pellet beyond which a run says so [mN]: some twenty times those of a solid bolus in vivo,
1.9 N for each cm of its length (J. Robot. Surg. 6 (2012), doi 10.1007/s11701-012-0346-3, abstract)."""
LEAST_BEYOND = 0.01
"""A pole that stands out over an end by less than this is not worth a remark [cm]."""


def remarks_of_summary(
    configuration: Configuration, summary: Mapping[str, Any], arrays: Mapping[str, Any]
) -> list[str]:
    """Sentences about a run that has ended, from its summary, its arrays and its configuration; none for a sane one."""
    return [
        *_ends(configuration, summary, arrays),
        *_forces(summary),
        *_waves(summary),
        *_balances(configuration, summary),
    ]


def _ends(configuration: Configuration, summary: Mapping[str, Any], arrays: Mapping[str, Any]) -> list[str]:
    """Whether pellet or wall stood out over the clamped ends."""
    found = []
    beyond = summary["beyond_oral_end_cm"]
    if beyond is not None and beyond > LEAST_BEYOND:
        moment = float(arrays["event_time"][arrays["event_kind"] == "oral_end"][0])
        found.append(
            f"the pellet stood {beyond:.2g} cm beyond the oral end at most, first at t = {moment:.4g} s: the segment "
            "ends there and does not hold it; set wall.oral_end = closed, or enlarge pellet.start_gap"
        )
    least = BULGE * configuration.wall.radius
    for end, course in zip(("oral", "anal"), bulges(arrays["axial_position"], configuration.wall.span), strict=True):
        if course.max() > max(least, course[0] + 0.1 * least):  # what it does from the start is said before the run
            moment = float(arrays["time"][course.argmax()])
            found.append(
                f"the wall bulges {course.max():.2g} cm over its clamped {end} ring at t = {moment:.4g} s; a gut that "
                "goes on beyond the segment would not: read nothing from the shape there, lower lumen.pressure, or "
                "take a longer tube"
            )
    return found


def _forces(summary: Mapping[str, Any]) -> list[str]:
    """Whether the wall squeezed with a force that no gut bears."""
    force = summary["max_normal_force_mN"]
    if force is None or force <= LARGEST_NORMAL_FORCE:
        return []
    return [
        f"max_normal_force_mN = {force:.2g}: the wall is stretched far into the steep part of its law, beyond what "
        "any tissue bears; use a smaller pellet.radius, or a softer passive wall"
    ]


def _waves(summary: Mapping[str, Any]) -> list[str]:
    """Whether tissue fired by itself."""
    return [
        f"{count} of {summary['waves'][layer]} waves of the {layer} layer began without a stimulus: the tissue fires "
        "by itself, and when it does depends on grid and steps"
        for layer, count in summary["waves_spontaneous"].items()
        if count
    ]


def _balances(configuration: Configuration, summary: Mapping[str, Any]) -> list[str]:
    """Whether the balances of energy and momentum close."""
    found = []
    power, momentum = summary["power_residual"], summary["momentum_residual"]
    jumps = ", or an input jumps between two steps (protocols)" if configuration.protocols else ""
    if power is not None and power > LARGEST_POWER_RESIDUAL:
        found.append(
            f"power_residual = {power:.2g}: the balance of energy leaves more than {LARGEST_POWER_RESIDUAL:g} of the "
            f"work over, so the step in time is too long for this run{jumps}; halve step.wall and compare"
        )
    if momentum is not None and momentum > LARGEST_MOMENTUM_RESIDUAL:
        found.append(
            f"momentum_residual = {momentum:.2g}: the balance of axial momentum leaves more than "
            f"{LARGEST_MOMENTUM_RESIDUAL:g} of the largest axial force over; lower "
            "solver.residual_tolerance and compare"
        )
    return found
