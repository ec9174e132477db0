"""E15: cross-bridges of Hai and Murphy against the matrix exponential and a stiff solver, Eqs. (79)-(82)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm, null_space

from peristalsis.inputs.parts import find
from peristalsis.tissue.activation import activation_of

from .problem import Check, Outcome, Problem, error, judged, order

Floats = NDArray[np.float64]

PART = find("activation", "hai_murphy")
SECONDS = 3.0


def _constants() -> Any:
    numbers = {one.name: one.value for one in PART.parameters} | {"fastest": 3.0}
    return activation_of("hai_murphy", PART.file).kernels.ActivationConstants(**numbers)


def rates(calcium: float, c: Any) -> Floats:
    """The matrix of Eq. (80), written once more: columns are the states M, Mp, AMp, AM that are left [1/s]."""
    kinase = c.fastest * calcium**c.exponent / (c.half**c.exponent + calcium**c.exponent)
    phosphatase, on, off, latch = c.dephosphorylation, c.attachment, c.detachment, c.latch_detachment
    return np.array(
        [
            [-kinase, phosphatase, 0.0, latch],
            [kinase, -phosphatase - on, off, 0.0],
            [0.0, on, -off - phosphatase, kinase],
            [0.0, 0.0, phosphatase, -kinase - latch],
        ]
    )


def calcium_at(time: float) -> float:
    """Calcium that goes up and down [uM]."""
    return 0.45 + 0.35 * np.sin(2.0 * time)


def cross_bridges() -> Outcome:
    """Steps of 2 ms to a minute at constant calcium, the steady state, and three seconds of changing calcium."""
    kernels, c = activation_of("hai_murphy", PART.file).kernels, _constants()
    start = np.array([0.9, 0.05, 0.03, 0.02])
    held = np.array([0.5])
    constant = []
    for dt in (2e-3, 0.1, 3.0, 60.0):
        states = start[:, None].copy()
        kernels.advance_states(held, held, 1.0, dt, c, states)
        constant.append(float(np.abs(states[:, 0] - expm(dt * rates(0.5, c)) @ start).max()))
    steady = np.zeros((4, 1))
    kernels.set_steady(held, 1.0, c, steady)
    still = null_space(rates(0.5, c))[:, 0]
    exact = solve_ivp(
        lambda t, y: rates(calcium_at(t), c) @ y, (0.0, SECONDS), start, method="LSODA", rtol=1e-12, atol=1e-14
    ).y[:, -1]
    sizes, errors = [], []
    for steps in (12, 24, 48, 96, 192):
        states, dt = start[:, None].copy(), SECONDS / steps
        for k in range(steps):
            ends = np.array([calcium_at(k * dt)]), np.array([calcium_at((k + 1) * dt)])
            kernels.advance_states(*ends, 1.0, dt, c, states)
        sizes.append(dt)
        errors.append(float(np.abs(states[:, 0] - exact).max()))
    return judged(
        "shares of the four states",
        [
            error("steps of 2 ms to 60 s at constant calcium, against the matrix exponential", max(constant), 1e-13),
            error("steady state against the null vector", np.abs(steady[:, 0] - still / still.sum()).max(), 1e-13),
            order("in time, in changing calcium", sizes[1:], errors[1:], 2.0),
            Check("smallest error in changing calcium", errors[-1], 0.0, 1e-5),
            error("sum of the shares", float(states.sum()) - 1.0, 1e-13),
        ],
    )


PROBLEMS = (
    Problem(
        "E15",
        "Cross-bridges of smooth muscle",
        "Hai & Murphy, Am. J. Physiol. 254 (1988), coded anew: matrix exponential and LSODA",
        "quick",
        cross_bridges,
        (79, 80, 82),
    ),
)
