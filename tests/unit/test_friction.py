"""The law of friction, Eqs. (13) and (27)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.pellet.friction import sliding_velocity

forces = st.floats(-5000, 5000)
frictions = st.floats(0, 3000)
viscosities = st.floats(1.0, 5000)


@given(forces, viscosities, frictions)
def test_sticks_exactly_or_slides_at_the_excess(force: float, viscous: float, dry: float) -> None:
    """F1: 0.0, not a small number, while |F| <= F_d; else sgn(F)(|F| - F_d)/eta."""
    velocity, slope = sliding_velocity(force, viscous, dry)
    if abs(force) <= dry:
        assert (velocity, slope) == (0.0, 0.0)
    else:
        exact = (abs(force) - dry) / viscous * (1.0 if force > 0 else -1.0)
        assert velocity == pytest.approx(exact, rel=1e-14)
        assert slope == 1.0 / viscous
        assert viscous * velocity + dry * (1.0 if velocity > 0 else -1.0) == pytest.approx(force, rel=1e-12)


@given(forces, viscosities, frictions)
def test_friction_is_the_same_both_ways_and_takes_energy(force: float, viscous: float, dry: float) -> None:
    velocity = sliding_velocity(force, viscous, dry)[0]
    assert sliding_velocity(-force, viscous, dry)[0] == -velocity
    assert force * velocity >= 0.0


@given(forces, viscosities)
def test_limits(force: float, viscous: float) -> None:
    """F9: without dry friction v = F/eta; friction without bound holds the pellet for ever."""
    assert sliding_velocity(force, viscous, 0.0)[0] == pytest.approx(force / viscous, rel=1e-14)
    assert abs(sliding_velocity(force, 1e12, 0.0)[0]) <= 5e-9
    assert sliding_velocity(force, viscous, 1e9)[0] == 0.0
