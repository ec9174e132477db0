"""Conduction on the whole surface against exact answers, Eqs. (6) to (11), (37), (38)."""

import numpy as np
import pytest

from peristalsis.tissue.surface import Conductivities
from verification.exact.gaussian import Gaussian
from verification.exact.kernel import Variant
from verification.exact.orders import assert_order
from verification.exact.surface import CIRCULAR, LONGITUDINAL, PathmanathanGray, Surface, apply_surface

OBLIQUE = [(1, 1), (3, 2), (0, 5), (7, 0), (11, 9), (20, 16)]


@pytest.mark.parametrize(("n", "m"), OBLIQUE)
def test_oblique_waves_of_the_monodomain_are_discrete_eigenvectors(n: int, m: int) -> None:
    """E1: both directions at once, to rounding, at stretches of their own."""
    surface = Surface(24, 32, conductivities=CIRCULAR, axial_stretch=0.8, hoop_stretch=1.3)
    wave = surface.wave(n, m, 0.4)
    rate = apply_surface(surface.monodomain(), wave)
    fastest = surface.decay(23, 16)
    assert np.abs(rate + surface.decay(n, m) * wave).max() <= 1e-13 * fastest
    assert np.abs(rate + surface.decay(n, m) * wave).max() <= 1e-12 * max(surface.decay(n, m), 0.05 * fastest)


@pytest.mark.parametrize(("n", "m"), OBLIQUE)
def test_oblique_waves_of_the_bidomain_decay_with_the_discrete_symbol(n: int, m: int) -> None:
    """B1: Q = q_i q_e/(q_i + q_e) and phi_e = -V q_i/(q_i + q_e)."""
    surface = Surface(24, 32, axial_stretch=0.8, hoop_stretch=1.3)
    wave = surface.wave(n, m, 0.4)
    operator = surface.bidomain()
    inner, outer = surface.symbols(n, m, discrete=True)
    assert np.abs(apply_surface(operator, wave) + surface.decay(n, m) * wave).max() <= 1e-10 * surface.decay(n, m)
    assert np.abs(operator.extracellular(wave) + inner / (inner + outer) * wave).max() <= 1e-10


@pytest.mark.parametrize("kind", ["monodomain", "bidomain"])
def test_symbols_are_fourth_order(kind: str) -> None:
    """E1, B1 against the continuum: both directions refined together."""
    sizes, errors = [], []
    for n in (16, 32, 64, 128):
        surface = Surface(n, n, conductivities=LONGITUDINAL if kind == "bidomain" else CIRCULAR)
        wave = surface.wave(3, 2)
        rate = apply_surface(getattr(surface, kind)(), wave)
        sizes.append(1.0 / n)
        errors.append(float(np.abs(rate / surface.decay(3, 2, discrete=False) + wave).max()))
    assert_order(sizes, errors, 4.0)
    assert errors[-1] <= 5e-7


def test_extracellular_potential_is_fourth_order_where_stretches_vary() -> None:
    """Manufactured: phi_e = cos(pi z/L) cos(theta) + cos(2 pi z/L)/2, waves in 1/stretch, current to match."""
    sizes, errors = [], []
    for n in (16, 32, 64, 128):
        grid = Surface(n, n)
        k, r = np.pi / grid.length, grid.radius

        def axial(z: np.ndarray, theta: np.ndarray, k: float = k) -> np.ndarray:
            return 1.0 + 0.3 * np.cos(2.0 * k * z) * np.cos(theta)

        def hoop(z: np.ndarray, theta: np.ndarray, k: float = k) -> np.ndarray:
            return 1.0 + 0.3 * np.sin(theta) + 0.2 * np.cos(k * z)

        surface = Surface(
            n,
            n,
            axial_stretch=1.0 / axial(grid.z_faces, grid.theta),
            hoop_stretch=1.0 / hoop(grid.z, grid.theta_faces),
        )
        z, theta = grid.z, grid.theta
        phi = np.cos(k * z) * np.cos(theta) + 0.5 * np.cos(2.0 * k * z)
        phi_z = -k * np.sin(k * z) * np.cos(theta) - k * np.sin(2.0 * k * z)
        phi_zz = -k * k * np.cos(k * z) * np.cos(theta) - 2.0 * k * k * np.cos(2.0 * k * z)
        along = axial(z, theta) * phi_zz - 0.6 * k * np.sin(2.0 * k * z) * np.cos(theta) * phi_z
        around = -hoop(z, theta) * np.cos(k * z) * np.cos(theta) - 0.3 * np.cos(theta) * np.cos(k * z) * np.sin(theta)
        g = grid.conductivities
        scale = 1e-3 * grid.diffusivity / g.effective_axial
        applied = -scale * ((g.inner_axial + g.outer_axial) * along + (g.inner_around + g.outer_around) * around / r**2)
        found = surface.bidomain().extracellular(np.zeros((n, n)), applied - applied.mean())
        sizes.append(1.0 / n)
        errors.append(float(np.abs(found - (phi - phi.mean())).max()))
    assert_order(sizes, errors, 4.0)
    assert errors[-1] <= 1e-6


