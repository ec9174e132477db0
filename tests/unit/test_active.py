"""The active law: a parabola cut at zero, Eq. (5)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.wall.active import ActiveConstants, active_tension
from verification.exact.wall import CIRCULAR, LONGITUDINAL


@pytest.mark.parametrize(
    ("constants", "roots", "largest"),
    [(LONGITUDINAL, (0.5, 2.5), 40.0), (CIRCULAR, (0.499, 2.501), 25.05)],
    ids=["longitudinal", "circular"],
)
def test_roots_and_maximum(constants: ActiveConstants, roots: tuple[float, float], largest: float) -> None:
    """Zero outside the roots, largest at 3/2, as stated with Eq. (5)."""
    value, slope = active_tension(1.5, constants)
    assert value == pytest.approx(largest, rel=1e-12)
    assert slope == pytest.approx(0.0, abs=1e-12)
    for root, inward in zip(roots, (1.0, -1.0), strict=True):
        assert active_tension(root - 2e-3 * inward, constants) == (0.0, 0.0)
        assert 0.0 < active_tension(root + 2e-3 * inward, constants)[0] < 0.2


@given(st.floats(0.0, 4.0))
def test_never_pushes_and_knows_its_slope(stretch: float) -> None:
    for constants in (LONGITUDINAL, CIRCULAR):
        value, slope = active_tension(stretch, constants)
        assert value >= 0.0
        d = 1e-6
        if active_tension(stretch - d, constants)[0] > 0.0 and active_tension(stretch + d, constants)[0] > 0.0:
            difference = (active_tension(stretch + d, constants)[0] - active_tension(stretch - d, constants)[0]) / (
                2 * d
            )
            assert slope == pytest.approx(difference, abs=1e-6)
