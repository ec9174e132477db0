"""E16, F10-F12, X9, X10: laws of the bench in closed form, Eqs. (105), (120)-(126)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from peristalsis import scenarios
from peristalsis.control.graded import Answer, answer, observe_receptors
from peristalsis.control.reflex import SILENT, Receptors, Reflex
from peristalsis.inputs.build import build
from peristalsis.many.passes import passes
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.constants import PelletConstants, Resistance
from peristalsis.pellet.friction import (
    FrictionLaw,
    Nodes,
    Shares,
    Start,
    falling_velocity,
    friction_of_step,
    sliding_velocity,
)
from peristalsis.pellet.load import pull_of_load
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere

from .cell import Cell, resting_start
from .exact.cell import ReferenceCell
from .problem import Check, Outcome, Problem, equal, error, judged, order

Floats = NDArray[np.float64]

LEVELS = (40, 80, 160, 320)
"""Steps of problems with an order in time."""


def pressed() -> Outcome:
    """A constant force against friction in proportion to a pressing that grows evenly in time."""
    force, viscous, coefficient, first, growth, end = 120.0, 40.0, 0.75, 30.0, 90.0, 2.0
    law, sphere = FrictionLaw(viscous_coefficient=coefficient), Sphere(0.4)
    places = np.zeros((2, 1, 3))
    slope = math.radians(60.0)
    places[:, 0, 0], places[1, 0, 2] = (0.4, 0.4 * math.sin(slope)), 0.4 * math.cos(slope)
    each = 1.0 + math.sin(slope)  # what the two nodes press for the same contact force

    def slowed(pressing: float) -> float:
        """The viscous friction of a step that begins with this pressing, by the step's own kernel."""
        contact = np.full((2, 1), pressing / each / 0.05)
        shares = Shares(np.empty((2, 1)), np.empty((2, 1)))
        start = Start(0.0, force, False)
        return float(friction_of_step(Nodes(contact, places, 0.05), start, sphere, viscous, 0.0, law, shares).viscous)

    exact = force / (coefficient * growth) * math.log1p(coefficient * growth * end / (viscous + coefficient * first))
    errors = []
    for steps in LEVELS:
        dt = end / steps
        travel = sum(dt * sliding_velocity(force, slowed(first + growth * k * dt), 0.0)[0] for k in range(steps))
        errors.append(abs(travel - exact))
    return judged(
        "Z = F/(cṄ) ln(1 + cṄt/(η + cN₀)) while N = N₀ + Ṅt",
        [
            error("η + cN at N = 30 mN, relative", slowed(first) / (viscous + coefficient * first) - 1.0, 1e-14),
            error("place at 320 steps [cm]", errors[-1], 5e-3),
            order("in time", [1.0 / n for n in LEVELS], errors, 1.0),
        ],
        "Pressing is that at the start of a step, so the order is one.",
    )


def falling() -> Outcome:
    """Dry friction that falls with speed: both speeds of one force, the fold, and a pellet that a spring slows."""
    rng = np.random.default_rng(11)
    worst = 0.0
    for viscous, dry, share, fall in rng.uniform((1.0, 1.0, 0.0, 0.01), (300.0, 200.0, 0.95, 2.0), (1000, 4)):
        force = dry * rng.uniform(1.001, 4.0)
        roots = np.roots([viscous, viscous * fall + dry * share - force, fall * (dry - force)])
        worst = max(worst, abs(falling_velocity(force, viscous, dry, share, fall, True)[0] / roots.max() - 1.0))
    viscous, dry, share, fall = 10.0, 50.0, 0.2, 0.1
    fold = dry * share - viscous * fall + 2.0 * math.sqrt(viscous * fall * dry * (1.0 - share))
    stops = _edge(lambda force: falling_velocity(force, viscous, dry, share, fall, True)[0] > 0.0, fold)
    leaves = _edge(lambda force: falling_velocity(force, viscous, dry, share, fall, False)[0] > 0.0, dry)
    errors = [abs(_slowed_by_spring(steps) - _SLOWED) for steps in LEVELS]
    return judged(
        "v solves ηv + D(s + (1 − s)/(1 + v/v₀)) = F; slides down to F = Ds − ηv₀ + 2√(ηv₀D(1 − s)), rests up to D; on "
        "a spring kt = η ln(v₁/v) − D(1 − s)/v₀ [G(v₁) − G(v)], G = ln(v/(v + v₀)) + v₀/(v + v₀)",
        [
            error("speed against the quadratic's root, relative", worst, 1e-10),
            error("force at which it stops, relative", stops / fold - 1.0, 1e-10),
            error("force at which it leaves, relative", leaves / dry - 1.0, 1e-10),
            Check("forces with two speeds, share of D", (dry - fold) / dry, 0.1),
            error("speed after 0.5 s on a spring at 320 steps [cm/s]", errors[-1], 1e-4),
            order("in time", [1.0 / n for n in LEVELS], errors, 2.0),
        ],
    )


