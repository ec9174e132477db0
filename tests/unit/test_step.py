"""The coupled step: pure, in pieces or in one, and honest when it fails."""

import copy
from dataclasses import fields, is_dataclass
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from peristalsis.errors import DivergenceError
from peristalsis.model.fields import axial_tension_of_elements
from peristalsis.model.schemes.choice import scheme_of
from peristalsis.model.schemes.column import muscle_drive
from peristalsis.model.step import advance
from peristalsis.running.observers import StopConditions
from verification.exact.runs import IDLE, march, moved, started


def same(a: Any, b: Any) -> bool:
    """Whether two states agree to the last bit, nan with nan."""
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f")


def test_step_is_pure_and_repeatable() -> None:
    """The state that goes in is not touched, and the same one gives the same bits twice."""
    taken = march(0.05)
    before = taken.last
    kept = copy.deepcopy(before)
    once, _ = advance(taken.model, before)
    twice, _ = advance(taken.model, before)
    assert same(before, kept)
    assert same(once, twice)
    assert not same(once, before)


def test_time_is_counted_in_whole_steps() -> None:
    taken = march(0.05)
    assert [s.step for s in taken.states] == list(range(26))


def test_failed_step_is_halved_and_not_accepted() -> None:
    """With two iterations allowed the whole step fails where two half steps or more still reach the answer."""
    taken = march(0.3)
    hard = max(range(1, 150), key=lambda k: np.abs(taken.states[k].wall.velocity).max())
    tight = {"solver.max_newton": 3, "solver.max_halvings": 12}
    model, _ = started(tight)
    after, report = advance(model, taken.states[hard])
    exact, _ = advance(taken.model, taken.states[hard])
    assert report.wall_solves > 1
    assert np.abs(after.wall.position - exact.wall.position).max() <= 1e-3
    assert after.step == taken.states[hard].step + 1


def test_step_that_cannot_be_solved_is_a_sentence() -> None:
    """R5: field, time, place, cause and remedy, and nothing that looks like a result."""
    model, state = started({"solver.max_newton": 1, "solver.max_halvings": 1})
    rough = state.wall.position.copy()
    rough[1:-1, 0, 0] *= 1.0 + 0.02 * (-1.0) ** np.arange(399)
    with pytest.raises(DivergenceError, match=r"wall position: no equilibrium at t = .* cm.*Lower step.wall"):
        advance(model, moved(state, rough))


def test_stimulus_that_leaves_the_range_is_a_sentence() -> None:
    model, state = started({"pacemaker.intensity": "1000 uA/cm^2"})

    def until_it_fails() -> None:
        now = state
        for _ in range(30):
            now, _ = advance(model, now)

    with pytest.raises(DivergenceError, match=r"longitudinal potential left -200...150 mV at z = .* cm"):
        until_it_fails()


def test_muscle_pulls_only_when_depolarised() -> None:
    """Eq. (19): at rest phi+ is zero, above the threshold it is the difference, times the force factor."""
    model, state = started(IDLE, {"longitudinal.active": 2.0})
    assert muscle_drive(model, model.longitudinal, state.longitudinal).max() == 0.0
    raised = type(state.longitudinal)(
        np.full_like(state.longitudinal.potential, -45.0), *(state.longitudinal.gates, *([np.empty(0)] * 2))
    )
    assert muscle_drive(model, model.longitudinal, raised) == pytest.approx(20.0, rel=1e-13)
    assert muscle_drive(model, model.circular, raised) == pytest.approx(10.0, rel=1e-13)


PLACES = np.array([1.0, 2.0, 2.5, 2.505, 2.507, 2.508])


@pytest.mark.parametrize(
    ("arrested", "stops"), [(True, [None] * 3 + ["the pellet has come to rest"] * 2), (False, [None] * 5)]
)
def test_pellet_that_rests_for_a_second_stops_the_run(arrested: bool, stops: list[str | None]) -> None:
    """With steps of half a second: within 0.1 mm of where it was two steps ago, and not at the start."""
    model = SimpleNamespace(pellet=SimpleNamespace(present=True), dt_wall=0.5)
    states = [SimpleNamespace(pellet=SimpleNamespace(position=place)) for place in PLACES]
    watch = StopConditions(9.0, arrested)
    watch.start(model, states[0])  # type: ignore[arg-type]
    said = [watch.see(model, *pair, None) for pair in pairwise(states)]  # type: ignore[arg-type]
    assert said == stops
    waiting = StopConditions(9.0, arrested)
    waiting.start(model, states[0])  # type: ignore[arg-type]
    assert [waiting.see(model, states[0], states[0], None) for _ in range(5)] == [None] * 5  # type: ignore[arg-type]


def test_pellet_that_reaches_its_place_stops_the_run() -> None:
    model = SimpleNamespace(pellet=SimpleNamespace(present=True), dt_wall=0.5)
    states = [SimpleNamespace(pellet=SimpleNamespace(position=place)) for place in PLACES]
    watch = StopConditions(2.0, when_arrested=False)
    said = [watch.see(model, *pair, None) for pair in pairwise(states)]  # type: ignore[arg-type]
    assert said == ["the pellet has reached 2 cm", None, None, None, None]
    empty = SimpleNamespace(pellet=SimpleNamespace(present=False))
    assert watch.see(empty, *states[:2], None) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("changes", [{}, {"grid.n_theta": 4, "grid.n_theta_conduction": 4}])
def test_total_tension_of_the_trigger_is_linear_between_elements(changes: dict[str, Any]) -> None:
    """On one column and on several."""
    model, state = started(IDLE, {"grid.n_z": 40, "grid.n_z_wall": 20, "trigger.rule": "total", **changes})
    tension = axial_tension_of_elements(state.wall, model.wall)
    found = scheme_of(model).trigger_tension(model, state.wall)
    assert found.shape == state.longitudinal.potential.shape
    middle = 0.5 * (model.grid.nodes[1:] + model.grid.nodes[:-1])
    for column in found.T:
        assert np.allclose(column, np.interp(model.grid.cells, middle, tension[:, 0]), rtol=1e-12)


def test_layer_that_does_not_conduct_keeps_its_cells_apart() -> None:
    """A driven cell of one column fires alone, on the implicit scheme and in steps of its own."""
    quiet = {"longitudinal.conduction": False, "grid.n_z": 40, "grid.n_z_wall": 40}
    taken = march(0.1, quiet)
    reached = np.isfinite(taken.last.longitudinal.first_activation[:, 0])
    driven = taken.model.grid.cells < 1e-9 + taken.model.grid.cells[int(reached.sum()) - 1]
    assert 0 < reached.sum() < 10
    assert np.array_equal(reached, driven | (np.arange(40) == int(reached.sum()) - 1))
