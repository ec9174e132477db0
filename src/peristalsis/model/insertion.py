"""Between two passes: the pellet taken out of the tube, the next one put in, and the clock set back, Eq. (105)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..control.pacemaker import waiting
from ..control.pulses import Pulse
from ..control.reflex import ReflexState
from ..control.sequence import TriggerState
from ..geometry.tube import lumen_volume
from ..pellet.body import require_shape, resized_pellet
from ..pellet.contact import room
from .inflation import GROWTH
from .initial import holding
from .model import Model
from .state import PelletState, SheetState, State, WallState
from .step import solve_wall

LONGEST = 0.05
"""Longest step in which the wall moves aside for a pellet that is put in [s]."""
STILL_FOR = 1.0
"""Time for which the wall settles around it [s]."""
CLEAR = 1.0 - 1e-6
"""Share of the room it finds at which a pellet begins to grow."""


class Insertion(NamedTuple):
    """A pass about to begin: the model with its V0, its state, and the largest speed of the wall then [cm/s]."""

    model: Model
    state: State
    speed: float


def emptied(state: State) -> State:
    """The state without its pellet: nothing touches the wall, and no source paces."""
    wall = replace(state.wall, contact=np.zeros_like(state.wall.contact))
    return replace(state, wall=wall, pellet=PelletState(0.0, 0.0, 0.0), sources=())


def inserted(model: Model, state: State) -> Insertion:
    """The state with a pellet at its start, at the time 0 of a new pass. model: with the pellet; state: without one.

    Cells and nerves stand still while the wall moves aside by its viscosity, around a pellet that grows, Eq. (59), and
    then for a second more; the lumen is open at p0 meanwhile, and V0 is its volume at the end. Raises DivergenceError.
    """
    require_shape(model.pellet)
    start, whole = model.start_position, model.pellet.radius
    open_lumen = model.lumen._replace(reference_volume=1.0, exponent=0.0)
    wall, drive = state.wall, state.wall.drive
    pellet = PelletState(start, 0.0, 0.0)
    found = float(room(wall.position[:, 0, 0], wall.position[:, 0, 2], start, model.pellet.shape))
    radius = min(whole, CLEAR * found)
    dt = min(LONGEST, model.dt_wall)
    steps = math.ceil((whole - radius) / (GROWTH * dt)) + math.ceil(STILL_FOR / dt)
    for _ in range(steps):
        radius = min(whole, radius + GROWTH * dt)
        sized = resized_pellet(model.pellet, radius)._replace(lowest=start, highest=start, volume=0.0, frame=0.0)
        held = replace(model, pellet=sized, lumen=open_lumen)
        solved = solve_wall(held, wall, pellet, model.lumen.pressure, drive, dt, model.max_halvings, 0.0)
        wall, pellet = solved.wall, solved.pellet
    return _beginning(model, state, wall, pellet.axial_force)


def _beginning(model: Model, state: State, wall: WallState, force: float) -> Insertion:
    rho, zeta = wall.position[:, 0, 0], wall.position[:, 0, 2]
    volume = lumen_volume(rho, zeta) - model.pellet.volume
    complete = replace(model, lumen=model.lumen._replace(reference_volume=volume))
    still = np.zeros_like(wall.velocity)
    resting = replace(
        wall,
        position_before=wall.position,
        velocity=still,
        velocity_before=still,
        stretch_rate=np.zeros_like(wall.stretch_rate),
        hoop_rate=np.zeros_like(wall.hoop_rate),
        step_before=0.0,
    )
    pellet = PelletState(model.start_position, 0.0, force, holding(complete, wall.contact[:, 0], rho, zeta))
    began = replace(
        set_back(state, state.step * model.dt_wall),
        wall=resting,
        pellet=pellet,
        pressure=model.lumen.pressure,
        sources=tuple(waiting(source) for source in model.sources),
    )
    return Insertion(complete, began, float(np.abs(wall.velocity).max()))


def set_back(state: State, seconds: float) -> State:
    """The same state on a clock that begins anew, where now is 0: what happened before has a negative time [s]."""
    return replace(
        state,
        step=0,
        longitudinal=_sheet(state.longitudinal, seconds),
        circular=_sheet(state.circular, seconds),
        network=None if state.network is None else _sheet(state.network, seconds),
        trigger=_trigger(state.trigger, seconds),
        reflex=_reflex(state.reflex, seconds),
    )


def _sheet(sheet: SheetState, seconds: float) -> SheetState:
    unset = np.full_like(sheet.first_activation, np.nan)
    return replace(sheet, first_activation=unset, last_activation=sheet.last_activation - 1e3 * seconds)


def _trigger(trigger: TriggerState, seconds: float) -> TriggerState:
    times = {name: getattr(trigger, name) - seconds for name in ("start", "answered", "opens", "closes", "seen")}
    return trigger._replace(**times)


def _reflex(reflex: ReflexState, seconds: float) -> ReflexState:
    def moved(pulses: tuple[Pulse, ...]) -> tuple[Pulse, ...]:
        return tuple(one._replace(begin=one.begin - seconds, end=one.end - seconds) for one in pulses)

    receptors = reflex.receptors
    if receptors is not None:
        receptors = receptors._replace(time=receptors.time - seconds)
    return ReflexState(reflex.fired - seconds, moved(reflex.excitation), moved(reflex.inhibition), receptors)
