"""Residual and tangent of the wall at any state: the residual from the energy, the tangent from the residual."""

import numpy as np
import pytest

from peristalsis.inputs.build import build
from peristalsis.model.fields import corner_tensions
from peristalsis.model.initial import initial_state
from peristalsis.numerics.block_band import PADDING, ROWS
from peristalsis.wall.assembly import KNOWN_ROWS, WALL_ROWS, wall_forces, wall_tangent
from peristalsis.wall.membrane import (
    PARTS,
    TOTAL_CIRCULAR,
    TOTAL_LONGITUDINAL,
    WallConstants,
    corner_tension,
    element_stretch,
    nominal_tensions,
)
from verification.exact.runs import configured
from verification.exact.wall import COUPLED, assembled, discrete_energy, discrete_volume, wall_constants

N = 9
INNER = slice(2, 2 * N - 2)
"""Unknowns of the nodes that are not clamped."""


def crooked(seed: int, contracted: bool = False) -> np.ndarray:
    """Nodes (rho_0, zeta_0, ...) of a tube far from straight, stretched or, for slack wall, contracted."""
    rng = np.random.default_rng(seed)
    x = np.empty(2 * N)
    x[0::2] = (0.6 if contracted else 0.9) + 0.05 * rng.normal(size=N)
    x[1::2] = np.linspace(0.0, 0.75 if contracted else 1.2, N) + 0.01 * rng.normal(size=N)
    return x


@pytest.mark.parametrize("bending", [0.0, 2e-3])
@pytest.mark.parametrize("seed", range(5))
def test_forces_are_the_gradient_of_the_energy(seed: int, bending: float) -> None:
    """Consistent convention, no drive, no rates: residual = dE/dx by complex steps, 1e-11, wall and bending."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, bending_stiffness=bending)
    x = crooked(seed)
    residual, _ = assembled(x[0::2].copy(), x[1::2].copy(), wall)
    exact = np.empty(2 * N)
    for k in range(2 * N):
        moved = x.astype(complex)
        moved[k] += 1e-30j
        exact[k] = discrete_energy(moved, wall).imag / 1e-30
    assert np.abs(residual - exact)[INNER].max() <= 1e-11 * np.abs(exact).max()


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("slack", [False, True])
@pytest.mark.parametrize("moving", [False, True])
def test_tangent_is_the_derivative_of_the_residual(published: bool, slack: bool, moving: bool) -> None:
    """Both conventions, with drives, with rates, with slack wall on its floor, with bending and folds."""
    rng = np.random.default_rng(11)
    wall = wall_constants(
        N - 1,
        1.0,
        passive=COUPLED,
        published=published,
        bending_stiffness=1e-3,
        bending_viscosity=1e-4,
        slack_blend=2.0 if slack else 0.0,
        slack_slope=0.1 if slack else 0.0,
        fold_stretch=0.9 if slack else 0.0,
        fold_tension=5.0 if slack else 0.0,
    )
    x = crooked(3, contracted=slack)
    slope = 200.0 if moving else 0.0
    histories = (rng.uniform(0.8, 1.2, N - 1), rng.uniform(0.8, 1.2, N))
    places = crooked(4).reshape(N, 2).T.copy()
    drives = (rng.uniform(0.0, 0.5, 2 * N - 2), rng.uniform(0.0, 0.5, 2 * N - 2))

    def forces(y: np.ndarray) -> np.ndarray:
        return assembled(y[0::2].copy(), y[1::2].copy(), wall, slope, histories, drives, places)[0]

    _, tangent = assembled(x[0::2].copy(), x[1::2].copy(), wall, slope, histories, drives, places)
    numerical = np.empty_like(tangent)
    for k in range(2 * N):
        step = np.zeros(2 * N)
        step[k] = 1e-5
        coarse = (forces(x + step) - forces(x - step)) / 2e-5
        fine = (forces(x + 0.5 * step) - forces(x - 0.5 * step)) / 1e-5
        numerical[:, k] = (4.0 * fine - coarse) / 3.0
    assert np.abs(tangent - numerical)[INNER].max() <= 2e-7 * np.abs(tangent).max()


def test_bending_viscosity_resists_the_rate_of_bending_alone() -> None:
    """Eq. (16): B_v/h^3 times second differences of the velocity, applied as second differences again."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED)
    x = crooked(5)
    rho, zeta = x[0::2].copy(), x[1::2].copy()
    velocity = np.random.default_rng(6).normal(size=(2, N))
    slope = 100.0
    known = (slope, None, None, np.stack([rho, zeta]) - velocity / slope)
    with_it, _ = assembled(rho, zeta, wall._replace(bending_viscosity=2e-4), *known)
    without, _ = assembled(rho, zeta, wall, *known)
    second = np.zeros((N - 2, N))
    for i in range(N - 2):
        second[i, i : i + 3] = 1.0, -2.0, 1.0
    force = 2e-4 / wall.element_size**3 * velocity @ second.T @ second
    assert np.abs((with_it - without).reshape(N, 2).T - force)[:, 1:-1].max() <= 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("published", [False, True])
