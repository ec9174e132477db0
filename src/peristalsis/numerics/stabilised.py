"""Runge-Kutta-Chebyshev methods of second order: explicit steps whose stability grows with the stages squared.

Source: B. P. Sommeijer, L. F. Shampine, J. G. Verwer, "RKC: An explicit solver for parabolic PDEs", J. Comput. Appl.
Math. 88 (1998) 315-326: the damped method of order two with their choice of damping, 2/13.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

DAMPING = 2.0 / 13.0
MOST_STAGES = 200


@cache
def stability_limit(stages: int) -> float:
    """Largest step times decay rate that a method of this many stages (2 or more) damps."""
    w0, first, second = _ends(stages)
    return (w0 + 1.0) * second / first


def stages_for(product: float) -> int:
    """Least number of stages for a step times decay rate, with a tenth in hand; 0 if 200 would not do."""
    stages = 2
    while not 1.1 * product <= stability_limit(stages):
        stages += 1
        if stages > MOST_STAGES:
            return 0
    return stages


@cache
def coefficients(stages: int) -> NDArray[np.float64]:
    """Rows (mu, nu, mu~, gamma~) of the stages 1...s, shape (s, 4): stage j is

    (1 - mu - nu) Y_0 + mu Y_{j-1} + nu Y_{j-2} + mu~ dt F(Y_{j-1}) + gamma~ dt F(Y_0).
    """
    w0, first, second = _ends(stages)
    w1 = first / second
    t, dt, ddt = _chebyshev(stages, w0)
    b = np.empty(stages + 1)
    b[2:] = ddt[2:] / dt[2:] ** 2
    b[:2] = b[2]
    a = 1.0 - b * t
    table = np.zeros((stages, 4))
    table[0] = 0.0, 0.0, b[1] * w1, 0.0
    for j in range(2, stages + 1):
        tilde = 2.0 * b[j] * w1 / b[j - 1]
        table[j - 1] = 2.0 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2], tilde, -a[j - 1] * tilde
    return table


def _ends(stages: int) -> tuple[float, float, float]:
    w0 = 1.0 + DAMPING / stages**2
    _, first, second = _chebyshev(stages, w0)
    return w0, float(first[-1]), float(second[-1])


def _chebyshev(order: int, x: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Chebyshev polynomials 0...order at x with first and second derivatives."""
    t, first, second = np.zeros(order + 1), np.zeros(order + 1), np.zeros(order + 1)
    t[0], t[1], first[1] = 1.0, x, 1.0
    for j in range(2, order + 1):
        t[j] = 2.0 * x * t[j - 1] - t[j - 2]
        first[j] = 2.0 * t[j - 1] + 2.0 * x * first[j - 1] - first[j - 2]
        second[j] = 4.0 * first[j - 1] + 2.0 * x * second[j - 1] - second[j - 2]
    return t, first, second
