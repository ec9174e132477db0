"""Mechanoreceptor reflex: excitation above the pellet, inhibition below it, Eq. (26)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .pulses import Pulse

Floats = NDArray[np.float64]

KINDS = ("all_or_none", "graded")
"""One pulse of stated extent where the pellet stretches the wall; or answers of every receptor to its own stretch."""


class Reflex(NamedTuple):
    """Settings of the reflex: lengths in cm, times in s, excitation in uA/cm^2, inhibition in mS/cm^2.

    kind: one of `KINDS`. gain: factor on all that its neurons bring. Of the graded one alone: stretch_range, beyond the
    threshold, at which a receptor answers with all it has; summation, length of wall [cm] so stretched that brings 63 %
    of the whole intensity; longitudinal_intensity [uA/cm^2] and longitudinal_delay [s].
    """

    enabled: bool
    threshold: float  # ratio of girths
    oral_length: float
    anal_length: float
    delay: float
    refractory: float
    excitation_intensity: float
    excitation_duration: float
    inhibition_conductance: float
    inhibition_duration: float
    kind: str = "all_or_none"
    gain: float = 1.0
    stretch_range: float = 1.0
    summation: float = 1.0
    longitudinal_intensity: float = 0.0
    longitudinal_delay: float = 0.0

    @property
    def graded(self) -> bool:
        """Whether every receptor answers its own stretch."""
        return self.kind == "graded"


class Receptors(NamedTuple):
    """Of the graded reflex, at every node of the wall: times of its last discharges [s], and how strong they were.

    Both (discharges, n), the latest first: as many as can be under way at one time.
    """

    time: Floats
    strength: Floats


class ReflexState(NamedTuple):
    """Time of the last discharge [s], and the exciting currents and inhibiting conductances under way or to come.

    receptors: of the graded reflex, which plans no pulses; its `fired` is the last time that silence ended.
    """

    fired: float
    excitation: tuple[Pulse, ...]
    inhibition: tuple[Pulse, ...]
    receptors: Receptors | None = None


SILENT = ReflexState(-np.inf, (), ())


def forget(state: ReflexState, time: float) -> ReflexState:
    """The state without the pulses that are over."""
    excitation, inhibition = _kept(state.excitation, time), _kept(state.inhibition, time)
    if len(excitation) == len(state.excitation) and len(inhibition) == len(state.inhibition):
        return state
    return state._replace(excitation=excitation, inhibition=inhibition)


def refractory(reflex: Reflex, state: ReflexState, time: float) -> bool:
    """Whether the receptors are deaf, whatever the pellet does."""
    return time - state.fired < reflex.refractory - 1e-9


def observe_stretch(
    reflex: Reflex, state: ReflexState, nodes: Floats, girth_ratio: Floats, touching: NDArray[np.bool_], time: float
) -> ReflexState:
    """Discharge if the pellet stretches the touching wall beyond the threshold and the receptors are not refractory.

    nodes: Lagrangian z [cm], (n,). girth_ratio: circumference over its pellet-free value at p0, (n,).
    """
    state = forget(state, time)
    if not reflex.enabled or refractory(reflex, state, time):
        return state
    part = stretched_part(reflex, nodes, girth_ratio, touching)
    if part is None:
        return state
    low, high = part
    begin = time + reflex.delay
    strength, opening = reflex.gain * reflex.excitation_intensity, reflex.gain * reflex.inhibition_conductance
    above = Pulse(begin, begin + reflex.excitation_duration, low - reflex.oral_length, low, strength)
    below = Pulse(begin, begin + reflex.inhibition_duration, high, high + reflex.anal_length, opening)
    return ReflexState(time, (*state.excitation, above), (*state.inhibition, below))


def stretched_part(
    reflex: Reflex, nodes: Floats, girth_ratio: Floats, touching: NDArray[np.bool_]
) -> tuple[float, float] | None:
    """First and last touching node beyond the threshold [cm], None if there is none; see `observe_stretch`."""
    stretched = nodes[touching & (girth_ratio > reflex.threshold)]
    return None if stretched.size == 0 else (float(stretched[0]), float(stretched[-1]))


def _kept(pulses: tuple[Pulse, ...], time: float) -> tuple[Pulse, ...]:
    for pulse in pulses:
        if not pulse.end > time:
            return tuple(pulse for pulse in pulses if pulse.end > time)
    return pulses
