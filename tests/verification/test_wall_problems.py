"""The wall against exact states, first integrals and decaying modes, Eqs. (1)-(5), (32), (35)."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from verification.problems.orders import assert_order
from verification.problems.runs import EXACT, IDLE, march, moved, started
from verification.problems.wall import (
    COUPLED,
    InflatedTube,
    assembled,
    axial_invariants,
    settle,
    wall_constants,
)

from peristalsis.errors import DivergenceError
from peristalsis.model.step import advance
from peristalsis.numerics.rates import rate_formula
from peristalsis.wall.membrane import PARTS, TOTAL_LONGITUDINAL, WallConstants, corner_tension
from peristalsis.wall.passive import PassiveConstants

Floats = NDArray[np.float64]


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("stretch", [1.0, 1.3])
@pytest.mark.parametrize("drive", [0.0, 0.4])
def test_laplace(published: bool, stretch: float, drive: float) -> None:
    """M1: where T_c = p rho (tension per deformed length) no force is left on a straight tube, 1e-10."""
    wall = wall_constants(20, published=published)
    tube = InflatedTube(10.0, wall, stretch, drive)
    rho = np.full(21, wall.radius * tube.hoop_stretch())
    zeta = np.linspace(0.0, 10.0 * stretch, 21)
    residual, _ = assembled(rho, zeta, wall, drives=(np.zeros(40), np.full(40, drive)))
    hoop_force = np.abs(residual[2:-2]).max()
    residual, _ = assembled(rho, zeta, wall, drives=(np.zeros(40), np.full(40, drive)), pressure=10.0)
    assert np.abs(residual[2:-2]).max() <= 1e-10 * hoop_force


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("drive", [0.0, 0.4, 1.5])
def test_solver_finds_the_inflated_tube(published: bool, drive: float) -> None:
    """M3: from a disturbed start between ends at the exact radius, the root of one scalar equation, 1e-8."""
    wall = wall_constants(40, 4.0, published=published)
    exact = wall.radius * InflatedTube(10.0, wall, 1.05, drive).hoop_stretch()
    s = np.linspace(0.0, 1.0, 41)
    rho, zeta = exact + 0.05 * np.sin(np.pi * s), 4.2 * s + 0.02 * np.sin(2.0 * np.pi * s)
    settle(rho, zeta, 10.0, wall, drive)
    assert np.abs(rho / exact - 1.0).max() <= 1e-8
    assert np.abs(zeta - 4.2 * s).max() <= 1e-8


@cache
def clamped(elements: int, published: bool) -> tuple[Floats, Floats, WallConstants]:
    """A tube 3 cm long, stretched by 30 %, clamped at r0 and inflated to 0.1 kPa: its ends are boundary layers."""
    wall = wall_constants(elements, 3.0, published=published)
    s = np.linspace(0.0, 1.0, elements + 1)
    rho, zeta = np.full(elements + 1, wall.radius), 3.9 * s
    settle(rho, zeta, 10.0, wall)
    return rho, zeta, wall


@pytest.mark.parametrize("published", [False, True])
def test_axial_force_is_the_same_everywhere(published: bool) -> None:
    """M4(i): F = 2 pi r T_m cos(alpha) - pi p r^2, discretely and whatever the convention, 1e-9."""
    rho, zeta, wall = clamped(200, published)
    force, _ = axial_invariants(rho, zeta, 10.0, wall)
    assert np.ptp(rho) > 0.01, "the ends must matter"
    assert np.ptp(force) <= 1e-9 * np.abs(force).max()


def test_second_first_integral_is_met_to_second_order() -> None:
    """M4(ii): W - lambda_l W_l is one number along a uniform membrane in the consistent convention."""
    sizes, spreads = [], []
    for elements in (200, 400, 800, 1600):
        rho, zeta, wall = clamped(elements, False)
        _, constant = axial_invariants(rho, zeta, 10.0, wall)
        sizes.append(wall.element_size)
        spreads.append(float(np.ptp(constant) / np.abs(constant).max()))
    assert_order(sizes, spreads, 2.0)
    assert spreads[1] <= 1e-3


def test_published_tensions_have_no_second_integral() -> None:
    """Eq. (35): as printed, the tensions are not those of an energy, and the spread does not shrink."""
    spreads = []
    for elements in (200, 400):
        rho, zeta, wall = clamped(elements, True)
        spreads.append(float(np.ptp(axial_invariants(rho, zeta, 10.0, wall)[1])))
    assert spreads[1] > 0.5 * spreads[0] > 1e-3


def test_clamped_tube_converges_to_second_order() -> None:
    """Radius a twentieth of the way in, against the finest grid: linear elements are second order."""
    finest = clamped(3200, False)[0]
    sizes, errors = [], []
    for elements in (100, 200, 400, 800):
        rho, _, wall = clamped(elements, False)
        stride = 3200 // elements
        sizes.append(wall.element_size)
        errors.append(float(np.abs(rho - finest[::stride]).max()))
    assert_order(sizes, errors, 2.0, tolerance=0.15)
    assert errors[-1] <= 1e-4


def creep(steps: int, second_order: bool) -> float:
    """Error of the hoop strain after 2 time constants under a pressure switched on at t = 0, one uniform ring.

    With c2 alone the law is linear, T_c = c2 e + k de/dt, and the pressure pulls p r0 (1 + e): a Kelvin-Voigt body.
    """
    wall = wall_constants(
        2, 1.0, passive=PassiveConstants(0.0, 10.4, 0.0, 0.0, 0.0, 0.0, 0.0), radius=0.8, published=False
    )
    pressure, stiffness = 4.0, 10.4 - 4.0 * 0.8
    end = 2.0 * wall.viscosity / stiffness
    zeta, dt = np.linspace(0.0, 1.0, 3), end / steps
    now = before = wall.radius
    for step in range(steps):
        formula = rate_formula(dt, dt if step else 0.0, second_order)
        hoop_history = (formula.keep * now + formula.older * before) / wall.radius
        before = now
        for _ in range(2):  # linear: the second pass only removes rounding
            residual, matrix = assembled(
                np.full(3, now),
                zeta,
                wall,
                formula.inverse,
                (np.ones(2), np.full(3, hoop_history)),
                pressure=pressure,
            )
            now -= residual[2] / matrix[2, 0::2].sum()
    exact = pressure * wall.radius / stiffness * (1.0 - np.exp(-2.0))
    return abs(now / wall.radius - 1.0 - exact)


def test_creep_under_pressure_with_second_order_rates() -> None:
    """M8: strain (P/K)(1 - exp(-K t/k)); order 2 with variable-step BDF2, 1e-6 at the finest step."""
    levels = [50, 100, 200, 400, 800]
    errors = [creep(n, True) for n in levels]
    assert_order([1.0 / n for n in levels], errors, 2.0)
    assert errors[-1] <= 2e-6


def test_creep_under_pressure_with_backward_euler() -> None:
    """M8 with the first-order scheme, which must be of first order and no better."""
    levels = [50, 100, 200, 400]
    assert_order([1.0 / n for n in levels], [creep(n, False) for n in levels], 1.0)


LINEAR_ROD = {
    "wall.c1": "40 mN/cm",
    "wall.c3": "0 mN/cm",
    "wall.c10": "0 mN/cm",
    "lumen.pressure": "0 kPa",
    "pellet.enabled": False,
    "grid.n_z": 8,
    "grid.n_z_wall": 32,
}
"""Without pressure, coupling and exponential the tube is a linear Kelvin-Voigt rod along z, clamped at its ends."""


def rod_error(dt: float, end: float, changes: dict[str, object], rate: complex) -> float:
    """Error of the amplitude of the first axial mode after `end` [s], by the package's own coupled step."""
    model, state = started(
        EXACT, IDLE, LINEAR_ROD, {"step.wall": f"{1e3 * dt} ms", "step.conduction": f"{1e3 * dt / 4} ms"}, changes
    )
    shape = np.sin(np.pi * model.grid.nodes / 10.0)
    position = state.wall.position.copy()
    position[:, 0, 2] += 0.05 * shape
    state = moved(state, position)
    for _ in range(round(end / dt)):
        state, _ = advance(model, state)
    displacement = state.wall.position[:, 0, 2] - model.grid.nodes
    assert np.abs(state.wall.position[:, 0, 0] - 0.795).max() <= 1e-9, "a rod does not bulge"
    amplitude = displacement @ shape / (shape @ shape)
    assert np.abs(displacement - amplitude * shape).max() <= 1e-9, "one mode stays one mode"
    exact = (
        0.05 * (np.exp(rate * end) * (1.0 + 1j * rate.real / rate.imag)).real
        if rate.imag
        else 0.05 * np.exp(rate.real * end)
    )
    return abs(amplitude - exact)


