"""The pellet in the tube: exact force identities, contact pressure, edges, symmetry, complementarity."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from peristalsis.model.equilibrium import CONVERGED, LumenConstants, Step, solve_equilibrium
from peristalsis.model.fields import contact_pressure, corner_tensions, end_reactions, nodal, stretch_of_elements
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.pellet.contact import smallest_gap
from peristalsis.verification.exact.orders import assert_order
from peristalsis.verification.exact.pellets import FrictionlessContact
from peristalsis.verification.exact.runs import EXACT, IDLE, March, march, moved, started, wave_catches_pellet
from peristalsis.verification.exact.wall import axial_invariants
from peristalsis.wall.membrane import TOTAL_CIRCULAR, TOTAL_LONGITUDINAL

Floats = NDArray[np.float64]

MIDDLE = {"pellet.start_gap": "4.1 cm"}
"""The pellet of radius 0.9 cm in the middle of the 10 cm tube."""


@pytest.fixture(scope="module")
def run() -> March:
    return wave_catches_pellet()


def gaps(model: Model, state: State) -> Floats:
    rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
    return np.hypot(rho, zeta - state.pellet.position) - model.pellet.radius


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
    rho, zeta = (np.ascontiguousarray(state.wall.position[:, 0, k]) for k in (0, 2))
    density, scalars = state.wall.contact[:, 0].copy(), np.array([state.pressure, 5.0, 0.0])
    n = rho.size
    for share in np.linspace(0.1, 1.0, 10):
        code, *_ = solve_equilibrium(
            rho,
            zeta,
            density,
            scalars,
            np.zeros((2, n)),
            np.zeros((2, n)),
            np.ones(n - 1),
            np.ones(n),
            np.zeros(2 * n - 2),
            share * drive,
            np.zeros(n),
            Step(0.0, False, 5.0, 0.0),
            model.wall,
            model.pellet,
            LumenConstants(state.pressure, 1.0, 0.0),
            model.tolerance,
            model.gap_tolerance,
            100,
        )
        assert code == CONVERGED, f"no equilibrium at {share:.0%} of the squeeze"
    position = state.wall.position.copy()
    position[:, 0, 0], position[:, 0, 2] = rho, zeta
    both = np.stack([np.zeros(2 * n - 2), drive])[:, :, None]
    wall = replace(moved(state, position).wall, contact=density[:, None], drive=both)
    return model, replace(state, wall=wall, pellet=replace(state.pellet, axial_force=float(scalars[2])))


def test_run_is_worth_checking(run: March) -> None:
    """The wave reaches the pellet, contact comes and goes, and the pellet slides both ways or far."""
    touching = {int((s.wall.contact > 0.0).sum()) for s in run.states}
    assert len(touching) > 10
    assert max(s.pellet.axial_force for s in run.states) > 100.0
    assert run.last.pellet.position - run.states[0].pellet.position > 0.3


def test_no_penetration_no_adhesion_and_one_of_both_vanishes(run: March) -> None:
    """C5 and Eq. (12) after every step: Q >= 0 exactly, gap >= 0 and their product 0 to the solver's tolerance."""
    radius = run.model.pellet.radius
    for state in run.states:
        gap, density = gaps(run.model, state), state.wall.contact[:, 0]
        assert gap[1:-1].min() >= -1e-9 * radius
        assert density.min() >= 0.0
        assert np.abs(density * gap).max() <= 1e-10
        assert smallest_gap(
            np.ascontiguousarray(state.wall.position[:, 0, 0]),
            np.ascontiguousarray(state.wall.position[:, 0, 2]),
            state.pellet.position,
            radius,
        ) == pytest.approx(gap[1:-1].min(), abs=1e-14)


def test_wall_between_nodes_hardly_enters_the_pellet(run: March) -> None:
    """C5 for the wall as a surface: chords between touching nodes stay within 1e-3 R of the sphere."""
    for state in run.states[::20]:
        position = state.wall.position[:, 0]
        middle = 0.5 * (position[1:] + position[:-1])
        gap = np.hypot(middle[:, 0], middle[:, 2] - state.pellet.position) - run.model.pellet.radius
        assert gap.min() >= -1e-3 * run.model.pellet.radius


@pytest.mark.parametrize("tension", ["published", "consistent"])
def test_pellet_force_is_the_difference_of_the_end_reactions(tension: str) -> None:
    """C1, Eq. (28): reactions at the clamped ends against the contact forces, 1e-8, after every tenth step."""
    taken = wave_catches_pellet() if tension == "published" else march(0.5, {"wall.tension": tension})
    largest = max(abs(s.pellet.axial_force) for s in taken.states)
    assert largest > 100.0
    for state in taken.states[10::10]:
        oral, anal, _ = end_reactions(state.wall, taken.model.wall, state.pressure)
        assert abs(anal - oral - state.pellet.axial_force) <= 1e-8 * largest


def test_friction_balances_the_force_of_the_wall(run: March) -> None:
    """C1, Eq. (13): eta v + F_d sgn v equals F_z to rounding whenever the pellet slides."""
    pellet = run.model.pellet
    sliding = [s.pellet for s in run.states[1:] if s.pellet.velocity != 0.0]
    assert len(sliding) > 50
    for p in sliding:
        friction = pellet.viscous * p.velocity + pellet.dry * np.sign(p.velocity)
        assert friction == pytest.approx(p.axial_force, rel=1e-12)


