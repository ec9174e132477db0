"""What studies of a pellet's passage keep of a run: a few numbers, and its track."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.simulation import Simulation

KEPT = ("transit_s", "mean_velocity_cm_s", "max_axial_force_mN", "travel_cm", "simulated_s")
"""Numbers of a summary; docs/conventions.md has what each of them is."""


def passage(simulation: Simulation, result: Result) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Numbers, and the arrays time_step [s] and pellet_position [cm], each (n_steps + 1,)."""
    numbers = {name: result.summary[name] for name in KEPT} | {"remarks": list(result.remarks)}
    return numbers, {name: result.arrays[name] for name in ("time_step", "pellet_position")}
