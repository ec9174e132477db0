"""The paper's passive wall, Eqs. (3) and (4): a quadratic energy and an exponential of the strains.

Its constants are the configuration's wall.c1 ... wall.c10, with their sources in `parameters`.
"""

from __future__ import annotations

from typing import NamedTuple

from ...numerics.compiled import inlined
from ...numerics.exponential import exponential

KIND = "law"
NAME = "tong_fung"
TITLE = "quadratic and exponential in the strains, after Tong and Fung (the paper's)"

LARGEST_EXPONENT = 50.0
"""Beyond this the exponential of Eq. (4) means a wall torn long ago; trial states there are refused."""
LIMIT = f"the exponential of Eq. (4) ends (e^{LARGEST_EXPONENT:g})"
STIFFER_ALONG = "wall.c1, wall.c3, wall.c6"
STIFFER_AROUND = "wall.c2, wall.c5, wall.c10"


class PassiveConstants(NamedTuple):
    """Constants of Eq. (4): c1, c2, c3, c10 in mN/cm; c4, c5, c6 without unit."""

    c1: float
    c2: float
    c3: float
    c4: float
    c5: float
    c6: float
    c10: float


@inlined
def admissible(longitudinal: float, circumferential: float, c: PassiveConstants) -> bool:
    """Whether the exponent of Eq. (4) is in range at two stretches."""
    el = longitudinal - 1.0
    ec = circumferential - 1.0
    return c.c4 * el * el + c.c5 * ec * ec + 2.0 * c.c6 * el * ec <= LARGEST_EXPONENT


@inlined
def strain_energy(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    """Strain energy per undeformed area [mN/cm] at two stretches, Eq. (4)."""
    el = longitudinal - 1.0
    ec = circumferential - 1.0
    exponent = c.c4 * el * el + c.c5 * ec * ec + 2.0 * c.c6 * el * ec
    return 0.5 * (c.c1 * el * el + 2.0 * c.c3 * el * ec + c.c2 * ec * ec) + c.c10 * exponential(exponent)


@inlined
def passive_tension(
    longitudinal: float, circumferential: float, c: PassiveConstants
) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) [mN/cm]: first and second derivatives of the energy by the strains, Eq. (3)."""
    el = longitudinal - 1.0
    ec = circumferential - 1.0
    exponent = c.c4 * el * el + c.c5 * ec * ec + 2.0 * c.c6 * el * ec
    g = c.c10 * exponential(min(exponent, LARGEST_EXPONENT))
    gl = 2.0 * (c.c4 * el + c.c6 * ec)
    gc = 2.0 * (c.c5 * ec + c.c6 * el)
    return (
        c.c1 * el + c.c3 * ec + g * gl,
        c.c3 * el + c.c2 * ec + g * gc,
        c.c1 + g * (gl * gl + 2.0 * c.c4),
        c.c3 + g * (gl * gc + 2.0 * c.c6),
        c.c2 + g * (gc * gc + 2.0 * c.c5),
    )