def test_wall_as_shipped_has_a_consistent_corner(published: bool) -> None:
    """`nominal_tensions` (in the forces) and `corner_tension` (in the outputs) are one law, with floor and folds."""
    wall: WallConstants = build(configured()).wall._replace(published=published)
    rng = np.random.default_rng(2)
    for _ in range(200):
        a, b = rng.uniform(0.1, 1.6, 2)
        rate_l, rate_c, drive_l, drive_c = (*rng.normal(size=2), *rng.uniform(0.0, 2.0, 2))
        parts = np.empty(PARTS)
        corner_tension(a, b, rate_l, rate_c, drive_l, drive_c, wall, parts)
        nl, nc, *_ = nominal_tensions(a, b, rate_l, rate_c, 1.0, drive_l, drive_c, wall)
        assert nl == pytest.approx(parts[TOTAL_LONGITUDINAL] * (b if published else 1.0), rel=1e-12, abs=1e-12)
        assert nc == pytest.approx(parts[TOTAL_CIRCULAR] * (a if published else 1.0), rel=1e-12, abs=1e-12)


def test_total_is_the_sum_of_three_parts() -> None:
    """Eq. (2): a sum, away from the floor; each part answers to its own cause."""
    wall = wall_constants(4, passive=COUPLED)
    parts = np.empty(PARTS)
    corner_tension(1.2, 1.1, 0.5, -0.25, 0.3, 0.2, wall, parts)
    assert parts[TOTAL_LONGITUDINAL] == pytest.approx(parts[:3].sum(), rel=1e-14)
    assert parts[TOTAL_CIRCULAR] == pytest.approx(parts[4:7].sum(), rel=1e-14)
    assert parts[2] == pytest.approx(33.3 * 0.5)
    assert parts[6] == pytest.approx(-33.3 * 0.25)
    assert parts[1] == pytest.approx(0.3 * 40.0 * 0.7 * 1.3)


def test_impossible_trials_are_refused() -> None:
    """Collapsed, overstretched and exploding states come back as False, before anything overflows."""
    wall = wall_constants(N - 1, 1.0)
    known = np.zeros((KNOWN_ROWS, N))
    for rho, length in ((0.01, 1.0), (7.0, 1.0), (0.8, 1e-3), (0.8, 9.0), (0.795 * 3.2, 1.0), (np.nan, 1.0)):
        x, z = np.full(N, rho), np.linspace(0.0, length, N)
        assert not wall_forces(x, z, known, 0.0, wall, 1, N - 2, np.zeros((WALL_ROWS, N)))


def test_a_stretch_of_wall_is_assembled_as_in_the_whole() -> None:
    """Forces and tangent of some nodes are those of the whole wall, bit for bit; the other nodes stay untouched."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, bending_stiffness=1e-3, bending_viscosity=1e-4, published=True)
    x = crooked(9)
    rho, zeta = x[0::2].copy(), x[1::2].copy()
    known = np.random.default_rng(10).uniform(0.8, 1.2, (KNOWN_ROWS, N))
    tables = []
    for first, last in ((1, N - 2), (3, 5), (1, 2), (N - 3, N - 2)):
        work, system = np.full((WALL_ROWS, N), np.nan), np.full((ROWS, N + PADDING), np.nan)
        assert wall_forces(rho, zeta, known, 50.0, wall, first, last, work)
        wall_tangent(rho, zeta, 10.0, 50.0, wall, first, last, work, system)
        tables.append((work[:4].copy(), system[:20].copy()))
    whole_forces, whole_tangent = tables[0]
    for (forces, tangent), (first, last) in zip(tables[1:], ((3, 5), (1, 2), (N - 3, N - 2)), strict=True):
        part = slice(first, last + 1)
        assert np.array_equal(forces[:, part], whole_forces[:, part])
        assert np.array_equal(tangent[:, part], whole_tangent[:, part])
        assert np.isnan(forces[:, :first]).all()
        assert np.isnan(forces[:, last + 1 :]).all()


def test_element_stretch_is_arc_length_over_reference() -> None:
    out = np.empty(2)
    assert element_stretch(np.array([0.5, 0.8, 0.8]), np.array([0.0, 0.4, 1.0]), 0.5, out)
    assert out == pytest.approx([1.0, 1.2])


def test_pressure_tangent_is_symmetric_and_that_of_the_force() -> None:
    """Pressure on a tube with fixed ends has a potential: its tangent is symmetric inside."""
    wall = wall_constants(N - 1, 1.0)
    x = crooked(7)

    def push(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rho, zeta = y[0::2].copy(), y[1::2].copy()
        with_it, without = assembled(rho, zeta, wall, pressure=10.0), assembled(rho, zeta, wall)
        return with_it[0] - without[0], with_it[1] - without[1]

    force, tangent = push(x)
    exact = np.empty(2 * N)
    for k in range(2 * N):
        moved = x.astype(complex)
        moved[k] += 1e-30j
        exact[k] = -10.0 * discrete_volume(moved).imag / 1e-30 / (2.0 * np.pi * wall.radius)
    assert np.abs(force - exact)[INNER].max() <= 1e-12 * np.abs(exact).max()
    numerical = np.empty_like(tangent)
    for k in range(2 * N):
        step = np.zeros(2 * N)
        step[k] = 1e-4
        numerical[:, k] = (push(x + step)[0] - push(x - step)[0]) / 2e-4
    assert np.abs(tangent - numerical)[INNER].max() <= 1e-7 * np.abs(tangent).max()
    inside = tangent[INNER, INNER]
    assert np.abs(inside - inside.T).max() <= 1e-11 * np.abs(tangent).max()


def test_outputs_of_the_resting_wall_carry_the_pressure() -> None:
    """Laplace in the published convention at mid-tube, from the fields that users see."""
    model, state, _ = initial_state(build(configured({"pellet.enabled": False})))
    middle = corner_tensions(state.wall, model.wall)[200, 0, 0]
    assert middle[TOTAL_CIRCULAR] == pytest.approx(state.pressure * state.wall.position[200, 0, 0], rel=1e-6)
