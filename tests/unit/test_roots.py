"""Brent's method against roots that are known."""

import math

import pytest

from peristalsis.numerics import roots
from peristalsis.numerics.roots import find_root


@pytest.mark.parametrize(
    ("function", "low", "high", "root"),
    [
        (lambda x: x * x - 2.0, 0.0, 2.0, math.sqrt(2.0)),
        (lambda x: math.cos(x) - x, 0.0, 1.0, 0.7390851332151607),
        (lambda x: math.exp(-x) - 1e-12, 0.0, 100.0, 12.0 * math.log(10.0)),
        (lambda x: (x - 0.3) ** 9, 0.0, 1.0, 0.3),
        (lambda x: 1.0 if x > 0.1 else -1.0, -1.0, 1.0, 0.1),
        (lambda x: x, 0.0, 1.0, 0.0),
        (lambda x: 5.0 - x, 0.0, 5.0, 5.0),
    ],
)
def test_root_is_found(function, low: float, high: float, root: float) -> None:  # type: ignore[no-untyped-def]
    """Smooth, flat, stepped, and at an end of the range."""
    tolerance = 2e-2 if root == 0.3 else 1e-11
    assert find_root(function, low, high, 1e-13) == pytest.approx(root, abs=tolerance)


def test_smooth_roots_take_few_calls() -> None:
    """Better than bisection, which would take 43 calls to this tolerance."""
    calls = []
    find_root(lambda x: calls.append(x) or math.exp(x) - 3.0, 0.0, 4.0, 1e-12)
    assert len(calls) <= 15


def test_no_change_of_sign_is_an_error() -> None:
    with pytest.raises(ValueError, match="no change of sign between 1 and 2"):
        find_root(lambda x: x, 1.0, 2.0)


def test_search_ends_with_its_best_where_iterations_run_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """One call an iteration beside those at the ends; the last place is inside of the range, and nearer than they."""
    monkeypatch.setattr(roots, "ITERATIONS", 3)
    calls: list[float] = []
    found = find_root(lambda x: calls.append(x) or x * x - 2.0, 0.0, 2.0, 1e-13)  # type: ignore[func-returns-value]
    assert len(calls) == 5
    assert found == calls[-1]
    assert 0.0 < abs(found - math.sqrt(2.0)) < 0.5
