"""Residual and tangent of the axisymmetric wall, Eq. (1) with (2)-(5), (14)-(16) and (35).

Linear elements along z with corner quadrature: the longitudinal stretch belongs to an element, the circumferential
one, rho/r0, to a node; each element has two corners of weight h/2. Forces are per 2*pi*r0, i.e. [mN/cm].
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.banded import HALF_WIDTH
from ..numerics.blend import floored, fold_resistance, positive_part
from ..numerics.compiled import compiled
from .active import ActiveConstants, active_tension
from .passive import LARGEST_EXPONENT, PassiveConstants, passive_tension

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
    for e in range(rho.size - 1):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        out[e] = math.sqrt(dr * dr + dz * dz) / element_size
        if not (SMALLEST_STRETCH < out[e] < LARGEST_STRETCH):
            return False
    return True


@compiled
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
    if c.published:
        return (
            tl * circumferential,
            tc * longitudinal,
            tll * circumferential,
            tlc * circumferential + tl,
            tcl * longitudinal + tc,
            tcc * longitudinal,
        )
    return tl, tc, tll, tlc, tcl, tcc


@compiled
def assemble_wall(
    rho: np.ndarray,
    zeta: np.ndarray,
    history: np.ndarray,
    stretch_history: np.ndarray,
    hoop_history: np.ndarray,
    rate_slope: float,
    drive_longitudinal: np.ndarray,
    drive_circular: np.ndarray,
    c: WallConstants,
    residual: np.ndarray,
    matrix: np.ndarray,
) -> bool:
    """Internal forces of the wall and their tangent, added into `residual` (2n,) and `matrix` (at least 2n, 11).

    rho, zeta: nodes [cm], (n,). Histories: positions (2, n), stretches of element and node from which rates are
    formed, Eq. (32). Drives of half elements [mV], (2n - 2,): each corner has its own. Unknown 2i is rho, 2i+1 zeta
    of node i. False when a trial state is out of range.
    """
    n = rho.size
    h = c.element_size
    half = 0.5 * h
    for e in range(n - 1):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        length = math.sqrt(dr * dr + dz * dz)
        stretch = length / h
        if not (SMALLEST_STRETCH < stretch < LARGEST_STRETCH):
            return False
        tr = dr / length
        tz = dz / length
        rate_l = (stretch - stretch_history[e]) * rate_slope
        axial = 0.0
        axial_slope = 0.0
        for corner in range(2):
            i = e + corner
            hoop = rho[i] / c.radius
            if not (SMALLEST_STRETCH < hoop < LARGEST_STRETCH):
                return False
            el = stretch - 1.0
            ec = hoop - 1.0
            p = c.passive
            if p.c4 * el * el + p.c5 * ec * ec + 2.0 * p.c6 * el * ec > LARGEST_EXPONENT:
                return False
            nl, nc, nll, nlc, ncl, ncc = nominal_tensions(
                stretch,
                hoop,
                rate_l,
                (hoop - hoop_history[i]) * rate_slope,
                rate_slope,
                drive_longitudinal[2 * e + corner],
                drive_circular[2 * e + corner],
                c,
            )
            axial += half * nl
            axial_slope += half * nll
            residual[2 * i] += half * nc / c.radius
            matrix[2 * i, HALF_WIDTH] += half * ncc / (c.radius * c.radius)
            along = half * nlc / (h * c.radius)
            across = half * ncl / (h * c.radius)
            # Axial force of this corner changes with rho_i; hoop force of this corner changes with the stretch.
            column = 2 * i
            row = 2 * e
            matrix[row, HALF_WIDTH + column - row] -= along * tr
            matrix[row + 1, HALF_WIDTH + column - row - 1] -= along * tz
            matrix[row + 2, HALF_WIDTH + column - row - 2] += along * tr
            matrix[row + 3, HALF_WIDTH + column - row - 3] += along * tz
            matrix[column, HALF_WIDTH + row - column] -= across * tr
            matrix[column, HALF_WIDTH + row + 1 - column] -= across * tz
            matrix[column, HALF_WIDTH + row + 2 - column] += across * tr
            matrix[column, HALF_WIDTH + row + 3 - column] += across * tz
        force = axial / h
        residual[2 * e] -= force * tr
        residual[2 * e + 1] -= force * tz
        residual[2 * e + 2] += force * tr
        residual[2 * e + 3] += force * tz
        stiff = axial_slope / (h * h)
        turn = force / length
        krr = stiff * tr * tr + turn * tz * tz
        krz = (stiff - turn) * tr * tz
        kzz = stiff * tz * tz + turn * tr * tr
        for a in range(2):
            for b in range(2):
                sign = 1.0 if a == b else -1.0
                row = 2 * (e + a)
                column = 2 * (e + b)
                matrix[row, HALF_WIDTH + column - row] += sign * krr
                matrix[row, HALF_WIDTH + column + 1 - row] += sign * krz
                matrix[row + 1, HALF_WIDTH + column - row - 1] += sign * krz
                matrix[row + 1, HALF_WIDTH + column - row] += sign * kzz
    if c.bending_stiffness > 0.0 or c.bending_viscosity > 0.0:
        _assemble_bending(rho, zeta, history, rate_slope, c, residual, matrix)
    return True


@compiled
def _assemble_bending(
    rho: np.ndarray,
    zeta: np.ndarray,
    history: np.ndarray,
    rate_slope: float,
    c: WallConstants,
    residual: np.ndarray,
    matrix: np.ndarray,
) -> None:
    """Bending regulariser, Eq. (16): second differences of the position cost energy, their rates dissipate."""
    elastic = c.bending_stiffness / c.element_size**3
    viscous = c.bending_viscosity * rate_slope / c.element_size**3
    factor = elastic + viscous
    weight = (1.0, -2.0, 1.0)
    for i in range(1, rho.size - 1):
        second_r = rho[i - 1] - 2.0 * rho[i] + rho[i + 1]
        second_z = zeta[i - 1] - 2.0 * zeta[i] + zeta[i + 1]
        force_r = factor * second_r - viscous * (history[0, i - 1] - 2.0 * history[0, i] + history[0, i + 1])
        force_z = factor * second_z - viscous * (history[1, i - 1] - 2.0 * history[1, i] + history[1, i + 1])
        for a in range(3):
            row = 2 * (i - 1 + a)
            residual[row] += weight[a] * force_r
            residual[row + 1] += weight[a] * force_z
            for b in range(3):
                column = 2 * (i - 1 + b)
                value = factor * weight[a] * weight[b]
                matrix[row, HALF_WIDTH + column - row] += value
                matrix[row + 1, HALF_WIDTH + column - row] += value


@compiled
def assemble_pressure(
    rho: np.ndarray,
    zeta: np.ndarray,
    pressure: float,
    c: WallConstants,
    gradient: np.ndarray,
    residual: np.ndarray,
    matrix: np.ndarray,
) -> None:
    """Subtract the pressure force p dV/dx from `residual` and its tangent; `gradient` receives dV/dx / (2 pi r0)."""
    unit = math.pi / 3.0 / (2.0 * math.pi * c.radius)
    gradient[:] = 0.0
    for e in range(rho.size - 1):
        a = rho[e]
        b = rho[e + 1]
        length = zeta[e + 1] - zeta[e]
        area = a * a + a * b + b * b
        i = 2 * e
        ga = unit * (2.0 * a + b) * length
        gb = unit * (a + 2.0 * b) * length
        gz = unit * area
        gradient[i] += ga
        gradient[i + 2] += gb
        gradient[i + 1] -= gz
        gradient[i + 3] += gz
        da = pressure * unit * (2.0 * a + b)
        db = pressure * unit * (a + 2.0 * b)
        dl = pressure * unit * length
        matrix[i, HALF_WIDTH] -= 2.0 * dl
        matrix[i, HALF_WIDTH + 2] -= dl
        matrix[i + 2, HALF_WIDTH - 2] -= dl
        matrix[i + 2, HALF_WIDTH] -= 2.0 * dl
        matrix[i, HALF_WIDTH + 1] += da
        matrix[i, HALF_WIDTH + 3] -= da
        matrix[i + 2, HALF_WIDTH - 1] += db
        matrix[i + 2, HALF_WIDTH + 1] -= db
        matrix[i + 1, HALF_WIDTH - 1] += da
        matrix[i + 3, HALF_WIDTH - 3] -= da
        matrix[i + 1, HALF_WIDTH + 1] += db
        matrix[i + 3, HALF_WIDTH - 1] -= db
    for k in range(residual.size):
        residual[k] -= pressure * gradient[k]


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
    """The parts of Eq. (2) at one corner [mN/cm] into `parts` (8,); the totals after the floor of Eq. (15)."""
    wl, wc, _, _, _ = passive_tension(stretch, hoop, c.passive)
    parts[PASSIVE_LONGITUDINAL] = positive_part(wl, c.slack_blend)[0]
    parts[PASSIVE_CIRCULAR] = positive_part(wc, c.slack_blend)[0]
    parts[ACTIVE_LONGITUDINAL] = drive_longitudinal * active_tension(stretch, c.longitudinal)[0]
    parts[ACTIVE_CIRCULAR] = drive_circular * active_tension(hoop, c.circular)[0]
    parts[VISCOUS_LONGITUDINAL] = c.viscosity * stretch_rate
    parts[VISCOUS_CIRCULAR] = c.viscosity * hoop_rate
    for total in (TOTAL_LONGITUDINAL, TOTAL_CIRCULAR):
        carried = parts[total - 3] + parts[total - 2] + parts[total - 1]
        parts[total] = floored(carried, c.slack_blend, c.slack_slope)[0]
    parts[TOTAL_LONGITUDINAL] += fold_resistance(stretch, c.fold_stretch, c.fold_tension)[0]
    parts[TOTAL_CIRCULAR] += fold_resistance(hoop, c.fold_stretch, c.fold_tension)[0]


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
