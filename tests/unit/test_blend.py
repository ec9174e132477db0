"""The smooth positive part and the floor, Eqs. (14), (15) and (36)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.numerics.blend import floored, fold_resistance, positive_part

WIDTH = 0.05
values = st.floats(-1.0, 1.0)


def test_positive_part_is_the_identity_above_and_nothing_below() -> None:
    assert positive_part(WIDTH, WIDTH) == (WIDTH, 1.0)
    assert positive_part(-WIDTH, WIDTH) == (0.0, 0.0)
    assert positive_part(-3.0, 0.0) == (-3.0, 1.0), "without width there is no smoothing at all"


def test_positive_part_adds_three_sixteenths_at_zero() -> None:
    """The stated offset, by which resting tension is raised: 3b/16."""
    assert positive_part(0.0, WIDTH)[0] == pytest.approx(3.0 * WIDTH / 16.0, rel=1e-15)


@pytest.mark.parametrize("edge", [-WIDTH, WIDTH])
def test_joints_are_twice_differentiable(edge: float) -> None:
    """Value, slope and curvature pass through the joints: a jump would cost Newton its order."""
    d = 1e-7
    (below, slope_below), (above, slope_above) = positive_part(edge - d, WIDTH), positive_part(edge + d, WIDTH)
    assert above - below == pytest.approx(d * (slope_below + slope_above), abs=1e-13)
    assert slope_above == pytest.approx(slope_below, abs=1e-9)


@given(values)
def test_derivatives_are_those_of_the_values(x: float) -> None:
    """Central differences at any argument; positive part between 0 and its argument plus 3b/16, and rising."""
    d = 1e-6
    for function in (lambda v: positive_part(v, WIDTH), lambda v: floored(v, WIDTH, 0.2)):
        difference = (function(x + d)[0] - function(x - d)[0]) / (2.0 * d)
        assert function(x)[1] == pytest.approx(difference, abs=1e-6)
    value, slope = positive_part(x, WIDTH)
    assert max(x, 0.0) <= value <= max(x, 0.0) + 0.1875 * WIDTH + 1e-15
    assert slope >= 0.0


@given(values)
def test_floor_keeps_a_small_slope_below_zero(x: float) -> None:
    value, slope = floored(x, WIDTH, 1e-3)
    assert slope >= 1e-3
    if x < -WIDTH:
        assert value == pytest.approx(1e-3 * x, rel=1e-12)
    if x > WIDTH:
        assert value == x


@given(st.floats(0.02, 2.0))
def test_folds_resist_only_when_packed(stretch: float) -> None:
    """Eq. (36): nothing at or above the limit, compression that grows below it, with its own derivative."""
    value, slope = fold_resistance(stretch, 0.2, 10.0)
    if stretch >= 0.2:
        assert (value, slope) == (0.0, 0.0)
    else:
        d = 1e-7
        difference = (fold_resistance(stretch + d, 0.2, 10.0)[0] - fold_resistance(stretch - d, 0.2, 10.0)[0]) / (2 * d)
        assert value < 0.0
        assert slope == pytest.approx(difference, rel=1e-4, abs=1e-3)
    assert np.all(np.array(fold_resistance(stretch, 0.2, 0.0)) == 0.0)
