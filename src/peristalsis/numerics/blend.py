"""The smooth positive part used where a soft shell must not carry compression, Eqs. (14) and (15)."""

from __future__ import annotations

from .compiled import compiled


@compiled
def positive_part(value: float, width: float) -> tuple[float, float]:
    """C2 positive part and its derivative: `value` above +width, 0 below -width, Eq. (14).

    width = 0 gives the identity: the exact problems run without any smoothing.
    """
    if width <= 0.0 or value >= width:
        return value, 1.0
    if value <= -width:
        return 0.0, 0.0
    x = value / width
    x2 = x * x
    return width * (-x2 * x2 / 16.0 + 0.375 * x2 + 0.5 * x + 0.1875), -0.25 * x2 * x + 0.75 * x + 0.5


@compiled
def floored(value: float, width: float, slope: float) -> tuple[float, float]:
    """The total tension that the shell carries and its derivative: a small slope below zero, Eq. (15)."""
    if width <= 0.0 or value >= width:
        return value, 1.0
    part, derivative = positive_part(value, width)
    return slope * value + (1.0 - slope) * part, slope + (1.0 - slope) * derivative


@compiled
def fold_resistance(stretch: float, limit: float, tension: float) -> tuple[float, float]:
    """Compression [same unit as `tension`] of a wall folded below the stretch `limit`, and its derivative, Eq. (36).

    -tension*(limit/stretch - 1)^2 below the limit, zero above it: negligible until the folds are packed.
    """
    if stretch >= limit:
        return 0.0, 0.0
    excess = limit / stretch - 1.0
    return -tension * excess * excess, 2.0 * tension * excess * limit / (stretch * stretch)
