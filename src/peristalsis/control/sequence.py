"""The circular layer started by the longitudinal one, rule by rule, Eq. (25)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]

RULES = ("active", "total", "pacemaker", "delay", "none")
LOCAL_RULES = ("active", "total", "delay")


class Trigger(NamedTuple):
    """Settings of the local trigger; times in s, level in mN/cm, intensity in uA/cm^2."""

    rule: str
    delay: float
    level: float
    intensity: float
    duration: float
    refractory: float


class TriggerState(NamedTuple):
    """Per cell, shape (n_z, n_theta): last tension seen [mN/cm], whether it was rising, last start of a pulse [s]."""

    tension: Floats
    rising: NDArray[np.bool_]
    start: Floats


def quiet(shape: tuple[int, int]) -> TriggerState:
    """A trigger that has not fired yet."""
    return TriggerState(np.zeros(shape), np.zeros(shape, np.bool_), np.full(shape, -np.inf))


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
    return TriggerState(tension, rising, start if fires else state.start)


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

    A pulse that is planned or under way is not replaced, and none begins in the past.
    """
    planned = activation + trigger.delay
    fires = planned - state.start > trigger.refractory  # false where nan
    fires &= state.start + trigger.duration <= time
    return state._replace(start=np.where(fires, np.maximum(planned, time), state.start))


def trigger_current(trigger: Trigger, state: TriggerState, start: float, stop: float) -> Floats:
    """Mean current of the local pulses over [start, stop] [uA/cm^2], shape (n_z, n_theta)."""
    current = np.zeros_like(state.start)
    add_trigger_current(trigger, state, start, stop, current)
    return current


def add_trigger_current(
    trigger: Trigger,
    state: TriggerState,
    start: float,
    stop: float,
    current: Floats,
    response: Floats | float = 1.0,
) -> None:
    """Add `trigger_current`, times the response of the cells, to `current`."""
    if isinstance(response, float):
        _add_pulses_from(
            state.start.ravel(), trigger.duration, response * trigger.intensity, start, stop, current.ravel()
        )
    else:
        current += trigger_current(trigger, state, start, stop) * response


@compiled
def _add_pulses_from(
    begins: np.ndarray, duration: float, intensity: float, start: float, stop: float, current: np.ndarray
) -> None:
    for k in range(begins.size):
        inside = min(stop, begins[k] + duration) - max(start, begins[k])
        if inside > 0.0:
            current[k] += intensity * (inside / (stop - start))