def _edge(moves: Callable[[float], bool], near: float) -> float:
    """The force at which a pellet begins to move, by bisection around `near`."""
    low, high = 0.5 * near, 2.0 * near
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if moves(middle) else (middle, high)
    return 0.5 * (low + high)


_SPRING, _PULL, _LAW = 60.0, 80.0, (100.0, 30.0, 0.25, 0.5)
"""Stiffness [mN/cm], constant force [mN]; eta, D, s, v0 of a friction that rises with speed everywhere."""


def _friction(v: float) -> float:
    viscous, dry, share, fall = _LAW
    return viscous * v + dry * (share + (1.0 - share) / (1.0 + v / fall))


_FIRST = float(brentq(lambda v: _friction(v) - _PULL, 0.0, 10.0, xtol=1e-15))


def _time_to(v: float) -> float:
    """When the speed has fallen to v [s]."""
    viscous, dry, share, fall = _LAW

    def g(u: float) -> float:
        return math.log(u / (u + fall)) + fall / (u + fall)

    return (viscous * math.log(_FIRST / v) - dry * (1.0 - share) / fall * (g(_FIRST) - g(v))) / _SPRING


_SLOWED = float(brentq(lambda v: _time_to(v) - 0.5, 1e-6, _FIRST, xtol=1e-15))


def _slowed_by_spring(steps: int) -> float:
    """Speed after half a second, by trapezoidal steps with the load solved for together with the place, Eq. (34)."""
    dt = 0.5 / steps
    place, speed = 0.0, _FIRST
    pellet = pellet_of(Sphere(0.4), resistance=Resistance(math.inf, _SPRING, 0.0))
    for _ in range(steps):

        def lacking(new: float, place: float = place, speed: float = speed) -> float:
            pull, _ = pull_of_load(place + 0.5 * dt * (speed + new), pellet)
            return falling_velocity(_PULL - pull, *_LAW, True)[0] - new

        new = float(brentq(lacking, 0.0, 2.0 * speed, xtol=1e-15))
        place, speed = place + 0.5 * dt * (speed + new), new
    return speed


def loaded() -> Outcome:
    """A constant force against a string that stretches until it lifts its weight, and against a spring."""
    force, viscous, stiffness, weight = 80.0, 200.0, 100.0, 50.0
    lifts = -viscous / stiffness * math.log1p(-weight / force)
    end = 2.0 * lifts
    levels = [2 * n for n in LEVELS]  # the weight is lifted at the end of a step
    errors: dict[str, list[float]] = {"weight": [], "spring": []}
    for steps in levels:
        for name, most, exact in (
            ("weight", weight, weight / stiffness + (force - weight) / viscous * lifts),
            ("spring", math.inf, force / stiffness * -math.expm1(-stiffness * end / viscous)),
        ):
            pellet = pellet_of(Sphere(0.4), resistance=Resistance(most, stiffness, 1.0))
            errors[name].append(abs(_against(pellet, force, viscous, end, steps) - 1.0 - exact))
    slack = pellet_of(Sphere(0.4), resistance=Resistance(weight, stiffness, 1.0))
    return judged(
        "Z − Z₀ = F/k (1 − e^(−kt/η)) until kZ = W at t* = −(η/k) ln(1 − W/F), then at (F − W)/η",
        [
            equal("pull of a slack string [mN]", pull_of_load(0.9, slack)[0], 0.0),
            error("place on a weight at 640 steps [cm]", errors["weight"][-1], 1e-5),
            error("place on a spring at 640 steps [cm]", errors["spring"][-1], 1e-6),
            order("in time, weight", [1.0 / n for n in levels], errors["weight"], 2.0),
            order("in time, spring", [1.0 / n for n in levels], errors["spring"], 2.0),
        ],
    )


