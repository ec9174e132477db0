"""The calibration of the conductivity: the root of a known law of speeds, and brackets that hold none."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many import calibration
from peristalsis.many.cable import CALIBRATED_SPEED
from peristalsis.many.calibration import CONVERGED_GRID, calibrated_scale

LAYERS = ("longitudinal", "circular")


def law(speed: float) -> Callable[[Configuration, str], float | None]:
    """Speeds as the root of the conductivity, this one at the shipped scale; none below 0.6 of it."""

    def measured(configuration: Configuration, layer: str) -> float | None:
        assert configuration.grid.n_z == CONVERGED_GRID["grid.n_z"]
        key = f"{layer}.conductivity_scale"
        share: Any = configuration.flat()[key]
        share = share / Configuration().flat()[key]
        return speed * math.sqrt(share) if share > 0.6 else None

    return measured


@pytest.mark.parametrize("layer", LAYERS)
def test_scale_is_the_root_of_the_law(monkeypatch: pytest.MonkeyPatch, layer: str) -> None:
    """A wave that is 10 % too slow needs 1/0.81 of the conductivity."""
    monkeypatch.setattr(calibration, "cable_wave_speed", law(0.9 * CALIBRATED_SPEED))
    shipped: Any = Configuration().flat()[f"{layer}.conductivity_scale"]
    assert calibrated_scale(Configuration(), layer) == pytest.approx(shipped / 0.81, rel=1e-3)
    assert calibrated_scale(Configuration(), layer, 1.2 * CALIBRATED_SPEED) == pytest.approx(
        shipped * (1.2 / 0.9) ** 2, rel=1e-3
    )


def test_speed_that_no_scale_gives_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "cable_wave_speed", law(CALIBRATED_SPEED))
    with pytest.raises(ConfigurationError, match=r"longitudinal\.conductivity_scale: no value between .* gives 9 cm/s"):
        calibrated_scale(Configuration(), speed=9.0)
