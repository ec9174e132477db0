"""Friction of the pellet over a step, from the state at its start, Eqs. (27), (50) and (51)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..pellet.friction import CONSTANT, dry_friction, sliding_velocity
from .model import Model
from .state import PelletState, WallState

Floats = NDArray[np.float64]


def friction_ahead(model: Model, wall: WallState, pellet: PelletState) -> tuple[float, Floats]:
    """Dry friction [mN] over the coming step, and the share of each node in the axial friction.

    The shares, (n_z_wall + 1, n_theta), sum to one, or vanish without contact.
    """
    pressing = wall.contact
    if model.friction.coefficient > 0.0:
        rho, axial = wall.position[:, :, 0], wall.position[:, :, 2] - pellet.position
        pressing = pressing * rho / np.hypot(rho, axial)
    total = float(pressing.sum())
    weight = pressing / total if total > 0.0 else np.zeros_like(pressing)
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size / model.grid.n_theta
    stuck = sliding_speed(model, pellet) == 0.0
    return dry_friction(model.pellet.dry, model.friction, area * total, stuck), weight


def dry_friction_now(model: Model, pellet: PelletState) -> float:
    """Dry friction [mN] in the step that led to this state."""
    return model.pellet.dry if model.friction == CONSTANT else pellet.dry


def sliding_speed(model: Model, pellet: PelletState) -> float:
    """Velocity of the pellet against the friction frame [cm/s]: exactly zero while it sticks."""
    return sliding_velocity(pellet.axial_force, model.pellet.viscous, dry_friction_now(model, pellet))[0]
