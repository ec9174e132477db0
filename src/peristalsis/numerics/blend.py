"""The smooth positive part used where a soft shell must not carry compression, Eqs. (14) and (15).

Written as choices between values, all of them computed, so that loops over these formulas run on vector registers.
"""

from __future__ import annotations

from .compiled import inlined


@inlined
def positive_part(value: float, width: float) -> tuple[float, float]:
    """C2 positive part and its derivative: `value` above +width, 0 below -width, Eq. (14).

    width = 0 gives the identity: the exact problems run without any smoothing.
    """
    above = (width <= 0.0) | (value >= width)
    below = value <= -width
    x = value * (1.0 / width)
    x2 = x * x
    part = width * (-x2 * x2 / 16.0 + 0.375 * x2 + 0.5 * x + 0.1875)
    derivative = -0.25 * x2 * x + 0.75 * x + 0.5
    return (
        value if above else (0.0 if below else part),
        1.0 if above else (0.0 if below else derivative),
    )


@inlined
def floored(value: float, width: float, slope: float) -> tuple[float, float]:
    """The total tension that the shell carries and its derivative: a small slope below zero, Eq. (15)."""
    above = (width <= 0.0) | (value >= width)
    part, derivative = positive_part(value, width)
    return (
        value if above else slope * value + (1.0 - slope) * part,
        1.0 if above else slope + (1.0 - slope) * derivative,
    )


@inlined
def fold_resistance(stretch: float, limit: float, tension: float) -> tuple[float, float]:
    """Compression [same unit as `tension`] of a wall folded below the stretch `limit`, and its derivative, Eq. (36).

    -tension*(limit/stretch - 1)^2 below the limit, zero above it: negligible until the folds are packed.
    """
    inverse = 1.0 / stretch
    ratio = limit * inverse
    excess = max(ratio - 1.0, 0.0)
    return -tension * excess * excess, 2.0 * tension * excess * ratio * inverse
