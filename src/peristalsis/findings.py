"""What a finished run has to say about its own numbers: one sentence for each that should not be taken as it stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .config import Configuration

LARGEST_POWER_RESIDUAL = 1e-3
"""Share of the absolute work that the balance of power, Eq. (29), may leave over without a remark."""
LARGEST_MOMENTUM_RESIDUAL = 1e-3
"""Share of the largest axial force that the balance of axial momentum, Eq. (52), may leave over without one."""


def remarks_of_summary(
    configuration: Configuration, summary: Mapping[str, Any], arrays: Mapping[str, Any]
) -> list[str]:
    """Sentences about a run that has ended, from its summary, its arrays and its configuration; none for a sane one."""
    return [*_balances(summary)]


def _balances(summary: Mapping[str, Any]) -> list[str]:
    """Whether the balances of energy and momentum close."""
    found = []
    power, momentum = summary["power_residual"], summary["momentum_residual"]
    if power is not None and power > LARGEST_POWER_RESIDUAL:
        found.append(
            f"power_residual = {power:.2g}: the balance of energy leaves more than {LARGEST_POWER_RESIDUAL:g} of the "
            "work over, so the step in time is too long for this run; halve step.wall and compare"
        )
    if momentum is not None and momentum > LARGEST_MOMENTUM_RESIDUAL:
        found.append(
            f"momentum_residual = {momentum:.2g}: the balance of axial momentum leaves more than "
            f"{LARGEST_MOMENTUM_RESIDUAL:g} of the largest axial force over; lower "
            "solver.residual_tolerance and compare"
        )
    return found
