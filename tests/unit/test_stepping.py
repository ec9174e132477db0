"""Steps whose length follows their error, Eqs. (102)-(104)."""

from dataclasses import replace

import numpy as np
import pytest

import peristalsis
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.build import build
from peristalsis.model.friction import sliding_speed
from peristalsis.model.guards import advance_safely
from peristalsis.model.initial import straight_state
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.model.stepping import advance_run, error_of_step
from peristalsis.running.simulation import Simulation

SMALL = {"grid.n_z": 200, "grid.n_z_wall": 100, "step.conduction": "1 ms", "run.duration": "0.4 s"}
BY_ERROR = {**SMALL, "step.control": "error"}


def model_of(**changes: object) -> Model:
    return build(peristalsis.configuration("baseline", changes={**BY_ERROR, **changes}))


def moved(model: Model, place: tuple[float, float, float], order: int) -> tuple[State, State]:
    """Two states of a wall whose inner nodes move by place * t**order, a step and two steps after t = dt."""
    state, dt = straight_state(model), model.dt_wall
    shift, inner = np.array(place), np.ones((model.grid.n_z_wall + 1, 1, 1))

    def at(time: float) -> tuple[np.ndarray, np.ndarray]:
        return (
            state.wall.position + inner * shift * time**order,
            inner * shift * order * time ** (order - 1) * np.ones_like(state.wall.position),
        )

    def wall(time: float) -> State:
        (now, rate), (before, rate_before) = at(time), at(time - dt)
        return replace(
            state,
            wall=replace(
                state.wall,
                position=now,
                position_before=before,
                velocity=rate,
                velocity_before=rate_before,
                step_before=dt,
            ),
        )

    return wall(2 * dt), wall(3 * dt)


def test_motion_at_a_steady_acceleration_is_expected_exactly() -> None:
    model = model_of(**{"pellet.enabled": "false"})
    assert error_of_step(model, *moved(model, (0.1, 0.0, 0.3), 2)) == pytest.approx(0.0, abs=1e-12)


def test_the_error_is_the_root_mean_square_over_a_diameter_of_the_tube() -> None:
    """Nodes that move by a t^3 miss 5/2 a dt^3 (trend of the velocities); all of them, over the length of the tube."""
    model = model_of(**{"pellet.enabled": "false"})
    dt, nodes = model.dt_wall, model.grid.n_z_wall + 1
    expected = 2.5 * 50.0 * dt**3 * np.sqrt(nodes * model.wall.element_size / (2.0 * model.wall.radius))
    assert error_of_step(model, *moved(model, (30.0, 0.0, 40.0), 3)) == pytest.approx(expected, rel=1e-9)


def test_the_error_of_a_step_does_not_depend_on_the_grid_nor_on_how_much_of_the_tube_is_at_rest() -> None:
    coarse, fine = (model_of(**{"grid.n_z_wall": n, "pellet.enabled": "false"}) for n in (100, 800))
    errors = [error_of_step(model, *moved(model, (30.0, 0.0, 40.0), 3)) for model in (coarse, fine)]
    assert errors[0] == pytest.approx(errors[1], rel=0.01)


def test_steps_of_one_length_are_those_of_before() -> None:
    model = replace(model_of(), control=None)
    state = straight_state(model)
    one, two = advance_run(model, state)[0], advance_safely(model, state)[0]
    assert np.array_equal(one.wall.position, two.wall.position)
    assert np.array_equal(one.longitudinal.potential, two.longitudinal.potential)


@pytest.fixture(scope="module")
def run() -> Simulation:
    simulation = Simulation(peristalsis.configuration("baseline", changes=BY_ERROR))
    simulation.run()
    return simulation


def test_parts_make_up_the_run_and_are_recorded(run: Simulation) -> None:
    arrays = run.result().arrays
    assert np.array_equal(arrays["time_step"], np.arange(len(arrays["time_step"])) * run.model.dt_wall)
    parts = arrays["step_parts"]
    assert parts[0] == 0
    assert parts[1:].min() == 1
    assert parts[1:].max() > 1
    assert arrays["steps_rejected"].sum() > 0