@pytest.mark.parametrize(("scheme", "order"), [("bdf2", 2.0), ("euler", 1.0)])
def test_recovery_of_the_stretched_rod(scheme: str, order: float) -> None:
    """M8: without inertia every mode relaxes as exp(-K t/k), by the whole coupled step; both schemes."""
    levels = [8e-3, 4e-3, 2e-3, 1e-3]
    errors = [rod_error(dt, 0.8, {"step.scheme": scheme}, complex(-40.0 / 33.3, 0.0)) for dt in levels]
    assert_order(levels, errors, order)
    assert errors[-1] <= (1e-6 if scheme == "bdf2" else 5e-5)


def test_clamped_ends_stay_where_they_are() -> None:
    """Both ends are clamped: not one bit may change while the wall moves between them."""
    taken = march(0.4, {"grid.n_z": 200, "grid.n_z_wall": 100})
    first, last = taken.states[0].wall.position, taken.last.wall.position
    assert np.abs(last - first).max() > 0.05, "the wall must have moved"
    assert np.array_equal(last[[0, -1]], first[[0, -1]])


def test_damped_oscillation_of_the_rod() -> None:
    """M9: m w^2 + i w k kz^2 - c1 kz^2 = 0 with inertia, frequency and decay of the discrete mode, order 2."""
    density, viscosity, h = 20e3, 3.0, 10.0 / 32
    mass = density * 1e-5
    symbol = (2.0 / h * np.sin(0.05 * np.pi * h)) ** 2
    damping = 0.5 * viscosity * symbol / mass
    rate = complex(-damping, np.sqrt(40.0 * symbol / mass - damping**2))
    changes: dict[str, object] = {
        "wall.inertia": True,
        "wall.surface_density": f"{density} mg/cm^2",
        "wall.viscosity": f"{viscosity} mN*s/cm",
    }
    levels = [8e-3, 4e-3, 2e-3, 1e-3]
    errors = [rod_error(dt, 2.0, changes, rate) for dt in levels]
    assert_order(levels, errors, 2.0)
    assert errors[-1] <= 1e-5


