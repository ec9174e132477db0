"""A wall that is solved on few columns, shown on many: nothing is added to what the columns carry, Eq. (98)."""

from pathlib import Path

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.geometry.grid import Grid
from peristalsis.model.state import WallState
from peristalsis.results.result import Result
from peristalsis.results.shown import shown_wall
from peristalsis.running.simulation import Simulation
from peristalsis.storing.checkpoint import Checkpoints
from peristalsis.storing.store import Workspace

ROWS = 9


def wall(columns: int, seed: int = 3) -> WallState:
    """A tube whose cross-sections are shifted and oval, smooth around the ring, with a ragged contact."""
    rng = np.random.default_rng(seed)
    turn, z = np.meshgrid(2.0 * np.pi * np.arange(columns) / columns, np.linspace(0.0, 1.0, ROWS))
    rho = 0.8 + 0.05 * z * np.cos(turn) + 0.03 * np.sin(2.0 * turn)
    places = np.stack([rho, turn + 0.1 * np.sin(turn), z + 0.02 * np.cos(turn)], axis=2)
    velocity = np.stack([np.cos(turn), 0.2 * np.sin(turn), z], axis=2)
    ragged = np.maximum(rng.normal(size=(ROWS, columns)), 0.0)
    return WallState(
        position=places,
        position_before=places,
        velocity=velocity,
        velocity_before=velocity,
        contact=ragged,
        stretch_rate=rng.normal(size=(ROWS - 1, columns)),
        hoop_rate=rng.normal(size=(ROWS, columns)),
        drive=np.maximum(rng.normal(size=(2, 2 * (ROWS - 1), columns)), 0.0),
        step_before=0.002,
    )


def grid(columns: int, shown: int) -> Grid:
    return Grid(1.0, 40, ROWS - 1, columns, 2 * columns, shown)


def test_as_many_columns_are_the_wall_itself() -> None:
    one = wall(12)
    assert shown_wall(grid(12, 12), one) is one
    assert shown_wall(grid(12, 0), one) is one


def test_places_between_columns_are_those_of_the_smooth_wall() -> None:
    """Sixteen columns carry this shape: between them it is that of 64 columns to a millionth of the radius."""
    found, true = shown_wall(grid(16, 64), wall(16)), wall(64)
    assert found.position == pytest.approx(true.position, abs=1e-6)
    assert found.velocity == pytest.approx(true.velocity, abs=1e-5)
    assert shown_wall(grid(8, 64), wall(8)).position == pytest.approx(true.position, abs=5e-3)


def test_columns_of_the_wall_keep_their_places() -> None:
    one = wall(8)
    found = shown_wall(grid(8, 24), one)
    assert found.position[:, ::3] == pytest.approx(one.position, abs=1e-13)
    assert np.array_equal(found.contact[:, ::3], one.contact)


def test_contact_and_drive_stay_positive_and_keep_their_integrals() -> None:
    """The force on the pellet is the sum over columns; a series would give negative contact beside a ragged edge."""
    one = wall(16)
    found = shown_wall(grid(16, 64), one)
    for name in ("contact", "drive"):
        few, many = getattr(one, name), getattr(found, name)
        assert many.min() >= 0.0
        assert many.mean(axis=-1) == pytest.approx(few.mean(axis=-1), rel=1e-13)
    for name in ("stretch_rate", "hoop_rate"):
        assert getattr(found, name).mean(axis=-1) == pytest.approx(getattr(one, name).mean(axis=-1), abs=1e-14)


def started(**changes: object) -> Simulation:
    small = {"grid.n_z": 60, "grid.n_z_wall": 40, "run.duration": "20 ms", "output.interval": "10 ms"}
    small |= {"output.fields": ["potential_longitudinal"]}
    return Simulation(scenarios.configuration("point_pacemaker", changes=small | changes))


def run(**changes: object) -> Result:
    return started(**changes).run()


def test_wall_on_fewer_columns_is_shown_on_all() -> None:
    """The same run as one whose wall has these columns and no more, on a finer ring: same numbers, finer fields."""
    cells = {"grid.n_theta_conduction": 32}
    few = run(**{"grid.n_theta": 8, **cells})
    many = run(**{"grid.n_theta": 16, "grid.n_theta_wall": 8, **cells})
    assert np.array_equal(many.arrays["pellet_position"], few.arrays["pellet_position"])
    assert np.array_equal(many.arrays["potential_longitudinal"], few.arrays["potential_longitudinal"])
    assert many.arrays["theta"].size == 16
    assert many.arrays["radius"].shape == (3, 41, 16)
    assert many.arrays["radius"][..., ::2] == pytest.approx(few.arrays["radius"], abs=1e-12)
    assert np.ptp(few.arrays["radius"][-1], axis=1).max() > 1e-4


def test_choices_of_the_sheets_change_the_digest_and_nothing_when_they_are_not_made() -> None:
    """A run that makes none of them is the run of before there were any."""
    before = {"tissue.front_correction": "none"}
    plain = scenarios.configuration("point_pacemaker", changes=before)
    for key, shipped, other in (
        ("grid.n_theta_wall", 0, 8),
        ("tissue.front_correction", "none", "measured"),
        ("tissue.bidomain", "full", "pseudo"),
        ("solver.elliptic_tolerance", 1e-8, 1e-4),
    ):
        assert scenarios.configuration("point_pacemaker", changes=before | {key: shipped}).digest() == plain.digest()
        assert scenarios.configuration("point_pacemaker", changes=before | {key: other}).digest() != plain.digest()


def test_resumed_run_has_the_bits_of_the_uninterrupted_one(tmp_path: Path) -> None:
    """Nothing that the sheets or the shown wall are made of is carried beside the state."""
    chosen = {
        "grid.n_theta": 16,
        "grid.n_theta_wall": 8,
        "grid.n_theta_conduction": 32,
        "tissue.front_correction": "measured",
        "solver.elliptic_tolerance": 1e-4,
        "step.conduction": "1 ms",
    }
    whole = run(**chosen)
    begun = started(**chosen)
    begun.advance("8 ms")
    Checkpoints(Workspace(tmp_path, tmp_path)).write(begun.time, begun.checkpoint())
    again = Simulation.resume(tmp_path).run()
    for name, values in whole.arrays.items():
        assert np.array_equal(values, again.arrays[name], equal_nan=values.dtype.kind == "f"), name
