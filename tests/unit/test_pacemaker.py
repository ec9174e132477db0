"""The clock of a source of pulses, Eq. (62): every beat once, at its time, whatever its inputs do meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis.control.pacemaker import Outlet, Source, SourceState, follow, waiting
from peristalsis.control.pulses import Pulse, overlap_in_time

OUTLET = Outlet("longitudinal", 0.0, 0.05, 2.0, 0.0, 0.3)
TINY = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 50,
    "grid.n_z_wall": 60,
    "output.interval": "0.1 s",
}


def source(onset: float = 0.0, period: float = 1.0, beats: int = 1000, *outlets: Outlet) -> Source:
    return Source(onset, period, beats, outlets or (OUTLET,))


def pulses(course: Callable[[float], Source], ends: np.ndarray, layer: str = "longitudinal") -> list[Pulse]:
    """Every pulse that was begun over these steps; inputs are those at the start of each step."""
    state: tuple[SourceState, ...] = (waiting(course(0.0)),)
    found: dict[Pulse, None] = {}
    for start, stop in pairwise(ends):
        state = follow((course(start),), state, start, stop)
        found |= dict.fromkeys(getattr(state[0], layer))
    return list(found)


def steps(seconds: float, dt: float = 0.002) -> np.ndarray:
    return np.arange(round(seconds / dt) + 1) * dt


@given(st.floats(0.0, 2.0), st.floats(0.2, 3.0), st.integers(1, 8), st.integers(10, 400))
def test_every_pulse_is_delivered_once(onset: float, period: float, count: int, number: int) -> None:
    """However the steps fall: `count` pulses of 50 ms each at onset + k period, none twice, none left out."""
    one = source(onset, period, count)
    ends = np.linspace(0.0, 30.0, number + 1)
    state, on, seen = (waiting(one),), 0.0, set()
    for start, stop in pairwise(ends):
        state = follow((one,), state, start, stop)
        for pulse in state[0].longitudinal:
            on += float(overlap_in_time(pulse.begin, pulse.end, start, stop)) * (stop - start)
            seen.add(pulse.begin)
    assert sorted(seen) == [onset + k * period for k in range(count)]
    assert on == pytest.approx(0.05 * count, rel=1e-9)


@pytest.mark.parametrize(
    ("course", "phase"),
    [
        (lambda t: 1.0 - 0.5 * min(t / 10.0, 1.0), lambda t: -20.0 * np.log(1.0 - t / 20.0)),
        (lambda t: 0.5 + 0.5 * min(t / 10.0, 1.0), lambda t: 20.0 * np.log(1.0 + t / 10.0)),
    ],
    ids=["down", "up"],
)
def test_a_ramp_of_the_period_keeps_the_phase(course: Callable[[float], float], phase: Callable[..., float]) -> None:
    """Beats are where the integral of 1/P is whole, to the lag of a step; intervals stay between the two periods."""
    found = pulses(lambda t: source(period=course(t)), steps(10.0))
    begins = np.array([pulse.begin for pulse in found])
    assert phase(begins) == pytest.approx(np.arange(begins.size), abs=3e-3)
    assert begins.size == int(phase(10.0)) + 1
    assert np.diff(begins).min() > 0.5 - 1e-3
    assert np.diff(begins).max() < 1.0 + 1e-3
    assert all(pulse.end - pulse.begin == pytest.approx(0.05) for pulse in found)


@pytest.mark.parametrize(
    ("after", "expected"),
    [
        (2.0, [0.0, 1.0, 2.0, 2.0 + 0.5 + 0.5 * 2.0, 5.5]),
        (0.5, [0.0, 1.0, 2.0, 2.75, 3.25, 3.75, 4.25, 4.75, 5.25, 5.75]),
    ],
    ids=["longer", "shorter"],
)
def test_a_step_of_the_period_keeps_the_phase(after: float, expected: list[float]) -> None:
    """Half a period is gone at 2.5 s, when it changes: the other half takes half of the new one. Exact."""
    found = pulses(lambda t: source(period=1.0 if t < 2.5 else after), steps(6.0))
    assert [pulse.begin for pulse in found] == pytest.approx(expected, abs=1e-12)


def test_a_step_during_a_pulse_leaves_it_whole() -> None:
    def course(t: float) -> Source:
        changed = t >= 2.02
        outlet = OUTLET._replace(duration=0.01, intensity=7.0, low=1.0) if changed else OUTLET
        return source(0.0, 1.5 if changed else 1.0, 1000, outlet)

    found = pulses(course, steps(4.0))
    assert found[2] == Pulse(2.0, 2.05, 0.0, 0.3, 2.0)
    assert found[3].begin == pytest.approx(2.02 + 0.98 * 1.5)
    assert found[3].end - found[3].begin == pytest.approx(0.01)
    assert (found[3].low, found[3].strength) == (1.0, 7.0)


def test_an_onset_still_to_come_begins_anew_and_one_gone_by_begins_at_once() -> None:
    def begins(first: float, then: float) -> list[float]:
        return [p.begin for p in pulses(lambda t: source(first if t < 1.0 else then, 3.0, 1), steps(4.0))]

    assert begins(0.5, 2.0) == [0.5, 2.0]
    assert begins(0.5, 0.7) == [0.5]
    assert begins(3.0, 0.5) == [1.0]
    assert begins(3.0, 2.0) == [2.0]


def test_count_is_of_beats_begun() -> None:
    """More beats asked for later fall where the clock would have them; fewer than there were end it."""
    later = pulses(lambda t: source(0.0, 1.0, 2 if t < 4.5 else 4), steps(10.0))
    assert [pulse.begin for pulse in later] == pytest.approx([0.0, 1.0, 5.0, 6.0])
    fewer = pulses(lambda t: source(0.0, 1.0, 10 if t < 4.5 else 2), steps(10.0))
    assert [pulse.begin for pulse in fewer] == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0])
    paused = pulses(lambda t: source(0.0, 1.0 if t < 3.0 else 2.0, 2 if t < 4.0 else 3), steps(10.0))
    assert [pulse.begin for pulse in paused] == pytest.approx([0.0, 1.0, 5.0])


def test_a_second_outlet_follows_by_its_lag() -> None:
    """The lag of a planned pulse is that of its beat, and a changed period stretches no lag."""
    late = OUTLET._replace(layer="circular", lag=0.4)

    def course(t: float) -> Source:
        return source(0.0, 1.0 if t < 2.2 else 2.0, 1000, OUTLET, late._replace(lag=0.4 if t < 2.2 else 0.1))

    first = [pulse.begin for pulse in pulses(course, steps(6.0))]
    second = [pulse.begin for pulse in pulses(course, steps(6.0), "circular")]
    assert first == pytest.approx([0.0, 1.0, 2.0, 2.2 + 0.8 * 2.0, 5.8])
    assert second == pytest.approx([0.4, 1.4, 2.4, 3.9, 5.9])


def test_a_step_made_in_parts_knows_all_its_pulses() -> None:
    """Pulses shorter than a part of the step are still there at its end, for the record of events."""
    one = source(0.0001, 10.0, 1, OUTLET._replace(duration=1e-4))
    state = (waiting(one),)
    for start, stop in pairwise(np.linspace(0.0, 0.002, 9)):
        state = follow((one,), state, start, stop)
    assert len(state[0].longitudinal) == 1


@pytest.mark.parametrize("line", ["ramp 0.1 s at 0 s, 0.06 s at 0.5 s", "step 0.1 s at 0 s, 0.15 s at 0.21 s"])
def test_events_note_each_pulse_once_at_its_begin(line: str) -> None:
    """Of a whole run under a protocol: the events are the pulses."""
    changes = {**TINY, "run.duration": "0.5 s", "pacemaker.kind": "periodic", "pacemaker.duration": "0.04 s"}
    protocols = {"pacemaker.period": "0.1 s", "protocols": [f"pacemaker.period: {line}"]}
    configuration = ps.configuration("baseline", changes=changes | protocols)
    (course,) = configuration.time_courses()
    expected = [p.begin for p in pulses(lambda t: source(0.0, course.at(t)), steps(0.5))]
    result = ps.Simulation(configuration).run()
    events = result.arrays["event_time"][result.arrays["event_kind"] == "pacemaker"]
    assert events.tolist() == expected
    assert np.diff(events).min() > 0.06 - 1e-9
