"""Viscous and dry friction on the pellet, Eqs. (13), (27), (50) and (51)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .shapes.sphere import ShapeConstants, gap_and_normal


class FrictionLaw(NamedTuple):
    """Dry friction beyond Eq. (13): static over kinetic friction, Eq. (50), and a share mu of the pressing, Eq. (51).

    The defaults are Eq. (13) itself.
    """

    static_factor: float = 1.0
    coefficient: float = 0.0


CONSTANT = FrictionLaw()
"""Dry friction as printed: one force, at rest and sliding."""


@compiled
def sliding_velocity(force: float, viscous: float, dry: float) -> tuple[float, float]:
    """Velocity against the friction frame [cm/s] under an axial force [mN], and its derivative by the force.

    viscous [mN s/cm] > 0, dry [mN] >= 0. Exactly zero while |force| <= dry: the pellet sticks.
    """
    if force > dry:
        return (force - dry) / viscous, 1.0 / viscous
    if force < -dry:
        return (force + dry) / viscous, 1.0 / viscous
    return 0.0, 0.0


@compiled
def held_by_ends(place: float, lowest: float, highest: float) -> bool:
    """Whether the centre would be at or beyond a closed end of the segment, Eq. (60), which then holds the pellet."""
    return place <= lowest or place >= highest


@compiled
def pressed_on_end(place: float, velocity: float, force: float, lowest: float, highest: float) -> bool:
    """Whether a pellet at rest is pressed onto a closed end by an axial force [mN], Eq. (60)."""
    return velocity == 0.0 and ((place <= lowest and force < 0.0) or (place >= highest and force > 0.0))


@compiled
def dry_friction(dry: float, law: FrictionLaw, pressing: float, stuck: bool) -> float:
    """Dry friction [mN] that must be overcome over a step, Eqs. (50) and (51).

    dry: F_d [mN]. pressing: the contact force across the axis [mN], sum of Q n_rho over the nodes. stuck: whether the
    pellet rests against the friction frame when the step begins.
    """
    kinetic = dry + law.coefficient * pressing if law.coefficient > 0.0 else dry
    return kinetic * law.static_factor if stuck else kinetic


@compiled
def pressed_part(dry: float, law: FrictionLaw, pressing: float, force: float, holding: float) -> float:
    """The part of the whole friction that is in proportion to pressing, Eq. (51): from 0 to 1.

    dry, pressing, holding [mN]: F_d, N and the dry friction in all, with its static factor. force [mN]: the whole
    friction, viscous and dry, for the pellet has no inertia. It vanishes with the coefficient.
    """
    kinetic = dry + law.coefficient * pressing
    if kinetic <= 0.0:
        return 0.0
    part = law.coefficient * pressing / kinetic
    size = abs(force)
    return part * holding / size if size > holding else part


@compiled
def share_out(
    contact: np.ndarray,
    position: np.ndarray,
    centre: float,
    shape: ShapeConstants,
    across: bool,
    weight: np.ndarray,
) -> float:
    """Shares of the nodes in the pressing, and its sum: of the contact, or of its part across the axis."""
    total = 0.0
    for i in range(contact.shape[0]):
        for j in range(contact.shape[1]):
            pressing = contact[i, j]
            if across and pressing != 0.0:
                _, normal_r, _, _, _ = gap_and_normal(position[i, j, 0], position[i, j, 2] - centre, shape)
                pressing *= normal_r
            weight[i, j] = pressing
            total += pressing
    for i in range(contact.shape[0]):
        for j in range(contact.shape[1]):
            weight[i, j] = weight[i, j] / total if total > 0.0 else 0.0
    return total


@compiled
def friction_of_step(
    contact: np.ndarray,
    position: np.ndarray,
    centre: float,
    shape: ShapeConstants,
    force: float,
    viscous: float,
    dry_before: float,
    dry: float,
    law: FrictionLaw,
    area: float,
    weight: np.ndarray,
    tangent: np.ndarray,
) -> float:
    """Dry friction [mN] that holds over a step, from the contact at its start, and the shares of the nodes in it.

    contact [mN/cm^2] (n, m) on nodes of `area` [cm^2] at position (n, m, 3). force and dry_before [mN] tell whether the
    pellet is stuck as the step begins. weight: receives the shares of the nodes in the whole friction, (n, m). tangent:
    receives what of them is friction in proportion to pressing, Eq. (51), which lies along the meridian; the rest is
    axial.
    """
    stuck = sliding_velocity(force, viscous, dry_before)[0] == 0.0
    if law.coefficient <= 0.0:
        tangent[:] = 0.0
        return dry_friction(dry, law, area * share_out(contact, position, centre, shape, False, weight), stuck)
    pressing = area * share_out(contact, position, centre, shape, True, tangent)
    holding = dry_friction(dry, law, pressing, stuck)
    share_out(contact, position, centre, shape, False, weight)
    part = pressed_part(dry, law, pressing, force, holding)
    for i in range(contact.shape[0]):
        for j in range(contact.shape[1]):
            tangent[i, j] *= part
            weight[i, j] = (1.0 - part) * weight[i, j] + tangent[i, j]
    return holding
