"""Viscous and dry friction on the pellet, Eqs. (13) and (27)."""

from __future__ import annotations

from ..numerics.compiled import compiled


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


def speed_at(force: float, viscous: float, dry: float) -> float:
    """`sliding_velocity` without its derivative."""
    velocity: float = sliding_velocity(force, viscous, dry)[0]
    return velocity
