"""The gate of the trigger, Eqs. (83), (84): stretch prepares the circular layer, which is started nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.control.sequence import (
    Gate,
    Trigger,
    TriggerState,
    observe_activation,
    observe_tension,
    prepared,
    quiet,
)
from peristalsis.control.sequence import prepare as prepare_rings
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import asked
from peristalsis.inputs.build import build
from peristalsis.model.initial import initial_state
from peristalsis.model.step import _stretched
from peristalsis.results.convergence import start_remarks
from verification.exact.runs import March, march

DT = 0.002
CELLS, SIZE = 0.1 + 0.2 * np.arange(50), 0.2
GATE = Gate("stretch", oral_length=1.0, anal_length=0.5, delay=0.1, duration=0.3)
TRIGGER = Trigger("active", 0.1, 100.0, 1.5, 0.05, 0.7, GATE)

SMALL = {"grid.n_z": 200, "grid.n_z_wall": 100, "solver.residual_tolerance": 1e-8}
LATE = {"pellet.start_gap": "2 cm", "reflex.excitation_intensity": "0 uA/cm^2", "circular.conduction": False}
"""A pellet that the wave reaches after 0.6 s, and nothing but the trigger that starts the circular layer."""
STRETCH = {"trigger.gate": "stretch"}


def prepare(state: TriggerState, stretched: tuple[float, float] | None, time: float) -> TriggerState:
    return prepare_rings(GATE, state, CELLS, SIZE, stretched, time)


def gated(state: TriggerState, time: float) -> list[float]:
    """Middles of the cells that can be started."""
    found = prepared(GATE, state, time)
    assert found is not None
    return [float(z) for z in CELLS[found[:, 0]].round(9)]


def starts(run: March) -> dict[float, float]:
    """Middle of each cell to the time of its first pulse."""
    found: dict[float, float] = {}
    for state in run.states:
        for place in np.flatnonzero(np.isfinite(state.trigger.start[:, 0])):
            found.setdefault(float(run.model.grid.cells[place]), float(state.trigger.start[place, 0]))
    return found


# --- the law ----------------------------------------------------------------------------------------


def test_rings_within_the_lengths_are_prepared() -> None:
    """Those that the reach touches: 4 to 5.5 cm around a part from 5 to 5 cm, cells of 2 mm."""
    state = prepare(quiet((50, 1)), (5.0, 5.0), 0.0)
    assert gated(state, 0.1) == pytest.approx(np.arange(3.9, 5.6, 0.2))


def test_delay_and_duration_to_a_step() -> None:
    """Stretched from 0.2 to 0.4 s: prepared from 0.3 to 0.7 s, both ends included, and at no other step."""
    state, open_at = quiet((50, 1)), []
    for step in range(500):
        stretched = (5.0, 5.0) if 100 <= step <= 200 else None
        state = prepare(state, stretched, step * DT)
        if gated(state, step * DT):
            open_at.append(step)
    assert open_at == list(range(150, 401))


def test_any_stretch_is_the_union_of_its_moments() -> None:
    """For bouts closer than a duration: prepared while some moment of stretch is `delay` to `delay + duration` ago."""
    draw = np.random.default_rng(5)
    state, moments = quiet((50, 1)), []
    for step in range(600):
        time = 0.01 * step
        stretched = (5.0, 5.0) if draw.random() < 0.08 and (not moments or time - moments[-1] < 0.3) else None
        if stretched is not None:
            moments.append(time)
        state = prepare(state, stretched, time)
        wanted = any(0.1 - 1e-9 <= time - moment <= 0.4 + 1e-9 for moment in moments)
        assert bool(gated(state, time)) is wanted, step
    assert len(moments) > 5


def test_a_stretch_while_muscle_is_prepared_prolongs_it() -> None:
    """No new delay: the second stretch comes at 0.35 s, the first one's preparation would end at 0.4 s."""
    state = prepare(prepare(quiet((50, 1)), (5.0, 5.0), 0.0), (5.0, 5.0), 0.35)
    assert [bool(gated(state, time)) for time in (0.09, 0.1, 0.4, 0.42, 0.75, 0.76)] == [0, 1, 1, 1, 1, 0]
    again = prepare(state, (5.0, 5.0), 0.8)
    assert [bool(gated(again, time)) for time in (0.8, 0.89, 0.9, 1.2, 1.21)] == [0, 0, 1, 1, 0]


