"""Fung's exponential wall, Eq. (64): orthotropic in the Green strains, with coupling of the two directions."""

from __future__ import annotations

from typing import NamedTuple

from ...declared import number
from ...numerics.compiled import inlined
from ...numerics.exponential import exponential

KIND = "law"
NAME = "fung"
TITLE = "Fung's exponential of the Green strains, coupled"

PARAMETERS = (
    number("stiffness", 628.0, "mN/cm", "factor on the exponential", tag="calibrated",
           source="with `around`: 32 kPa of rabbit proximal colon at its best length (abstract, scilit 050a76a1), read "
           "as a stretch of 1.5, and a slope of 0.63 MPa (human colon, Massalou 2019, J Biomech 91:102, abstract), "
           "read at a stretch of 2, both at 1 along and times a wall of 0.6 mm (rat colon, PMC3653021, table 1)",
           lowest=1e-6, highest=1e6),
    number("along", 0.813, "1", "weight of the longitudinal strain in the exponent", tag="calibrated",
           source="`around` times 1.76/0.63, the moduli of human colon (Massalou 2019, J Biomech 91:102, abstract)",
           lowest=0.0, highest=100.0),
    number("around", 0.291, "1", "weight of the circumferential strain in the exponent", tag="calibrated",
           source="see `stiffness`", lowest=0.0, highest=100.0),
    number("coupling", 0.1, "1", "weight of the product of both strains; convex below the root of along times around",
           tag="chosen", lowest=0.0, highest=100.0),
)  # fmt: skip

LARGEST_EXPONENT = 50.0
"""Trial states beyond are refused."""
LIMIT = "the exponential of Eq. (64) ends (e^50)"
STIFFER_ALONG = "wall.fung.stiffness, wall.fung.along"
STIFFER_AROUND = "wall.fung.stiffness, wall.fung.around"


class PassiveConstants(NamedTuple):
    """Eq. (64): stiffness in mN/cm, weights in the exponent without unit."""

    stiffness: float
    along: float
    around: float
    coupling: float


@inlined
def _exponent(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    el = 0.5 * (longitudinal * longitudinal - 1.0)
    ec = 0.5 * (circumferential * circumferential - 1.0)
    return c.along * el * el + c.around * ec * ec + 2.0 * c.coupling * el * ec


@inlined
def admissible(longitudinal: float, circumferential: float, c: PassiveConstants) -> bool:
    """Whether the exponent of Eq. (64) is in range at two stretches."""
    return _exponent(longitudinal, circumferential, c) <= LARGEST_EXPONENT


@inlined
def strain_energy(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    """Strain energy per undeformed area [mN/cm] at two stretches, Eq. (64)."""
    return 0.5 * c.stiffness * (exponential(_exponent(longitudinal, circumferential, c)) - 1.0)


@inlined
def passive_tension(
    longitudinal: float, circumferential: float, c: PassiveConstants
) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) [mN/cm], Eq. (64)."""
    el = 0.5 * (longitudinal * longitudinal - 1.0)
    ec = 0.5 * (circumferential * circumferential - 1.0)
    g = c.stiffness * exponential(min(_exponent(longitudinal, circumferential, c), LARGEST_EXPONENT))
    # Half the slopes of the exponent by the Green strains, then by the stretches.
    along, around = c.along * el + c.coupling * ec, c.around * ec + c.coupling * el
    by_l, by_c = along * longitudinal, around * circumferential
    return (
        g * by_l,
        g * by_c,
        g * (2.0 * by_l * by_l + along + c.along * longitudinal * longitudinal),
        g * (2.0 * by_l * by_c + c.coupling * longitudinal * circumferential),
        g * (2.0 * by_c * by_c + around + c.around * circumferential * circumferential),
    )
