"""A manufactured motion of the axisymmetric membrane, Eq. (1), and the body force that makes it a solution.

Body force = gamma0 x_tt minus everything else of Eq. (1), with exact derivatives: those by z of the tensions come from
complex steps. The solver has no body force; but where inertia is kept, a force f is the same as f/(gamma0 slope) added
to the history of the velocity, Eq. (32), so the unchanged solver can be given one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis.errors import DivergenceError
from peristalsis.model.constants import LumenConstants, Step
from peristalsis.model.equilibrium import History, solve_equilibrium
from peristalsis.model.problem import Limits, Unknowns
from peristalsis.model.verdicts import CONVERGED, REASONS
from peristalsis.numerics.rates import rate_formula
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere
from peristalsis.wall.constants import WallConstants

from .wall import assembled, gradient

Floats = NDArray[np.float64]
Number = Any

NO_PELLET = pellet_of(Sphere(0.5), present=False)


@dataclass(frozen=True)
class ManufacturedMotion:
    """rho = R + 0.05 sin(k z) cos(w t), zeta = 1.2 z + 0.03 sin(2 k z) cos(w t + 0.3), k = 2 pi/L.

    pressure [mN/cm^2] and pull (of muscle, a factor on smooth drives of both layers) may be 0 to leave a term out;
    viscosity and surface density are those of the wall.
    """

    wall: WallConstants
    length: float = 2.0
    pressure: float = 10.0
    pull: float = 1.0
    omega: float = 8.0
    radius: float = 0.85

    def place(self, z: Number, t: float, derivative: int = 0, rate: int = 0) -> tuple[Number, Number]:
        """(rho, zeta) or a derivative by z and by t."""
        k = 2.0 * np.pi / self.length
        turn = 0.5 * np.pi
        rho = 0.05 * k**derivative * np.sin(k * z + derivative * turn)
        zeta = 0.03 * (2.0 * k) ** derivative * np.sin(2.0 * k * z + derivative * turn)
        rho = rho * self.omega**rate * np.cos(self.omega * t + rate * turn)
        zeta = zeta * self.omega**rate * np.cos(self.omega * t + 0.3 + rate * turn)
        if rate == 0 and derivative == 0:
            return self.radius + rho, 1.2 * z + zeta
        if rate == 0 and derivative == 1:
            return rho, 1.2 + zeta
        return rho, zeta

    def stretches(self, z: Number, t: float) -> tuple[Number, Number, Number, Number]:
        """lambda_l, lambda_c and their rates."""
        (r, s), (rt, st) = self.place(z, t, 1), self.place(z, t, 1, 1)
        along = np.sqrt(r * r + s * s)
        hoop, hoop_rate = self.place(z, t)[0], self.place(z, t, 0, 1)[0]
        return along, hoop / self.wall.radius, (r * rt + s * st) / along, hoop_rate / self.wall.radius

    def drives(self, z: Number) -> tuple[Number, Number]:
        """Drives of both layers [mV]."""
        k = 2.0 * np.pi / self.length
        return 0.1 * self.pull * (1.0 + 0.5 * np.sin(k * z)), 0.15 * self.pull * (1.0 + 0.5 * np.cos(k * z))

    def tensions(self, z: Number, t: float) -> tuple[Number, Number]:
        """N_l and N_c."""
        along, hoop, along_rate, hoop_rate = self.stretches(z, t)
        wl, wc = gradient(along, hoop, self.wall.passive)
        dl, dc = self.drives(z)
        a, b = self.wall.longitudinal, self.wall.circular
        tl = wl + self.wall.viscosity * along_rate + dl * ((a.c7 * along + a.c8) * along + a.c9)
        tc = wc + self.wall.viscosity * hoop_rate + dc * ((b.c7 * hoop + b.c8) * hoop + b.c9)
        return (tl * hoop, tc * along) if self.wall.published else (tl, tc)

    def body_force(self, z: Floats, t: float) -> tuple[Floats, Floats]:
        """Force per undeformed area [mN/cm^2] that Eq. (1) needs for this motion."""

        def flux(x: Number) -> tuple[Number, Number]:
            pull = self.tensions(x, t)[0] / self.stretches(x, t)[0]
            r, s = self.place(x, t, 1)
            return pull * r, pull * s

        step = 1e-30
        inner = [np.imag(part) / step for part in flux(z + 1j * step)]
        hoop = self.stretches(z, t)[1]
        slope_r, slope_z = self.place(z, t, 1)
        push_r, push_z = self.pressure * hoop * slope_z, -self.pressure * hoop * slope_r
        acc_r, acc_z = self.place(z, t, 0, 2)
        mass = self.wall.surface_density
        force_r = mass * acc_r - (inner[0] - self.tensions(z, t)[1] / self.wall.radius + push_r)
        return np.asarray(force_r), np.asarray(mass * acc_z - (inner[1] + push_z))

    def grid_force(self, z: Floats, t: float) -> tuple[Floats, Floats]:
        """The force that the *discrete* wall needs for this motion of its nodes: only the step's own error is left."""
        x, v = np.stack(self.place(z, t)), np.stack(self.place(z, t, 0, 1))
        (dr, ds), (vr, vs) = np.diff(x), np.diff(v)
        h = self.wall.element_size
        along = np.hypot(dr, ds) / h
        along_rate = (dr * vr + ds * vs) / (along * h * h)
        histories = along - along_rate, (x[0] - v[0]) / self.wall.radius
        drives = self._corner_drives()
        residual, _ = assembled(x[0], x[1], self.wall, 1.0, histories, drives, pressure=self.pressure)
        acceleration = np.stack(self.place(z, t, 0, 2))
        force = self.wall.surface_density * acceleration + residual.reshape(-1, 2).T / h
        return force[0], force[1]

    def _nodes(self) -> Floats:
        return np.linspace(0.0, self.length, round(self.length / self.wall.element_size) + 1)

    def _corner_drives(self) -> tuple[Floats, Floats]:
        corners = np.repeat(self._nodes(), 2)[1:-1]
        along, around = self.drives(corners)
        return np.asarray(along), np.asarray(around)

    def _solve(self, guess: Floats, history: History, slope: float) -> Floats:
        rho, zeta = guess[0].copy(), guess[1].copy()
        code, iterations, *_ = solve_equilibrium(
            Unknowns(rho, zeta, np.zeros(rho.size), np.array([self.pressure, 0.0, 0.0])),
            history,
            np.stack(self._corner_drives()),
            np.zeros(rho.size),
            Step(slope, True, 0.0, 0.0),
            self.wall,
            NO_PELLET,
            LumenConstants(self.pressure, 1.0, 0.0),
            Limits(max(1e-12, 1e-14 * self.length / self.wall.element_size**2), 1e-12, 60),
        )
        if code != CONVERGED:
            raise DivergenceError(f"no equilibrium after {iterations} iterations: {REASONS[code]}")
        return np.stack([rho, zeta])

    def instant_error(self, t: float = 0.1) -> float:
        """Error of the places [cm] when everything in time is exact: one solve with the exact rates as histories."""
        z, slope = self._nodes(), 1.0
        middle = 0.5 * (z[1:] + z[:-1])
        exact, velocity, acceleration = (np.stack(self.place(z, t, 0, rate)) for rate in range(3))
        force = np.stack(self.body_force(z, t)) / (self.wall.surface_density * slope)
        along, _, along_rate, _ = self.stretches(middle, t)
        _, hoop, _, hoop_rate = self.stretches(z, t)
        found = self._solve(
            exact,
            History(
                exact - velocity / slope,
                velocity - acceleration / slope + force,
                along - along_rate / slope,
                hoop - hoop_rate / slope,
            ),
            slope,
        )
        return float(np.abs(found - exact).max())

    def marched(self, steps: int, end: float = 0.4, grid: bool = False) -> float:
        """Error of the places [cm] at `end` by BDF2 from exact pasts; `grid`: driven by `grid_force`."""
        force_of = self.grid_force if grid else self.body_force
        z, dt = self._nodes(), end / steps
        before, now = (np.stack(self.place(z, t)) for t in (-dt, 0.0))
        v_before, v_now = (np.stack(self.place(z, t, 0, 1)) for t in (-dt, 0.0))
        formula = rate_formula(dt, dt, True)
        for n in range(1, steps + 1):
            force = np.stack(force_of(z, n * dt)) / (self.wall.surface_density * formula.inverse)
            history = formula.history(now, before)
            along, along_before = (self._along(x) for x in (now, before))
            found = self._solve(
                now + dt * v_now,
                History(
                    history,
                    formula.history(v_now, v_before) + force,
                    formula.history(along, along_before),
                    history[0] / self.wall.radius,
                ),
                formula.inverse,
            )
            velocity = (found - history) * formula.inverse
            before, now, v_before, v_now = now, found, v_now, velocity
        return float(np.abs(now - np.stack(self.place(z, end))).max())

    def _along(self, x: Floats) -> Floats:
        return np.asarray(np.hypot(np.diff(x[0]), np.diff(x[1])) / self.wall.element_size)
