"""A pellet under a given force, moved by the package's law and its rule in time, Eqs. (13), (27), (34)."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from verification.friction import travel


@settings(max_examples=200)
@given(
    st.lists(st.floats(-500, 3000), min_size=3, max_size=12),
    st.floats(20, 2000),
    st.floats(0, 1000),
    st.floats(1.0, 5.0),
    st.floats(0.0, 500.0),
)
def test_more_friction_is_never_faster(
    knots: list[float], viscous: float, dry: float, factor: float, more: float
) -> None:
    """F9, 200 drives that only push forward: larger eta and larger F_d never arrive earlier, and never go back."""
    t = np.linspace(0.0, 1.0, len(knots))

    def force(x: float) -> float:
        return max(0.0, float(np.interp(x, t, knots)))

    usual = travel(force, viscous, dry, 1.0, 100)
    assert np.all(travel(force, viscous * factor, dry, 1.0, 100) <= usual + 1e-12)
    assert np.all(travel(force, viscous, dry + more, 1.0, 100) <= usual + 1e-12)
    assert np.all(np.diff(usual) >= 0.0)
