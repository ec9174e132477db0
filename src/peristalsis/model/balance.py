"""Balances over a step, term by term, from the states at its two ends: work, Eq. (29), and axial momentum, (52)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import rates_to_frames
from ..numerics.rates import rate_formula
from ..pellet.contact import normal_slope
from .bookkeeping import WallWork
from .explicit.marching import contact_energy, explicit_acceleration
from .friction import (
    dry_friction_now,
    net_force,
    sliding_speed,
    tangential_friction_ahead,
    viscous_friction_now,
)
from .model import Model
from .state import State
from .surface_balance import surface_wall_work, volume_of

Floats = NDArray[np.float64]

NEAR_ONE = 1e-3
"""Distance of the adiabatic exponent from 1 below which the energy of the gas is computed without cancellation."""


class Work(NamedTuple):
    """Work over a step [mN cm]: by the muscle and the gas, stored in the wall, lost in wall and friction, kinetic."""

    active: float
    gas: float
    stored: float
    lost_wall: float
    lost_pellet: float
    kinetic: float

    @property
    def residual(self) -> float:
        """What was stored and lost minus what was put in: zero but for the error of the time step."""
        return self.stored + self.lost_wall + self.lost_pellet + self.kinetic - self.active - self.gas


def work_from(model: Model, before: State, after: State, wall: WallWork) -> Work:
    """Trapezoidal work of every term between two states of one column, from what `bookkeeping.wall_work` found."""
    pellet_volume = model.pellet.volume if model.pellet.present else 0.0
    gas = _gas_energy(model, wall.volume_before - pellet_volume) - _gas_energy(model, wall.volume_after - pellet_volume)
    kinetic = 0.0
    if model.inertia:
        squares = [float((state.wall.velocity[:, 0, [0, 2]] ** 2).sum()) for state in (before, after)]
        kinetic = _kinetic(model, squares)
    stored = wall.passive + (contact_energy(model, after.wall) - contact_energy(model, before.wall))
    return Work(
        active=-wall.active,
        gas=gas,
        stored=stored,
        lost_wall=wall.viscous + wall.floor,
        lost_pellet=_lost_pellet(model, before, after),
        kinetic=kinetic,
    )


def work_on_surface(model: Model, before: State, after: State) -> Work:
    """`work_from` of the whole surface."""
    old, new = before.wall, after.wall
    stored, active, lost = surface_wall_work(old, new, model.wall, model.surface)
    pellet_volume = model.pellet.volume if model.pellet.present else 0.0
    gas = _gas_energy(model, volume_of(old) - pellet_volume) - _gas_energy(model, volume_of(new) - pellet_volume)
    kinetic = 0.0
    if model.inertia:
        squares = [float((rates_to_frames(wall.position, wall.velocity) ** 2).sum()) for wall in (old, new)]
        kinetic = _kinetic(model, squares) / model.grid.n_theta
    across = np.subtract(after.pellet.across, before.pellet.across)
    if model.sideways_friction is not None:  # backward Euler: the force of the end times the way
        lost_across = model.sideways_friction / model.dt_wall * float(across @ across)
    else:
        lost_across = 0.0
    return Work(
        active=-active,
        gas=gas,
        stored=stored,
        lost_wall=lost,
        lost_pellet=_lost_pellet(model, before, after) + lost_across,
        kinetic=kinetic,
    )


def _kinetic(model: Model, squares: list[float]) -> float:
    mass = 2.0 * math.pi * model.wall.radius * model.wall.element_size * model.wall.surface_density
    return 0.5 * mass * (squares[1] - squares[0])


def _lost_pellet(model: Model, before: State, after: State) -> float:
    power = _friction_power(model, before) + _friction_power(model, after)
    if model.pellet.tangential and model.pellet.frame > 0.0 and model.pellet.present:
        # A reaction along the meridian also works on the wall across the axis: it slips faster than along it.
        tangent = tangential_friction_ahead(model, before.wall, before.pellet)
        power += sum(_power_across(model, state, tangent) for state in (before, after))
    return 0.5 * model.dt_wall * power


def _power_across(model: Model, state: State, tangent: Floats) -> float:
    """Power lost in friction by slip across the axis [mN cm/s], Eq. (51)."""
    wall, pellet = state.wall, state.pellet
    slopes = normal_slope(wall.position, tangent, pellet.position, model.pellet.shape)
    return model.pellet.frame * pellet.axial_force * float((tangent * slopes * wall.velocity[:, :, 0]).sum())


class Momentum(NamedTuple):
    """Axial forces on wall and lumen at the end of a step [mN], and the rate of the wall's momentum, Eq. (52)."""

    ends: float
    pellet: float
    friction: float
    inertia: float

    @property
    def residual(self) -> float:
        """Zero but for the tolerance of the solver."""
        return self.ends - self.pellet + self.friction - self.inertia


def momentum_from(model: Model, before: State, after: State, ends: float) -> Momentum:
    """Axial momentum at the end of the step, from the difference of the anal and the oral reaction [mN].

    With inertia, a step that was cut into pieces keeps no record of what its rate is made of: its terms are nan.
    """
    force = after.pellet.axial_force if model.pellet.present else 0.0
    # Friction holds by the contact at a step's start where the step is implicit, by that of now where it is explicit.
    holding = before if model.explicit is None else after
    held = before is not after and bool((holding.wall.contact > 0.0).any())
    friction = model.pellet.frame * force if held else 0.0
    inertia = 0.0
    if model.explicit is not None:
        rate = float(explicit_acceleration(after)[:, :, 2].sum())
        inertia = 2.0 * math.pi * model.wall.radius * model.wall.element_size * model.wall.surface_density * rate
    elif model.inertia and before is not after:
        if after.wall.step_before != model.dt_wall:
            return Momentum(math.nan, math.nan, math.nan, math.nan)
        formula = rate_formula(model.dt_wall, before.wall.step_before, model.second_order)
        history = formula.history(before.wall.velocity, before.wall.velocity_before)
        rate = float((after.wall.velocity - history)[:, :, 2].sum()) * formula.inverse
        area = 2.0 * math.pi * model.wall.radius * model.wall.element_size / model.grid.n_theta
        inertia = area * model.wall.surface_density * rate
    return Momentum(ends, force, friction, inertia)


def _gas_energy(model: Model, volume: float) -> float:
    """Energy of the lumen's content against V0 [mN cm]: minus the integral of p dV, in closed form."""
    lumen = model.lumen
    ratio = lumen.reference_volume / volume
    scale = lumen.pressure * lumen.reference_volume
    above = lumen.exponent - 1.0
    if abs(above) < NEAR_ONE:  # the difference below would cancel
        return scale * (math.expm1(above * math.log(ratio)) / above if above != 0.0 else math.log(ratio))
    return scale * (ratio ** (lumen.exponent - 1.0) - 1.0) / (lumen.exponent - 1.0)


def _friction_power(model: Model, state: State) -> float:
    if not model.pellet.present:
        return 0.0
    speed = sliding_speed(model, state.pellet)
    if model.pellet.pull_stiffness > 0.0 or model.pellet.fast_share < 1.0:
        pull = state.pellet.axial_force - net_force(model, state.pellet)
        return net_force(model, state.pellet) * speed + pull * state.pellet.velocity
    return viscous_friction_now(model, state.pellet) * speed * speed + dry_friction_now(model, state.pellet) * abs(
        speed
    )
