"""A root of one equation by Brent's method: loading a library for it alone takes longer than a run's steps.

Source: R. P. Brent, Algorithms for Minimization without Derivatives (1973), ch. 4.
"""

from __future__ import annotations

from collections.abc import Callable

ITERATIONS = 200
EPSILON = 2.0**-52


def find_root(function: Callable[[float], float], low: float, high: float, tolerance: float = 2e-12) -> float:
    """A place between `low` and `high` where `function` changes its sign, to `tolerance` or the rounding of the place.

    Raises ValueError when the function has the same sign at both ends.
    """
    a, b = float(low), float(high)
    fa, fb = function(a), function(b)
    if not fa * fb <= 0.0:
        raise ValueError(f"no change of sign between {a:g} and {b:g}")
    c, fc = a, fa
    step = before = b - a
    for _ in range(ITERATIONS):
        if fb * fc > 0.0:
            c, fc = a, fa
            step = before = b - a
        if abs(fc) < abs(fb):
            a, b, c = b, c, b
            fa, fb, fc = fb, fc, fb
        near = 2.0 * EPSILON * abs(b) + 0.5 * tolerance
        middle = 0.5 * (c - b)
        if abs(middle) <= near or fb == 0.0:
            return b
        if abs(before) < near or abs(fa) <= abs(fb):
            step = before = middle
        else:
            # Secant with two points, inverse quadratic with three; bisection where neither would shrink the range.
            s = fb / fa
            if a == c:
                p, q = 2.0 * middle * s, 1.0 - s
            else:
                q, r = fa / fc, fb / fc
                p = s * (2.0 * middle * q * (q - r) - (b - a) * (r - 1.0))
                q = (q - 1.0) * (r - 1.0) * (s - 1.0)
            if p > 0.0:
                q = -q
            p = abs(p)
            if 2.0 * p < min(3.0 * middle * q - abs(near * q), abs(before * q)):
                before, step = step, p / q
            else:
                step = before = middle
        a, fa = b, fb
        b += step if abs(step) > near else (near if middle > 0.0 else -near)
        fb = function(b)
    return b