def test_an_event_in_unprepared_muscle_is_lost() -> None:
    """Under both kinds of rules: it is not made up for when the muscle is prepared later, and no time is refractory."""
    high, low = np.full((50, 1), 200.0), np.full((50, 1), 150.0)
    state = quiet((50, 1))._replace(tension=high, rising=np.ones((50, 1), np.bool_))
    state = observe_tension(TRIGGER, prepare(state, (5.0, 5.0), 0.0), low, 0.05, DT)
    assert not np.isfinite(state.start).any()
    state = observe_tension(TRIGGER, state, low - 1.0, 0.2, DT)
    assert not np.isfinite(state.start).any()
    state = observe_tension(TRIGGER, state._replace(tension=high, rising=np.ones((50, 1), np.bool_)), low, 0.25, DT)
    assert CELLS[np.isfinite(state.start[:, 0])] == pytest.approx(np.arange(3.9, 5.6, 0.2))

    delayed = TRIGGER._replace(rule="delay")
    state = prepare(quiet((50, 2)), (5.0, 5.0), 0.0)
    for time in (0.05, 0.2):  # the activation of 0.04 s is judged once, while nothing is prepared
        state = observe_activation(delayed, state, np.full((50, 2), 0.04), time)
        assert not np.isfinite(state.start).any()
    state = observe_activation(delayed, state, np.full((50, 2), 0.25), 0.25)
    for column in state.start.T:
        assert CELLS[np.isfinite(column)] == pytest.approx(np.arange(3.9, 5.6, 0.2))
        assert column[np.isfinite(column)] == pytest.approx(0.35)


# --- in a run ---------------------------------------------------------------------------------------


def test_a_gate_that_is_open_everywhere_changes_no_bit() -> None:
    """The pellet stretches the wall from the start on; preparation reaches every cell at once and lasts."""
    wide = {"trigger.gate_oral_length": "200 cm", "trigger.gate_anal_length": "200 cm", "trigger.gate_delay": "0 s"}
    long = {"trigger.gate_duration": "100 s"}
    none, opened = march(0.2, SMALL).last, march(0.2, SMALL, STRETCH | wide | long).last
    assert np.isfinite(none.trigger.start).any()
    assert np.array_equal(none.trigger.start, opened.trigger.start)
    assert np.array_equal(none.circular.potential, opened.circular.potential)
    assert np.array_equal(none.wall.position, opened.wall.position)


@pytest.mark.parametrize("rule", ["active", "total", "delay"])
def test_without_a_pellet_the_trigger_starts_nothing(rule: str) -> None:
    empty = {"pellet.enabled": False, "trigger.rule": rule, "trigger.delay": "0.02 s", "trigger.level": "10 mN/cm"}
    assert starts(march(0.1, SMALL, empty))
    run = march(0.1, SMALL, empty, STRETCH)
    assert starts(run) == {}
    assert not np.isfinite(run.last.circular.first_activation).any()


def test_the_circular_layer_is_started_at_the_pellet_and_not_far_from_it() -> None:
    """The wave comes from the oral end; what it passes before the stretched part and its reach stays quiet."""
    lengths = {"trigger.gate_oral_length": "0.5 cm", "trigger.gate_anal_length": "0.2 cm"}
    free, run = march(0.8, SMALL, LATE), march(0.8, SMALL, LATE, lengths, STRETCH)
    parts = [part for state in run.states if (part := _stretched(run.model, state.wall)) is not None]
    size = run.model.grid.cell_size
    low, high = min(part[0] for part in parts) - 0.5 - size, max(part[1] for part in parts) + 0.2 + size
    assert min(starts(free)) < 0.1
    found = starts(run)
    assert found
    assert all(low <= place <= high for place in found)
    active = run.model.grid.cells[np.isfinite(run.last.circular.first_activation[:, 0])]
    assert active.size > 0
    assert low <= active.min()


