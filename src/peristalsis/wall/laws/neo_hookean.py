"""A rubber-like wall, Eq. (63): neo-Hookean, incompressible, in plane stress; one constant."""

from __future__ import annotations

from typing import NamedTuple

from ...declared import number
from ...numerics.compiled import inlined

KIND = "law"
NAME = "neo_hookean"
TITLE = "neo-Hookean membrane, one constant"

PARAMETERS = (
    number("stiffness", 24.4, "mN/cm", "shear modulus times thickness of the wall", tag="calibrated",
           source="passive stress 4.9 kPa of rabbit distal colon at its best length (abstract, scilit 050a76a1), read "
           "as a stretch of 1.5 around at 1 along, times a wall of 0.6 mm (rat colon, PMC3653021, table 1)",
           lowest=0.01, highest=1e6),
)  # fmt: skip


class PassiveConstants(NamedTuple):
    """Eq. (63): stiffness in mN/cm."""

    stiffness: float


@inlined
def strain_energy(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    """Strain energy per undeformed area [mN/cm] at two stretches, Eq. (63)."""
    ll, cc = longitudinal * longitudinal, circumferential * circumferential
    return 0.5 * c.stiffness * (ll + cc + 1.0 / (ll * cc) - 3.0)


@inlined
def passive_tension(
    longitudinal: float, circumferential: float, c: PassiveConstants
) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) [mN/cm], Eq. (63)."""
    per_l, per_c = 1.0 / longitudinal, 1.0 / circumferential
    thinning = per_l * per_l * per_c * per_c
    return (
        c.stiffness * (longitudinal - thinning * per_l),
        c.stiffness * (circumferential - thinning * per_c),
        c.stiffness * (1.0 + 3.0 * thinning * per_l * per_l),
        2.0 * c.stiffness * thinning * per_l * per_c,
        c.stiffness * (1.0 + 3.0 * thinning * per_c * per_c),
    )
