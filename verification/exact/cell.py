"""Plant's bursting cell written anew from Eqs. (20)-(22), and solved by a general-purpose integrator.

Source: R. E. Plant, J. Math. Biol. 11 (1981), 15-32; BioModels BIOMD0000000304. Nothing here comes from the package.
State: V [mV], h, n, x, c; time in ms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Floats = NDArray[np.float64]

BURSTING_START = (-55.0, 0.9, 0.27, 0.03, 0.4)
"""V, h, x, n, c from which the burst of the reference is measured (the order of the source)."""


def _linoid(x: float) -> float:
    return 1.0 if abs(x) < 1e-12 else x / np.expm1(x)


@dataclass(frozen=True)
class ReferenceCell:
    """The cell at a given slow conductance [mS/cm^2], its clock slowed by `rate`, under a constant current."""

    slow: float = 0.004
    rate: float = 0.125
    fast: float = 4.0
    potassium: float = 0.3
    calcium_potassium: float = 0.03
    leak: float = 0.003

    def steady_gates(self, v: float) -> tuple[float, float, float, float]:
        """h, n, x, c at rest at potential v."""
        a_h, b_h, a_n, b_n = self._rates(v)
        x = 1.0 / (1.0 + np.exp(-0.15 * (v + 50.0)))
        return a_h / (a_h + b_h), a_n / (a_n + b_n), x, 0.0085 * x * (140.0 - v)

    def current(self, v: float, h: float, n: float, x: float, c: float) -> float:
        """I_ion [uA/cm^2], outward positive, Eq. (21)."""
        u = (127.0 * v + 8265.0) / 105.0
        a_m, b_m = _linoid((50.0 - u) / 10.0), 4.0 * np.exp((25.0 - u) / 18.0)
        m = a_m / (a_m + b_m)
        inward = (self.fast * m**3 * h + self.slow * x) * (v - 30.0)
        outward = (self.potassium * n**4 + self.calcium_potassium * c / (0.5 + c)) * (v + 75.0)
        return float(inward + outward + self.leak * (v + 40.0))

    def slope(self, y: Floats, stimulus: float = 0.0) -> Floats:
        """d/dt of (V, h, n, x, c)."""
        v, h, n, x, c = y
        a_h, b_h, a_n, b_n = self._rates(v)
        x_steady = 1.0 / (1.0 + np.exp(-0.15 * (v + 50.0)))
        own = np.array(
            [
                -self.current(v, h, n, x, c),
                (a_h * (1.0 - h) - b_h * h) / 12.5,
                (a_n * (1.0 - n) - b_n * n) / 12.5,
                (x_steady - x) / 235.0,
                0.0003 * (0.0085 * x * (140.0 - v) - c),
            ]
        )
        own *= self.rate
        own[0] += stimulus
        return own

    def steady_states(self) -> list[float]:
        """Every potential between -100 and 0 mV at which nothing moves."""

        def net(v: float) -> float:
            return self.current(v, *self.steady_gates(v))

        scan = np.linspace(-100.0, 0.0, 4001)
        values = np.array([net(v) for v in scan])
        roots = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        return [float(brentq(net, scan[k], scan[k + 1], xtol=1e-13)) for k in roots]

    def growth(self, v: float) -> float:
        """Largest real part of the eigenvalues at the steady state v [1/ms], by central differences."""
        y = np.array([v, *self.steady_gates(v)])
        columns = []
        for k in range(5):
            step = np.zeros(5)
            step[k] = 1e-6 * max(1.0, abs(y[k]))
            columns.append((self.slope(y + step) - self.slope(y - step)) / (2.0 * step[k]))
        return float(np.linalg.eigvals(np.array(columns).T).real.max())

    def solve(
        self, y: Floats, pieces: list[tuple[float, float]], times: Floats, rtol: float = 1e-12, method: str = "DOP853"
    ) -> Floats:
        """V at `times` [ms], by an integrator of scipy; pieces: (duration [ms], stimulus), joined end to end."""
        found, begin = np.full(times.size, np.nan), 0.0
        for duration, stimulus in pieces:
            end = begin + duration
            inside = (times >= begin - 1e-9) & (times <= end + 1e-9)
            solution = solve_ivp(
                lambda t, s, i=stimulus: self.slope(s, i),
                (begin, end),
                y,
                method=method,
                rtol=rtol,
                atol=1e-13,
                dense_output=True,
            )
            if inside.any():
                found[inside] = solution.sol(np.clip(times[inside], begin, end))[0]
            y, begin = solution.y[:, -1], end
        return found

    @staticmethod
    def _rates(v: float) -> tuple[float, float, float, float]:
        u = (127.0 * v + 8265.0) / 105.0
        return (
            0.07 * np.exp((25.0 - u) / 20.0),
            1.0 / (1.0 + np.exp((55.0 - u) / 10.0)),
            0.1 * _linoid((55.0 - u) / 10.0),
            0.125 * np.exp((45.0 - u) / 80.0),
        )
