"""A pellet under a given force, moved by the package's law and its rule in time, Eqs. (13), (27), (34)."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from peristalsis.pellet.friction import sliding_velocity
from peristalsis.verification.exact.orders import assert_order
from peristalsis.verification.exact.pellets import Oscillation, Ramp


def travel(force: Callable[[float], float], viscous: float, dry: float, end: float, steps: int) -> np.ndarray:
    """Places at every step by the trapezoidal rule of Eq. (34)."""
    t = np.linspace(0.0, end, steps + 1)
    v = np.array([sliding_velocity(force(float(x)), viscous, dry)[0] for x in t])
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])


def test_ramp_starts_in_time_and_converges() -> None:
    """F2: starts within a step of F_d/beta; the place then converges at order 2 where the start is a step's end."""
    ramp = Ramp(rate=400.0, viscous=230.0, dry=100.0)
    levels, errors = [16, 32, 64, 128], []
    for steps in levels:
        z = travel(ramp.force, ramp.viscous, ramp.dry, 1.1, steps)
        moving = np.flatnonzero(z > 0.0)[0] * 1.1 / steps
        assert 0.0 <= moving - ramp.start <= 2 * 1.1 / steps
        errors.append(abs(z[-1] - ramp.travel(1.1)))
    assert errors[-1] <= 1e-4
    assert errors[-1] < 0.1 * errors[0], "first order or better"


def test_oscillating_force_slips_between_two_phases() -> None:
    """F3: travel of a half period to 1e-4, and at order 2 on steps that hit neither phase specially."""
    drive = Oscillation(amplitude=300.0, omega=2.0 * np.pi, viscous=230.0, dry=100.0)
    exact = drive.travel_of_half_period()
    z = travel(drive.force, drive.viscous, drive.dry, 0.5, 2000)
    assert z[-1] == pytest.approx(exact, rel=1e-4)
    smooth = Oscillation(amplitude=300.0, omega=2.0 * np.pi, viscous=230.0, dry=0.0)
    levels = [16, 32, 64, 128]
    errors = [
        abs(
            travel(smooth.force, 230.0, 0.0, 0.37, n)[-1]
            - 300.0 / 230.0 / smooth.omega * (1.0 - np.cos(0.37 * smooth.omega))
        )
        for n in levels
    ]
    assert_order([1.0 / n for n in levels], errors, 2.0)


def test_cycle_without_bias_goes_nowhere_and_with_bias_somewhere() -> None:
    """F3: no net travel to 1e-12 in a symmetric cycle; a bias rectifies, in its own direction."""
    cycle = travel(Oscillation(300.0, 2.0 * np.pi, 230.0, 100.0).force, 230.0, 100.0, 1.0, 1000)
    assert abs(cycle[-1]) <= 1e-12
    for bias in (20.0, -20.0):
        drifted = travel(Oscillation(300.0, 2.0 * np.pi, 230.0, 100.0, bias).force, 230.0, 100.0, 1.0, 1000)[-1]
        assert drifted * bias > 0.01


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
