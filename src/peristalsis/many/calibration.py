"""The one calibration of the model: conductivity scales that give 4.2 cm/s on the undeformed cable."""

from __future__ import annotations

from scipy.optimize import brentq

from ..errors import ConfigurationError
from ..inputs.config import Configuration
from .cable import CALIBRATED_SPEED, cable_wave_speed

CONVERGED_GRID = {"grid.n_z": 2400, "step.conduction": "0.125 ms"}


def calibrated_scale(
    configuration: Configuration, layer: str = "longitudinal", speed: float = CALIBRATED_SPEED
) -> float:
    """The conductivity scale at which the grid-converged wave of a layer runs at `speed` [cm/s].

    The search brackets the shipped scale between its half and its double. Raises ConfigurationError if no scale in
    the bracket does it, for example because the tissue does not conduct.
    """
    shipped = configuration.flat()[f"{layer}.conductivity_scale"]
    assert isinstance(shipped, float)

    def excess(scale: float) -> float:
        changed = configuration.with_changes({**CONVERGED_GRID, f"{layer}.conductivity_scale": scale})
        found = cable_wave_speed(changed, layer)
        return (found or 0.0) - speed

    low, high = 0.5 * shipped, 2.0 * shipped
    if excess(low) * excess(high) > 0.0:
        raise ConfigurationError(
            f"{layer}.conductivity_scale: no value between {low:g} and {high:g} gives {speed:g} cm/s; check the "
            "conductances of the layer"
        )
    return float(brentq(excess, low, high, xtol=1e-4 * shipped, rtol=1e-4))