def _against(pellet: PelletConstants, force: float, viscous: float, end: float, steps: int) -> float:
    """Place of a pellet at the end, from 1 cm on, by trapezoidal steps with the load solved for."""
    dt, place = end / steps, 1.0
    speed = force / viscous
    for _ in range(steps):

        def lacking(new: float, place: float = place, speed: float = speed) -> float:
            pull, _ = pull_of_load(place + 0.5 * dt * (speed + new), pellet)
            return sliding_velocity(force - pull, viscous, 0.0)[0] - new

        new = float(brentq(lacking, -1.0, 1.0, xtol=1e-15))
        place, speed = place + 0.5 * dt * (speed + new), new
    return place


NERVES = Reflex(
    *(True, 1.02, 1.0, 2.0, 0.7, 1.0, 0.75, 1.0, 0.001, 1.0, "graded"),
    stretch_range=0.12,
    summation=0.3,
    longitudinal_intensity=0.75,
    longitudinal_delay=0.2,
)
"""The guinea pig's."""


def discharged(girth: Floats, touching: NDArray[np.bool_]) -> Receptors:
    """Receptors that have just discharged for the first time, at 1 s."""
    state = observe_receptors(NERVES, SILENT, girth, touching, 1.0)
    assert state.receptors is not None
    return state.receptors


def brought(receptors: Receptors, nodes: Floats, cells: Floats, start: float) -> Answer:
    """What they bring to cells over a step of 0.1 s."""
    found = answer(NERVES, receptors, nodes, cells, start, start + 0.1)
    assert found is not None
    return found


