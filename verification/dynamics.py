"""M12-M14: mirror images, a manufactured motion of the whole membrane, energy without dissipation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from peristalsis.geometry.tube import lumen_volume
from peristalsis.wall.assembly import (
    FORCE_R,
    FORCE_Z,
    HISTORY_HOOP,
    HISTORY_STRETCH,
    KNOWN_ROWS,
    VOLUME_R,
    VOLUME_Z,
    WALL_ROWS,
    wall_forces,
)
from peristalsis.wall.constants import WallConstants

from .exact.cable import apply_operator
from .exact.manufactured import ManufacturedMotion
from .exact.runs import EXACT, march
from .exact.wall import COUPLED, discrete_energy, wall_constants
from .problem import Check, Outcome, Problem, equal, error, judged, order
from .waves import rod_amplitudes, vertex

Floats = NDArray[np.float64]


def mirror() -> Outcome:
    """Everything reflected about the middle moves the pellet the other way."""
    rng = np.random.default_rng(4)
    potential, diffusivity = rng.normal(size=300), rng.uniform(0.5, 2.0, 299)
    straight = apply_operator(potential, diffusivity, 0.05)
    turned = apply_operator(potential[::-1].copy(), diffusivity[::-1].copy(), 0.05)[::-1]
    quiet = {
        "pacemaker.kind": "none",
        "trigger.rule": "none",
        "reflex.enabled": False,
        "rings.enabled": True,
        "wall.slack_blend": "0.05 mN/cm",
        "wall.slack_slope": 1e-3,
    }
    left = march(0.5, EXACT, quiet, {"pellet.start_gap": "3.6 cm", "rings.positions": ["3.5 cm", "7 cm"]})
    right = march(0.5, EXACT, quiet, {"pellet.start_gap": "4.6 cm", "rings.positions": ["3 cm", "6.5 cm"]})
    total = left.last.pellet.position + right.last.pellet.position
    return judged(
        "z → −z with mirrored activation mirrors Z_c",
        [
            equal("conduction: bits that differ", float((straight != turned).sum()), 0.0),
            error("pellets: sum of both places less the length [cm]", total - 10.0, 1e-12),
            Check("way of the pellet [cm]", abs(left.last.pellet.position - 4.5), 1e-3),
        ],
        "Rotation belongs to the full surface.",
    )


def manufactured() -> Outcome:
    """The full dynamic membrane with a body force: orders in space for each term, in time, and in both."""

    def wall(elements: int, viscosity: float, density: float, published: bool) -> WallConstants:
        return wall_constants(
            elements, 2.0, viscosity=viscosity, surface_density=density, passive=COUPLED, published=published
        )

    light = 1e-6
    cases = {
        "passive": (0.0, light, 0.0, 0.0, False),
        "pressure": (0.0, light, 10.0, 0.0, False),
        "active": (0.0, light, 0.0, 1.0, False),
        "viscous": (3.0, light, 0.0, 0.0, False),
        "inertia": (0.0, 0.05, 0.0, 0.0, False),
        "all": (3.0, 0.05, 10.0, 1.0, False),
        "all, published": (3.0, 0.05, 10.0, 1.0, True),
    }
    levels = (20, 40, 80, 160)
    checks = []
    for name, (viscosity, density, pressure, pull, published) in cases.items():
        errors = [
            ManufacturedMotion(wall(n, viscosity, density, published), pressure=pressure, pull=pull).instant_error()
            for n in levels
        ]
        checks.append(order(f"in space, {name}", [2.0 / n for n in levels], errors, 2.0))
    counts = (80, 160, 320, 640)
    full = ManufacturedMotion(wall(20, 3.0, 0.05, False))
    checks.append(order("in time, all", [1.0 / n for n in counts], [full.marched(n, grid=True) for n in counts], 2.0))
    both = [ManufacturedMotion(wall(n, 3.0, 0.05, False)).marched(4 * n) for n in levels]
    checks.append(order("in space and time, all", [2.0 / n for n in levels], both, 2.0))
    checks.append(error("largest error of a place at 160 elements, 640 steps [cm]", both[-1], 1e-4))
    return judged(
        "ρ = R + ε₁ sin(kz) cos ωt, ζ = 1.2 z + ε₂ sin(2kz) cos(ωt + 0.3), body force exact",
        checks,
        "Passive tension is in every case, or nothing would hold the tube. In time: with the force that the "
        "discrete wall needs, so that only the step's error is left.",
    )


class Conservative:
    """The wall's forces at constant pressure, without viscosity, for an integrator that conserves energy."""

    def __init__(self, elements: int, pressure: float) -> None:
        self.wall = wall_constants(elements, 2.0, viscosity=0.0, passive=COUPLED)
        n = elements + 1
        self.mass, self.pressure = 0.05 * self.wall.element_size, pressure
        self._known, self._work = np.zeros((KNOWN_ROWS, n)), np.zeros((WALL_ROWS, n))
        self._known[[HISTORY_STRETCH, HISTORY_HOOP]] = 1.0

    def acceleration(self, rho: Floats, zeta: Floats) -> Floats:
        """Of every node, shape (2, n); zero at the ends."""
        work = self._work
        if not wall_forces(rho, zeta, self._known, 0.0, self.wall, 1, rho.size - 2, work):
            raise ValueError("a stretch left the range of the wall's law: shorten the step")
        out = (self.pressure * work[VOLUME_R : VOLUME_Z + 1] - work[FORCE_R : FORCE_Z + 1]) / self.mass
        out[:, [0, -1]] = 0.0
        return np.asarray(out)

    def energy(self, x: Floats, v: Floats) -> float:
        """K + W - p V per 2 pi r0."""
        kinetic = 0.5 * self.mass * float((v**2).sum())
        volume = lumen_volume(np.ascontiguousarray(x[0]), np.ascontiguousarray(x[1]))
        stored = float(discrete_energy(x.T.ravel(), self.wall))
        return kinetic + stored - self.pressure * volume / (2.0 * np.pi * self.wall.radius)

    def march(self, dt: float, steps: int, every: int, weights: tuple[float, ...] = (1.0,)) -> Floats:
        """Energies at every `every`-th step by a composition of Verlet steps of these shares of dt."""
        count = round(2.0 / self.wall.element_size)
        z = np.linspace(0.0, 2.0, count + 1)
        x = np.stack([0.85 + 0.05 * np.sin(0.5 * np.pi * z), 1.2 * z + 0.02 * np.sin(np.pi * z)])
        v = np.zeros_like(x)
        force = self.acceleration(x[0], x[1])
        energies = [self.energy(x, v)]
        for step in range(1, steps + 1):
            for weight in weights:
                v += 0.5 * weight * dt * force
                x += weight * dt * v
                force = self.acceleration(x[0], x[1])
                v += 0.5 * weight * dt * force
            if step % every == 0:
                energies.append(self.energy(x, v))
        return np.array(energies)


