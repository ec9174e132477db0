"""Coupled runs on the whole surface: ring-uniform ones are those of one column, a point source is seen all around."""

from dataclasses import replace

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.results.result import Result
from peristalsis.running.simulation import Simulation

SMALL = {
    "grid.exchange": "averages",
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 120,
    "grid.n_z_wall": 60,
    "output.interval": "20 ms",
    "pellet.start_gap": "3 mm",
}


def run(columns: int, duration: str = "0.12 s", **changes: object) -> Result:
    given = {**SMALL, "grid.n_theta": columns, "run.duration": duration}
    given |= {key.replace("__", "."): value for key, value in changes.items()}
    return Simulation(scenarios.configuration("baseline", changes=given)).run()


@pytest.fixture(scope="module")
def one() -> Result:
    return run(1)


def same(one: Result, many: Result, limit: float) -> None:
    """All scalars and fields but counts, to a share of the largest value of each."""
    for name, values in one.arrays.items():
        if values.dtype == object or name in ("theta", "theta_cell", "angle", "newton_iterations", "slack_share"):
            continue
        if name.endswith("residual") or values.size == 0:
            continue
        found = many.arrays[name]
        scale = max(1.0, float(np.nanmax(np.abs(values), initial=0.0)))
        if name in ("contact_start", "contact_end"):
            # Places of nodes: one that touches with a force of rounding counts or does not; forces are compared.
            assert np.mean(np.abs(found - values) > limit * scale) <= 0.02, name
            continue
        assert np.array_equal(np.isnan(values), np.isnan(found[..., :1]) if values.ndim > 1 else np.isnan(found)), name
        assert float(np.nanmax(np.abs(found - values), initial=0.0)) <= limit * scale, name


@pytest.mark.parametrize(
    "columns", [8, pytest.param(32, marks=pytest.mark.slow), pytest.param(64, marks=pytest.mark.slow)]
)
def test_ring_uniform_drive_is_one_column(one: Result, columns: int) -> None:
    """Pellet track, pressure, forces and every field; the wall and both sheets are those of the axisymmetric model."""
    many = run(columns)
    same(one, many, 1e-8)
    for name, values in many.arrays.items():
        if values.dtype != object and values.ndim == 3 and name != "angle":
            assert float(np.nanmax(np.abs(values - values[:, :, :1]), initial=0.0)) <= 1e-8 * max(
                1.0, float(np.nanmax(np.abs(values)))
            ), name


def test_point_source_is_seen_around_the_ring() -> None:
    """A model that ignored the angle would start the same wave as the whole ring, or the same in every column."""
    found = run(8, "40 ms", pacemaker__angular_width="90 deg", pacemaker__width="5 mm", grid__n_theta_conduction=32)
    potential = found.arrays["potential_longitudinal"][-1]
    assert np.ptp(potential, axis=1).max() > 20.0
    radius = found.arrays["radius"][-1]
    assert np.ptp(radius, axis=1).max() > 1e-3
    mirrored = np.roll(potential[:, ::-1], 1, axis=1)  # the source is centred on column 0
    assert float(np.abs(potential - mirrored).max()) <= 1e-6
    assert found.summary["power_residual"] <= 5e-3


def test_turned_source_turns_the_answer() -> None:
    """By whole columns of wall: to the tolerance of the solvers."""
    changes = {"pacemaker__angular_width": "90 deg", "pacemaker__width": "5 mm", "solver__surface_tolerance": 1e-8}
    plain = run(8, "20 ms", **changes)
    turned = run(8, "20 ms", **changes, pacemaker__angle="90 deg")
    for name in ("potential_longitudinal", "potential_circular", "radius", "axial_position"):
        moved = np.roll(plain.arrays[name], 2, axis=2)
        assert float(np.abs(turned.arrays[name] - moved).max()) <= 1e-6, name
    assert turned.arrays["pellet_position"][-1] == pytest.approx(plain.arrays["pellet_position"][-1], abs=1e-8)


def test_noise_decays_under_ring_uniform_drive() -> None:
    """Exact symmetry would hide an instability: 1e-7 cm of noise on the wall dies out."""
    given = {**SMALL, "grid.n_theta": 8, "run.duration": "0.1 s"}
    simulation = Simulation(scenarios.configuration("baseline", changes=given))
    rng = np.random.default_rng(7)
    wall = simulation.state.wall
    noise = np.zeros_like(wall.position)
    noise[1:-1, :, 0] = 1e-7 * rng.standard_normal(noise[1:-1, :, 0].shape)
    noisy = replace(wall, position=wall.position + noise, position_before=wall.position_before + noise)
    simulation.state = replace(simulation.state, wall=noisy)
    spreads = [float(np.ptp(noise[:, :, 0], axis=1).max())]
    for _ in range(5):
        simulation.advance("20 ms")
        spreads.append(float(np.ptp(simulation.state.wall.position[:, :, 0], axis=1).max()))
    assert spreads[-1] < 0.1 * spreads[0]
    assert max(spreads[1:]) < spreads[0]


@pytest.mark.slow
def test_noise_decays_while_the_neck_is_packed() -> None:
    """Behind the starting pellet the wall is packed and pushed along: it neither leaves its axis nor wrinkles."""
    changes = {"grid.n_z": 400, "grid.n_z_wall": 200, "grid.n_theta": 16, "output.interval": "0.1 s"}
    simulation = Simulation(scenarios.configuration("baseline", changes=changes))
    simulation.advance("10 ms")
    draw = np.random.default_rng(1)
    places = simulation.state.wall.position.copy()
    places[1:-1] += 1e-7 * draw.standard_normal(places[1:-1].shape)
    simulation.state = replace(simulation.state, wall=replace(simulation.state.wall, position=places))
    spreads = []
    while simulation.time < 0.9:
        simulation.advance("50 ms")
        spreads.append(float(np.ptp(simulation.state.wall.position[:, :, 0], axis=1).max()))
    assert max(spreads) <= 3e-7  # the range of as many draws is six times their deviation
    assert spreads[-1] <= 0.2 * spreads[0]


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("correction", ["none", "measured"])
def test_blocked_conduction_on_many_columns_warns_of_nothing(correction: str) -> None:
    """Where a region blocks conduction the sheet's resistance is infinite: meant, and not a division gone wrong."""
    given = {**SMALL, "grid.n_theta": 8, "run.duration": "4 ms", "tissue.front_correction": correction}
    found = Simulation(scenarios.configuration("aganglionic", changes=given)).run()
    assert found.error is None
    blocked = (found.arrays["z_cell"] > 5.5) & (found.arrays["z_cell"] < 7.5)
    assert np.isfinite(found.arrays["potential_longitudinal"][-1][blocked]).all()
