"""The conduction operator where the stretch varies, Eq. (30); constant stretch is E1-E3, E8, E9."""

import numpy as np

from verification.exact.cable import (
    apply_operator,
)
from verification.exact.orders import assert_order

LENGTH = 10.0


def test_operator_is_fourth_order_where_the_stretch_varies() -> None:
    """Manufactured: D = 1 + 0.3 cos(2 pi z/L) at the faces, V = cos(pi z/L)."""
    sizes, errors = [], []
    k = np.pi / LENGTH
    for n in (32, 64, 128, 256):
        h = LENGTH / n
        z, faces = (np.arange(n) + 0.5) * h, np.arange(1, n) * h
        rate = apply_operator(np.cos(k * z), 1.0 + 0.3 * np.cos(2.0 * k * faces), h)
        spread, slope = 1.0 + 0.3 * np.cos(2.0 * k * z), -0.6 * k * np.sin(2.0 * k * z)
        exact = -k * np.sin(k * z) * slope - k * k * np.cos(k * z) * spread
        sizes.append(h)
        errors.append(float(np.abs(rate - exact).max()))
    assert_order(sizes, errors, 4.0)
