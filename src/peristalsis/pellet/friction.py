"""Viscous and dry friction on the pellet, Eqs. (13), (27), (50), (51), (124) and (125)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .shapes.sphere import ShapeConstants, gap_and_normal


class FrictionLaw(NamedTuple):
    """Friction beyond Eq. (13): static over kinetic friction, Eq. (50), shares of the pressing, Eqs. (51) and (124).

    coefficient: of dry friction [1]; viscous_coefficient: of the viscous one [s/cm]. The defaults are Eq. (13) itself.
    """

    static_factor: float = 1.0
    coefficient: float = 0.0
    viscous_coefficient: float = 0.0

    @property
    def presses(self) -> bool:
        """Whether any of it is in proportion to pressing."""
        return self.coefficient > 0.0 or self.viscous_coefficient > 0.0


CONSTANT = FrictionLaw()
"""Dry friction as printed: one force, at rest and sliding."""


class Nodes(NamedTuple):
    """What presses on the pellet: contact [mN/cm^2] (n, m) of nodes at `position` (n, m, 3), `area` [cm^2] each."""

    contact: np.ndarray
    position: np.ndarray
    area: float


class Start(NamedTuple):
    """The pellet as a step begins: its centre [cm], and whether it rests against the friction frame.

    force: axial, of the wall, less the pull of a load [mN].
    """

    centre: float
    force: float
    stuck: bool


class Held(NamedTuple):
    """Friction that holds over a step: viscous [mN s/cm] and dry [mN]."""

    viscous: float
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
def falling_velocity(
    force: float, viscous: float, dry: float, fast_share: float, fall_speed: float, sliding: bool
) -> tuple[float, float]:
    """As `sliding_velocity`, where dry friction falls with the speed v to a share of itself, Eq. (125).

    dry friction is dry (s + (1 - s)/(1 + v/v0)), with s = `fast_share` and v0 = `fall_speed` [cm/s]. Where the whole
    falls with v, two speeds belong to one force: a pellet that is `sliding` keeps the faster one as long as there is
    one, one at rest stays there up to the dry friction.
    """
    size = abs(force)
    if fast_share >= 1.0 or dry == 0.0:
        return sliding_velocity(force, viscous, dry)
    if size <= dry and not sliding:
        return 0.0, 0.0
    linear = viscous * fall_speed + dry * fast_share - size
    under = linear * linear - 4.0 * viscous * fall_speed * (dry - size)
    if under <= 0.0:
        return 0.0, 0.0
    root = math.sqrt(under)
    speed = 0.5 * (root - linear) / viscous
    if speed <= 0.0:
        return 0.0, 0.0
    return math.copysign(speed, force), (speed + fall_speed) / root


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
def pressed_part(
    dry: float, law: FrictionLaw, pressing: float, force: float, holding: float, viscous: float = 1.0
) -> float:
    """The part of the whole friction that is in proportion to pressing, Eqs. (51) and (124): from 0 to 1.

    dry, pressing, holding [mN]: F_d, N and the dry friction in all, with its static factor. force [mN]: the whole
    friction, viscous and dry, for the pellet has no inertia. viscous: eta [mN s/cm]. It vanishes with the coefficients.
    """
    if law.viscous_coefficient > 0.0:
        thick = law.viscous_coefficient * pressing
        kinetic = dry + law.coefficient * pressing
        dry_part = law.coefficient * pressing / kinetic if kinetic > 0.0 else 0.0
        size = abs(force)
        if size <= holding:
            return dry_part if kinetic > 0.0 else thick / (thick + viscous)
        return (dry_part * holding + thick / (thick + viscous) * (size - holding)) / size
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
) -> Held:
    """Friction that holds over a step, from the contact at its start; `shares` receives those of the nodes.

    Friction in proportion to pressing, Eqs. (51) and (124), lies along the meridian; the rest is axial.
    """
    weight, tangent, centre = shares.weight, shares.tangent, start.centre
    if law.coefficient <= 0.0 and law.viscous_coefficient <= 0.0:
        tangent[:] = 0.0
        pressing = nodes.area * share_out(nodes, centre, shape, False, weight)
        return Held(viscous, dry_friction(dry, law, pressing, start.stuck))
    pressing = nodes.area * share_out(nodes, centre, shape, True, tangent)
    holding = dry_friction(dry, law, pressing, start.stuck)
    share_out(nodes, centre, shape, False, weight)
    part = pressed_part(dry, law, pressing, start.force, holding, viscous)
    for i in range(weight.shape[0]):
        for j in range(weight.shape[1]):
            tangent[i, j] *= part
            weight[i, j] = (1.0 - part) * weight[i, j] + tangent[i, j]
    return Held(viscous + law.viscous_coefficient * pressing, holding)
