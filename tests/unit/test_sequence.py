"""The circular layer started by the longitudinal one, Eq. (25)."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from peristalsis.control.sequence import (
    Trigger,
    TriggerState,
    add_trigger_current,
    observe_activation,
    observe_tension,
    quiet,
    trigger_current,
)

DT = 0.01
"""Step of the tests [s]."""
TRIGGER = Trigger("active", 0.1, 100.0, 1.5, 0.05, 0.7)


def starts(
    tension: Callable[[float], float], seconds: float, dt: float = 0.002, trigger: Trigger = TRIGGER
) -> list[float]:
    """The times at which a cell with this tension starts its circular neighbour."""
    state, found = quiet((1, 1)), []
    for k in range(1, round(seconds / dt) + 1):
        before = state.start[0, 0]
        state = observe_tension(trigger, state, np.array([[tension(k * dt)]]), k * dt, dt)
        if state.start[0, 0] != before:
            found.append(float(state.start[0, 0]))
    return found


def begun(*starts: float) -> TriggerState:
    """Cells whose last pulses began then, with what the trigger has."""
    place = np.array(starts)[:, None]
    pulse = {"duration": np.full(place.shape, TRIGGER.duration), "intensity": np.full(place.shape, TRIGGER.intensity)}
    return quiet(place.shape)._replace(start=place, **pulse)


@pytest.mark.parametrize("dt", [0.004, 0.002, 0.001])
def test_fires_once_and_right_after_the_maximum(dt: float) -> None:
    """One maximum, one pulse, not more than a step and a half late, whatever the step."""
    found = starts(lambda t: 300.0 * np.exp(-(((t - 0.5) / 0.1) ** 2)), 1.5, dt)
    assert len(found) == 1
    assert 0.0 <= found[0] - 0.5 <= 1.5 * dt + 1e-12


def test_maximum_below_the_level_is_ignored() -> None:
    assert starts(lambda t: 99.0 * np.sin(np.pi * t) ** 2, 1.0) == []
    assert len(starts(lambda t: 101.0 * np.sin(np.pi * t) ** 2, 1.0)) == 1


def test_refractory_time_swallows_what_comes_too_soon() -> None:
    """Maxima every 0.3 s with 0.7 s of refractory time: every third starts a pulse."""
    found = starts(lambda t: 200.0 * np.sin(np.pi * t / 0.3) ** 2, 3.0)
    assert np.diff(found) == pytest.approx(0.9, abs=0.005)


def test_plateau_fires_when_it_ends() -> None:
    """A tension that stays at its largest value has not yet passed it."""
    found = starts(lambda t: 200.0 * min(t / 0.1, 1.0, max(0.0, (0.6 - t) / 0.1)), 1.0)
    assert found == pytest.approx([0.502], abs=0.003)


def test_falling_from_the_start_is_no_maximum() -> None:
    state = quiet((1, 1))._replace(tension=np.array([[500.0]]))
    state = observe_tension(TRIGGER, state, np.array([[400.0]]), 0.002, DT)
    assert state.start[0, 0] == -np.inf


def test_cells_fire_each_for_themselves() -> None:
    state = quiet((2, 1))._replace(tension=np.array([[200.0], [200.0]]), rising=np.array([[True], [False]]))
    state = observe_tension(TRIGGER, state, np.array([[199.0], [199.0]]), 1.0, DT)
    assert state.start.ravel().tolist() == [1.0, -np.inf]


@pytest.mark.parametrize("dt", [0.05, 0.0123, 0.002])
def test_pulse_carries_its_charge_whatever_the_step(dt: float) -> None:
    state = begun(0.1111)
    ends = np.arange(0.0, 0.4 + dt, dt)
    charge = sum(float(trigger_current(state, a, b)[0, 0]) * (b - a) for a, b in pairwise(ends))
    assert charge == pytest.approx(1.5 * 0.05, rel=1e-9)


def test_delay_rule_waits_and_respects_the_refractory_time() -> None:
    trigger = TRIGGER._replace(rule="delay")
    state = observe_activation(trigger, quiet((1, 3)), np.array([[np.nan, 0.2, 0.3]]), 0.3)
    assert state.start[0].tolist() == [-np.inf, pytest.approx(0.3), pytest.approx(0.4)]
    later = observe_activation(trigger, state, np.array([[np.nan, 0.8, 1.1]]), 1.1)
    assert later.start[0, 1:].tolist() == [pytest.approx(0.3), pytest.approx(1.2)]


def test_delay_rule_keeps_a_pulse_that_is_still_to_come() -> None:
    """Two activations 1 s apart with a delay of 2 s: two pulses, at 2 and at 3 s."""
    trigger = TRIGGER._replace(rule="delay", delay=2.0)
    state, charge, dt = quiet((1, 1)), 0.0, 0.01
    for k in range(400):
        state = observe_activation(trigger, state, np.array([[0.0 if k * dt < 1.0 else 1.0]]), k * dt)
        charge += float(trigger_current(state, k * dt, (k + 1) * dt)[0, 0]) * dt
    assert charge == pytest.approx(2 * 1.5 * 0.05, rel=1e-9)


@pytest.mark.parametrize("response", [0.5, np.full((3, 1), 0.5)], ids=["everywhere", "by cell"])
def test_response_of_the_cells_scales_what_is_added(response: float | np.ndarray) -> None:
    """To what is there already, for a factor as for a field of factors (regions)."""
    state = begun(-np.inf, 0.01, -np.inf)
    current = np.full((3, 1), 0.25)
    add_trigger_current(state, 0.02, 0.03, current, response)
    assert current.ravel() == pytest.approx([0.25, 0.25 + 0.5 * TRIGGER.intensity, 0.25])


def test_a_pulse_keeps_what_it_was_begun_with() -> None:
    """Duration and intensity of the trigger may change in a run: the pulses under way stay as they are."""
    state = quiet((1, 1))._replace(tension=np.array([[200.0]]), rising=np.array([[True]]))
    state = observe_tension(TRIGGER, state, np.array([[150.0]]), 0.1, DT)
    changed = TRIGGER._replace(duration=0.01, intensity=9.0, level=1e3)
    state = observe_tension(changed, state, np.array([[140.0]]), 0.11, DT)
    charge = sum(float(trigger_current(state, 0.1 + a, 0.102 + a)[0, 0]) * 0.002 for a in np.arange(50) * 0.002)
    assert charge == pytest.approx(TRIGGER.duration * TRIGGER.intensity)


def test_delay_rule_answers_an_activation_once_whatever_changes() -> None:
    """A longer delay is no second answer to the same wave, a shorter refractory time does not recall one let go."""
    trigger = TRIGGER._replace(rule="delay")
    state = observe_activation(trigger, quiet((1, 1)), np.array([[0.2]]), 0.2)
    for later in (trigger._replace(delay=2.0), trigger._replace(refractory=0.0)):
        assert observe_activation(later, state, np.array([[0.2]]), 0.6).start[0, 0] == pytest.approx(0.3)
    state = observe_activation(trigger, state, np.array([[0.5]]), 0.5)  # refractory: let go
    again = observe_activation(trigger._replace(refractory=0.1), state, np.array([[0.5]]), 0.6)
    assert again.start[0, 0] == pytest.approx(0.3)


WITHIN = TRIGGER._replace(timing="within")


@pytest.mark.parametrize("dt", [0.008, 0.004, 0.0013])
def test_a_maximum_between_steps_is_found_exactly_where_the_tension_is_a_parabola(dt: float) -> None:
    """Eq. (100), whatever the step; steps of two lengths below."""
    found = starts(lambda t: 300.0 - 2e3 * (t - 0.50333) ** 2, 0.6, dt, WITHIN)
    assert found == pytest.approx([0.50333], abs=1e-12)


def test_a_maximum_between_steps_of_two_lengths() -> None:
    state, times = quiet((1, 1)), [0.01, 0.05, 0.09, 0.1, 0.11, 0.13, 0.15]
    before = 0.0
    for time in times:
        tension = np.array([[200.0 - 1e4 * (time - 0.1081) ** 2]])
        state = observe_tension(WITHIN, state, tension, time, time - before)
        before = time
    assert state.start[0, 0] == pytest.approx(0.1081, abs=1e-12)
    assert state.seen[0, 0] == 0.13


def test_a_maximum_between_steps_is_found_to_second_order() -> None:
    """A rise and a slower fall, largest at 0.1 s, wherever the steps lie."""

    def error(dt: float) -> float:
        errors = []
        for shift in np.linspace(0.0, 1.0, 7) * dt:
            found = starts(lambda t, s=shift: 3e3 * (t + s) * np.exp(1.0 - 10.0 * (t + s)), 0.3, dt, WITHIN)
            errors.append(abs(found[0] - (0.1 - shift)))
        return max(errors)

    assert 3.4 < error(0.008) / error(0.004) < 4.6
    assert error(0.004) < 0.02 * 0.004


@pytest.mark.parametrize("dt", [0.008, 0.003])
def test_a_pulse_that_is_seen_late_brings_all_its_charge(dt: float) -> None:
    """Eq. (101): the first step brings what the pulse would have brought since its start."""
    state, charge, first = quiet((1, 1)), 0.0, None
    for k in range(1, 60):
        time = k * dt
        brought = float(trigger_current(state, time - dt, time)[0, 0])
        charge += brought * dt
        first = time if first is None and brought > 0.0 else first
        state = observe_tension(WITHIN, state, np.array([[200.0 - 1e4 * (time - 0.1003) ** 2]]), time, dt)
    assert charge == pytest.approx(TRIGGER.intensity * TRIGGER.duration, rel=1e-12)
    assert first is not None
    assert first - 0.1003 < 2.5 * dt
