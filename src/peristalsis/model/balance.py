"""Work done and lost in a step, term by term, Eq. (29), from the states at its two ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..pellet.friction import speed_at
from .bookkeeping import wall_work
from .model import Model
from .state import PelletState, State, WallState


class Work(NamedTuple):
    """Work over a step [mN cm]: by the muscle and the gas, stored in the wall, lost in wall and friction, kinetic."""

    active: float
    gas: float
    stored: float
    lost_wall: float
    lost_pellet: float
    kinetic: float

    def __add__(self, other: object) -> Work:
        """Work of two steps, one after the other."""
        if not isinstance(other, Work):
            return NotImplemented
        return Work(*(mine + its for mine, its in zip(self, other, strict=True)))

    @property
    def turnover(self) -> float:
        """Half of all that changed hands: what was put in, if the balance closes."""
        return 0.5 * sum(abs(term) for term in self)

    @property
    def residual(self) -> float:
        """What was stored and lost minus what was put in: zero but for the error of the time step."""
        return self.stored + self.lost_wall + self.lost_pellet + self.kinetic - self.active - self.gas


def work_of_step(model: Model, before: State, after: State) -> Work:
    """Trapezoidal work of every term between two states a step apart (axisymmetric wall)."""
    return work_between(model, before.wall, before.pellet, after.wall, after.pellet, model.dt_wall)


def work_between(
    model: Model, old: WallState, old_pellet: PelletState, new: WallState, new_pellet: PelletState, dt: float
) -> Work:
    """`work_of_step` for a step of dt [s] between two states of wall and pellet."""
    parts = np.empty(4)
    volume_0, volume_1 = wall_work(
        old.position,
        old.velocity,
        old.stretch_rate,
        old.hoop_rate,
        old.drive,
        new.position,
        new.velocity,
        new.stretch_rate,
        new.hoop_rate,
        new.drive,
        model.packed[0],
        parts,
    )
    stored, active, viscous, floor = parts.tolist()
    pellet_volume = model.pellet.volume if model.pellet.present else 0.0
    gas = _gas_energy(model, volume_0 - pellet_volume) - _gas_energy(model, volume_1 - pellet_volume)
    kinetic = 0.0
    if model.inertia:
        mass = 2.0 * math.pi * model.wall.radius * model.wall.element_size * model.wall.surface_density
        squares = [float((wall.velocity[:, 0, [0, 2]] ** 2).sum()) for wall in (old, new)]
        kinetic = 0.5 * mass * (squares[1] - squares[0])
    lost_pellet = 0.5 * dt * (_friction_power(model, old_pellet) + _friction_power(model, new_pellet))
    return Work(-active, gas, stored, viscous + floor, lost_pellet, kinetic)


def _gas_energy(model: Model, volume: float) -> float:
    """Energy of the lumen's content against V0 [mN cm]: minus the integral of p dV, in closed form."""
    lumen = model.lumen
    ratio = lumen.reference_volume / volume
    scale = lumen.pressure * lumen.reference_volume
    if abs(lumen.exponent - 1.0) < 1e-12:
        return scale * math.log(ratio)
    return scale * (ratio ** (lumen.exponent - 1.0) - 1.0) / (lumen.exponent - 1.0)


def _friction_power(model: Model, pellet: PelletState) -> float:
    if not model.pellet.present:
        return 0.0
    speed = speed_at(pellet.axial_force, model.pellet.viscous, model.pellet.dry)
    return model.pellet.viscous * speed * speed + model.pellet.dry * abs(speed)
