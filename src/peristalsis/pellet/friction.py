"""Viscous and dry friction on the pellet, Eqs. (13), (27), (50) and (51)."""

from __future__ import annotations

from typing import NamedTuple

from ..numerics.compiled import compiled


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
def dry_friction(dry: float, law: FrictionLaw, pressing: float, stuck: bool) -> float:
    """Dry friction [mN] that must be overcome over a step, Eqs. (50) and (51).

    dry: F_d [mN]. pressing: the contact force across the axis [mN], sum of Q n_rho over the nodes. stuck: whether the
    pellet rests against the friction frame when the step begins.
    """
    kinetic = dry + law.coefficient * pressing if law.coefficient > 0.0 else dry
    return kinetic * law.static_factor if stuck else kinetic
