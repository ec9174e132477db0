"""The wall on the whole surface at any state: where ring-uniform, the axisymmetric wall; the rest on its own."""

import numpy as np
import pytest

from peristalsis.geometry.surface import (
    from_frames,
    polygon_factor,
    rates_from_frames,
    rates_to_frames,
    surface_volume,
    to_frames,
    volume_gradient,
)
from peristalsis.geometry.tube import lumen_volume
from peristalsis.numerics.ring_blocks import multiply_transposed
from peristalsis.wall.constants import SurfaceConstants
from peristalsis.wall.surface import measure_edges, new_edges, stored_energy
from peristalsis.wall.surface_regularisers import patch_shear
from verification.exact.surface_wall import (
    BARE,
    at_rest,
    crumpled,
    discrete_energy,
    forces,
    in_frames,
    in_motion,
    in_room,
    padded,
    tangent,
    times,
    uniform,
)
from verification.exact.wall import COUPLED, assembled, wall_constants

N = 9
SMOOTH = {"bending_stiffness": 1e-3, "bending_viscosity": 1e-4}
SLACK = {"slack_blend": 2.0, "slack_slope": 0.1, "fold_stretch": 0.95, "fold_tension": 5.0}
REGULAR = SurfaceConstants(0.5, 2e-3, 1e-4, 1.5)