def test_force_from_the_contact_pressure_converges() -> None:
    """C1 in integral form: the stored pressure gives F_z within 2 h^2 of the normal force.

    Bounded and not gated as an order: where the edge falls between two nodes changes the last strip at random.
    """
    for elements in (200, 400, 800, 1600):
        model, state = squeezed(elements)
        assert state.pellet.axial_force > 0.5, "the squeeze must push the pellet"
        h = model.wall.element_size
        normal = 2.0 * np.pi * model.wall.radius * h * state.wall.contact.sum()
        error = abs(force_from_pressure(model, state) - state.pellet.axial_force)
        assert error <= 2.0 * h**2 * normal


def test_static_squeeze_ends_in_the_reactions() -> None:
    """C1 without any motion: contact forces and end reactions agree to 1e-8."""
    model, state = squeezed(400)
    oral, anal, _ = end_reactions(state.wall, model.wall, state.pressure)
    assert anal - oral == pytest.approx(state.pellet.axial_force, rel=1e-8)


def test_force_from_the_contact_pressure_in_motion(run: March) -> None:
    """C1 while the pellet is driven: both evaluations within a per cent of the largest force."""
    largest = max(abs(s.pellet.axial_force) for s in run.states)
    for state in run.states[10::10]:
        assert abs(force_from_pressure(run.model, state) - state.pellet.axial_force) <= 0.01 * largest


def test_contact_pressure_in_the_middle_of_the_band() -> None:
    """C2: both curvatures are 1/R, so q = (T_m + T_c)/R - p with tensions per deformed length; order 2."""
    sizes, errors = [], []
    for elements in (600, 800, 1200, 1600):
        model, state = held(elements)
        corners = corner_tensions(state.wall, model.wall)[:, :, 0]
        k = elements // 2
        mean = 0.5 * (corners[k - 1, 1] + corners[k, 0])
        stretch = float(nodal(stretch_of_elements(state.wall.position, model.wall.element_size))[k, 0])
        hoop = float(state.wall.position[k, 0, 0] / model.wall.radius)
        tension = mean[TOTAL_LONGITUDINAL] / hoop + mean[TOTAL_CIRCULAR] / stretch
        exact = tension / model.pellet.radius - state.pressure
        sizes.append(model.wall.element_size)
        errors.append(abs(float(contact_pressure(state.wall, model.wall)[k, 0]) / exact - 1.0))
    assert_order(sizes, errors, 2.0)
    assert errors[-1] <= 1e-4


def test_second_first_integral_holds_under_frictionless_contact() -> None:
    """M4(ii) with C: W - lambda_l W_l does not jump at the contact edges; friction on the wall would break it."""
    spreads = []
    for elements in (400, 1600):
        model, state = held(elements)
        rho, zeta = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
        inner = (model.grid.nodes[1:] > 2.0) & (model.grid.nodes[1:] < 8.0)
        _, constant = axial_invariants(rho, zeta, state.pressure, model.wall)
        spreads.append(float(np.ptp(constant[inner]) / np.abs(constant).max()))
    assert spreads[1] <= 0.25 * spreads[0]
    assert spreads[0] <= 1e-3


def test_contact_edge_is_where_the_membrane_leaves_the_sphere() -> None:
    """C4: the edge of the algebraic solution, with F and W - lambda_l W_l of the far field, to a per cent."""
    model, state = held(1600)
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
    length = 0.5 * (zeta[touching[-1]] - zeta[touching[0]])
    assert exact >= 10.0 * model.wall.element_size
    assert length == pytest.approx(exact, rel=0.01, abs=0.5 * model.wall.element_size)


def test_pellet_in_the_middle_feels_no_force() -> None:
    """C3: everything is symmetric, so F_z vanishes against the normal force."""
    model, state = held(400)
    normal = 2.0 * np.pi * model.wall.radius * model.wall.element_size * state.wall.contact.sum()
    assert normal > 100.0
    assert abs(state.pellet.axial_force) <= 1e-9 * normal


def test_symmetric_rings_leave_the_pellet_in_the_middle() -> None:
    """C3 in time: rings on both sides squeeze alike; without dry friction nothing else would hold the pellet."""
    rings = {
        "rings.enabled": True,
        "rings.positions": ["3.5 cm", "6.5 cm"],
        "pellet.dry_friction": "0 mN",
        "grid.n_z_wall": 200,
    }
    taken = march(0.5, IDLE, MIDDLE, rings)
    squeezed = taken.last.wall.position[:, 0, 0].min()
    assert squeezed < 0.7, "the rings must have closed"
    assert abs(taken.last.pellet.position - 5.0) <= 1e-8
    uneven = march(0.5, IDLE, MIDDLE, rings, {"rings.positions": ["3.5 cm", "7.5 cm"]})
    assert uneven.last.pellet.position > 5.0 + 1e-3, "an uneven pair does move it"


def test_force_budget(run: March) -> None:
    """C7: no force above the axial tension around the ring and the pressure on the change of section."""
    for state in run.states[::20]:
        corners = corner_tensions(state.wall, run.model.wall)
        radius = float(state.wall.position[:, 0, 0].max())
        tension = float(corners[..., TOTAL_LONGITUDINAL].max())
        assert abs(state.pellet.axial_force) <= 2.0 * (
            2.0 * np.pi * radius * tension + state.pressure * np.pi * radius**2
        )


def test_looser_tube_does_not_touch() -> None:
    """A pellet narrower than the inflated tube has no contact, feels no force and does not move."""
    taken = march(0.02, IDLE, {"pellet.radius": "0.7 cm"})
    assert taken.last.wall.contact.max() == 0.0
    assert taken.last.pellet.axial_force == 0.0
    assert taken.last.pellet.position == taken.states[0].pellet.position
