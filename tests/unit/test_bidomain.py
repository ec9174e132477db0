"""The bidomain's elliptic problem: against dense matrices, gauge, compatibility, effort, Eqs. (6), (37), (38)."""

import numpy as np
import pytest

from peristalsis.numerics.cylinder import CylinderSolver
from peristalsis.results.electrodes import electrode_potentials, electrode_weights
from peristalsis.tissue.bidomain import TOLERANCE, Bidomain, EllipticError, surface_operator
from peristalsis.tissue.surface import Conductivities, Monodomain, SurfaceSizes
from verification.exact.kernel import KernelProblem, kernel_current
from verification.exact.surface import CIRCULAR, LONGITUDINAL, Surface, apply_surface


def uneven(n_z: int, n_theta: int, around: bool, conductivities: Conductivities = LONGITUDINAL) -> Surface:
    """Random stretches between 0.5 and 1.5, varying around the ring or not."""
    rng = np.random.default_rng(n_z + n_theta)
    columns = n_theta if around else 1
    return Surface(
        n_z,
        n_theta,
        conductivities=conductivities,
        axial_stretch=rng.uniform(0.5, 1.5, (n_z - 1, columns)),
        hoop_stretch=rng.uniform(0.5, 1.5, (n_z, columns)),
    )


def matrices(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Dense operators of the two media [1/ms], each built as a monodomain of its own conductivities."""
    g = surface.conductivities
    scale = surface.diffusivity / g.effective_axial

    def one(axial: float, ring: float) -> np.ndarray:
        _, _, sizes, along, around = surface.parts()
        medium = Monodomain(scale * axial, Conductivities(axial, axial, ring, ring), sizes, along, around)
        units = np.eye(surface.n_z * surface.n_theta).reshape(-1, surface.n_z, surface.n_theta)
        return np.array([apply_surface(medium, unit).ravel() for unit in units]).T

    return one(g.inner_axial, g.inner_around), one(g.outer_axial, g.outer_around)


@pytest.mark.parametrize(("n_z", "n_theta"), [(9, 8), (6, 3), (7, 2), (5, 1), (2, 9), (1, 12)])
@pytest.mark.parametrize("around", [False, True])
def test_current_and_potential_agree_with_dense_matrices(n_z: int, n_theta: int, around: bool) -> None:
    """Eq. (6) as it stands: (L_i + L_o) phi_e = -L_i V, I = L_i (V + phi_e); no Fourier modes, no correction u."""
    surface = uneven(n_z, n_theta, around)
    inner, outer = matrices(surface)
    potential = np.random.default_rng(7).normal(size=(n_z, n_theta))
    phi = -np.linalg.pinv(inner + outer) @ inner @ potential.ravel()
    phi -= phi.mean()
    current = inner @ (potential.ravel() + phi)
    operator = surface.bidomain()
    assert np.abs(apply_surface(operator, potential).ravel() - current).max() <= 1e-12 * np.abs(inner).max()
    assert np.abs(operator.extracellular(potential).ravel() - phi).max() <= 1e-12


def test_equal_anisotropy_is_the_monodomain() -> None:
    """B2: nothing is left to solve for, so the two agree bit for bit, and the builder knows it."""
    equal = Conductivities(20.0, 80.0, 4.0, 16.0)
    surface = uneven(12, 10, True, equal)
    potential = np.random.default_rng(8).normal(size=(12, 10))
    operator = surface.bidomain()
    assert np.array_equal(apply_surface(operator, potential), apply_surface(surface.monodomain(), potential))
    assert operator.solves == 0
    assert isinstance(surface_operator(0.1, equal, *surface.parts()[2:]), Monodomain)
    assert isinstance(surface_operator(0.1, LONGITUDINAL, *surface.parts()[2:]), Bidomain)


@pytest.mark.parametrize("around", [False, True])
def test_nearly_equal_anisotropy_is_nearly_the_monodomain(around: bool) -> None:
    """B2 through the elliptic solver: an anisotropy off by 1e-9 moves the current by as little."""
    surface = uneven(12, 10, around, Conductivities(20.0, 80.0, 4.0, 16.0 * (1.0 + 1e-9)))
    potential = np.random.default_rng(8).normal(size=(12, 10))
    operator = surface.bidomain()
    found, expected = apply_surface(operator, potential), apply_surface(surface.monodomain(), potential)
    assert operator.solves > 0
    assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()


def test_gauge() -> None:
    """B3: phi_e has zero mean; a constant added to V moves neither the current nor phi_e."""
    surface = uneven(12, 10, True)
    potential = np.random.default_rng(9).normal(size=(12, 10))
    phi, shifted = (surface.bidomain().extracellular(potential + constant) for constant in (0.0, 50.0))
    assert abs(phi.sum()) <= 1e-12 * np.abs(phi).sum()
    assert np.abs(phi - shifted).max() <= 1e-12 * 50.0
    rates = [apply_surface(surface.bidomain(), potential + constant) for constant in (0.0, 50.0)]
    assert np.abs(rates[0] - rates[1]).max() <= 1e-12 * 50.0 * np.abs(rates[0]).max()


@pytest.mark.parametrize("around", [False, True])
def test_applied_current_must_balance(around: bool) -> None:
    """B3: what is put into a sealed sheet must come out, or there is no potential; balanced, it drives phi_e alone."""
    surface = uneven(12, 10, around)
    inner, outer = matrices(surface)
    applied, rest = np.zeros((12, 10)), np.zeros((12, 10))
    applied[3, 2], applied[9, 7] = 1.0, -1.0
    phi = surface.bidomain().extracellular(rest, applied)
    assert np.abs((inner + outer) @ phi.ravel() + applied.ravel()).max() <= 1e-10
    assert phi[3, 2] > 0.0 > phi[9, 7]
    applied[9, 7] = -0.9
    with pytest.raises(EllipticError, match="balance it"):
        surface.bidomain().extracellular(rest, applied)
    assert np.abs(surface.bidomain().extracellular(rest, rest)).max() == 0.0


def test_rounding_is_not_solved_for() -> None:
    """A ring uniform but for its last bits is a cable: no solve, and no difference beyond those bits."""
    surface = uneven(20, 16, True)
    column = np.random.default_rng(10).normal(size=(20, 1)) - 60.0
    potential = np.repeat(column, 16, axis=1)
    potential[:, 3] = np.nextafter(potential[:, 3], 0.0)
    operator = surface.bidomain()
    apply_surface(operator, potential)
    assert operator.solves == 0
    potential[:, 3] += 1e-10
    apply_surface(operator, potential)
    assert operator.solves > 0


def test_past_solutions_save_work() -> None:
    """A slowly changing potential: the first guess is good, and the answer is that of a fresh operator."""
    surface = uneven(24, 16, True)
    rng = np.random.default_rng(11)
    start, change = rng.normal(size=(2, 24, 16))
    operator = surface.bidomain(TOLERANCE)
    costs = []
    for step in range(5):
        before = operator.solves
        found = apply_surface(operator, start + 0.01 * step * change)
        costs.append(operator.solves - before)
    assert costs[-1] < 0.6 * costs[0]
    fresh = apply_surface(surface.bidomain(1e-13), start + 0.04 * change)
    assert np.abs(found - fresh).max() <= 100.0 * TOLERANCE * np.abs(fresh).max()


def test_tolerance_is_kept() -> None:
    """Tighter is closer, and the stated one is close enough not to be seen beside the time step."""
    surface = uneven(24, 16, True)
    potential = np.random.default_rng(12).normal(size=(24, 16))
    exact = apply_surface(surface.bidomain(1e-14), potential)
    errors = [np.abs(apply_surface(surface.bidomain(t), potential) - exact).max() for t in (1e-4, 1e-8, 1e-12)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[1] <= 1e-7 * np.abs(exact).max()


def test_lost_stretch_is_refused() -> None:
    """A stretch that is not a number must not reach the potential."""
    hoop = np.ones((12, 10))
    hoop[4, 5] = np.nan
    potential = np.random.default_rng(13).normal(size=(12, 10))
    for operator in (
        Bidomain(0.1, LONGITUDINAL, SurfaceSizes(0.1, 0.1), np.ones((11, 10)), hoop),
        Surface(12, 10, hoop_stretch=-1.0).bidomain(),
    ):
        with pytest.raises((EllipticError, ValueError)):
            apply_surface(operator, potential)


@pytest.mark.parametrize(("n_z", "n_theta"), [(40, 12), (3, 200), (5, 1), (1, 7)])
def test_cylinder_solver_inverts_its_operator(n_z: int, n_theta: int) -> None:
    """More modes than one block, an odd number, one column, one ring."""
    rng = np.random.default_rng(14)
    along, around = rng.uniform(0.5, 2.0, n_z - 1), rng.uniform(0.5, 2.0, n_z)
    sizes = SurfaceSizes(1.0 / 24.0, 1.0 / 24.0)
    medium = Monodomain(
        2e3, Conductivities(4.0, 4.0, 4.0, 4.0), sizes, np.ones((n_z - 1, n_theta)), np.ones((n_z, n_theta))
    )
    medium.along, medium.around = (np.repeat(a[:, None], n_theta, axis=1) for a in (along, around))
    right = rng.normal(size=(n_z, n_theta))
    right -= right.mean()
    solution = CylinderSolver(along, around, n_theta).solve(right)
    assert np.abs(apply_surface(medium, solution) + right).max() <= 1e-10
    assert abs(solution.mean()) <= 1e-12 * max(np.abs(solution).max(), 1e-300)
    without = CylinderSolver(along, around, n_theta).solve(right, with_mean=False)
    expected = solution - solution.mean(axis=1, keepdims=True)
    assert np.abs(without - expected).max() <= 1e-12 * max(np.abs(solution).max(), 1.0)


@pytest.mark.parametrize("around", [np.array([1.0, -1.0, 1.0]), np.array([1.0, np.nan, 1.0]), np.ones(4)])
def test_cylinder_solver_refuses_bad_coefficients(around: np.ndarray) -> None:
    with pytest.raises(ValueError, match="positive numbers are needed"):
        CylinderSolver(np.ones(2), around, 8)


def test_kernel_refuses_what_it_cannot_sum() -> None:
    problem = KernelProblem(CIRCULAR, SurfaceSizes(0.1, 0.1))
    with pytest.raises(ValueError, match="no sum over images"):
        kernel_current(np.zeros((4, 4)), problem, "midpoint")
    with pytest.raises(ValueError, match="choose one of corrected"):
        kernel_current(np.zeros((4, 4)), problem, "right")  # type: ignore[arg-type]


def test_electrodes_read_the_mean_under_them() -> None:
    """A contact across the seam, one smaller than a cell, and one off the sheet."""
    surface = Surface(40, 32, length=2.0)
    cells, columns = surface.z[:, 0], surface.theta[0]
    places = [(1.0, 2.0 * np.pi - 0.01), (0.5, 1.0), (0.0, 0.0)]
    weights = electrode_weights(cells, columns, surface.radius, places, 0.2)
    assert weights.sum(axis=(1, 2)) == pytest.approx(1.0)
    assert weights[0, :, 1].any()
    assert weights[0, :, -1].any()
    phi = 3.0 + np.cos(surface.theta) + 0.0 * surface.z
    found = electrode_potentials(phi, weights)
    assert found[0] == pytest.approx(4.0, abs=0.02)
    assert found[1] == pytest.approx(3.0 + np.cos(1.0), abs=0.05)
    tiny = electrode_weights(cells, columns, surface.radius, [(1.02, columns[4])], 1e-6)
    assert np.count_nonzero(tiny) == 1
    assert tiny[0, 20, 4] == 1.0
    with pytest.raises(ValueError, match="off the sheet"):
        electrode_weights(cells, columns, surface.radius, [(2.2, 0.0)], 0.2)


def test_electrodes_across_a_front_see_it_pass() -> None:
    """A plane front along z: the interstitium mirrors the depolarisation at a fifth of its height, phi_e = -k V."""
    surface = Surface(200, 4)
    potential = np.repeat(-62.0 + 60.0 / (1.0 + np.exp((surface.z - 1.0) / 0.05)), 4, axis=1)
    phi = surface.bidomain().extracellular(potential)
    assert np.abs(phi + 0.2 * (potential - potential.mean())).max() <= 1e-12 * 60.0
