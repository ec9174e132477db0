"""M1-M4, M8: the wall against exact states, first integrals and creep, Eqs. (1)-(5), (32), (35)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from peristalsis.model.fields import end_reactions
from peristalsis.model.state import WallState
from peristalsis.numerics.rates import rate_formula
from peristalsis.wall.active import ActiveConstants
from peristalsis.wall.constants import WallConstants
from peristalsis.wall.passive import PassiveConstants, passive_tension

from .exact import mooney_rivlin
from .exact.wall import (
    COUPLED,
    InflatedTube,
    Number,
    assembled,
    axial_invariants,
    complex_step,
    energy,
    gradient,
    settle,
    wall_constants,
)
from .problem import Check, Outcome, Problem, error, judged, order

Floats = NDArray[np.float64]


def still(rho: Floats, zeta: Floats) -> WallState:
    """A wall at rest there, without contact and drive."""
    position = np.zeros((rho.size, 1, 3))
    position[:, 0, 0], position[:, 0, 2] = rho, zeta
    nodes, elements = np.zeros((rho.size, 1)), np.zeros((rho.size - 1, 1))
    zero = np.zeros_like(position)
    return WallState(position, position, zero, zero, nodes, elements, nodes, np.zeros((2, 2 * rho.size - 2, 1)), 0.0)


def laplace() -> Outcome:
    """A straight tube is balanced where T_c = p rho, and its ends pull as the formula says."""
    worst, pull = 0.0, 0.0
    for published in (False, True):
        for stretch in (1.0, 1.3):
            for drive in (0.0, 0.4):
                wall = wall_constants(20, published=published)
                tube = InflatedTube(10.0, wall, stretch, drive)
                hoop = tube.hoop_stretch()
                rho, zeta = np.full(21, wall.radius * hoop), np.linspace(0.0, 10.0 * stretch, 21)
                drives = np.zeros(40), np.full(40, drive)
                hoop_force = np.abs(assembled(rho, zeta, wall, drives=drives)[0][2:-2]).max()
                residual, _ = assembled(rho, zeta, wall, drives=drives, pressure=10.0)
                worst = max(worst, float(np.abs(residual[2:-2]).max() / hoop_force))
                if drive == 0.0:
                    tension = gradient(stretch, hoop, wall.passive)[0] * (hoop if published else 1.0)
                    exact = 2.0 * np.pi * wall.radius * tension - 10.0 * np.pi * (wall.radius * hoop) ** 2
                    found = end_reactions(still(rho, zeta), wall, 10.0)[:2]
                    pull = max(pull, *(abs(f / exact - 1.0) for f in found))
    return judged(
        "W₂ = p R₀ λ₁λ₂ (T_c = p r); end force 2πR₀W₁ − pπR₀²λ₂²",
        [error("force left, relative", worst, 1e-10), error("end force, relative", pull, 1e-10)],
        "Both conventions, two stretches, with and without muscle.",
    )


def rubber_tube() -> Outcome:
    """Mooney-Rivlin tube between held ends, from a disturbed start."""
    c1, c2, thickness = 6.0, 1.5, 1.0
    checks = []
    for stretch in (1.0, 1.2):
        for hoop in (1.15, 1.6):
            wall = wall_constants(16, 2.0)
            pressure = 2.0 * thickness / (wall.radius * stretch) * (1.0 - stretch**-2 * hoop**-4)
            pressure *= c1 + c2 * stretch**2
            s = np.linspace(0.0, 1.0, 17)
            rho = wall.radius * hoop * (1.0 + 0.02 * np.sin(np.pi * s))
            zeta = 2.0 * stretch * s + 0.01 * np.sin(2.0 * np.pi * s)
            rho[[0, -1]] = wall.radius * hoop
            mooney_rivlin.settle(rho, zeta, pressure, wall, c1 * thickness, c2 * thickness)
            off = np.abs(rho / (wall.radius * hoop) - 1.0).max()
            checks.append(error(f"radius, relative, λ₁ = {stretch:g}, λ₂ = {hoop:g}", off, 1e-8))
    return judged(
        "p = (2H/(R₀λ₁))(1 − λ₁⁻²λ₂⁻⁴)(C₁ + C₂λ₁²)",
        checks,
        "By the wall's own assembly run uncompiled with this energy: the compiled kernel binds Eq. (4).",
    )


def paper_tube() -> Outcome:
    """The solver finds the root of the scalar equation; derivatives of the energy against complex steps."""
    radius, place = 0.0, 0.0
    for published in (False, True):
        for drive in (0.0, 0.4, 1.5):
            wall = wall_constants(40, 4.0, published=published)
            exact = wall.radius * InflatedTube(10.0, wall, 1.05, drive).hoop_stretch()
            s = np.linspace(0.0, 1.0, 41)
            rho, zeta = exact + 0.05 * np.sin(np.pi * s), 4.2 * s + 0.02 * np.sin(2.0 * np.pi * s)
            settle(rho, zeta, 10.0, wall, drive)
            radius = max(radius, float(np.abs(rho / exact - 1.0).max()))
            place = max(place, float(np.abs(zeta - 4.2 * s).max()))
    first, second = 0.0, 0.0
    for l, c in np.random.default_rng(3).uniform(0.5, 2.0, (300, 2)):
        wl, wc, wll, wlc, wcc = passive_tension(l, c, COUPLED)
        scale = abs(wll) + abs(wcc)
        exact_first = (
            complex_step(partial(energy, circumferential=c, c=COUPLED), l),
            complex_step(partial(energy, l, c=COUPLED), c),
        )
        exact_second = (
            complex_step(partial(_tension, 0, circumferential=c), l),
            complex_step(partial(_tension, 0, l), c),
            complex_step(partial(_tension, 1, l), c),
        )
        first = max(first, *(abs(a - b) / scale for a, b in zip((wl, wc), exact_first, strict=True)))
        second = max(second, *(abs(a - b) / scale for a, b in zip((wll, wlc, wcc), exact_second, strict=True)))
    return judged(
        "p R₀λ_c = W₂(λ_l, λ_c) + φ⁺T^a_c(λ_c), root of one equation",
        [
            error("radius, relative", radius, 1e-8),
            error("places [cm]", place, 1e-8),
            error("W₁, W₂ against complex steps", first, 1e-10),
            error("W₁₁, W₁₂, W₂₂ against complex steps", second, 1e-10),
        ],
        "Both conventions; derivatives at 300 random stretches in [0.5, 2]².",
    )


def _tension(layer: int, longitudinal: Number, circumferential: Number) -> Number:
    """W_l or W_c, for real or complex stretches."""
    return gradient(longitudinal, circumferential, COUPLED)[layer]


@cache
def clamped(elements: int, published: bool) -> tuple[Floats, Floats, WallConstants]:
    """A tube 3 cm long, stretched by 30 %, clamped at r0 and inflated to 0.1 kPa: its ends are boundary layers."""
    wall = wall_constants(elements, 3.0, published=published)
    s = np.linspace(0.0, 1.0, elements + 1)
    rho, zeta = np.full(elements + 1, wall.radius), 3.9 * s
    settle(rho, zeta, 10.0, wall)
    return rho, zeta, wall


def first_integrals() -> Outcome:
    """Axial force in both conventions, W - lambda_l W_l in the consistent one."""
    checks = []
    for published in (False, True):
        rho, zeta, wall = clamped(200, published)
        force, _ = axial_invariants(rho, zeta, 10.0, wall)
        name = "published" if published else "consistent"
        checks.append(error(f"spread of F, {name}", np.ptp(force) / np.abs(force).max(), 1e-9))
        checks.append(Check(f"change of radius, {name} [cm]", float(np.ptp(rho)), 0.01))
    sizes, spreads = [], []
    for elements in (200, 400, 800, 1600):
        rho, zeta, wall = clamped(elements, False)
        constant = axial_invariants(rho, zeta, 10.0, wall)[1]
        sizes.append(wall.element_size)
        spreads.append(float(np.ptp(constant) / np.abs(constant).max()))
    checks += [error("spread of W − λ₁W₁ at h = 0.0075 cm", spreads[1], 1e-3), order("in space", sizes, spreads, 2.0)]
    return judged(
        "F = 2πrT_m cosα − πpr² and W − λ₁W₁ constant along the tube",
        checks,
        "Under frictionless contact: C2. Broken by friction: F7.",
    )


def ring_strain(load: Callable[[float], float], end: float, steps: int, second_order: bool = True) -> Floats:
    """Hoop strain of one uniform ring under a contracting load [mN/cm], at every step.

    A drive of muscle with the active tension 1 whatever its stretch is a load: with c2 alone the ring is the
    Kelvin-Voigt body c2 e + k de/dt = -load, exactly.
    """
    linear = PassiveConstants(0.0, 10.4, 0.0, 0.0, 0.0, 0.0, 0.0)
    wall = wall_constants(2, 1.0, passive=linear, radius=0.8, published=False, circular=ActiveConstants(0.0, 0.0, 1.0))
    zeta, dt = np.linspace(0.0, 1.0, 3), end / steps
    now = before = wall.radius
    strains = [0.0]
    for step in range(steps):
        formula = rate_formula(dt, dt if step else 0.0, second_order)
        history = (formula.keep * now + formula.older * before) / wall.radius
        before = now
        drives = np.zeros(4), np.full(4, load((step + 1) * dt))
        residual, matrix = assembled(
            np.full(3, now), zeta, wall, formula.inverse, (np.ones(2), np.full(3, history)), drives
        )
        now -= residual[2] / matrix[2, 2]
        strains.append(now / wall.radius - 1.0)
    return np.array(strains)


STIFFNESS, VISCOSITY = 10.4, 33.3
TIME = VISCOSITY / STIFFNESS
"""K [mN/cm], k [mN s/cm] and tau = k/K [s] of the ring."""


def creep() -> Outcome:
    """Step, ramp, recovery and harmonic load of a Kelvin-Voigt ring."""
    end = 2.0 * TIME
    levels = [100, 200, 400, 800]

    def step(n: int, second: bool) -> float:
        found = ring_strain(lambda t: 1.0, end, n, second)[-1]
        return float(abs(found + (1.0 - np.exp(-2.0)) / STIFFNESS))

    def ramp(n: int) -> float:
        exact = -(end - TIME * (1.0 - np.exp(-2.0))) / STIFFNESS
        return float(abs(ring_strain(lambda t: t, end, n)[-1] - exact))

    def recovery(n: int) -> float:
        found = ring_strain(lambda t: 1.0 if t <= 0.5 * end * (1.0 + 1e-12) else 0.0, end, n, False)
        exact = found[n // 2] * np.exp(-1.0)
        return float(abs(found[-1] - exact))

    omega = 2.0 / TIME

    def loss_tangent(n: int) -> float:
        """tan(delta) from the in-phase and quadrature parts of the last of 6 periods."""
        period = 2.0 * np.pi / omega
        found = ring_strain(lambda t: float(np.sin(omega * t)), 6.0 * period, 6 * n)[-n:]
        t = np.linspace(0.0, 6.0 * period, 6 * n + 1)[-n:]
        return abs(float(-(found @ np.cos(omega * t)) / (found @ np.sin(omega * t)) / (omega * TIME) - 1.0))

    steps = [end / n for n in levels]
    of_step, of_ramp = [step(n, True) for n in levels], [ramp(n) for n in levels]
    periods = (100, 200, 400, 800)
    return judged(
        "ε = (P/K)(1 − e^(−Kt/k)); ramp (Ṗ/K)(t − τ(1 − e^(−t/τ))); recovery e^(−t/τ); tan δ = ωτ",
        [
            order("in time, step (BDF2)", steps, of_step, 2.0),
            order("in time, step (Euler)", steps, [step(n, False) for n in levels], 1.0),
            order("in time, ramp", steps, of_ramp, 2.0),
            order("in time, recovery (Euler)", steps, [recovery(n) for n in levels], 1.0),
            order("in time, tan δ", [1.0 / n for n in periods], [loss_tangent(n) for n in periods], 2.0),
            error("strain after 2 τ, 3200 steps", step(3200, True), 1e-6),
        ],
        "The load is an active tension that does not depend on stretch.",
    )


GREEN = "Green & Adkins, Large Elastic Deformations (1960), ch. IV"
PROBLEMS = (
    Problem("M1", "Laplace, uniform tube", GREEN, "quick", laplace, (1, 2, 3, 4, 5, 18, 35)),
    Problem("M2", "Mooney-Rivlin tube", "Green & Adkins (1960); Rivlin (1949)", "quick", rubber_tube, (1, 3, 18)),
    Problem(
        "M3", "Tube of the paper's energy", "root of one scalar equation", "quick", paper_tube, (1, 2, 3, 4, 5, 35)
    ),
    Problem("M4", "First integrals", GREEN, "quick", first_integrals, (1, 3, 4, 18, 35)),
    Problem("M8", "Kelvin-Voigt creep", "elementary integration", "quick", creep, (2, 32)),
)
