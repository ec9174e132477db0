"""Friction of the pellet over a step, from the state at its start, Eqs. (27), (50), (51), (124) and (125)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..pellet.body import require_shape
from ..pellet.friction import (
    CONSTANT,
    Nodes,
    Shares,
    Start,
    falling_velocity,
    friction_of_step,
    pressed_on_end,
    sliding_velocity,
)
from ..pellet.load import pull_of_load
from .model import Model
from .state import PelletState, WallState

Floats = NDArray[np.float64]


def friction_ahead(model: Model, wall: WallState, pellet: PelletState) -> tuple[float, Floats]:
    """Dry friction [mN] over the coming step, and the share of each node in the axial friction.

    The shares, (n_z_wall + 1, n_theta), sum to one, or vanish without contact.
    """
    dry, weight, _ = _friction_ahead(model, wall, pellet)
    return dry, weight


def tangential_friction_ahead(model: Model, wall: WallState, pellet: PelletState) -> Floats:
    """What of the shares of `friction_ahead` lies along the meridian, Eq. (51); the rest is axial."""
    return _friction_ahead(model, wall, pellet)[2]


def _friction_ahead(model: Model, wall: WallState, pellet: PelletState) -> tuple[float, Floats, Floats]:
    require_shape(model.pellet)
    shares = Shares(np.empty_like(wall.contact), np.empty_like(wall.contact))
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size / model.grid.n_theta
    force = 0.0 if rests_on_end(model, pellet) else net_force(model, pellet)
    held = friction_of_step(
        Nodes(wall.contact, wall.position, area),
        Start(pellet.position, force, _velocity(model, pellet, force) == 0.0),
        model.pellet.shape,
        model.pellet.viscous,
        model.pellet.dry,
        model.friction,
        shares,
    )
    return held.dry, shares.weight, shares.tangent


def net_force(model: Model, pellet: PelletState) -> float:
    """Axial force of the wall on the pellet less the pull of its load [mN], Eq. (123)."""
    return pellet.axial_force - pull_of_load(pellet.position, model.pellet)[0]


def viscous_friction_now(model: Model, pellet: PelletState) -> float:
    """Viscous friction [mN s/cm] in the step that led to this state; before the first one that of no pressing."""
    return pellet.viscous if model.friction.viscous_coefficient > 0.0 and pellet.viscous else model.pellet.viscous


def _velocity(model: Model, pellet: PelletState, force: float) -> float:
    """Velocity against the friction frame [cm/s] under a net force [mN], by the friction of the step before."""
    viscous, dry = viscous_friction_now(model, pellet), dry_friction_now(model, pellet)
    own = model.pellet
    return float(falling_velocity(force, viscous, dry, own.fast_share, own.fall_speed, pellet.slid)[0])


def dry_friction_now(model: Model, pellet: PelletState) -> float:
    """Dry friction [mN] in the step that led to this state."""
    return model.pellet.dry if model.friction == CONSTANT else pellet.dry


def sliding_speed(model: Model, pellet: PelletState) -> float:
    """Velocity of the pellet against the friction frame [cm/s]: exactly zero while it sticks, or rests on an end."""
    if rests_on_end(model, pellet):
        return 0.0
    return _velocity(model, pellet, net_force(model, pellet))


def rests_on_end(model: Model, pellet: PelletState) -> bool:
    """Whether the wall presses the pellet onto a closed end of the segment, Eq. (60)."""
    bounds = model.pellet
    if bounds.lowest < pellet.position < bounds.highest:
        return False
    return bool(pressed_on_end(pellet.position, pellet.velocity, pellet.axial_force, bounds.lowest, bounds.highest))


def end_reaction(model: Model, pellet: PelletState) -> float:
    """Axial force of a closed end on the pellet [mN], positive towards the anal end: what friction leaves, Eq. (60)."""
    if not rests_on_end(model, pellet):
        return 0.0
    force, dry = net_force(model, pellet), dry_friction_now(model, pellet)
    drive = sliding_velocity(force, model.pellet.viscous, dry)[0]
    return -model.pellet.viscous * drive if drive != 0.0 else 0.0
