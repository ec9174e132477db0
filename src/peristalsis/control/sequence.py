"""The circular layer started by the longitudinal one, rule by rule, Eq. (25)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .pulses import overlap_in_time

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
    falling = tension < state.tension
    fires = state.rising & falling & (state.tension > trigger.level)
    fires &= time - state.start > trigger.refractory
    rising = np.where(tension == state.tension, state.rising, ~falling)
    return TriggerState(tension, rising, np.where(fires, time, state.start))


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
    return trigger.intensity * overlap_in_time(state.start, state.start + trigger.duration, start, stop)
