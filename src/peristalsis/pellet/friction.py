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


class Nodes(NamedTuple):
    """What presses on the pellet: contact [mN/cm^2] (n, m) of nodes at `position` (n, m, 3), `area` [cm^2] each."""

    contact: np.ndarray
    position: np.ndarray
    area: float


class Start(NamedTuple):
    """The pellet as a step begins: its centre [cm], the axial force on it and the dry friction until then [mN]."""

    centre: float
    force: float
    dry: float


class Shares(NamedTuple):
    """Shares of the nodes (n, m) in the whole friction, and what of them lies along the meridian, Eq. (51)."""

    weight: np.ndarray
    tangent: np.ndarray


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
def share_out(nodes: Nodes, centre: float, shape: ShapeConstants, across: bool, weight: np.ndarray) -> float:
    """Shares of the nodes in the pressing, and its sum: of the contact, or of its part across the axis."""
    contact, position = nodes.contact, nodes.position
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
    nodes: Nodes,
    start: Start,
    shape: ShapeConstants,
    viscous: float,
    dry: float,
    law: FrictionLaw,
    shares: Shares,
) -> float:
    """Dry friction [mN] that holds over a step, from the contact at its start; `shares` receives those of the nodes.

    start: tells whether the pellet is stuck. shares: friction in proportion to pressing, Eq. (51), lies along the
    meridian; the rest is axial.
    """
    weight, tangent, centre = shares.weight, shares.tangent, start.centre
    stuck = sliding_velocity(start.force, viscous, start.dry)[0] == 0.0
    if law.coefficient <= 0.0:
        tangent[:] = 0.0
        return dry_friction(dry, law, nodes.area * share_out(nodes, centre, shape, False, weight), stuck)
    pressing = nodes.area * share_out(nodes, centre, shape, True, tangent)
    holding = dry_friction(dry, law, pressing, stuck)
    share_out(nodes, centre, shape, False, weight)
    part = pressed_part(dry, law, pressing, start.force, holding)
    for i in range(weight.shape[0]):
        for j in range(weight.shape[1]):
            tangent[i, j] *= part
            weight[i, j] = (1.0 - part) * weight[i, j] + tangent[i, j]
    return holding
