"""The circular layer started by the longitudinal one, rule by rule, Eq. (25), behind a gate, Eqs. (83), (84)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]

RULES = ("active", "total", "pacemaker", "delay", "none")
GATED = ("active", "total", "delay")
"""Rules that start the circular layer place by place, so that a gate can keep them from it."""
TIMINGS = ("step", "within")
"""When a maximum of tension was passed: at the end of the step in which it is seen, or between steps, Eq. (100)."""

ROUNDING = 1e-9
"""Times this close are one [s]."""


class Gate(NamedTuple):
    """Where the trigger can start the circular layer: `none`, everywhere; `stretch`, where receptors prepared it.

    oral_length, anal_length: how far from the stretched part [cm]. delay: from stretch to preparation; duration: how
    long it lasts after the last stretch [s].
    """

    kind: str = "none"
    oral_length: float = 0.0
    anal_length: float = 0.0
    delay: float = 0.0
    duration: float = 0.0


class Trigger(NamedTuple):
    """Settings of the local trigger; times in s, level in mN/cm, intensity in uA/cm^2; timing: one of `TIMINGS`."""

    rule: str
    delay: float
    level: float
    intensity: float
    duration: float
    refractory: float
    gate: Gate = Gate()
    timing: str = "step"


class TriggerState(NamedTuple):
    """Per cell, shape (n_z, n_theta): last tension seen [mN/cm], whether it was rising, last start of a pulse [s].

    slope: of the tension over the step before [mN/cm/s], and `span`, the length of that step [s]. seen: the time at
    which the last pulse was noticed [s], later than its start where a maximum was found between steps.

    duration [s] and intensity [uA/cm^2]: of that pulse, which keeps what it was begun with. answered: the latest
    longitudinal activation that was judged under the rule `delay` [s]. opens, closes: from when and until when a ring
    of cells is prepared, (n_z,) [s]; a gate of the kind `none` reads neither.
    """

    tension: Floats
    rising: NDArray[np.bool_]
    start: Floats
    duration: Floats
    intensity: Floats
    answered: Floats
    opens: Floats
    closes: Floats
    slope: Floats
    seen: Floats
    span: float = 0.0


def quiet(shape: tuple[int, int]) -> TriggerState:
    """A trigger that has not fired yet."""
    numbers = (np.full(shape, -np.inf), np.zeros(shape), np.zeros(shape), np.full(shape, -np.inf))
    unprepared = (np.full(shape[0], np.inf), np.full(shape[0], -np.inf))
    return TriggerState(
        np.zeros(shape), np.zeros(shape, np.bool_), *numbers, *unprepared, np.zeros(shape), np.full(shape, -np.inf)
    )


def prepare(
    gate: Gate, state: TriggerState, cells: Floats, cell_size: float, stretched: tuple[float, float] | None, time: float
) -> TriggerState:
    """Prepare the rings of cells that receptors reach, Eq. (83); one that is, or is about to be, stays so longer.

    cells: their middles [cm], (n_z,). stretched: first and last z [cm] of the stretched part, None if there is none.
    """
    if stretched is None:
        return state
    low, high = stretched[0] - gate.oral_length, stretched[1] + gate.anal_length
    reached = (cells + 0.5 * cell_size >= low) & (cells - 0.5 * cell_size <= high)
    afresh = reached & (time > state.closes + ROUNDING)
    opens = np.where(afresh, time + gate.delay, state.opens)
    return state._replace(opens=opens, closes=np.where(reached, time + gate.delay + gate.duration, state.closes))


def prepared(gate: Gate, state: TriggerState, time: float) -> NDArray[np.bool_] | None:
    """Whether each ring of cells can be started now, (n_z, 1), Eq. (84); None where nothing keeps any from it."""
    if gate.kind == "none":
        return None
    return ((state.opens <= time + ROUNDING) & (time <= state.closes + ROUNDING))[:, None]


def observe_tension(trigger: Trigger, state: TriggerState, tension: Floats, time: float, span: float) -> TriggerState:
    """Fire where the tension passes its maximum: it was rising, falls now, and was above the level.

    time: now [s]; span: since the tension before [s].
    """
    rising, start, slope = np.empty_like(state.rising), np.empty_like(state.start), np.empty_like(state.slope)
    fires = _pass_maximum(
        tension.ravel(),
        Seen(state.tension.ravel(), state.rising.ravel(), state.slope.ravel(), state.start.ravel()),
        trigger.level,
        trigger.refractory,
        time,
        (state.span if trigger.timing == "within" else 0.0, span),
        Seen(tension.ravel(), rising.ravel(), slope.ravel(), start.ravel()),
    )
    after = state._replace(tension=tension, rising=rising, slope=slope, span=span)
    open_ = prepared(trigger.gate, state, time) if fires else None
    if open_ is not None:
        start = np.where(open_, start, state.start)
    return _begun(trigger, after, start, time) if fires else after


class Seen(NamedTuple):
    """What the trigger knows of every cell, flattened: see `TriggerState`."""

    tension: np.ndarray
    rising: np.ndarray
    slope: np.ndarray
    start: np.ndarray


def _begun(trigger: Trigger, state: TriggerState, start: Floats, time: float) -> TriggerState:
    """The state with pulses that begin where `start` is new, seen now; they have what the trigger has now."""
    new = start != state.start
    return state._replace(
        start=start,
        seen=np.where(new, time, state.seen),
        duration=np.where(new, trigger.duration, state.duration),
        intensity=np.where(new, trigger.intensity, state.intensity),
    )


@compiled
def _pass_maximum(
    tension: np.ndarray,
    before: Seen,
    level: float,
    refractory: float,
    time: float,
    spans: tuple[float, float],
    after: Seen,
) -> bool:
    """Whether a cell fires; `after.start` then holds the times of the last pulses.

    spans: of the step before and of this one [s]; with 0 for the first a pulse begins when it is seen. Otherwise it
    begins where the parabola through the last three tensions is largest, Eq. (100).
    """
    earlier, span = spans
    found = 0
    for k in range(tension.size):  # no branches: on vector registers
        old, was = before.tension[k], before.rising[k]
        falling, same = tension[k] < old, tension[k] == old
        fires = was & falling & (old > level) & (time - before.start[k] > refractory)
        found += fires
        after.rising[k] = (same & was) | ((not same) & (not falling))
        after.slope[k] = (tension[k] - old) / span
        after.start[k] = time if fires else before.start[k]
    if found > 0 and earlier > 0.0:
        for k in range(tension.size):
            if after.start[k] != before.start[k]:
                slope = after.slope[k]
                after.start[k] -= 0.5 * span + 0.5 * (earlier + span) * slope / (slope - max(before.slope[k], 0.0))
    return found > 0


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
    open_ = prepared(trigger.gate, state, time)
    if open_ is not None:
        fires &= open_
    if fires.any():
        state = _begun(trigger, state, np.where(fires, np.maximum(planned, time), state.start), time)
    return state._replace(answered=answered)


def trigger_current(state: TriggerState, start: float, stop: float) -> Floats:
    """Mean current of the local pulses over [start, stop] [uA/cm^2], shape (n_z, n_theta).

    A pulse that began before it was seen brings in its first step what it would have brought before, Eq. (101).
    """
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
        pulses = state.start.ravel(), state.seen.ravel(), state.duration.ravel(), state.intensity.ravel()
        _add_pulses_from(*pulses, response, start, stop, current.ravel())
    else:
        current += trigger_current(state, start, stop) * response


@compiled
def _add_pulses_from(
    begins: np.ndarray,
    seen: np.ndarray,
    durations: np.ndarray,
    intensities: np.ndarray,
    response: float,
    start: float,
    stop: float,
    current: np.ndarray,
) -> None:
    for k in range(begins.size):
        missed = seen[k] > start - ROUNDING  # noticed just now: nothing of it has been brought yet
        begin = begins[k] if missed else max(start, begins[k])
        inside = min(stop, begins[k] + durations[k]) - begin
        if inside > 0.0:
            current[k] += response * intensities[k] * (inside / (stop - start))
