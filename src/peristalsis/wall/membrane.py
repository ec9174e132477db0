"""Tensions of the wall at one corner of an element, Eq. (2) with (3)-(5), (14), (15), (35) and (36).

Linear elements along z with corner quadrature: the longitudinal stretch belongs to an element, the circumferential
one, rho/r0, to a node; each element has two corners of weight h/2. Forces on the nodes are in `assembly`.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.blend import floored, fold_resistance, positive_part
from ..numerics.compiled import compiled, inlined
from .active import active_tension
from .constants import WallConstants
from .passive import passive_tension

SMALLEST_STRETCH, LARGEST_STRETCH = 0.02, 8.0
"""Trial states outside are refused by the solver, whatever the law; a law may end earlier (`passive.admissible`)."""


@compiled
def element_stretch(rho: np.ndarray, zeta: np.ndarray, element_size: float, out: np.ndarray) -> bool:
    """Longitudinal stretch of every element into `out`; False when a stretch leaves the allowed range."""
    good = 0
    for e in range(rho.size - 1):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        stretch = math.sqrt(dr * dr + dz * dz) / element_size
        out[e] = stretch
        good += 1 if (stretch > SMALLEST_STRETCH) & (stretch < LARGEST_STRETCH) else 0
    return good >= rho.size - 1


PARTS = 8
(
    PASSIVE_LONGITUDINAL,
    ACTIVE_LONGITUDINAL,
    VISCOUS_LONGITUDINAL,
    TOTAL_LONGITUDINAL,
    PASSIVE_CIRCULAR,
    ACTIVE_CIRCULAR,
    VISCOUS_CIRCULAR,
    TOTAL_CIRCULAR,
) = range(PARTS)


@inlined
def carried(one: float, two: float, three: float, fold: float, c: WallConstants) -> tuple[float, float]:
    """What the shell carries of a sum of tensions, Eq. (15), with its fold, Eq. (36), and the slope by the sum."""
    value, slope = floored(one + two + three, c.slack_blend, c.slack_slope)
    return value + fold, slope


@inlined
def before_floor(
    longitudinal: float,
    circumferential: float,
    rate_longitudinal: float,
    rate_circumferential: float,
    rate_slope: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float]:
    """Passive, active and viscous tension along, then around; slopes of their sums; W_lc and the blends' slopes.

    (P_l, A_l, V_l, P_c, A_c, V_c, S_ll, S_cc, W_lc, b_l, b_c): S_lc = b_l W_lc and S_cl = b_c W_lc. For the arguments
    see `tensions`.
    """
    wl, wc, wll, wlc, wcc = passive_tension(longitudinal, circumferential, c.passive)
    pl, dpl = positive_part(wl, c.slack_blend)
    pc, dpc = positive_part(wc, c.slack_blend)
    ml, dml = active_tension(longitudinal, c.longitudinal)
    mc, dmc = active_tension(circumferential, c.circular)
    vl, vc = c.viscosity * rate_longitudinal, c.viscosity * rate_circumferential
    al, ac = drive_longitudinal * ml, drive_circular * mc
    viscous = c.viscosity * rate_slope
    sll = viscous + drive_longitudinal * dml + dpl * wll
    scc = viscous + drive_circular * dmc + dpc * wcc
    return pl, al, vl, pc, ac, vc, sll, scc, wlc, dpl, dpc


@inlined
def tensions(
    longitudinal: float,
    circumferential: float,
    rate_longitudinal: float,
    rate_circumferential: float,
    rate_slope: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float, float]:
    """The PARTS of Eq. (2) at one corner [mN/cm] in their order, then T_ll, T_lc, T_cl, T_cc of the totals.

    Totals after the floor of Eq. (15), with the folds of Eq. (36). Rates are stretch rates [1/s], rate_slope their
    derivative by the stretch [1/s]; drives are factor * phi+ [mV]. This is the one place where the tensions are
    added up: what a caller does not read, the compiler drops.
    """
    pl, al, vl, pc, ac, vc, sll, scc, wlc, dpl, dpc = before_floor(
        longitudinal,
        circumferential,
        rate_longitudinal,
        rate_circumferential,
        rate_slope,
        drive_longitudinal,
        drive_circular,
        c,
    )
    fold_l, dfold_l = fold_resistance(longitudinal, c.fold_stretch, c.fold_tension)
    fold_c, dfold_c = fold_resistance(circumferential, c.fold_stretch, c.fold_tension)
    tl, dl = carried(vl, al, pl, fold_l, c)
    tc, dc = carried(vc, ac, pc, fold_c, c)
    return (
        pl,
        al,
        vl,
        tl,
        pc,
        ac,
        vc,
        tc,
        dl * sll + dfold_l,
        dl * dpl * wlc,
        dc * dpc * wlc,
        dc * scc + dfold_c,
    )


@inlined
def nominal_tensions(
    longitudinal: float,
    circumferential: float,
    rate_longitudinal: float,
    rate_circumferential: float,
    rate_slope: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float]:
    """(N_l, N_c, N_ll, N_lc, N_cl, N_cc) at one corner: work conjugates of the stretches and their derivatives.

    From the totals of `tensions` by the convention of Eq. (35).
    """
    _, _, _, tl, _, _, _, tc, tll, tlc, tcl, tcc = tensions(
        longitudinal,
        circumferential,
        rate_longitudinal,
        rate_circumferential,
        rate_slope,
        drive_longitudinal,
        drive_circular,
        c,
    )
    across_l = circumferential if c.published else 1.0
    across_c = longitudinal if c.published else 1.0
    turned = 1.0 if c.published else 0.0
    return (
        tl * across_l,
        tc * across_c,
        tll * across_l,
        tlc * across_l + turned * tl,
        tcl * across_c + turned * tc,
        tcc * across_c,
    )


@inlined
def tension_parts(
    stretch: float,
    hoop: float,
    stretch_rate: float,
    hoop_rate: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float, float, float]:
    """The PARTS of Eq. (2) at one corner [mN/cm], in their order; see `tensions`.

    The totals are added up in the order of the parts, as recorded runs have them: a reader's sum gives the same bits.
    """
    pl, al, vl, _, pc, ac, vc, _, _, _, _, _ = tensions(
        stretch, hoop, stretch_rate, hoop_rate, 0.0, drive_longitudinal, drive_circular, c
    )
    tl, _ = carried(pl, al, vl, fold_resistance(stretch, c.fold_stretch, c.fold_tension)[0], c)
    tc, _ = carried(pc, ac, vc, fold_resistance(hoop, c.fold_stretch, c.fold_tension)[0], c)
    return pl, al, vl, tl, pc, ac, vc, tc


@compiled
def corner_tension(
    stretch: float,
    hoop: float,
    stretch_rate: float,
    hoop_rate: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
    parts: np.ndarray,
) -> None:
    """`tension_parts` into `parts` (8,)."""
    found = tension_parts(stretch, hoop, stretch_rate, hoop_rate, drive_longitudinal, drive_circular, c)
    for k in range(PARTS):
        parts[k] = found[k]


@compiled
def wall_tension(
    rho: np.ndarray,
    zeta: np.ndarray,
    stretch_rate: np.ndarray,
    hoop_rate: np.ndarray,
    drive_longitudinal: np.ndarray,
    drive_circular: np.ndarray,
    c: WallConstants,
    corners: np.ndarray,
) -> None:
    """All parts of the tension [mN/cm] at the two corners of every element into `corners` (n - 1, 2, 8)."""
    for e in range(rho.size - 1):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        stretch = math.sqrt(dr * dr + dz * dz) / c.element_size
        for corner in range(2):
            i = e + corner
            corner_tension(
                stretch,
                rho[i] / c.radius,
                stretch_rate[e],
                hoop_rate[i],
                drive_longitudinal[2 * e + corner],
                drive_circular[2 * e + corner],
                c,
                corners[e, corner],
            )
