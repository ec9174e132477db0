"""What is asked in time and place is honoured, or said before the run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis import scenarios
from peristalsis.errors import StoppedRun
from peristalsis.inputs import asked
from peristalsis.inputs.recording import due, frames_apart, whole_steps

STEPS = {"step.wall": "2 ms", "step.conduction": "0.25 ms"}
SMALL = STEPS | {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "20 ms", "output.interval": "10 ms"}
RINGS = {"rings.enabled": True, "trigger.rule": "none", "rings.positions": ["5 cm"]}


def configuration(changes: Mapping[str, object] | None = None) -> ps.Configuration:
    return ps.configuration("baseline", changes=SMALL | (changes or {}))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"run.duration": "51 ms"}, "the run goes on to 0.052 s"),
        ({"output.interval": "5 ms"}, "first step at or after each multiple"),
        (
            {"solver.integrator": "explicit", "step.explicit": "0.3 ms", "step.conduction": "0.5 ms"},
            "2 steps of 0.25 ms are made of it",
        ),
        ({"protocols": ["lumen.pressure: step 0.1 kPa at 0 s, 0.2 kPa at 3 ms"]}, "first at 0.003 s, and takes its"),
        (
            {"protocols": ["lumen.pressure: step 0.1 kPa at 0 s, 0.2 kPa at 4.5 ms, 0.1 kPa at 5.5 ms"]},
            "1 of 3 values of lumen.pressure lie within a step of 2 ms with a later one, first that at 0.0045 s",
        ),
        (
            {"protocols": ["lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 20 ms, 0.1 kPa at 5 s"]},
            "2 of 3 values of lumen.pressure lie at or beyond the end of the run at 0.02 s",
        ),
        ({"run.stop_position": "0.5 cm"}, "at it or beyond it"),
        ({"run.stop_position": "300 cm"}, "it stops no run"),
        ({"run.stop_when_arrested": True}, "rest is judged over 1 s"),
        ({"run.stop_when_arrested": True, "pellet.enabled": False}, "there is none"),
        ({"pacemaker.onset": "1 s"}, "before the first pulse"),
        ({"pacemaker.width": "1 mm"}, "less than a cell of"),
        (RINGS | {"rings.width": "1 mm"}, "less than a cell of"),
        (RINGS | {"rings.positions": ["1 mm"]}, "which is lost"),
        ({"output.probes": ["5 cm", "5.01 cm"]}, "lie in one cell"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_cannot_be_done_as_asked_is_said(changes: Mapping[str, object], says: str) -> None:
    assert says in asked.remarks(configuration(changes))[0]
    assert asked.remarks(configuration()) == []


@pytest.mark.parametrize("name", scenarios.names())
def test_nothing_is_said_of_shipped_scenarios(name: str) -> None:
    assert asked.remarks(ps.configuration(name)) == []


def test_a_run_lasts_at_least_as_long_as_asked() -> None:
    result = ps.Simulation(configuration({"run.duration": "51 ms"})).run()
    assert result.summary["simulated_s"] == pytest.approx(0.052)
    assert any("goes on to 0.052 s" in remark for remark in result.remarks)
    assert result.configuration.texts()["run.duration"] == "0.051 s"
    assert ps.Simulation(configuration({"run.duration": "50 ms"})).run().summary["steps"] == 25


def test_fields_are_stored_at_or_just_after_each_multiple() -> None:
    result = ps.Simulation(configuration({"output.interval": "5 ms"})).run()
    assert result.arrays["time"] == pytest.approx([0.0, 0.006, 0.01, 0.016, 0.02])
    assert result.configuration.output.interval == 0.005


@given(st.floats(1e-3, 50.0), st.sampled_from([1e-3, 2e-3, 1.5e-3, 0.01]))
def test_every_multiple_has_its_frame(interval: float, step: float) -> None:
    """The k-th frame is the first step at or after k intervals, for any interval of a step or more."""
    every = frames_apart(interval, step)
    frames = [number for number in range(1, 2000) if due(number, every)]
    expected = [int(np.ceil(k * every - 1e-6)) for k in range(1, len(frames) + 1)]
    assert frames == expected


@given(st.integers(1, 10**6), st.sampled_from([1e-3, 2e-3, 1.5e-3, 0.01]), st.floats(0.01, 0.99))
def test_whole_steps(count: int, step: float, more: float) -> None:
    assert whole_steps(count * step, step) == count
    assert whole_steps((count + more) * step, step) == count + 1


def test_a_stopped_run_does_not_go_on_in_silence() -> None:
    sim = ps.Simulation(configuration(), observers=(Enough(),))
    sim.advance("1 s")
    assert sim.stopped == "enough"
    assert sim.time == pytest.approx(0.006)
    with pytest.raises(StoppedRun, match=r"stopped at t = 0.006 s \(enough\) and does not go on; an observer"):
        sim.advance("0.2 s")
    assert sim.run().summary["steps"] == 3


@pytest.mark.parametrize(
    ("reason", "says"),
    [
        ("expelled", "run.stop_when_expelled = false"),
        ("the pellet has reached 1 cm", "run.stop_position farther"),
        ("the pellet has come to rest", "run.stop_when_arrested = false"),
    ],
)
def test_how_to_go_on_is_said(reason: str, says: str) -> None:
    sim = ps.Simulation(configuration())
    sim.stopped = reason
    with pytest.raises(StoppedRun, match=says):
        sim.advance("2 ms")


def test_advance_goes_on_from_where_a_run_ended() -> None:
    sim = ps.Simulation(configuration())
    sim.run()
    sim.advance("3 ms")
    assert sim.time == pytest.approx(0.022)
    sim.advance("1 ms")
    assert sim.time == pytest.approx(0.024)


class Enough:
    def start(self, model: object, state: object) -> None:
        pass

    def see(self, model: object, before: object, after: object, report: object) -> str | None:
        return "enough" if after.step == 3 else None  # type: ignore[attr-defined]
