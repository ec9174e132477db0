"""Sources of pulses: a clock that begins them one after the other, whatever its inputs do meanwhile, Eq. (62)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from .pulses import RING, Pulse

OVER_FOR = 8
"""A pulse is forgotten this many steps after its end: a step that was made in eighths still knows all of its own."""


class Outlet(NamedTuple):
    """What every beat of a source begins in one layer: a pulse `lag` [s] later, of `duration` [s], in uA/cm^2.

    It covers z in [low, high] [cm], and around the ring `sector` [rad], centred at `angle`.
    """

    layer: str
    lag: float
    duration: float
    intensity: float
    low: float
    high: float
    angle: float = 0.0
    sector: float = RING


class Source(NamedTuple):
    """Beats every `period` [s] from `onset` [s] on, `beats` in all; each begins a pulse at every outlet."""

    onset: float
    period: float
    beats: int
    outlets: tuple[Outlet, ...]


class SourceState(NamedTuple):
    """How far a source has come: the coming beat is at origin + ticks * period [s], after `begun` beats.

    onset and period: the inputs that this holds for. longitudinal, circular: pulses that were begun or are planned,
    with what they had at their beat; pulses that are over are dropped some steps later.
    """

    begun: int
    origin: float
    ticks: int
    onset: float
    period: float
    longitudinal: tuple[Pulse, ...] = ()
    circular: tuple[Pulse, ...] = ()


def waiting(source: Source) -> SourceState:
    """A source before its first beat."""
    return SourceState(0, source.onset, 0, source.onset, source.period)


def follow(
    sources: Iterable[Source], states: Iterable[SourceState], start: float, stop: float
) -> tuple[SourceState, ...]:
    """The sources at the end of the step [start, stop] [s], with all pulses that are on during it, Eq. (62)."""
    return tuple(_follow(source, state, start, stop) for source, state in zip(sources, states, strict=True))


def _follow(source: Source, state: SourceState, start: float, stop: float) -> SourceState:
    if source.onset != state.onset or source.period != state.period:
        state = _turned(source, state, start)
    kept = {"longitudinal": state.longitudinal, "circular": state.circular}
    forgotten = start - OVER_FOR * (stop - start)
    for layer, pulses in kept.items():
        if any(pulse.end <= forgotten for pulse in pulses):
            kept[layer] = tuple(pulse for pulse in pulses if pulse.end > forgotten)
    begun, ticks = state.begun, state.ticks
    if (
        begun < source.beats and state.origin + ticks * source.period < start
    ):  # more beats were asked for since its last
        ticks = math.ceil((start - state.origin) / source.period)
    while begun < source.beats and state.origin + ticks * source.period < stop:
        for outlet in source.outlets:
            begin = (state.origin + outlet.lag) + ticks * source.period
            where = (outlet.low, outlet.high, outlet.intensity, outlet.angle, outlet.sector)
            kept[outlet.layer] += (Pulse(begin, begin + outlet.duration, *where),)
        begun, ticks = begun + 1, ticks + 1
    if begun == state.begun and all(kept[layer] is getattr(state, layer) for layer in kept):
        return state._replace(ticks=ticks) if ticks != state.ticks else state
    return state._replace(begun=begun, ticks=ticks, longitudinal=kept["longitudinal"], circular=kept["circular"])


def _turned(source: Source, state: SourceState, now: float) -> SourceState:
    """The state under changed inputs: the clock keeps its phase, and an onset still to come begins it anew."""
    if source.onset != state.onset and source.onset >= now:
        return state._replace(begun=0, origin=source.onset, ticks=0, onset=source.onset, period=source.period)
    if state.begun == 0:  # its onset was put before now: it begins at once
        origin = state.origin if source.onset == state.onset else now
        return state._replace(origin=origin, onset=source.onset, period=source.period)
    beat = state.origin + state.ticks * state.period
    left = (beat - now) / state.period
    if left < 0.0:  # no beat was asked for any more; the clock went on
        left %= 1.0
    if source.period == state.period:
        return state._replace(onset=source.onset)
    return state._replace(origin=now + left * source.period, ticks=0, onset=source.onset, period=source.period)
