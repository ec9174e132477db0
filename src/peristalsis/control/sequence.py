"""The circular layer started by the longitudinal one, rule by rule, Eq. (25)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]

RULES = ("active", "total", "pacemaker", "delay", "none")


class Trigger(NamedTuple):
    """Settings of the local trigger; times in s, level in mN/cm, intensity in uA/cm^2."""

    rule: str
    delay: float
    level: float
    intensity: float
    duration: float
    refractory: float


class TriggerState(NamedTuple):
    """Per cell, shape (n_z, n_theta): last tension seen [mN/cm], whether it was rising, last start of a pulse [s].

    duration [s] and intensity [uA/cm^2]: of that pulse, which keeps what it was begun with. answered: the latest
    longitudinal activation that was judged under the rule `delay` [s].
    """

    tension: Floats
    rising: NDArray[np.bool_]
    start: Floats
    duration: Floats
    intensity: Floats
    answered: Floats


def quiet(shape: tuple[int, int]) -> TriggerState:
    """A trigger that has not fired yet."""
    numbers = (np.full(shape, -np.inf), np.zeros(shape), np.zeros(shape), np.full(shape, -np.inf))
    return TriggerState(np.zeros(shape), np.zeros(shape, np.bool_), *numbers)


def observe_tension(trigger: Trigger, state: TriggerState, tension: Floats, time: float) -> TriggerState:
    """Fire where the tension passes its maximum: it was rising, falls now, and was above the level."""
    rising, start = np.empty_like(state.rising), np.empty_like(state.start)
    fires = _pass_maximum(
        tension.ravel(),
        state.tension.ravel(),
        state.rising.ravel(),
        state.start.ravel(),
        trigger.level,
        trigger.refractory,
        time,
        rising.ravel(),
        start.ravel(),
    )
    after = state._replace(tension=tension, rising=rising)
    return _begun(trigger, after, start) if fires else after


def _begun(trigger: Trigger, state: TriggerState, start: Floats) -> TriggerState:
    """The state with pulses that begin where `start` is new; they have what the trigger has now."""
    new = start != state.start
    duration = np.where(new, trigger.duration, state.duration)
    return state._replace(start=start, duration=duration, intensity=np.where(new, trigger.intensity, state.intensity))


@compiled
def _pass_maximum(
    tension: np.ndarray,
    before: np.ndarray,
    was_rising: np.ndarray,
    last: np.ndarray,
    level: float,
    refractory: float,
    time: float,
    rising: np.ndarray,
    start: np.ndarray,
) -> bool:
    """Whether a cell fires; `start` then holds the times of the last pulses."""
    any_fires = False
    for k in range(tension.size):
        falling = tension[k] < before[k]
        fires = was_rising[k] and falling and before[k] > level and time - last[k] > refractory
        rising[k] = was_rising[k] if tension[k] == before[k] else not falling
        start[k] = time if fires else last[k]
        any_fires |= fires
    return any_fires


def observe_activation(trigger: Trigger, state: TriggerState, activation: Floats, time: float) -> TriggerState:
    """Fire a fixed delay after the longitudinal activation of the same cell (times in s, nan before any).

    A pulse that is planned or under way is not replaced, and none begins in the past. Each activation is judged once.
    """
    new = activation > state.answered  # false where nan
    if not new.any():
        return state
    planned = activation + trigger.delay
    ready = planned - state.start > trigger.refractory
    fires = new & ready & (state.start + state.duration <= time)
    answered = np.where(fires | (new & ~ready), activation, state.answered)
    if fires.any():
        state = _begun(trigger, state, np.where(fires, np.maximum(planned, time), state.start))
    return state._replace(answered=answered)


def trigger_current(state: TriggerState, start: float, stop: float) -> Floats:
    """Mean current of the local pulses over [start, stop] [uA/cm^2], shape (n_z, n_theta)."""
    current = np.zeros_like(state.start)
    add_trigger_current(state, start, stop, current)
    return current


def add_trigger_current(
    state: TriggerState,
    start: float,
    stop: float,
    current: Floats,
    response: Floats | float = 1.0,
) -> None:
    """Add `trigger_current`, times the response of the cells, to `current`."""
    if isinstance(response, float):
        pulses = state.start.ravel(), state.duration.ravel(), state.intensity.ravel()
        _add_pulses_from(*pulses, response, start, stop, current.ravel())
    else:
        current += trigger_current(state, start, stop) * response


@compiled
def _add_pulses_from(
    begins: np.ndarray,
    durations: np.ndarray,
    intensities: np.ndarray,
    response: float,
    start: float,
    stop: float,
    current: np.ndarray,
) -> None:
    for k in range(begins.size):
        inside = min(stop, begins[k] + durations[k]) - max(start, begins[k])
        if inside > 0.0:
            current[k] += response * intensities[k] * (inside / (stop - start))
