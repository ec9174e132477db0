"""C1-C7: the pellet in the tube: force identities, contact pressure, edges, symmetry, drag."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from peristalsis.errors import DivergenceError
from peristalsis.model.constants import LumenConstants, Step
from peristalsis.model.equilibrium import History, solve_equilibrium
from peristalsis.model.fields import contact_pressure, corner_tensions, end_reactions, nodal, stretch_of_elements
from peristalsis.model.model import Model
from peristalsis.model.problem import Limits, Unknowns
from peristalsis.model.state import State
from peristalsis.model.step_summary import work_of_step
from peristalsis.model.verdicts import CONVERGED, REASONS
from peristalsis.numerics.rates import STATIC, RateFormula, rate_formula
from peristalsis.wall.membrane import TOTAL_CIRCULAR, TOTAL_LONGITUDINAL

from .exact.pellets import FrictionlessContact
from .exact.runs import EXACT, IDLE, March, march, started, wave_catches_pellet
from .exact.wall import axial_invariants, energy, wall_constants
from .problem import Check, Outcome, Problem, error, judged, order
from .waves import inflated

Floats = NDArray[np.float64]

MIDDLE = {"pellet.start_gap": "4.1 cm"}
"""The pellet of radius 0.9 cm in the middle of the 10 cm tube."""


def gaps(model: Model, state: State) -> Floats:
    """Distance of every node from the pellet [cm]."""
    rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
    return np.asarray(np.hypot(rho, zeta - state.pellet.position) - model.pellet.radius)


def normal_force(model: Model, state: State) -> float:
    """Sum of the contact forces [mN]."""
    return float(2.0 * np.pi * model.wall.radius * model.wall.element_size * state.wall.contact.sum())


def force_from_pressure(model: Model, state: State) -> float:
    """-2 pi int q (zeta - Z_c) dzeta by the trapezoidal rule over the stored contact pressure [mN]."""
    q = contact_pressure(state.wall, model.wall)[:, 0]
    zeta = state.wall.position[:, 0, 2]
    return float(-2.0 * np.pi * np.trapezoid(q * (zeta - state.pellet.position), zeta))


@cache
def held(elements: int) -> tuple[Model, State]:
    """The passive tube on the pellet in its middle, without friction along the wall, smoothing and bending."""
    return started(EXACT, IDLE, MIDDLE, {"grid.n_z_wall": elements})


@cache
def squeezed(elements: int) -> tuple[Model, State]:
    """The same with circular muscle pulling smoothly behind the pellet: static, one-sided, with a force on it."""
    model, state = held(elements)
    corners = np.repeat(model.grid.nodes, 2)[1:-1]
    drive = 0.25 * np.exp(-(((corners - 4.2) / 0.6) ** 2))
    for share in np.linspace(0.1, 1.0, 10):
        state = carried(model, state, state.pellet.position, STATIC, share * drive)
    return model, state


def carried(
    model: Model, state: State, centre: float, formula: RateFormula, drive: Floats | None = None, dt: float = 0.0
) -> State:
    """The state with its pellet put to `centre` [cm] at constant pressure and the wall in equilibrium around it.

    drive: of the circular muscle at the half elements [mV]. With a static formula the wall forgets how it came there.
    Raises DivergenceError where there is no equilibrium.
    """
    wall, n = state.wall, model.grid.nodes.size
    drives = np.zeros((2, 2 * n - 2))
    if drive is not None:
        drives[1] = drive
    rho, zeta = (np.ascontiguousarray(wall.position[:, 0, k]) for k in (0, 2))
    density, scalars = wall.contact[:, 0].copy(), np.array([state.pressure, centre, 0.0])
    history = formula.history(wall.position, wall.position_before)
    h = model.wall.element_size
    along, along_before = (stretch_of_elements(p, h) for p in (wall.position, wall.position_before))
    along_history = formula.history(along, along_before)[:, 0]
    hoop_history = history[:, 0, 0] / model.wall.radius
    code, *_ = solve_equilibrium(
        Unknowns(rho, zeta, density, scalars),
        History(history[:, 0, [0, 2]].T, np.zeros((2, n)), along_history, hoop_history),
        drives,
        np.zeros(n),
        Step(formula.inverse, False, centre, 0.0),
        model.wall,
        model.pellet,
        LumenConstants(state.pressure, 1.0, 0.0),
        Limits(model.tolerance, model.gap_tolerance, 100),
    )
    if code != CONVERGED:
        raise DivergenceError(f"no equilibrium around a pellet at {centre:g} cm: {REASONS[code]}")
    position = wall.position.copy()
    position[:, 0, 0], position[:, 0, 2] = rho, zeta
    velocity = (position - history) * formula.inverse
    after = replace(
        wall,
        position=position,
        position_before=wall.position,
        velocity=velocity,
        velocity_before=wall.velocity,
        contact=density[:, None],
        stretch_rate=(stretch_of_elements(position, h) - along_history[:, None]) * formula.inverse,
        hoop_rate=(position[:, :, 0] / model.wall.radius - hoop_history[:, None]) * formula.inverse,
        drive=drives[:, :, None],
        step_before=dt,
    )
    pellet = replace(state.pellet, position=centre, axial_force=float(scalars[2]))
    return replace(state, wall=after, pellet=pellet)


def force_identity() -> Outcome:
    """The force on the pellet is the difference of the end reactions; and the integral of the contact pressure."""
    checks = []
    for tension in ("published", "consistent"):
        taken = wave_catches_pellet() if tension == "published" else march(0.5, {"wall.tension": tension})
        largest = max(abs(s.pellet.axial_force) for s in taken.states)
        worst = 0.0
        for state in taken.states[10::5]:
            oral, anal, _ = end_reactions(state.wall, taken.model.wall, state.pressure)
            worst = max(worst, abs(anal - oral - state.pellet.axial_force) / largest)
        checks.append(error(f"reactions, {tension}, relative", worst, 1e-10))
        checks.append(Check(f"largest force, {tension} [mN]", largest, 100.0))
    model, state = squeezed(400)
    oral, anal, _ = end_reactions(state.wall, model.wall, state.pressure)
    checks.append(error("reactions, static, relative", (anal - oral) / state.pellet.axial_force - 1.0, 1e-8))
    left = 0.0
    for elements in (200, 400, 800, 1600):
        model, state = squeezed(elements)
        off = abs(force_from_pressure(model, state) - state.pellet.axial_force)
        left = max(left, off / (model.wall.element_size**2 * normal_force(model, state)))
    checks.append(error("∫q against F_z, over h² N, four grids", left, 2.0))
    return judged(
        "F_z = [2πrT_m cosα − πpr²] at the anal end less at the oral end",
        checks,
        "The integral is bounded and not gated as an order: where the edge falls between two nodes changes the last "
        "strip at random.",
    )


def band_pressure() -> Outcome:
    """q in the middle of the band; the force and the normal force by Archimedes; W - lambda_l W_l under contact."""
    sizes, errors, forces = [], [], []
    for elements in (600, 800, 1200, 1600):
        model, state = held(elements)
        corners = corner_tensions(state.wall, model.wall)[:, :, 0]
        k = elements // 2
        mean = 0.5 * (corners[k - 1, 1] + corners[k, 0])
        stretch = float(nodal(stretch_of_elements(state.wall.position, model.wall.element_size))[k, 0])
        hoop = float(state.wall.position[k, 0, 0] / model.wall.radius)
        tension = mean[TOTAL_LONGITUDINAL] / hoop + mean[TOTAL_CIRCULAR] / stretch
        exact = tension / model.pellet.radius - state.pressure
        q = contact_pressure(state.wall, model.wall)[:, 0]
        sizes.append(model.wall.element_size)
        errors.append(abs(float(q[k]) / exact - 1.0))
        zeta = state.wall.position[:, 0, 2]
        total = 2.0 * np.pi * model.pellet.radius * float(np.trapezoid(q, zeta))
        forces.append(abs(total / normal_force(model, state) - 1.0))
    spreads = []
    for elements in (400, 1600):
        model, state = held(elements)
        rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
        inner = (model.grid.nodes[1:] > 2.0) & (model.grid.nodes[1:] < 8.0)
        _, constant = axial_invariants(rho, zeta, state.pressure, model.wall)
        spreads.append(float(np.ptp(constant[inner]) / np.abs(constant).max()))
    model, state = squeezed(1600)
    force = force_from_pressure(model, state) / state.pellet.axial_force - 1.0
    return judged(
        "q = (T_m + T_c)/R − p; N = 2πR ∫q dz; F_z = −2π ∫q (z − Z_c) dz",
        [
            error("q in the middle at 1600 elements, relative", errors[-1], 1e-4),
            order("of q in space", sizes, errors, 2.0),
            error("N by two ways at 1600 elements, relative", forces[-1], 0.01),
            error("F_z by two ways, squeezed, relative", force, 0.01),
            error("spread of W − λ₁W₁ across the band, 400 elements", spreads[0], 1e-3),
            Check("spread falls from 400 to 1600 elements by", spreads[0] / spreads[1], 4.0),
        ],
    )


def symmetry() -> Outcome:
    """Symmetric wall and activation: no force, no motion."""
    model, state = held(400)
    rings = {
        "rings.enabled": True,
        "rings.positions": ["3.5 cm", "6.5 cm"],
        "pellet.dry_friction": "0 mN",
        "grid.n_z_wall": 200,
    }
    taken = march(0.5, IDLE, MIDDLE, rings)
    uneven = march(0.5, IDLE, MIDDLE, rings, {"rings.positions": ["3.5 cm", "7.5 cm"]})
    return judged(
        "F_z = 0, Z_c stays",
        [
            error("|F_z|/N at the start", state.pellet.axial_force / normal_force(model, state), 1e-12),
            error("way in 0.5 s between two rings, F_d = 0 [cm]", taken.last.pellet.position - 5.0, 1e-12),
            Check("narrowest radius of the rings [cm]", float(taken.last.wall.position[:, 0, 0].min()), 0.1, 0.7),
            Check("way with an uneven pair [cm]", uneven.last.pellet.position - 5.0, 1e-3),
        ],
    )


def _edge(elements: int) -> tuple[float, float, float]:
    """Half length of the contact, exact one for its far field, and element size [cm]."""
    model, state = held(elements)
    rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
    force, constant = axial_invariants(rho, zeta, state.pressure, model.wall)
    far = int(2.0 / model.wall.element_size)
    exact = FrictionlessContact(
        model.wall.radius,
        model.pellet.radius,
        model.wall.passive,
        float(force[far]),
        float(constant[far]),
        state.pressure,
    ).half_length()
    touching = np.flatnonzero(state.wall.contact[:, 0] > 0.0)
    return 0.5 * float(zeta[touching[-1]] - zeta[touching[0]]), exact, model.wall.element_size


def contact_edge() -> Outcome:
    """Where the membrane leaves the sphere."""
    checks = []
    for elements in (400, 800, 1600):
        found, exact, h = _edge(elements)
        checks.append(error(f"half length at {elements} elements, over the element", (found - exact) / h, 1.0))
    checks.append(error("half length at 1600 elements, relative", found / exact - 1.0, 0.01))
    checks.append(Check("half length over the element", exact / h, 10.0))
    return judged(
        "2πR₀W₁ sinθ − πpR² sin²θ = F on the sphere, where W − λ₁W₁ = K",
        checks,
        "F and K of the computed far field. A contact length is a whole number of elements: within "
        "one element on every grid is first order.",
    )


def small_interference() -> Outcome:
    """The closed form for a pellet that hardly fits, against the exact edge, and the program against both."""
    wall = wall_constants(4, 1.0)
    tube = inflated(wall, 1.05)
    free = wall.radius * tube.circumferential
    w1 = tube.derivatives[0]
    force = 2.0 * np.pi * wall.radius * w1 - tube.pressure * np.pi * free**2
    constant = float(energy(1.05, tube.circumferential, wall.passive)) - 1.05 * w1
    layer = 1.05 * tube.end_layer
    sizes, errors = [], []
    for share in (0.008, 0.004, 0.002, 0.001):
        sphere = free / (1.0 - share)
        exact = FrictionlessContact(wall.radius, sphere, wall.passive, force, constant, tube.pressure).half_length()
        closed = -layer + np.sqrt(layer**2 + 2.0 * sphere * (sphere - free))
        sizes.append(share)
        errors.append(abs(float(closed / exact) - 1.0))
    return judged(
        "a = −ℓ_z + √(ℓ_z² + 2Rδ), ℓ_z = λ₁ℓ",
        [
            error("relative at δ/R = 0.002", errors[2], 5e-3),
            order("in δ/R", sizes, errors, 1.0, 0.2),
        ],
        "The closed form against the algebraic edge of C4, which is the oracle for the program.",
    )


@cache
def long_run() -> March:
    """The baseline on the small grid over 0.8 s."""
    return wave_catches_pellet()


def complementarity() -> Outcome:
    """No penetration, no adhesion, and one of both vanishes, after every step."""
    taken = long_run()
    radius = taken.model.pellet.radius
    entered, adhesion, product, chord, jump = 0.0, 0.0, 0.0, 0.0, 0
    edges = None
    for state in taken.states:
        gap, density = gaps(taken.model, state), state.wall.contact[:, 0]
        entered = max(entered, -float(gap[1:-1].min()) / radius)
        adhesion = max(adhesion, -float(density.min()))
        product = max(product, float(np.abs(density * gap).max()))
        position = state.wall.position[:, 0]
        middle = 0.5 * (position[1:] + position[:-1])
        between = np.hypot(middle[:, 0], middle[:, 2] - state.pellet.position) - radius
        chord = max(chord, -float(between.min()) / radius)
        touching = np.flatnonzero(density > 0.0)
        if touching.size and edges is not None and edges.size:
            jump = max(jump, abs(int(touching[0] - edges[0])), abs(int(touching[-1] - edges[-1])))
        edges = touching
    return judged(
        "gap ≥ 0, q ≥ 0, gap·q = 0",
        [
            error("deepest node over R", max(entered, 0.0), 1e-9),
            error("deepest chord over R", max(chord, 0.0), 1e-3),
            error("strongest adhesion [mN/cm²]", max(adhesion, 0.0), 1e-12),
            error("|gap·Q| [mN/cm]", product, 1e-10),
            Check("largest force [mN]", max(s.pellet.axial_force for s in taken.states), 100.0),
            Check("largest jump of an edge in a step, in elements", jump, 1.0, 40.0),
        ],
        "The augmentation ε of Eq. (28) picks the touching nodes and does not enter the solution, so "
        "there is no penalty to vary.",
    )


def drag() -> Outcome:
    """A pellet carried along: no mean force without viscosity, and with it the work is stored or lost."""
    model, state = held(400)
    h = model.wall.element_size
    normal = normal_force(model, state)
    phases = 16
    forces = []
    for _ in range(2 * phases):
        state = carried(model, state, state.pellet.position + h / phases, STATIC)
        forces.append(state.pellet.axial_force)
    mean = float(np.mean(forces[-phases:])) / normal
    model, state = started(EXACT, IDLE, MIDDLE, {"grid.n_z_wall": 400, "lumen.adiabatic_exponent": 0.0})
    dt, speed = model.dt_wall, 2.0
    work, stored, lost, given = 0.0, 0.0, 0.0, 0.0
    before = state
    for k in range(250):
        formula = rate_formula(dt, dt if k else 0.0, True)
        after = carried(model, before, before.pellet.position + speed * dt, formula, dt=dt)
        part = work_of_step(replace(model, pellet=model.pellet._replace(viscous=1e30, dry=0.0)), before, after)
        stored, lost, given = stored + part.stored, lost + part.lost_wall, given + part.gas
        work -= 0.5 * (before.pellet.axial_force + after.pellet.axial_force) * speed * dt
        before = after
    return judged(
        "work of the pellet = Δenergy + dissipation; mean force 0 on an elastic tube",
        [
            error("mean force over an element, elastic, over N", mean, 5e-3),
            error("work less stored and lost, relative", (stored + lost - given) / work - 1.0, 5e-3),
            Check("work in 1 cm at 2 cm/s [mN cm]", work, 1.0),
            Check("of it lost in the wall", lost / work, 0.3, 1.5),
        ],
    )


def budget() -> Outcome:
    """No force above what tension and pressure can give."""
    taken = long_run()
    used = 0.0
    for state in taken.states[::5]:
        corners = corner_tensions(state.wall, taken.model.wall)
        radii = state.wall.position[:, 0, 0]
        tension = float(corners[..., TOTAL_LONGITUDINAL].max())
        bound = 2.0 * (2.0 * np.pi * float(radii.max()) * tension) + state.pressure * np.pi * float(np.ptp(radii**2))
        used = max(used, abs(state.pellet.axial_force) / bound)
    return judged(
        "|F_z| ≤ 2·2π r_max T_m,max + πp |r₁² − r₂²|",
        [Check("largest share of the bound", used, 1e-3, 1.0)],
        "Every fifth step of 0.8 s. Both ends of the band may pull, hence the factor 2.",
    )


YANG = "Yang & Feng, J. Appl. Mech. 37 (1970)"
PROBLEMS = (
    Problem("C1", "Force identity", "axial balance of wall and lumen", "quick", force_identity, (1, 13, 28, 35)),
    Problem("C2", "Pressure on the band", "both curvatures are 1/R; Archimedes", "quick", band_pressure, (12, 13, 28)),
    Problem("C3", "Symmetry", "mirror about the pellet", "quick", symmetry, (12, 13)),
    Problem("C4", "Contact edge", YANG, "quick", contact_edge, (1, 3, 4, 12)),
    Problem("C4s", "Small interference", "linearised C4", "quick", small_interference, (3, 4, 12)),
    Problem("C5", "Complementarity", "Signorini's conditions", "quick", complementarity, (12, 28)),
    Problem("C6", "Drag of a carried pellet", "first law", "quick", drag, (12, 28, 29)),
    Problem("C7", "Force budget", "bound of C1", "quick", budget, (1, 13)),
)
