"""Graded reflex: every receptor answers its own stretch, and what it sends fades with distance, Eqs. (120)-(122)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .reflex import Receptors, Reflex, ReflexState

Floats = NDArray[np.float64]

ROUNDING = 1e-9
"""Times this close are one [s]."""


class Answer(NamedTuple):
    """What the receptors bring to the rings of cells over a step, as shares of the whole intensities, (n_z,) each.

    longitudinal, excitation: on the oral side; inhibition: on the anal side.
    """

    longitudinal: Floats
    excitation: Floats
    inhibition: Floats


def observe_receptors(
    reflex: Reflex,
    state: ReflexState,
    girth_ratio: Floats | None,
    touching: NDArray[np.bool_],
    time: float,
) -> ReflexState:
    """Let every receptor discharge that is stretched and not refractory, Eq. (120).

    girth_ratio: circumference over its pellet-free value at p0, (n,), None where none is beyond the threshold.
    touching: whether the pellet touches the node, (n,). Receptors sit at the nodes of the wall.
    """
    if girth_ratio is None:
        return state
    before = kept(reflex, state.receptors, girth_ratio.size)
    ready = time - before.time[0] >= reflex.refractory - ROUNDING
    fires = ready & touching & (girth_ratio > reflex.threshold)
    if not fires.any():
        return state
    strength = np.minimum((girth_ratio - reflex.threshold) / reflex.stretch_range, 1.0)
    after = Receptors(_pushed(before.time, time, fires), _pushed(before.strength, strength, fires))
    begins = time - float(before.time[0].max()) > reflex.refractory + lasting(reflex)
    return state._replace(receptors=after, fired=time if begins else state.fired)


def kept(reflex: Reflex, receptors: Receptors | None, count: int) -> Receptors:
    """Room for as many discharges as can be under way, with those that there are, of `count` receptors."""
    now = 0 if receptors is None else len(receptors.time)
    needed = max(1, now, math.ceil(lasting(reflex) / max(reflex.refractory, ROUNDING) - ROUNDING))
    if receptors is not None and needed == now:
        return receptors
    time, strength = np.full((needed, count), -np.inf), np.zeros((needed, count))
    if receptors is not None:
        time[:now], strength[:now] = receptors
    return Receptors(time, strength)


def _pushed(before: Floats, new: Floats | float, where: NDArray[np.bool_]) -> Floats:
    """The rows, moved down by one where there is a new value, which takes the first."""
    return np.where(where, np.vstack([np.broadcast_to(new, before[:1].shape), before[:-1]]), before)


def lasting(reflex: Reflex) -> float:
    """Time from a discharge until the last of its answers is over [s]."""
    late = max(reflex.delay, reflex.longitudinal_delay)
    return late + max(reflex.excitation_duration, reflex.inhibition_duration)


def answer(
    reflex: Reflex, receptors: Receptors, nodes: Floats, cells: Floats, start: float, stop: float
) -> Answer | None:
    """What the receptors bring over the step [start, stop] [s]; None if nothing.

    nodes, cells: Lagrangian z of receptors (n,) and of the middles of cells (n_z,) [cm].
    """
    lasts = reflex.excitation_duration

    def sent(delay: float, lasts: float) -> Floats:
        shares = receptors.strength * _overlap(receptors.time + delay, lasts, start, stop)
        found: Floats = shares.sum(axis=0)
        return found

    along, above = sent(reflex.longitudinal_delay, lasts), sent(reflex.delay, lasts)
    below = sent(reflex.delay, reflex.inhibition_duration)
    if not (along.any() or above.any() or below.any()):
        return None
    spacing = float(nodes[1] - nodes[0])
    share = spacing / reflex.summation
    return Answer(
        saturated(share * spread(along, -nodes, -cells, reflex.oral_length, spacing)),
        saturated(share * spread(above, -nodes, -cells, reflex.oral_length, spacing)),
        saturated(share * spread(below, nodes, cells, reflex.anal_length, spacing)),
    )


def saturated(summed: Floats) -> Floats:
    """Share of the whole that neurons bring at a sum of what reaches them, Eq. (122): the sum while it is small."""
    return -np.expm1(-summed)


def spread(sent: Floats, nodes: Floats, cells: Floats, length: float, spacing: float) -> Floats:
    """Sum at the cells of what nodes before them send, fading over `length` [cm], Eq. (121); (n_z,).

    A node sends from the stretch of `spacing` [cm] about it; of one that reaches across a cell's middle counts what
    lies before that.
    """
    sends = np.flatnonzero(sent)
    distance = cells[:, None] - nodes[sends]
    before = np.clip(distance / spacing + 0.5, 0.0, 1.0)
    faded = np.exp(-np.maximum(distance, 0.0) / length) if length > 0.0 else (distance <= 0.0).astype(np.float64)
    found: Floats = (before * faded) @ sent[sends]
    return found


def _overlap(begin: Floats, lasts: float, start: float, stop: float) -> Floats:
    """Share of the step during which the answer to each discharge is on."""
    return np.clip(np.minimum(stop, begin + lasts) - np.maximum(start, begin), 0.0, None) / (stop - start)
