"""A soft matrix with fibres that are recruited late, Eq. (65), in the manner of Holzapfel and co-workers.

Wavy collagen bears nothing until it is straight; from there tension rises sharply, as of rectum stretched to more than
twice its resting length. The exponent is a cube of the strain, so that tension and slope are smooth where it begins.
"""

from __future__ import annotations

from typing import NamedTuple

from ...declared import number
from ...numerics.compiled import inlined
from ...numerics.exponential import exponential

KIND = "law"
NAME = "late_fibres"
TITLE = "neo-Hookean matrix and fibres recruited from about twice the resting length"

PARAMETERS = (
    number("matrix", 24.4, "mN/cm", "shear modulus times thickness of the matrix", tag="calibrated",
           source="passive stress 4.9 kPa of rabbit distal colon at its best length (abstract, scilit 050a76a1), read "
           "as a stretch of 1.5 around at 1 along, times a wall of 0.6 mm (rat colon, PMC3653021, table 1)",
           lowest=0.01, highest=1e6),
    number("fibres", 566.0, "mN/cm", "stiffness of the fibres", tag="calibrated",
           source="slope 0.63 MPa (human colon, around, Massalou 2019, J Biomech 91:102, abstract) times a wall of 0.6 "
           "mm (rat colon, PMC3653021, table 1), read at a stretch of 2.75, a quarter beyond the onset",
           lowest=0.0, highest=1e6),
    number("sharpness", 1.0, "1", "how fast the fibres stiffen", tag="chosen", lowest=1e-6, highest=1e3),
    number("recruitment", 2.0, "1", "stretch of a fibre at which it is straight", tag="sourced",
           source="tension of human rectum, around, rises sharply only from 200 to 380 % of the resting length "
           "(Glavind 1993, AJP 265:G792, abstract); the lower end", lowest=1.0, highest=8.0),
    number("around", 0.8, "1", "share of a fibre's squared length that lies around the tube: the squared sine of its "
           "angle with the axis", tag="chosen", lowest=0.0, highest=1.0),
)  # fmt: skip

LARGEST_EXPONENT = 50.0
"""Trial states beyond are refused."""
LIMIT = "the exponential of Eq. (65) ends (e^50)"


class PassiveConstants(NamedTuple):
    """Eq. (65): matrix and fibres in mN/cm, the others without unit."""

    matrix: float
    fibres: float
    sharpness: float
    recruitment: float
    around: float


@inlined
def _excess(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    """By how much the squared length of a fibre is beyond that at which it is straight, as a share, or 0."""
    length = (1.0 - c.around) * longitudinal * longitudinal + c.around * circumferential * circumferential
    return max(length / (c.recruitment * c.recruitment) - 1.0, 0.0)


@inlined
def admissible(longitudinal: float, circumferential: float, c: PassiveConstants) -> bool:
    """Whether the exponent of Eq. (65) is in range at two stretches."""
    x = _excess(longitudinal, circumferential, c)
    return c.sharpness * x * x * x <= LARGEST_EXPONENT


@inlined
def strain_energy(longitudinal: float, circumferential: float, c: PassiveConstants) -> float:
    """Strain energy per undeformed area [mN/cm] at two stretches, Eq. (65)."""
    ll, cc = longitudinal * longitudinal, circumferential * circumferential
    x = _excess(longitudinal, circumferential, c)
    straight = c.fibres / c.sharpness * (exponential(c.sharpness * x * x * x) - 1.0)
    return 0.5 * c.matrix * (ll + cc + 1.0 / (ll * cc) - 3.0) + straight


@inlined
def passive_tension(
    longitudinal: float, circumferential: float, c: PassiveConstants
) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) [mN/cm], Eq. (65)."""
    per_l, per_c = 1.0 / longitudinal, 1.0 / circumferential
    thinning = per_l * per_l * per_c * per_c
    x = _excess(longitudinal, circumferential, c)
    cube = x * x * x
    g = c.fibres * exponential(min(c.sharpness * cube, LARGEST_EXPONENT))
    first, second = g * 3.0 * x * x, g * (6.0 * x + 9.0 * c.sharpness * x * cube)
    unit = 2.0 / (c.recruitment * c.recruitment)
    along, around = (1.0 - c.around) * unit, c.around * unit
    xl, xc = along * longitudinal, around * circumferential
    return (
        c.matrix * (longitudinal - thinning * per_l) + first * xl,
        c.matrix * (circumferential - thinning * per_c) + first * xc,
        c.matrix * (1.0 + 3.0 * thinning * per_l * per_l) + second * xl * xl + first * along,
        2.0 * c.matrix * thinning * per_l * per_c + second * xl * xc,
        c.matrix * (1.0 + 3.0 * thinning * per_c * per_c) + second * xc * xc + first * around,
    )