def test_work_is_balanced_over_the_parts(run: Simulation) -> None:
    """The work of every part counts: over whole steps alone, the start of the wave would leave more over."""
    arrays = run.result().arrays
    spent = np.abs(arrays["work_active"]).max()
    assert np.abs(arrays["power_residual"]).max() < 2e-3 * spent


def test_a_smaller_tolerance_takes_more_parts_and_comes_nearer(run: Simulation) -> None:
    fine = Simulation(
        peristalsis.configuration("baseline", changes={**SMALL, "step.wall": "0.5 ms", "step.conduction": "0.5 ms"})
    ).run()
    found = []
    for tolerance in ("0.02 cm", "0.0005 cm"):
        result = Simulation(
            peristalsis.configuration("baseline", changes={**BY_ERROR, "step.tolerance": tolerance})
        ).run()
        track = np.interp(fine.arrays["time_step"], result.arrays["time_step"], result.arrays["pellet_position"])
        error = float(np.sqrt(np.mean((track - fine.arrays["pellet_position"]) ** 2)))
        found.append((result.arrays["step_parts"].sum(), error))
    assert found[1][0] > 1.5 * found[0][0]
    assert found[1][1] < 0.8 * found[0][1]


def test_a_run_that_is_taken_up_again_makes_the_same_parts(run: Simulation) -> None:
    configuration = peristalsis.configuration("baseline", changes=BY_ERROR)
    first = Simulation(configuration)
    first.advance("0.12 s")
    state = first.state
    for _ in range(20):
        state, _ = advance_run(first.model, state)
    first.advance("0.16 s")
    assert state.step == first.state.step
    for one, two in ((state.wall.position, first.state.wall.position), (state.wall.contact, first.state.wall.contact)):
        assert np.array_equal(one, two)


def test_the_pellet_starts_in_a_step_of_the_shortest_length() -> None:
    """Dry friction holds the pellet until the wave pulls: Eq. (104)."""
    changes = {**BY_ERROR, "pellet.dry_friction": "100 mN", "step.tolerance": "1 cm"}
    simulation = Simulation(peristalsis.configuration("baseline", changes=changes))
    model, state, shortest = simulation.model, simulation.state, []
    for _ in range(50):
        after, report = advance_run(model, state)
        for part in report.made_of(model, state, after):
            slides = [sliding_speed(model, one.pellet) != 0.0 for one in (part.before, part.after)]
            if slides[0] != slides[1]:
                shortest.append(part.model.dt_wall)
        state = after
    assert shortest
    assert set(shortest) == {1e-3}


def test_without_a_pellet_the_wall_alone_decides() -> None:
    result = Simulation(
        peristalsis.configuration("baseline", changes={**BY_ERROR, "pellet.enabled": "false", "run.duration": "0.2 s"})
    ).run()
    assert result.status == "finished"
    assert result.arrays["step_parts"].max() > 1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"step.shortest": "3 ms"}, "step.shortest = 3.0 ms"),
        ({"step.shortest": "16 ms"}, "step.shortest = 16.0 ms"),
        ({"step.longest": "8.5 ms"}, "step.longest = 8.5 ms"),
        ({"solver.integrator": "explicit"}, "step.control = error"),
        ({"step.tolerance": "0 cm"}, "step.tolerance"),
    ],
)
def test_lengths_that_do_not_fit_are_refused(changes: dict[str, str], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        peristalsis.configuration("baseline", changes={**BY_ERROR, **changes})


def test_a_run_with_steps_of_one_length_has_the_digest_of_before() -> None:
    plain = peristalsis.configuration("baseline")
    assert plain.digest() == plain.with_changes({"step.tolerance": "0.1 cm", "step.longest": "4 ms"}).digest()
    controlled = plain.with_changes({"step.control": "error", "step.conduction": "1 ms"})
    assert controlled.digest() != plain.digest()
    assert controlled.digest() != controlled.with_changes({"step.tolerance": "0.1 cm"}).digest()
    assert controlled.digest() == controlled.with_changes({"step.wall": "1 ms"}).digest()
