"""Time derivatives: variable-step BDF2 and backward Euler, Eq. (32)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.numerics.rates import STATIC, rate_formula
from verification.exact.orders import assert_order

steps = st.floats(1e-5, 1.0)


@given(steps, steps, st.floats(-3, 3), st.floats(-3, 3))
def test_second_order_formula_is_exact_for_parabolas(dt: float, before: float, a: float, b: float) -> None:
    """Any ratio of steps: the rate of a + b t + t^2 at the new time, with the older value where it was."""
    formula = rate_formula(dt, before, True)
    x = [a + b * t + t * t for t in (-before, 0.0, dt)]
    rate = (x[2] - formula.keep * x[1] - formula.older * x[0]) * formula.inverse
    scale = max(abs(v) for v in x) * (1.0 / dt + 1.0 / before)
    assert rate == pytest.approx(b + 2.0 * dt, abs=1e-12 + 1e-13 * scale * (1.0 + dt / before))


def test_start_and_request_give_backward_euler() -> None:
    assert rate_formula(0.5, 0.0, True) == rate_formula(0.5, 0.3, False) == (1.0, 0.0, 2.0)


def test_static_formula_has_no_rate() -> None:
    assert STATIC.inverse == 0.0


def relax(steps: int, second_order: bool, uneven: bool) -> float:
    """Error of y' = -y over one unit of time, in steps that alternate one to two if uneven."""
    pattern = np.tile([2.0, 4.0] if uneven else [3.0, 3.0], steps // 2)
    pattern /= pattern.sum()
    y, older, before = 1.0, 1.0, 0.0
    for dt in pattern:
        formula = rate_formula(float(dt), before, second_order)
        new = formula.inverse * (formula.keep * y + formula.older * older) / (formula.inverse + 1.0)
        y, older, before = new, y, float(dt)
    return abs(y - np.exp(-1.0))


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize(("second_order", "order"), [(True, 2.0), (False, 1.0)])
def test_order_on_even_and_uneven_steps(second_order: bool, order: float, uneven: bool) -> None:
    """Order 2 although every other step is twice as long, and the start is backward Euler."""
    levels = [64, 128, 256, 512, 1024]
    assert_order([1.0 / n for n in levels], [relax(n, second_order, uneven) for n in levels], order)