OUTER = 1.0 / (2.0 - 2.0 ** (1.0 / 3.0))
FOURTH_ORDER = (OUTER, 1.0 - 2.0 * OUTER, OUTER)
"""Shares of three Verlet steps that make one of fourth order (Yoshida, Phys. Lett. A 150, 1990)."""


def lost_by_the_step(dt: float) -> float:
    """Rate [1/s] at which the package's step damps an undamped axial mode of 4.4 rad/s."""
    quiet: dict[str, object] = {
        "wall.inertia": True,
        "wall.surface_density": "20000 mg/cm^2",
        "wall.viscosity": "1e-9 mN*s/cm",
    }
    found = np.abs(rod_amplitudes(dt, 8.0, quiet))
    peaks = [k for k in range(1, found.size - 1) if found[k] >= max(found[k - 1], found[k + 1])]
    heights = [vertex(found[k - 1 : k + 2]) for k in peaks]
    return float(-np.polyfit(np.array(peaks) * dt, np.log(heights), 1)[0])


def energy() -> Outcome:
    """The wall's forces are those of an energy; and what the package's own step loses."""
    tube = Conservative(16, 10.0)
    dt = 2e-4
    sizes, swings = [], []
    for factor in (8, 4, 2, 1):
        energies = tube.march(factor * dt, 4000 // factor, 1)
        sizes.append(factor * dt)
        swings.append(float(np.ptp(energies) / abs(energies[0])))
    long = tube.march(dt, 100_000, 20, FOURTH_ORDER)
    tenth = long.size // 10
    drift = float((long[-tenth:].mean() - long[:tenth].mean()) / abs(long[0]))
    levels = [32e-3, 16e-3, 8e-3, 4e-3]
    losses = [lost_by_the_step(step) for step in levels]
    return judged(
        "E = K + ∫W − pV constant",
        [
            order("of the swing of E in dt (Verlet)", sizes, swings, 2.0),
            error("secular drift over 1e5 steps (fourth order), relative", drift, 1e-8),
            order("of the decay rate in dt (the package's BDF2)", levels, losses, 3.0, 0.2),
        ],
        "The forces are conservative: shown by a symplectic integrator on them. The package's own step is BDF2, which "
        "damps on purpose: with inertia, an undamped mode loses amplitude at a rate that falls as dt³ "
        f"({losses[-1]:.1e} /s at 4 ms and ω = 4.4 /s), so the clause on no drift is not met by the step itself.",
    )


PROBLEMS = (
    Problem("M12", "Mirror image", "symmetry of Eqs. (1)-(36)", "full", mirror, (1, 11, 13, 28)),
    Problem(
        "M13",
        "Manufactured motion of the membrane",
        "method of manufactured solutions",
        "quick",
        manufactured,
        (1, 2, 3, 4, 5, 18, 32, 35),
    ),
    Problem("M14", "Energy without dissipation", "Eq. (1) with k = 0", "full", energy, (1, 3, 4, 18, 29)),
)
