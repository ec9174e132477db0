"""Balances over a step, term by term, from the states at its two ends: work, Eq. (29), and axial momentum, (52)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import rates_to_frames
from ..geometry.tube import lumen_volume
from ..numerics.compiled import compiled
from ..numerics.rates import rate_formula
from ..wall.membrane import PARTS, WallConstants, corner_tension
from .explicit_step import contact_energy, explicit_acceleration
from .fields import column, end_reactions
from .friction import dry_friction_now, sliding_speed
from .model import Model
from .state import State, WallState
from .surface_balance import surface_wall_work, volume_of

Floats = NDArray[np.float64]


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


def work_of_step(model: Model, before: State, after: State) -> Work:
    """Trapezoidal work of every term between two states a step apart."""
    if model.grid.is_surface:
        return _work_on_surface(model, before, after)
    parts = np.zeros(4)
    old, new = before.wall, after.wall
    rho_0, zeta_0 = column(old.position, 0, 0), column(old.position, 0, 2)
    rho_1, zeta_1 = column(new.position, 0, 0), column(new.position, 0, 2)
    _wall_work(
        rho_0,
        zeta_0,
        column(old.stretch_rate, 0),
        column(old.hoop_rate, 0),
        np.ascontiguousarray(old.drive[:, :, 0]),
        rho_1,
        zeta_1,
        column(new.stretch_rate, 0),
        column(new.hoop_rate, 0),
        np.ascontiguousarray(new.drive[:, :, 0]),
        model.wall,
        parts,
    )
    parts[2] += _bending_loss(model, old, new)
    pellet_volume = model.pellet.volume if model.pellet.present else 0.0
    gas = _gas_energy(model, lumen_volume(rho_0, zeta_0) - pellet_volume)
    gas -= _gas_energy(model, lumen_volume(rho_1, zeta_1) - pellet_volume)
    kinetic = 0.0
    if model.inertia:
        squares = [float((wall.velocity[:, 0, [0, 2]] ** 2).sum()) for wall in (old, new)]
        kinetic = _kinetic(model, squares)
    parts[0] += contact_energy(model, new) - contact_energy(model, old)
    return Work(-parts[1], gas, parts[0], parts[2] + parts[3], _lost_pellet(model, before, after), kinetic)


def _work_on_surface(model: Model, before: State, after: State) -> Work:
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
    return Work(-active, gas, stored, lost, _lost_pellet(model, before, after) + lost_across, kinetic)


def _kinetic(model: Model, squares: list[float]) -> float:
    mass = 2.0 * math.pi * model.wall.radius * model.wall.element_size * model.wall.surface_density
    return 0.5 * mass * (squares[1] - squares[0])


def _lost_pellet(model: Model, before: State, after: State) -> float:
    return 0.5 * model.dt_wall * (_friction_power(model, before) + _friction_power(model, after))


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


def momentum_of_step(model: Model, before: State, after: State) -> Momentum:
    """Axial momentum at the end of the step.

    With inertia, a step that was cut into pieces keeps no record of what its rate is made of: its terms are nan.
    """
    oral, anal, _ = end_reactions(after.wall, model.wall, after.pressure)
    force = after.pellet.axial_force if model.pellet.present else 0.0
    # Friction holds by the contact at a step's start where the step is implicit, by that of now where it is explicit.
    holding = before if model.explicit is None else after
    held = before is not after and bool((holding.wall.contact > 0.0).any())
    friction = model.pellet.frame * force if held else 0.0
    inertia = 0.0
    if model.explicit is not None:
        rate = float(explicit_acceleration(after.wall)[:, :, 2].sum())
        inertia = 2.0 * math.pi * model.wall.radius * model.wall.element_size * model.wall.surface_density * rate
    elif model.inertia and before is not after:
        if after.wall.step_before != model.dt_wall:
            return Momentum(math.nan, math.nan, math.nan, math.nan)
        formula = rate_formula(model.dt_wall, before.wall.step_before, model.second_order)
        history = formula.history(before.wall.velocity, before.wall.velocity_before)
        rate = float((after.wall.velocity - history)[:, :, 2].sum()) * formula.inverse
        area = 2.0 * math.pi * model.wall.radius * model.wall.element_size / model.grid.n_theta
        inertia = area * model.wall.surface_density * rate
    return Momentum(anal - oral, force, friction, inertia)


def _bending_loss(model: Model, old: WallState, new: WallState) -> float:
    """Work lost in the bending viscosity [mN cm]: its trapezoidal force on the change of curvature."""
    wall = model.wall

    def second(field: Floats) -> Floats:
        return np.asarray(field[:-2, 0] - 2.0 * field[1:-1, 0] + field[2:, 0])[:, [0, 2]]

    mean = 0.5 * (second(old.velocity) + second(new.velocity))
    change = second(new.position) - second(old.position)
    return float(2.0 * math.pi * wall.radius * wall.bending_viscosity / wall.element_size**3 * (mean * change).sum())


def _gas_energy(model: Model, volume: float) -> float:
    """Energy of the lumen's content against V0 [mN cm]: minus the integral of p dV, in closed form."""
    lumen = model.lumen
    ratio = lumen.reference_volume / volume
    scale = lumen.pressure * lumen.reference_volume
    if abs(lumen.exponent - 1.0) < 1e-12:
        return scale * math.log(ratio)
    return scale * (ratio ** (lumen.exponent - 1.0) - 1.0) / (lumen.exponent - 1.0)