def profile(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Radius and place of the nodes of an axisymmetric wall far from straight."""
    rng = np.random.default_rng(seed)
    return 0.9 + 0.05 * rng.normal(size=N), np.linspace(0.0, 1.2, N) + 0.01 * rng.normal(size=N)


@pytest.mark.parametrize("columns", [3, 8, 32, 64])
@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("slack", [False, True])
def test_ring_uniform_forces_are_the_axisymmetric_ones(columns: int, published: bool, slack: bool) -> None:
    """Tension, viscosity, drive, bending and pressure, number by number, whatever the regularisers around the ring."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, published=published, **SMOOTH, **(SLACK if slack else {}))
    rng = np.random.default_rng(columns)
    (rho, zeta), (old_rho, old_zeta) = profile(1), profile(2)
    histories = rng.uniform(0.8, 1.2, N - 1), rng.uniform(0.8, 1.2, N)
    drives = rng.uniform(0.0, 0.5, 2 * N - 2), rng.uniform(0.0, 0.5, 2 * N - 2)
    reference, _ = assembled(rho, zeta, wall, 200.0, histories, drives, np.stack([old_rho, old_zeta]), 10.0)
    places = uniform(rho, zeta, columns)
    known = in_motion(
        places,
        wall,
        0,
        stretch_history=np.repeat(histories[0][:, None], columns, axis=1),
        hoop_history=np.repeat(histories[1][:, None], columns, axis=1),
        shear_history=np.zeros((N - 1, columns)),
        history=uniform(old_rho, old_zeta, columns),
        drive=np.repeat(np.stack(drives)[:, :, None], columns, axis=2),
        surface=REGULAR._replace(foundation=0.0),
        pressure=10.0,
    )
    found, scale = forces(places, known), np.abs(reference).max()
    inner = slice(1, -1)
    assert np.abs(found[inner, 0] - reference.reshape(N, 2)[inner, 0, None]).max() <= 1e-12 * scale
    assert np.abs(found[inner, 2] - reference.reshape(N, 2)[inner, 1, None]).max() <= 1e-12 * scale
    assert np.abs(found[inner, 1]).max() <= 1e-12 * scale


def test_foundation_sees_the_centre_of_rings_alone() -> None:
    """Eq. (43): a sideways shift costs its constant times the shift on every node, any ring-uniform state nothing."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED)
    rho, zeta = profile(3)
    places = uniform(rho, zeta, 8)
    only = SurfaceConstants(0.0, 0.0, 0.0, 2.0)

    def of_foundation(state: np.ndarray) -> np.ndarray:
        return forces(state, at_rest(state, wall, surface=only)) - forces(state, at_rest(state, wall))

    assert np.abs(of_foundation(places)).max() <= 1e-13
    room = in_room(places)
    room[1:-1, 1] += 0.03
    found = in_room(of_foundation(in_frames(room)))[1:-1]
    assert found[:, 1] == pytest.approx(2.0 * wall.element_size * 0.03, rel=1e-11)
    assert np.abs(found[:, [0, 2]]).max() <= 1e-13


@pytest.mark.parametrize("columns", [3, 7, 16])
def test_volume_of_a_ring_uniform_surface_is_that_of_its_frusta(columns: int) -> None:
    rho, zeta = profile(4)
    assert surface_volume(padded(uniform(rho, zeta, columns))) == pytest.approx(lumen_volume(rho, zeta), rel=1e-13)


def test_volume_of_a_sheared_prism() -> None:
    """Moving whole rings across the axis changes no cross-section, hence no volume."""
    places = uniform(np.full(N, 0.8), np.linspace(0.0, 1.0, N), 12)
    room = in_room(places)
    room[:, 0] += 0.3 * np.sin(np.arange(N))[:, None]
    whole = polygon_factor(12) * 0.8**2 * 6.0 * np.sin(np.pi / 6.0)
    assert surface_volume(padded(in_frames(room))) == pytest.approx(whole, rel=1e-12)


def test_gradient_of_the_volume() -> None:
    """The volume is cubic in the nodes: two central differences extrapolate to its derivative exactly."""
    places = crumpled(N, 7, 5)
    places[0, 2], places[-1, 2] = 0.0, 1.2
    gradient = np.empty_like(places)
    volume_gradient(padded(places), 1.0, gradient)
    for seed in range(3):
        change = np.random.default_rng(seed).normal(size=places.shape)
        change[[0, -1]] = 0.0

        def slope(step: float, change: np.ndarray = change) -> float:
            ends = [surface_volume(padded(places + sign * step * change)) for sign in (1.0, -1.0)]
            return float((ends[0] - ends[1]) / (2.0 * step))

        assert (4.0 * slope(0.01) - slope(0.02)) / 3.0 == pytest.approx((gradient * change).sum(), rel=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_forces_are_the_gradient_of_the_energy(seed: int) -> None:
    """Consistent convention at rest, random surfaces: complex steps of an energy written anew in the room, 1e-11."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, bending_stiffness=2e-3)
    surface = REGULAR._replace(shear_viscosity=0.0)
    places = crumpled(N, 6, seed)
    found = forces(places, at_rest(places, wall, surface=surface))[1:-1]
    exact = np.empty_like(found)
    for index in np.ndindex(*found.shape):
        moved = places.astype(complex)
        moved[index[0] + 1, index[1], index[2]] += 1e-30j
        exact[index] = discrete_energy(moved, wall, surface).imag / 1e-30
    assert np.abs(found - exact).max() <= 1e-11 * np.abs(exact).max()


def test_stored_energy_is_that_of_the_corners() -> None:
    wall = wall_constants(N - 1, 1.0, passive=COUPLED)
    places, edges = crumpled(N, 6, 3), new_edges(N, 6)
    assert measure_edges(padded(places), wall, edges)
    whole = discrete_energy(places, wall, BARE) * 2.0 * np.pi * wall.radius / 6
    assert stored_energy(edges, wall) == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("slack", [False, True])
@pytest.mark.parametrize("columns", [3, 8])
def test_tangent_is_the_derivative_of_the_forces(published: bool, slack: bool, columns: int) -> None:
    """Random surfaces in motion under drive and pressure, with all regularisers, on taut and on slack wall."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, published=published, **SMOOTH, **(SLACK if slack else {}))
    places = crumpled(N, columns, 6)
    known = in_motion(places, wall, 7, surface=REGULAR, pressure=10.0)
    operator = tangent(places, known)
    for seed in range(3):
        change = np.random.default_rng(seed).normal(size=places.shape)
        change[[0, -1]] = 0.0

        def slope(step: float, change: np.ndarray = change) -> np.ndarray:
            return (forces(places + step * change, known) - forces(places - step * change, known)) / (2.0 * step)

        numerical = ((4.0 * slope(0.5e-5) - slope(1e-5)) / 3.0)[1:-1]
        assert np.abs(times(operator, change)[1:-1] - numerical).max() <= 1e-8 * np.abs(numerical).max()


def test_transposed_tangent_is_the_adjoint() -> None:
    places = crumpled(N, 7, 8)
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, published=True, **SMOOTH)
    operator = tangent(places, in_motion(places, wall, 9, surface=REGULAR, pressure=10.0))
    rng = np.random.default_rng(10)
    left, right = rng.normal(size=places.shape), rng.normal(size=places.shape)
    left[[0, -1]] = right[[0, -1]] = 0.0
    left[3:6] = 0.0
    out = np.empty_like(left)
    multiply_transposed(operator, left, np.empty((N, 3, 9)), out)
    assert (out * right).sum() == pytest.approx((left * times(operator, right)).sum(), rel=1e-12)


def test_forces_follow_rigid_motions() -> None:
    """Turned about the axis by any angle or shifted any way, the wall pulls alike: edges know nothing of frames."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, published=True)
    places = crumpled(N, 7, 11)
    known = in_motion(places, wall, 12, surface=SurfaceConstants(0.5, 0.0, 0.0, 0.0), pressure=10.0)
    still = in_room(forces(places, known))
    room, c, s = in_room(places), np.cos(0.7), np.sin(0.7)

    def turn(field: np.ndarray) -> np.ndarray:
        return np.stack([c * field[:, 0] - s * field[:, 1], s * field[:, 0] + c * field[:, 1], field[:, 2]], axis=1)

    turned = in_room(forces(in_frames(turn(room)), known))
    shifted = in_room(forces(in_frames(room + np.array([0.2, -0.1, 0.3])[None, :, None]), known))
    assert np.abs(turned - turn(still))[1:-1].max() <= 1e-11 * np.abs(still).max()
    assert np.abs(shifted - still)[1:-1].max() <= 1e-11 * np.abs(still).max()


def test_columns_are_all_alike() -> None:
    """Everything moved on by three columns gives the same forces three columns on, but for the order of sums."""
    wall = wall_constants(N - 1, 1.0, passive=COUPLED, published=True, **SMOOTH)
    places = crumpled(N, 8, 13)
    known = in_motion(places, wall, 14, surface=REGULAR._replace(foundation=0.0), pressure=10.0)

    def on(field: np.ndarray) -> np.ndarray:
        return np.roll(field, 3, axis=-1)

    histories = {name: on(getattr(known, f"{name}_history")) for name in ("stretch", "hoop", "shear")}
    later = at_rest(
        places,
        wall,
        history=on(known.history),
        drive=on(known.drive),
        surface=known.surface,
        slope=known.slope,
        pressure=known.pressure,
        **{f"{name}_history": value for name, value in histories.items()},
    )
    expected = on(forces(places, known))
    assert np.abs(forces(on(places), later) - expected).max() <= 1e-13 * np.abs(expected).max()


def test_shear_of_a_sheared_sheet() -> None:
    """A slow twist turns e_l towards e_c: the patch's shear is lambda_l lambda_c times the cosine between them."""
    wall = wall_constants(N - 1, 1.0)
    room = in_room(uniform(np.full(N, 0.795), np.linspace(0.0, 1.0, N), 256))
    angle = 0.05 * np.arange(N)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    twisted = np.stack([c * room[:, 0] - s * room[:, 1], s * room[:, 0] + c * room[:, 1], room[:, 2]], axis=1)
    shear = np.empty((N - 1, 256))
    patch_shear(padded(in_frames(twisted)), wall, shear)
    assert shear == pytest.approx(0.795 * 0.05 / wall.element_size, rel=1e-3)


def test_impossible_trials_are_refused() -> None:
    """Edges that collapse or overstretch, along z or around, come back as False."""
    wall = wall_constants(N - 1, 1.0)
    for rho, length in ((0.01, 1.0), (7.0, 1.0), (0.8, 1e-3), (0.8, 9.0)):
        places = uniform(np.full(N, rho), np.linspace(0.0, length, N), 8)
        assert not measure_edges(padded(places), wall, new_edges(N, 8))


def test_ways_between_cylindrical_and_frames() -> None:
    """Places and velocities survive the way there and back; a ring-uniform wall has no component across."""
    places = crumpled(N, 8, 15)
    position = from_frames(places)
    assert np.abs(to_frames(position) - places).max() <= 1e-14
    velocity = np.random.default_rng(16).normal(size=places.shape)
    assert np.abs(rates_to_frames(position, rates_from_frames(places, velocity)) - velocity).max() <= 1e-13
    step = 1e-7
    numerical = (from_frames(places + step * velocity) - from_frames(places - step * velocity)) / (2.0 * step)
    assert np.abs(rates_from_frames(places, velocity) - numerical).max() <= 1e-7
    assert np.array_equal(to_frames(from_frames(uniform(*profile(1), 8)))[:, 1], np.zeros((N, 8)))