def test_wall_that_cannot_hold_the_pressure_is_a_sentence() -> None:
    """M6: with no exponential and 5 kPa no hoop tension balances p r; the failure names pressure and cause."""
    with pytest.raises(DivergenceError, match=r"lumen\.pressure = 5 kPa"):
        started({"lumen.pressure": "5 kPa", "wall.c10": "0 mN/cm", "pellet.enabled": False})


def test_compressed_wall_needs_its_floor() -> None:
    """Eq. (15): squeezed by a tenth along z, the exact wall has negative tension; with the floor it has hardly any."""
    for blend, slope, lowest, highest in ((0.0, 0.0, -30.0, -1.0), (0.05, 1e-3, -0.05, 0.0)):
        wall = wall_constants(20, slack_blend=blend, slack_slope=slope, passive=COUPLED, viscosity=50.0)
        parts = np.empty(PARTS)
        corner_tension(0.9, 1.0, -0.1, 0.0, 0.0, 0.0, wall, parts)
        assert lowest <= parts[TOTAL_LONGITUDINAL] <= highest


def test_ring_at_rest_does_not_pull() -> None:
    """The undeformed tube without pressure is an equilibrium of every convention, to the last bit."""
    for published in (False, True):
        residual, _ = assembled(np.full(21, 0.795), np.linspace(0.0, 10.0, 21), wall_constants(20, published=published))
        assert np.abs(residual).max() <= 1e-13


def test_rates_enter_the_tension_once() -> None:
    """k times the stretch rate, per layer: a hoop that widens at 1/s pulls k more, whatever the step."""
    wall = wall_constants(4, 1.0)
    rho, zeta = np.full(5, 0.795), np.linspace(0.0, 1.0, 5)
    slow, _ = assembled(rho, zeta, wall)
    for slope in (1.0, 500.0):
        fast, _ = assembled(rho, zeta, wall, slope, (np.ones(4), np.full(5, 1.0 - 1.0 / slope)))
        assert (fast - slow)[2] == pytest.approx(33.3 * wall.element_size / wall.radius, rel=1e-9)


def test_moved_keeps_the_rest() -> None:
    """The helper that starts the modes changes the wall's place and nothing else."""
    _, state = started(LINEAR_ROD, IDLE)
    other = moved(state, state.wall.position + 1.0)
    assert replace(other, wall=state.wall) == state