def _friction_power(model: Model, state: State) -> float:
    if not model.pellet.present:
        return 0.0
    speed = sliding_speed(model, state.pellet)
    return model.pellet.viscous * speed * speed + dry_friction_now(model, state.pellet) * abs(speed)


@compiled
def _wall_work(
    rho_0: np.ndarray,
    zeta_0: np.ndarray,
    stretch_rate_0: np.ndarray,
    hoop_rate_0: np.ndarray,
    drive_0: np.ndarray,
    rho_1: np.ndarray,
    zeta_1: np.ndarray,
    stretch_rate_1: np.ndarray,
    hoop_rate_1: np.ndarray,
    drive_1: np.ndarray,
    c: WallConstants,
    out: np.ndarray,
) -> None:
    """Work on the wall by part into `out`: passive with bending, active, viscous, and what the floor adds."""
    old = np.empty(PARTS)
    new = np.empty(PARTS)
    out[:] = 0.0
    h = c.element_size
    for e in range(rho_0.size - 1):
        stretch_0 = math.hypot(rho_0[e + 1] - rho_0[e], zeta_0[e + 1] - zeta_0[e]) / h
        stretch_1 = math.hypot(rho_1[e + 1] - rho_1[e], zeta_1[e + 1] - zeta_1[e]) / h
        for i in (e, e + 1):
            k = e + i
            hoop_0 = rho_0[i] / c.radius
            hoop_1 = rho_1[i] / c.radius
            corner_tension(stretch_0, hoop_0, stretch_rate_0[e], hoop_rate_0[i], drive_0[0, k], drive_0[1, k], c, old)
            corner_tension(stretch_1, hoop_1, stretch_rate_1[e], hoop_rate_1[i], drive_1[0, k], drive_1[1, k], c, new)
            for layer in range(2):
                across_0 = (stretch_0 if layer else hoop_0) if c.published else 1.0
                across_1 = (stretch_1 if layer else hoop_1) if c.published else 1.0
                change = (hoop_1 - hoop_0) if layer else (stretch_1 - stretch_0)
                total = 0.0
                for part in range(4):
                    mean = 0.5 * (old[4 * layer + part] * across_0 + new[4 * layer + part] * across_1)
                    if part < 3:
                        out[part] += mean * change
                        total += mean * change
                    else:
                        out[3] += mean * change - total
    for part in range(4):
        out[part] *= math.pi * c.radius * h
    bending = 0.0
    for i in range(1, rho_0.size - 1):
        bending += (rho_1[i - 1] - 2.0 * rho_1[i] + rho_1[i + 1]) ** 2
        bending += (zeta_1[i - 1] - 2.0 * zeta_1[i] + zeta_1[i + 1]) ** 2
        bending -= (rho_0[i - 1] - 2.0 * rho_0[i] + rho_0[i + 1]) ** 2
        bending -= (zeta_0[i - 1] - 2.0 * zeta_0[i] + zeta_0[i + 1]) ** 2
    out[0] += math.pi * c.radius * c.bending_stiffness / h**3 * bending