def nodes_over(count: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Nodes [cm] of 8 cm, and which lie in the stretched part: its ends are halfway between two."""
    nodes = np.asarray(8.0 / count * (np.arange(count, dtype=np.float64) + 0.5))
    return nodes, (nodes > STRETCHED[0]) & (nodes < STRETCHED[1])


STRETCHED, STRETCH = (3.0, 4.0), 1.08
"""Where the wall is stretched evenly [cm], and by how much."""


def graded() -> Outcome:
    """Receptors over an evenly stretched length, and over one that is stretched more and more."""
    low, high = STRETCHED
    share = (STRETCH - NERVES.threshold) / NERVES.stretch_range
    below, above = np.array([2.95, 2.5, 1.7, 0.4]), np.array([4.05, 4.6, 5.5, 7.9])

    def neurons(near: Floats, length: float) -> Floats:
        """What neurons bring over a stretched centimetre that begins so far away."""
        reached = share * length / NERVES.summation * (np.exp(-near / length) - np.exp(-(near + high - low) / length))
        return np.asarray(-np.expm1(-reached))

    summed = 0.5 / NERVES.summation * math.exp(-0.5) * (1.0 - 2.0 * math.exp(-1.0))
    counts, errors, ramps = (80, 160, 320, 640), [], []
    for count in counts:
        nodes, inside = nodes_over(count)
        even = discharged(np.where(inside, STRETCH, 1.0), inside)
        oral = brought(even, nodes, below, 1.8).excitation - neurons(low - below, NERVES.oral_length)
        anal = brought(even, nodes, above, 1.8).inhibition - neurons(above - high, NERVES.anal_length)
        errors.append(float(np.abs(np.concatenate([oral, anal])).max()))
        rising = discharged(NERVES.threshold + 0.5 * NERVES.stretch_range * (nodes - low), inside)
        reached = brought(rising, nodes, np.array([low - 0.5]), 1.8).excitation
        ramps.append(abs(float(reached[0]) + math.expm1(-summed)))
    begun, whole = (brought(even, nodes, below, start).excitation for start in (1.65, 1.8))  # it begins at 1.7 s
    early = answer(NERVES, even, nodes, below, 1.0, 1.15)
    deaf = observe_receptors(NERVES, SILENT._replace(receptors=even), np.where(inside, STRETCH, 1.0), inside, 1.9)
    full = discharged(np.where(inside, 1.5, 1.0), inside)
    sizes = [8.0 / count for count in counts]
    return judged(
        "g = (σ − σ₀)/Δσ ≤ 1; S = gL/w (e^(−(a − z)/L) − e^(−(b − z)/L)); I/I₀ = 1 − e^(−S); for g = (s − a)/2 cm, "
        "L = b − a = 1 cm, S = e^(−(a − z)/L)(1 − 2/e)/2w",
        [
            error("strength of a receptor", float(even.strength[0].max()) - share, 1e-12),
            equal("strength beyond the range", float(full.strength[0].max()), 1.0),
            equal("new discharges within the refractory time", float(deaf.receptors is not even), 0.0),
            error("share of what neurons bring on 640 nodes", errors[-1], 1e-4),
            order("in space, even stretch", sizes, errors, 2.0),
            order("in space, rising stretch", sizes, ramps, 2.0),
            error(
                "answer that begins in the middle of a step, over the whole",
                float(np.abs(np.log1p(-begun) / np.log1p(-whole) - 0.5).max()),
                1e-9,
            ),
            equal("answer before its delay", float(early is not None), 0.0),
        ],
    )


def warmed() -> Outcome:
    """Cells that are colder do the same later, and pull less, by the stated factors."""
    kelvin = -7.0
    usual = build(scenarios.configuration("baseline"))
    cold = build(scenarios.configuration("baseline", changes={"tissue.warming": f"{kelvin} K"}))
    tissue = scenarios.configuration("baseline").tissue
    slower, weaker = tissue.q10_kinetics ** (kelvin / 10.0), tissue.q10_force ** (kelvin / 10.0)
    start, rate = np.array(resting_start()), cold.circular.constants.kinetics_rate
    reference = ReferenceCell(slow=0.004, rate=0.125)
    times = np.arange(40.0, 1200.0, 40.0)
    wanted = reference.solve(start, [(50.0, 2.0), (1150.0, 0.0)], times)
    levels, errors = [0.25, 0.125, 0.0625, 0.03125], []
    for dt in levels:
        cell = Cell(start, 0.004, rate, dt / slower, True)
        steps = round(10.0 / dt)
        found = [cell.advance(steps, 2.0 * slower if t <= 50.0 else 0.0) for t in np.arange(10.0, 1200.0, 10.0)]
        errors.append(float(np.abs(np.array(found)[3::4] - wanted).max() / np.ptp(wanted)))
    ratios = [
        getattr(cold, layer).force_factor / getattr(usual, layer).force_factor / weaker - 1.0
        for layer in ("longitudinal", "circular")
    ]
    return judged(
        "V(t; ΔT, I) = V(t Q_k^(ΔT/10); 0, I Q_k^(−ΔT/10)); force times Q_F^(ΔT/10)",
        [
            error("rate of the cells, relative", rate / (usual.circular.constants.kinetics_rate * slower) - 1.0, 1e-14),
            error("force factors, relative", max(map(abs, ratios)), 1e-14),
            error("of the range of V at the shortest step", errors[-1], 1e-5),
            order("in time", levels, errors, 2.0),
        ],
        "The independent cell is solved at the usual temperature, and its time stretched.",
    )


TAUT = {
    "wall.slack_length": "0 cm",
    "grid.n_z": 200,
    "grid.n_z_wall": 150,
    "step.wall": "100 ms",
    "step.conduction": "20 ms",
}
"""A tube held at its length, on coarse grids: its empty wall has one state of rest, a slack one many."""


def repeated() -> Outcome:
    """A pass on tissue that has come to rest repeats the first one; one that follows at once does not."""
    late = passes("guinea_pig", TAUT, count=2, rest="1200 s").passes
    soon = passes("guinea_pig", TAUT, count=2, rest="2 s").passes
    transits = [one.result.summary["transit_s"] for one in (*late, soon[1])]
    potentials = [one.result.arrays["potential_circular"][0] for one in late]
    return judged(
        "after 1200 s of rest the second pass is the first; after 2 s it is not",
        [
            error("potential at the beginning [mV]", float(np.abs(potentials[1] - potentials[0]).max()), 1e-3),
            error("transit, relative", transits[1] / transits[0] - 1.0, 2e-3),
            error("speed in the middle, relative", late[1].speed / late[0].speed - 1.0, 3e-3),
            Check("transit at once over that of the first", transits[2] / transits[0], 1.05),
        ],
        "What is left is the wall: the pellet is put in by its viscosity, and the first pass begins in equilibrium.",
    )


PROBLEMS = (
    Problem("F10", "Friction in proportion to pressing", "elementary integration", "quick", pressed, (34, 124)),
    Problem("F11", "Dry friction that falls with speed", "quadratic; elementary integration", "quick", falling, (125,)),
    Problem("F12", "Load on a string", "elementary integration", "quick", loaded, (34, 123)),
    Problem("E16", "Temperature", "scaling time in Eq. (20)", "quick", warmed, (20, 126)),
    Problem("X9", "Graded reflex", "integral of an exponential", "quick", graded, (120, 121, 122)),
    Problem("X10", "Repeated passes", "the first pass", "full", repeated, (105,)),
)
