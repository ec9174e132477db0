"""The calibrated wave of both layers on the undeformed cable, Eqs. (6), (11), (31); stretch is E6."""

import pytest

from peristalsis.inputs.config import Configuration
from peristalsis.many.cable import cable_wave_speed
from verification.exact.wave import speed


@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_calibrated_wave_on_the_default_grid(layer: str) -> None:
    """Calibrated once, on the undeformed cable from rest: 4.2 cm/s to a per cent."""
    assert speed(layer, 1000) == pytest.approx(4.2, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_calibrated_wave_does_not_depend_on_the_grid(layer: str) -> None:
    """A grid twice finer keeps 4.2 cm/s to a per cent, and moves it by less than half of one."""
    fine = speed(layer, 2000)
    assert fine == pytest.approx(4.2, rel=0.01)
    assert fine == pytest.approx(speed(layer, 1000), rel=5e-3)


@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_the_cable_conducts_as_a_run_does(layer: str) -> None:
    """On the shipped cells a corrected front has its exact speed (85), and one that is not is 1.2 % slow."""
    exact = speed(layer, 2000)
    assert cable_wave_speed(Configuration(), layer) == pytest.approx(exact, rel=1e-3)
    plain = Configuration().with_changes({"tissue.front_correction": "none"})
    assert cable_wave_speed(plain, layer) == pytest.approx(0.988 * exact, rel=2e-3)
