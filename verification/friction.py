"""F1-F9: the laws of friction against motions solved by hand, Eqs. (13), (27), (34), (50), (51)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from peristalsis.model.constants import LumenConstants, Step
from peristalsis.model.equilibrium import History, solve_equilibrium
from peristalsis.model.fields import contact_pressure
from peristalsis.model.friction import dry_friction_now, friction_ahead, sliding_speed
from peristalsis.model.problem import Limits, Unknowns
from peristalsis.model.state import PelletState
from peristalsis.model.verdicts import CONVERGED
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.friction import FrictionLaw, dry_friction, sliding_velocity
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere
from peristalsis.wall.passive import PassiveConstants

from .contact import squeezed
from .exact.pellets import Oscillation, Ramp
from .exact.wall import wall_constants
from .problem import Check, Outcome, Problem, equal, error, judged, not_applicable, order

Floats = NDArray[np.float64]


def travel(force: Callable[[float], float], viscous: float, dry: float, end: float, steps: int) -> Floats:
    """Places at every step by the trapezoidal rule of Eq. (34)."""
    t = np.linspace(0.0, end, steps + 1)
    v = np.array([sliding_velocity(force(float(x)), viscous, dry)[0] for x in t])
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])


def constant_force() -> Outcome:
    """Sticks exactly, slides at the excess."""
    rng = np.random.default_rng(5)
    stuck, slides = 0.0, 0.0
    for force, viscous, dry in rng.uniform((-3000.0, 1.0, 0.0), (3000.0, 2000.0, 2000.0), (2000, 3)):
        velocity, _ = sliding_velocity(force, viscous, dry)
        if abs(force) <= dry:
            stuck = max(stuck, abs(velocity))
        else:
            exact = math.copysign((abs(force) - dry) / viscous, force)
            slides = max(slides, abs(velocity / exact - 1.0))
    return judged(
        "|F| ≤ F_d: Ż = 0 exactly; else Ż = sgn F (|F| − F_d)/η",
        [equal("velocity while stuck", stuck, 0.0), error("relative while sliding", slides, 1e-14)],
        "2000 random forces and frictions.",
    )


def ramp() -> Outcome:
    """A growing force."""
    given = Ramp(rate=400.0, viscous=230.0, dry=100.0)
    levels, errors, late = (176, 352, 704, 1408), [], 0.0
    for steps in levels:  # F_d is reached at the end of a step
        z = travel(given.force, given.viscous, given.dry, 1.1, steps)
        late = max(late, abs(np.flatnonzero(z > 0.0)[0] - 1 - given.start * steps / 1.1))
        errors.append(abs(float(z[-1]) - given.travel(1.1)))
    ragged = [abs(float(travel(given.force, 230.0, 100.0, 1.1, n)[-1]) - given.travel(1.1)) for n in (37, 149, 597)]
    return judged(
        "starts at F_d/β; Z = β(t − t*)²/(2η)",
        [
            error("start, in steps", late, 1.0 + 1e-9),
            error("place at 1408 steps [cm]", errors[-1], 1e-6),
            Check("error falls from 37 to 597 steps by", ragged[0] / max(ragged[-1], 1e-16), 16.0),
        ],
        "The trapezoidal rule is exact for the parabola once it slides; what is left is the step in which it "
        "starts, so the error depends on where in it F_d is reached, and falls at first order or better.",
    )


def oscillation() -> Outcome:
    """An oscillating force, with and without bias."""
    drive = Oscillation(amplitude=300.0, omega=2.0 * np.pi, viscous=230.0, dry=100.0)
    half = travel(drive.force, drive.viscous, drive.dry, 0.5, 2000)[-1] / drive.travel_of_half_period() - 1.0
    cycle = travel(drive.force, 230.0, 100.0, 1.0, 1000)[-1]
    drifts = [
        travel(Oscillation(300.0, 2.0 * np.pi, 230.0, 100.0, b).force, 230.0, 100.0, 1.0, 1000)[-1] * b / 20.0
        for b in (20.0, -20.0)
    ]
    smooth = Oscillation(300.0, 2.0 * np.pi, 230.0, 0.0)
    exact = 300.0 / 230.0 / smooth.omega * (1.0 - math.cos(0.37 * smooth.omega))
    levels = (16, 32, 64, 128)
    errors = [abs(float(travel(smooth.force, 230.0, 0.0, 0.37, n)[-1]) - exact) for n in levels]
    return judged(
        "ΔZ = (A/ηω)[2 cos φ₁ − (π − 2φ₁) sin φ₁], φ₁ = asin(F_d/A); no net travel; a bias drifts its own way",
        [
            error("half period, relative", half, 1e-4),
            error("net travel of a cycle [cm]", cycle, 1e-12),
            Check("least drift with a bias [cm]", float(min(drifts)), 0.01),
            order("in time, F_d = 0", [1.0 / n for n in levels], errors, 2.0),
        ],
    )


def block(
    stiffness: float, mass: float, pull: float, law: FrictionLaw, kinetic: float, start: float, dt: float, steps: int
) -> tuple[Floats, Floats]:
    """Places and velocities of a block on a spring whose end moves at `pull`, by midpoint steps of the law.

    The law is solved for the velocity as it stands: m (v' - v) = dt (force - friction) is Eq. (27) with eta = m/dt.
    """
    x, v = start, 0.0
    places, speeds = [x], [v]
    for step in range(steps):
        middle = x + 0.5 * dt * v
        force = stiffness * (pull * (step + 0.5) * dt - middle)
        dry = dry_friction(kinetic, law, 0.0, v == 0.0)
        v = sliding_velocity(mass * v / dt + force, mass / dt, dry)[0]
        x = middle + 0.5 * dt * v
        places.append(x)
        speeds.append(v)
    return np.array(places), np.array(speeds)


def stick_slip() -> Outcome:
    """Times of sticking and slipping of a block drawn by a spring."""
    stiffness, mass, pull, kinetic, law = 10.0, 0.4, 0.6, 3.0, FrictionLaw(static_factor=1.5)
    excess = kinetic * (law.static_factor - 1.0) / stiffness
    omega = math.sqrt(stiffness / mass)
    stick, slip = 2.0 * excess / pull, 2.0 / omega * (math.pi - math.atan(excess * omega / pull))
    dt = 2e-5
    _, speeds = block(stiffness, mass, pull, law, kinetic, 0.0, dt, round(6.0 * (stick + slip) / dt))
    moving = speeds != 0.0
    changes = np.flatnonzero(np.diff(moving.astype(int)))
    spans = np.diff(changes) * dt
    slips = spans[0::2] if moving[changes[0] + 1] else spans[1::2]
    sticks = spans[1::2] if moving[changes[0] + 1] else spans[0::2]
    return judged(
        "t_stick = 2Δ/v, t_slip = (2/ω)(π − atan(Δω/v)), Δ = (F_s − F_k)/k",
        [
            error("time of sticking, relative", np.abs(sticks / stick - 1.0).max(), 1e-3),
            error("time of slipping, relative", np.abs(slips / slip - 1.0).max(), 1e-3),
            Check("slips seen", float(slips.size), 4.0),
        ],
        "The pellet has no mass; the block's is put where η stands, which is an implicit step of the same law.",
    )


def coulomb_oscillator() -> Outcome:
    """A block on a spring with dry friction alone."""
    stiffness, mass, kinetic = 10.0, 0.4, 0.37
    period = 2.0 * math.pi * math.sqrt(mass / stiffness)
    places, speeds = block(stiffness, mass, 0.0, FrictionLaw(), kinetic, 1.0, 1e-5, round(8.0 * period / 1e-5))
    turns = np.flatnonzero(speeds[1:-1] * speeds[2:] < 0.0) + 1
    tops = np.abs(places[turns])
    falls = -np.diff(np.concatenate([[1.0], tops])) * stiffness / (2.0 * kinetic)
    still = np.flatnonzero(speeds != 0.0)[-1]
    return judged(
        "amplitude falls by 4F_k/k a cycle, linearly; stops for |x| ≤ F_s/k",
        [
            error("fall in half a cycle, relative", np.abs(falls - 1.0).max(), 1e-3),
            Check("half cycles seen", float(falls.size), 10.0),
            Check("place of rest [F_s/k]", abs(float(places[-1])) * stiffness / kinetic, 0.0, 1.0),
            Check("moving part of the time", still / speeds.size, 0.1, 0.99),
        ],
    )


def regularised() -> Outcome:
    """There is no regularised law."""
    return not_applicable(
        "creep ε atanh(F/F_d) of F_d tanh(v/ε)",
        "Sticking is exact (F1): the law is set-valued and solved as such, so there is no ε and nothing creeps.",
    )


FIBRES = PassiveConstants(10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Longitudinal fibres alone: T_c = 0, so the wall over the pellet is a sheaf of belts."""


def wrapped(elements: int, coefficient: float) -> tuple[Floats, Floats, Floats]:
    """Polar angle and contact of the nodes, and the pull in the elements [mN], of fibres that slide over a pellet.

    The pellet pushes against its own friction, F_z = mu N, and nothing else: its place is looked for, and the shares
    of the reaction are repeated until they are those of the contact they make.
    """
    length, sphere, stretch = 1.6, 1.25, 1.5
    wall = wall_constants(elements, length, passive=FIBRES)
    n = elements + 1
    rho, zeta = np.full(n, wall.radius), np.linspace(0.0, length * stretch, n)
    contact, weight, scalars = np.zeros(n), np.zeros(n), np.array([0.0, 0.5 * length * stretch, 0.0])
    area = 2.0 * np.pi * wall.radius * wall.element_size

    def solve(radius: float, centre: float) -> float:
        """F_z [mN] with the pellet held there."""
        code, *_ = solve_equilibrium(
            Unknowns(rho, zeta, contact, scalars),
            History(np.zeros((2, n)), np.zeros((2, n)), np.ones(n - 1), np.ones(n)),
            np.zeros((2, 2 * n - 2)),
            weight,
            Step(0.0, False, centre, 0.0),
            wall,
            pellet_of(Sphere(radius), frame=1.0, tangential=True)._replace(volume=0.0),
            LumenConstants(0.0, 1.0, 0.0),
            Limits(1e-9, 1e-10, 200),
        )
        if code != CONVERGED:
            raise ValueError(f"the fibres find no equilibrium around a pellet of {radius:g} cm")
        return float(scalars[2])

    centre = float(scalars[1])
    for radius in np.linspace(wall.radius + 0.005, sphere, 20):
        solve(float(radius), centre)
    stiffness = 0.0
    for _ in range(200):
        pressing = area * contact * rho / np.hypot(rho, zeta - scalars[1])
        weight[:] = pressing / pressing.sum()
        if stiffness == 0.0:
            stiffness = (solve(sphere, centre + 1e-3) - solve(sphere, centre)) / 1e-3
        force = solve(sphere, centre)
        lacking = coefficient * float(pressing.sum()) - force
        if abs(lacking) <= 1e-7 * pressing.sum():
            break
        centre += 0.5 * lacking / stiffness
    pull = 2.0 * np.pi * wall.radius * 10.0 * (np.hypot(np.diff(rho), np.diff(zeta)) / wall.element_size - 1.0)
    return np.arctan2(rho, zeta - centre), contact, pull


def capstan() -> Outcome:
    """Friction on the sphere makes the pull of fibres grow as a belt's does."""
    mu = 0.1
    angle, contact, pull = wrapped(400, mu)
    touching = np.flatnonzero(contact > 0.0)
    first, last = touching[0], touching[-1]
    inner = slice(first + 2, last - 2)
    middle = 0.5 * (angle[1:] + angle[:-1])
    slope = np.polyfit(middle[inner], np.log(pull[inner]), 1)[0]
    ratio = pull[last + 2] / pull[first - 3]
    wrap = angle[first] - angle[last]
    turned = math.log(ratio) / wrap
    return judged(
        "T₂ = T₁ e^(μΔθ); with T_c = 0: T_m sinθ ∝ e^(±μθ)",
        [
            error("exponent within the band, relative", abs(slope) / mu - 1.0, 5e-3),
            error("exponent over the whole wrap, relative", abs(turned) / mu - 1.0, 5e-3),
            Check("angle of wrap [rad]", float(wrap), 0.3),
        ],
        "By the solver, with the tangential reaction of Eq. (51). Over the whole wrap, edges are known to an element.",
    )


def slip_threshold() -> Outcome:
    """The coefficient at which the squeezed pellet slips, by bisection over steps, against the integral."""
    model, state = squeezed(1600)
    q = contact_pressure(state.wall, model.wall)[:, 0]
    rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
    theta = np.arctan2(rho, zeta - state.pellet.position)
    integral = abs(float(np.trapezoid(q * np.sin(theta) ** 2, theta))) * 2.0 * np.pi * model.pellet.radius**2
    exact = abs(state.pellet.axial_force) / integral

    def slips(coefficient: float) -> bool:
        rubbing = replace(model, friction=FrictionLaw(1.0, coefficient), pellet=model.pellet._replace(dry=0.0))
        dry, _ = friction_ahead(rubbing, state.wall, state.pellet)
        after = PelletState(state.pellet.position, 0.0, state.pellet.axial_force, dry)
        return sliding_speed(rubbing, after) != 0.0 and dry_friction_now(rubbing, after) == dry

    low, high = 0.0, 10.0 * exact
    for _ in range(60):
        centre = 0.5 * (low + high)
        low, high = (centre, high) if slips(centre) else (low, centre)
    return judged(
        "|F_z| = μ 2πR² ∫ q sin²θ dθ",
        [
            error("threshold, relative", 0.5 * (low + high) / exact - 1.0, 1e-3),
            Check("axial force [mN]", abs(state.pellet.axial_force), 0.1),
        ],
    )


def limits() -> Outcome:
    """No dry friction, endless friction, and never earlier with more of either."""
    rng = np.random.default_rng(9)
    frozen, free, later = 0.0, 0.0, 0
    for _ in range(200):
        knots = np.maximum(rng.uniform(-500.0, 3000.0, 8), 0.0)
        times = np.linspace(0.0, 1.0, 8)
        viscous, dry = rng.uniform(20.0, 2000.0), rng.uniform(0.0, 1000.0)

        def force(t: float, times: Floats = times, knots: Floats = knots) -> float:
            return float(np.interp(t, times, knots))

        usual = travel(force, viscous, dry, 1.0, 50)
        more = (
            travel(force, viscous * rng.uniform(1.0, 5.0), dry, 1.0, 50),
            travel(force, viscous, dry + rng.uniform(0.0, 500.0), 1.0, 50),
        )
        later += sum(bool(np.any(one > usual + 1e-12)) for one in more)
        frozen = max(frozen, float(np.abs(travel(force, 1e12, dry, 1.0, 5)).max()))
        f = float(rng.uniform(1.0, 3000.0))
        free = max(free, abs(sliding_velocity(f, viscous, 0.0)[0] * viscous / f - 1.0))
    return judged(
        "η → ∞: frozen; F_d → 0: Ż = F/η; more friction is never earlier",
        [
            error("travel at η = 1e12 [cm]", frozen, 1e-8),
            error("F_d = 0, relative", free, 1e-14),
            equal("of 400 comparisons, earlier", float(later), 0.0),
        ],
        "200 random drives that only push forward.",
    )


PROBLEMS = (
    Problem("F1", "Constant force", "Eq. (13)", "quick", constant_force, (13, 27)),
    Problem("F2", "Growing force", "elementary integration", "quick", ramp, (13, 34)),
    Problem("F3", "Oscillating force", "elementary integration", "quick", oscillation, (13, 34)),
    Problem("F4", "Stick-slip block", "Rabinowicz, Proc. Phys. Soc. 71 (1958)", "quick", stick_slip, (27, 50)),
    Problem("F5", "Coulomb-damped oscillator", "elementary integration", "quick", coulomb_oscillator, (27,)),
    Problem("F6", "Regularised law", "tanh(v/ε) by hand", "quick", regularised),
    Problem("F7", "Capstan", "Euler's belt; equilibrium of a membrane along the meridian", "quick", capstan, (28, 51)),
    Problem("F8", "Slip threshold under pressing", "axial part of μq over the sphere", "quick", slip_threshold, (51,)),
    Problem("F9", "Limits and monotonicity", "Eq. (13)", "quick", limits, (13, 34)),
)
