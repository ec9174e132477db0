"""Observed orders of convergence, gated from both sides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def observed_orders(sizes: Sequence[float], errors: Sequence[float]) -> np.ndarray:
    """Order between each pair of neighbouring levels: the slope of log error over log size."""
    return np.diff(np.log(errors)) / np.diff(np.log(sizes))


def assert_order(
    sizes: Sequence[float], errors: Sequence[float], expected: float, tolerance: float = 0.1, levels: int = 4
) -> None:
    """Every observed order lies within `tolerance` of the expected one, above as well as below.

    A higher order than promised is a failure too: then the problem does not exercise the scheme.
    """
    assert len(sizes) == len(errors) >= levels, f"{len(errors)} levels, at least {levels} are needed"
    assert np.all(np.isfinite(errors)), f"errors are not finite: {errors}"
    assert np.all(np.asarray(errors) > 0.0), f"errors vanish: {errors}"
    orders = observed_orders(sizes, errors)
    assert np.all(np.abs(orders - expected) <= tolerance), (
        f"orders {np.round(orders, 3)} instead of {expected} +- {tolerance}; errors {np.array(errors)}"
    )
