"""The coupled step: pure, in pieces or in one, and honest when it fails."""

import copy
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from peristalsis.errors import DivergenceError
from peristalsis.model.step import advance, muscle_drive
from peristalsis.verification.exact.runs import IDLE, march, moved, started


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
