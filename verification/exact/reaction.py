"""Cables with a given reaction, stepped by the operator (30) and the stabilised method of (31).

The sheet's own kernel is bound to one cell model; here its operator and its time step meet reactions whose waves
are known in closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.conduction import largest_eigenvalue

from .cable import apply_operator

Floats = NDArray[np.float64]


@dataclass
class ReactingCable:
    """u_t = D u_zz + reaction(u) between sealed ends; `steepest` bounds the size of the reaction's slope."""

    z: Floats
    u: Floats
    diffusivity: float
    reaction: Callable[[Floats], Floats]
    steepest: float

    @property
    def h(self) -> float:
        """Cell size."""
        return float(self.z[1] - self.z[0])

    def rate(self, u: Floats) -> Floats:
        """du/dt."""
        return apply_operator(u, self.diffusivity, self.h) + self.reaction(u)

    def advance(self, dt: float, steps: int) -> None:
        """Steps of the stabilised Runge-Kutta-Chebyshev method, with as many stages as stability asks for."""
        table = coefficients(stages_for(dt * (largest_eigenvalue(self.diffusivity, self.h) + self.steepest)))
        for _ in range(steps):
            start, first = self.u, dt * self.rate(self.u)
            older, last = start, start + table[0, 2] * first
            for mu, nu, mu_rate, gamma_rate in table[1:]:
                new = (1.0 - mu - nu) * start + mu * last + nu * older
                new += mu_rate * dt * self.rate(last) + gamma_rate * first
                older, last = last, new
            self.u = last

    def place(self) -> float:
        """Place of a front from 1 to 0: the area under it, to which the grid adds no error of its own."""
        return float(self.u.sum() * self.h)


@dataclass(frozen=True)
class Nagumo:
    """Front of u_t = D u_zz + kappa u (1 - u)(u - a): u = 1/(1 + exp((z - c t)/w))."""

    threshold: float
    diffusivity: float = 1.0
    rate: float = 1.0

    @property
    def width(self) -> float:
        """w = sqrt(2 D/kappa)."""
        return float(np.sqrt(2.0 * self.diffusivity / self.rate))

    @property
    def speed(self) -> float:
        """c = sqrt(kappa D/2)(1 - 2 a)."""
        return float(np.sqrt(0.5 * self.rate * self.diffusivity) * (1.0 - 2.0 * self.threshold))

    def cable(self, cells_per_width: float, length: float, start: float) -> ReactingCable:
        """The exact front at `start` on a sealed cable; length and start in units of w."""
        n = round(length * cells_per_width)
        z = (np.arange(n) + 0.5) * self.width * length / n
        u = 1.0 / (1.0 + np.exp(np.clip((z - start * self.width) / self.width, -500.0, 500.0)))

        def reaction(x: Floats) -> Floats:
            return self.rate * x * (1.0 - x) * (x - self.threshold)

        return ReactingCable(z, u, self.diffusivity, reaction, self.rate)


def mckean_speed(threshold: float) -> float:
    """Speed of the front of u_t = u_zz - u + H(u - a): (1 - 2a)/sqrt(a (1 - a))."""
    return (1.0 - 2.0 * threshold) / float(np.sqrt(threshold * (1.0 - threshold)))


@dataclass(frozen=True)
class PathmanathanGray:
    """The unforced nonlinear problem on a sealed cable: V = sqrt(1 + t) cos(n pi z/L), three gates.

    Source: P. Pathmanathan, R. A. Gray, Int. J. Numer. Meth. Biomed. Eng. 30 (2014), here with C = chi = 1 and
    G = 1 + z/(2 L), which enters pointwise only.
    """

    diffusivity: float = 0.05
    mode: int = 2
    length: float = 2.0

    @property
    def beta(self) -> float:
        """-D (n pi/L)^2."""
        return -self.diffusivity * (self.mode * np.pi / self.length) ** 2

    def exact(self, z: Floats, t: float) -> tuple[Floats, Floats]:
        """V (n,) and the gates (3, n)."""
        shape = np.cos(self.mode * np.pi * z / self.length)
        g = 1.0 + 0.5 * z / self.length
        v = np.sqrt(1.0 + t) * shape
        return v, np.stack([(1.0 + t) * g**2 + v, 1.0 / ((1.0 + t) * g), np.zeros_like(z)])

    def current(self, v: Floats, gates: Floats) -> Floats:
        """I_ion."""
        u1, u2, u3 = gates
        return np.asarray(-0.5 * (u1 + u3 - v) * u2**2 * (v - u3) + self.beta * (v - u3))

    def _inward(self, gates: Floats, v: Floats) -> Floats:
        return -self.current(v, gates)

    def gate_rates(self, v: Floats, gates: Floats) -> Floats:
        """du/dt of the three gates."""
        u1, u2, u3 = gates
        w = u1 + u3 - v
        return np.stack([w**2 * u2**2 + 0.5 * w * u2**2 * (v - u3), -w * u2**3, np.zeros_like(v)])

    def solve(self, cells: int, steps: int, end: float = 0.5) -> tuple[Floats, Floats]:
        """(V, exact V) at `end` by gates-potential-gates steps, Eq. (31); gates by the classical Runge-Kutta method."""
        z = (np.arange(cells) + 0.5) * self.length / cells
        v, gates = self.exact(z, 0.0)
        dt = end / steps
        for _ in range(steps):
            gates = self._relaxed(v, gates, 0.5 * dt)
            cable = ReactingCable(z, v, self.diffusivity, partial(self._inward, gates), 1.0)
            cable.advance(dt, 1)
            v = cable.u
            gates = self._relaxed(v, gates, 0.5 * dt)
        return v, self.exact(z, end)[0]

    def _relaxed(self, v: Floats, gates: Floats, dt: float) -> Floats:
        a = self.gate_rates(v, gates)
        b = self.gate_rates(v, gates + 0.5 * dt * a)
        c = self.gate_rates(v, gates + 0.5 * dt * b)
        d = self.gate_rates(v, gates + dt * c)
        return np.asarray(gates + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d))
