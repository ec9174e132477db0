"""exp(x) in plain arithmetic, so that a loop over nodes runs on vector registers; a library call would not.

Reduction by multiples of ln 2 in two parts (Cody & Waite), then the Taylor polynomial of degree 12: within 3 units in
the last place for |x| <= 700, with no branch and no table. The same bits on every processor with IEEE 754.
"""

from __future__ import annotations

import numpy as np

from .compiled import inlined

PER_LN2 = 1.4426950408889634
LN2_HIGH = 6.93147180369123816490e-01
LN2_LOW = 1.90821492927058770002e-10
ROUNDER = 6755399441055744.0
"""1.5 * 2^52: adding it leaves the nearest whole number in the low bits of the sum."""
MANTISSA_BITS = 52


@inlined
def exponential(x: float) -> float:
    """exp(x) for |x| <= 700; outside, and for nan, the value means nothing and the caller must not use it."""
    shifted = x * PER_LN2 + ROUNDER
    twos = shifted - ROUNDER
    r = (x - twos * LN2_HIGH) - twos * LN2_LOW
    p = r * (1.0 / 479001600.0) + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * (r * r) + r
    exponent = np.float64(shifted).view(np.int64) << MANTISSA_BITS
    return np.int64(np.float64(p + 1.0).view(np.int64) + exponent).view(np.float64)