def test_kernel_form_is_second_order() -> None:
    """B4: the corrected (7) and (8), with every image on the cylinder."""
    cells = [0.2, 0.1, 0.05, 0.025]
    errors = [Gaussian(cell, width=16.0).error() for cell in cells]
    assert errors[0] <= 1e-3
    assert errors[1] <= 2.5e-4
    assert_order(cells, errors, 2.0)


def test_kernel_form_on_the_open_plane_agrees_with_the_cylinder() -> None:
    """A source narrow against the ring: the images hardly matter, and each sum checks the other."""
    case = Gaussian(0.1)
    open_plane, closed = case.by_kernel(closed=False), case.by_kernel()
    assert np.abs(open_plane - closed).max() <= 1e-4 * np.abs(closed).max()


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0, 4.0])
def test_shape_of_the_cells_does_not_matter(aspect: float) -> None:
    """B5: the kernel is exact over cells of any shape; what is left is second order in the longer side."""
    longer = 0.1 * max(aspect, 1.0)
    assert Gaussian(0.1, aspect).error() <= 0.025 * longer**2


@pytest.mark.parametrize(("variant", "expected"), [("no_pi", 0.364), ("inverted_root", 0.269), ("outer_share", 3.345)])
def test_each_misprint_is_wrong_by_its_own_size(variant: Variant, expected: float) -> None:
    """B4: none of them can pass, and none of them can be blamed on the grid."""
    for cell in (0.2, 0.1):
        assert Gaussian(cell).error(variant) == pytest.approx(expected, rel=0.01)


def test_unsquared_denominator_depends_on_the_unit_of_length() -> None:
    """The misprint of (8): the same tissue measured in another unit gives another current."""
    errors = [Gaussian(0.1, unit=unit).error("unsquared", closed=False) for unit in (1.0, 10.0)]
    assert errors[0] > 0.05
    assert errors[1] > 3.0 * errors[0]
    corrected = [Gaussian(0.1, unit=unit).error(closed=False) for unit in (1.0, 10.0)]
    assert corrected[0] == pytest.approx(corrected[1], rel=1e-6)


@pytest.mark.parametrize(("aspect", "expected"), [(1.0, -0.24), (4.0, -2.13)])
def test_kernel_at_the_middle_of_cells_never_converges(aspect: float, expected: float) -> None:
    """B4: a quarter too little on square cells at any resolution, and of the wrong sign on long ones."""
    for cell in (0.1, 0.05):
        case = Gaussian(cell, aspect)
        peak = np.unravel_index(np.abs(case.current).argmax(), case.current.shape)
        share = case.by_kernel("midpoint", closed=False)[peak] / case.current[peak] - 1.0
        assert share == pytest.approx(expected, rel=0.04)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_elliptic_solver_and_kernel_agree(aspect: float) -> None:
    """B4: two independent ways to the same current; at each shape of cell (B5)."""
    case = Gaussian(0.1, aspect)
    n_z, n_theta = case.potential.shape
    surface = Surface(
        n_z, n_theta, length=20.0, radius=20.0 / (2.0 * np.pi), diffusivity=1e3 * LONGITUDINAL.effective_axial
    )
    solved = apply_surface(surface.bidomain(), case.potential)
    top = np.abs(case.current).max()
    assert np.abs(solved - case.current).max() <= 5e-5 * max(1.0, aspect) ** 4 * top
    assert np.abs(solved - case.by_kernel()).max() <= 2.5e-4 * max(1.0, aspect) ** 2 * top


ANISOTROPIES = {"monodomain": CIRCULAR, "equal": Conductivities(20.0, 80.0, 4.0, 16.0), "bidomain": LONGITUDINAL}


@pytest.mark.parametrize("kind", ANISOTROPIES)
def test_pathmanathan_gray_is_second_order_in_time(kind: str) -> None:
    """E7: with the discrete symbol the space is exact, and what is left is the splitting (31)."""
    surface = Surface(12, 16, conductivities=ANISOTROPIES[kind], diffusivity=87.3)
    operator = surface.monodomain() if kind == "monodomain" else surface.bidomain()
    problem = PathmanathanGray(surface, operator, 2, 1, discrete=True)
    steps = [16, 32, 64, 128]
    errors = [float(np.sqrt(((problem.run(1.0 / n, n) - problem.exact(1.0)) ** 2).mean())) for n in steps]
    assert_order([1.0 / n for n in steps], errors, 2.0)
    assert errors[-1] <= 1e-4


@pytest.mark.parametrize("kind", ANISOTROPIES)
def test_pathmanathan_gray_is_fourth_order_in_space(kind: str) -> None:
    """E7: the scheme's own order, on a step short enough not to matter; phi_e = -k V where anisotropies are equal."""
    sizes, errors = [], []
    for n in (8, 12, 16, 24):
        surface = Surface(n, n, conductivities=ANISOTROPIES[kind], diffusivity=0.5 * 87.3)
        operator = surface.monodomain() if kind == "monodomain" else surface.bidomain()
        problem = PathmanathanGray(surface, operator, 1, 1, discrete=False)
        found = problem.run(0.1 / 400, 400)
        sizes.append(1.0 / n)
        errors.append(float(np.sqrt(((found - problem.exact(0.1)) ** 2).mean())))
        if kind == "equal":
            assert np.abs(operator.extracellular(found) + 0.2 * (found - found.mean())).max() <= 1e-9
    assert_order(sizes, errors, 4.0)