def test_preparation_follows_the_receptors_of_the_run() -> None:
    """Each cell opens a delay after it is first reached, and closes a delay and a duration after it is last."""
    run = march(0.3, SMALL, STRETCH, {"trigger.gate_delay": "0.05 s", "trigger.gate_duration": "0.02 s"})
    gate, cells, size = run.model.trigger.gate, run.model.grid.cells, run.model.grid.cell_size
    opens, closes = np.full(cells.size, np.inf), np.full(cells.size, -np.inf)
    for state in run.states[1:]:
        part = _stretched(run.model, state.wall)
        assert part is not None
        time = state.step * run.model.dt_wall
        reached = (cells + 0.5 * size >= part[0] - gate.oral_length) & (cells - 0.5 * size <= part[1])
        opens[reached & np.isinf(opens)] = time + gate.delay
        closes[reached] = time + gate.delay + gate.duration
    assert np.array_equal(run.last.trigger.opens, opens)
    assert np.array_equal(run.last.trigger.closes, closes)
    assert all(begun >= opens[cells == place][0] - 1e-9 for place, begun in starts(run).items())
    assert min(opens) == pytest.approx(0.052)


@pytest.mark.parametrize("delay", ["0.04 s", "0.06 s"])
def test_the_whole_surface_is_the_column(delay: str) -> None:
    """Where the ring is uniform: same rings, same times, in every column."""
    grid = {"grid.n_z": 60, "grid.n_z_wall": 40, "pellet.start_gap": "3 mm"}
    given = (SMALL, grid, STRETCH, {"trigger.gate_delay": delay, "trigger.gate_duration": "0.1 s"})
    one, many = march(0.1, *given), march(0.1, *given, {"grid.n_theta": 4})
    assert np.array_equal(one.last.trigger.opens, many.last.trigger.opens)
    assert np.array_equal(one.last.trigger.closes, many.last.trigger.closes)
    assert np.isfinite(one.last.trigger.start).any()
    assert np.array_equal(np.tile(one.last.trigger.start, 4), many.last.trigger.start)


def test_the_explicit_scheme_has_the_same_gate() -> None:
    given = (SMALL, {"grid.n_z": 60, "grid.n_z_wall": 60, "solver.integrator": "explicit"})
    closed = {"trigger.gate_delay": "0.04 s", "trigger.gate_duration": "0.1 s"}
    assert starts(march(0.05, *given))
    assert starts(march(0.03, *given, STRETCH, closed)) == {}
    run = march(0.05, *given, STRETCH, closed)
    assert min(run.last.trigger.opens) == pytest.approx(0.042)


# --- what is said -----------------------------------------------------------------------------------


def configuration(changes: Mapping[str, Any]) -> ps.Configuration:
    return ps.configuration("baseline", changes=changes)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"pellet.enabled": False}, "without a pellet no receptor is stretched"),
        ({"reflex.enabled": False}, "the gate never opens"),
        ({"trigger.rule": "pacemaker"}, "nothing to keep back"),
        ({"trigger.rule": "none"}, "nothing to keep back"),
    ],
)
def test_a_gate_in_vain_is_said(changes: Mapping[str, Any], says: str) -> None:
    assert any(says in text for text in asked.remarks(configuration(STRETCH | changes)))
    assert not any("gate" in text for text in asked.remarks(configuration(changes)))
    assert asked.remarks(configuration(STRETCH)) == []


@pytest.mark.parametrize(("radius", "silent"), [("0.82 cm", True), ("0.855 cm", True), ("0.9 cm", False)])
def test_a_pellet_too_narrow_for_the_receptors_is_said(radius: str, silent: bool) -> None:
    grid = {"grid.n_z": 60, "grid.n_z_wall": 60}
    model, _, _ = initial_state(build(configuration(STRETCH | grid | {"pellet.radius": radius})))
    assert any("the gate never opens" in text for text in start_remarks(model)) is silent
    plain, _, _ = initial_state(build(configuration(grid | {"pellet.radius": radius})))
    assert not any("gate" in text for text in start_remarks(plain))


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"trigger\.gate_oral_length"):
        configuration({"trigger.gate_oral_length": "-1 cm"})
    with pytest.raises(ConfigurationError, match=r"use at least step\.wall"):
        configuration(STRETCH | {"trigger.gate_duration": "1 ms"})
    with pytest.raises(ConfigurationError, match=r"trigger\.gate"):
        configuration({"protocols": ["trigger.gate: step none at 0 s, stretch at 1 s"]})


def test_numbers_of_a_gate_that_is_not_there_are_no_part_of_the_digest() -> None:
    plain = configuration({})
    assert plain.digest() == configuration({"trigger.gate_delay": "0.3 s"}).digest()
    assert plain.digest() != configuration(STRETCH).digest()
    assert configuration(STRETCH).digest() != configuration(STRETCH | {"trigger.gate_delay": "0.3 s"}).digest()
