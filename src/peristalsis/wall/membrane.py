"""Tensions of the wall at one corner of an element, Eq. (2) with (3)-(5), (14), (15), (35) and (36).

Linear elements along z with corner quadrature: the longitudinal stretch belongs to an element, the circumferential
one, rho/r0, to a node; each element has two corners of weight h/2. Forces on the nodes are in `assembly`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.blend import floored, fold_resistance, positive_part
from ..numerics.compiled import compiled, inlined
from .active import ActiveConstants, active_tension
from .passive import PassiveConstants, passive_tension

SMALLEST_STRETCH, LARGEST_STRETCH = 0.02, 8.0
"""Trial states outside are refused by the solver."""


class WallConstants(NamedTuple):
    """Everything the wall needs, in mN, cm, s, mV; `published` picks the tension convention of Eq. (35)."""

    radius: float
    element_size: float
    viscosity: float
    surface_density: float
    bending_stiffness: float
    bending_viscosity: float
    slack_blend: float
    slack_slope: float
    fold_stretch: float
    fold_tension: float
    published: bool
    passive: PassiveConstants
    longitudinal: ActiveConstants
    circular: ActiveConstants


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

    Rates are stretch rates [1/s], rate_slope their derivative by the stretch [1/s]; drives are factor * phi+ [mV].
    """
    wl, wc, wll, wlc, wcc = passive_tension(longitudinal, circumferential, c.passive)
    pl, dpl = positive_part(wl, c.slack_blend)
    pc, dpc = positive_part(wc, c.slack_blend)
    al, dal = active_tension(longitudinal, c.longitudinal)
    ac, dac = active_tension(circumferential, c.circular)
    tl, dl = floored(c.viscosity * rate_longitudinal + drive_longitudinal * al + pl, c.slack_blend, c.slack_slope)
    tc, dc = floored(c.viscosity * rate_circumferential + drive_circular * ac + pc, c.slack_blend, c.slack_slope)
    viscous = c.viscosity * rate_slope
    fold_l, dfold_l = fold_resistance(longitudinal, c.fold_stretch, c.fold_tension)
    fold_c, dfold_c = fold_resistance(circumferential, c.fold_stretch, c.fold_tension)
    tl += fold_l
    tc += fold_c
    tll = dl * (viscous + drive_longitudinal * dal + dpl * wll) + dfold_l
    tlc = dl * dpl * wlc
    tcl = dc * dpc * wlc
    tcc = dc * (viscous + drive_circular * dac + dpc * wcc) + dfold_c
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
def tension_parts(
    stretch: float,
    hoop: float,
    stretch_rate: float,
    hoop_rate: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float, float, float]:
    """The PARTS of Eq. (2) at one corner [mN/cm], in their order; the totals after the floor of Eq. (15)."""
    wl, wc, _, _, _ = passive_tension(stretch, hoop, c.passive)
    passive_l, _ = positive_part(wl, c.slack_blend)
    passive_c, _ = positive_part(wc, c.slack_blend)
    muscle_l, _ = active_tension(stretch, c.longitudinal)
    muscle_c, _ = active_tension(hoop, c.circular)
    active_l, active_c = drive_longitudinal * muscle_l, drive_circular * muscle_c
    viscous_l, viscous_c = c.viscosity * stretch_rate, c.viscosity * hoop_rate
    total_l, _ = floored(passive_l + active_l + viscous_l, c.slack_blend, c.slack_slope)
    total_c, _ = floored(passive_c + active_c + viscous_c, c.slack_blend, c.slack_slope)
    fold_l, _ = fold_resistance(stretch, c.fold_stretch, c.fold_tension)
    fold_c, _ = fold_resistance(hoop, c.fold_stretch, c.fold_tension)
    return passive_l, active_l, viscous_l, total_l + fold_l, passive_c, active_c, viscous_c, total_c + fold_c


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
