"""Forces on the nodes of the axisymmetric wall and their tangent, Eqs. (1), (16) and (18).

Forces are per 2*pi*r0, i.e. [mN/cm]. One pass over the elements for each corner gives tensions and derivatives, one
over the nodes gathers forces; the tangent is gathered only where an iteration goes on. The passes hold no branch, so
that they run on vector registers, and they cover any stretch of the wall, so that a part of it can be solved by itself.

What they work on stands in two tables with a column for every node or element: KNOWN_ROWS rows of what a step knows
beforehand, and WALL_ROWS rows of results (a caller may add rows of its own to either).
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.block_band import DIAGONAL, FARTHEST, LAST, LOWER, UPPER
from ..numerics.compiled import INDEX, compiled
from .constants import WallConstants
from .membrane import LARGEST_STRETCH, SMALLEST_STRETCH, nominal_tensions
from .passive import admissible

(
    HISTORY_R,
    HISTORY_Z,
    HISTORY_STRETCH,
    HISTORY_HOOP,
    DRIVE_L_LEFT,
    DRIVE_L_RIGHT,
    DRIVE_C_LEFT,
    DRIVE_C_RIGHT,
) = range(8)
KNOWN_ROWS = 8
"""Rows of `known`: histories of Eq. (32) of places [cm] and stretches; drives [mV] at both corners of the elements."""

(
    FORCE_R,
    FORCE_Z,
    VOLUME_R,
    VOLUME_Z,
    STRETCH,
    TANGENT_R,
    TANGENT_Z,
    LEFT,
) = range(8)
RIGHT_CORNER = LEFT + 6
BENT_R, BENT_Z = RIGHT_CORNER + 6, RIGHT_CORNER + 7
STIFF_RR, STIFF_RZ, STIFF_ZZ = RIGHT_CORNER + 8, RIGHT_CORNER + 9, RIGHT_CORNER + 10
WALL_ROWS = RIGHT_CORNER + 11
"""Rows of `work`: forces and dV/dx / (2 pi r0) at nodes; stretch and direction of elements; from LEFT on N_l, N_c,
N_ll, N_lc, N_cl, N_cc (see `nominal_tensions`) at the corner by the oral node, from RIGHT_CORNER on at the other;
second differences of the places at nodes; stiffness of elements."""


@compiled
def set_drives(longitudinal: np.ndarray, circular: np.ndarray, known: np.ndarray) -> None:
    """Write drives of half elements [mV], (2n - 2,) each, into `known`."""
    for e in range(longitudinal.size // 2):
        known[DRIVE_L_LEFT, e] = longitudinal[2 * e]
        known[DRIVE_L_RIGHT, e] = longitudinal[2 * e + 1]
        known[DRIVE_C_LEFT, e] = circular[2 * e]
        known[DRIVE_C_RIGHT, e] = circular[2 * e + 1]


@compiled
def wall_forces(
    rho: np.ndarray,
    zeta: np.ndarray,
    known: np.ndarray,
    slope: float,
    c: WallConstants,
    first: int,
    last: int,
    work: np.ndarray,
) -> bool:
    """Internal forces and volume gradient at the nodes first...last of the wall rho, zeta [cm] (n,) into `work`.

    slope: of the rates, Eq. (32) [1/s]. Only inner nodes, 1...n - 2, can be asked for; the clamped ends have
    no equation. False, and nothing to be used, when a trial state is out of range.
    """
    n = rho.size
    if first < 1 or last > n - 2:
        return False
    # The elements low...last meet these nodes.
    low, high, last = (first - 1) & INDEX, (last + 1) & INDEX, last & INDEX
    per_size = 1.0 / c.element_size
    per_radius = 1.0 / c.radius
    good = 0
    for e in range(low, high):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        length = math.sqrt(dr * dr + dz * dz)
        inverse = 1.0 / length
        stretch = length * per_size
        work[STRETCH, e] = stretch
        work[TANGENT_R, e] = dr * inverse
        work[TANGENT_Z, e] = dz * inverse
        a = rho[e] * per_radius
        b = rho[e + 1] * per_radius
        fits = (stretch > SMALLEST_STRETCH) & (stretch < LARGEST_STRETCH)
        fits = fits & (a > SMALLEST_STRETCH) & (a < LARGEST_STRETCH) & (b > SMALLEST_STRETCH) & (b < LARGEST_STRETCH)
        fits = fits & admissible(stretch, a, c.passive) & admissible(stretch, b, c.passive)
        good += 1 if fits else 0
    if good != high - low:
        return False
    for corner in range(2):
        corner_tensions(rho, known, slope, c, low, high, corner, work)
    weight = 0.5 * c.element_size / c.radius
    for e in range(low, last):
        i = e + 1
        before = 0.5 * (work[LEFT, e] + work[RIGHT_CORNER, e])
        behind = 0.5 * (work[LEFT, i] + work[RIGHT_CORNER, i])
        hoop = weight * (work[LEFT + 1, i] + work[RIGHT_CORNER + 1, e])
        work[FORCE_R, i] = before * work[TANGENT_R, e] - behind * work[TANGENT_R, i] + hoop
        work[FORCE_Z, i] = before * work[TANGENT_Z, e] - behind * work[TANGENT_Z, i]
    volume_gradient(rho, zeta, c.radius, first, last, work)
    if c.bending_stiffness > 0.0 or c.bending_viscosity > 0.0:
        _bend(rho, zeta, known, slope, c, first, last, work)
    return True


@compiled
def volume_gradient(rho: np.ndarray, zeta: np.ndarray, radius: float, first: int, last: int, work: np.ndarray) -> None:
    """dV/dx / (2 pi r0) of the lumen's volume at the nodes first...last into `work`, Eq. (18)."""
    unit = 1.0 / (6.0 * radius)
    for e in range((first - 1) & INDEX, last & INDEX):
        i = e + 1
        o, a, b = rho[e], rho[i], rho[i + 1]
        before = zeta[i] - zeta[e]
        behind = zeta[i + 1] - zeta[i]
        work[VOLUME_R, i] = unit * ((2.0 * a + b) * behind + (2.0 * a + o) * before)
        work[VOLUME_Z, i] = unit * (o * (o + a) - b * (b + a))


@compiled
def corner_tensions(
    rho: np.ndarray,
    known: np.ndarray,
    slope: float,
    c: WallConstants,
    low: int,
    high: int,
    corner: int,
    work: np.ndarray,
) -> None:
    """Tensions and their derivatives at the corners 0 or 1 of the elements low...high - 1 into six rows of `work`."""
    low, high, corner = low & INDEX, high & INDEX, corner & INDEX
    row = LEFT + 6 * corner
    per_radius = 1.0 / c.radius
    stretches, hoops = work[STRETCH], rho[corner:]
    stretch_history, hoop_history = known[HISTORY_STRETCH], known[HISTORY_HOOP, corner:]
    longitudinal, circular = known[DRIVE_L_LEFT + corner], known[DRIVE_C_LEFT + corner]
    nl, nc, nll, nlc, ncl, ncc = work[row], work[row + 1], work[row + 2], work[row + 3], work[row + 4], work[row + 5]
    for e in range(low, high):
        stretch = stretches[e]
        hoop = hoops[e] * per_radius
        nl[e], nc[e], nll[e], nlc[e], ncl[e], ncc[e] = nominal_tensions(
            stretch,
            hoop,
            (stretch - stretch_history[e]) * slope,
            (hoop - hoop_history[e]) * slope,
            slope,
            longitudinal[e],
            circular[e],
            c,
        )


@compiled
def _bend(
    rho: np.ndarray,
    zeta: np.ndarray,
    known: np.ndarray,
    slope: float,
    c: WallConstants,
    first: int,
    last: int,
    work: np.ndarray,
) -> None:
    """Bending regulariser, Eq. (16): second differences of the position cost energy, their rates dissipate."""
    n = rho.size
    first, last = first & INDEX, last & INDEX
    viscous = c.bending_viscosity * slope / c.element_size**3
    factor = c.bending_stiffness / c.element_size**3 + viscous
    for axis in range(2):
        x = rho if axis == 0 else zeta
        bent = BENT_R + axis
        # The clamped ends have no second difference.
        work[bent, 0] = 0.0
        work[bent, n - 1] = 0.0
        past = HISTORY_R + axis
        for o in range(max(first - 2, 0) & INDEX, min(last + 1, n - 2) & INDEX):
            i = o + 1
            now = x[o] - 2.0 * x[i] + x[i + 1]
            before = known[past, o] - 2.0 * known[past, i] + known[past, i + 1]
            work[bent, i] = factor * now - viscous * before
        for o in range((first - 1) & INDEX, last):
            i = o + 1
            work[FORCE_R + axis, i] += work[bent, o] - 2.0 * work[bent, i] + work[bent, i + 1]


@compiled
def wall_tangent(
    rho: np.ndarray,
    zeta: np.ndarray,
    pressure: float,
    slope: float,
    c: WallConstants,
    first: int,
    last: int,
    work: np.ndarray,
    system: np.ndarray,
) -> None:
    """Tangent of wall and pressure forces at the nodes first...last into `system` (see `block_band`).

    After `wall_forces` on these nodes. Every entry of their blocks is written, right-hand sides are not touched.
    """
    low, high, last = (first - 1) & INDEX, (last + 1) & INDEX, last & INDEX
    first = first & INDEX
    h = c.element_size
    unit = 0.5 / h
    for e in range(low, high):
        along = unit * (work[LEFT + 2, e] + work[RIGHT_CORNER + 2, e])
        turn = unit * (work[LEFT, e] + work[RIGHT_CORNER, e]) / work[STRETCH, e]
        r, z = work[TANGENT_R, e], work[TANGENT_Z, e]
        work[STIFF_RR, e] = along * r * r + turn * z * z
        work[STIFF_RZ, e] = (along - turn) * r * z
        work[STIFF_ZZ, e] = along * z * z + turn * r * r
    across = 0.5 / c.radius
    push = pressure / (6.0 * c.radius)
    bend = (c.bending_stiffness + c.bending_viscosity * slope) / h**3
    # The node before, through the element i - 1, whose right corner this node is.
    for e in range(low, last):
        i = e + 1
        r, z = work[TANGENT_R, e], work[TANGENT_Z, e]
        force = across * work[LEFT + 3, e]
        turn = across * work[RIGHT_CORNER + 4, e]
        o, a = rho[e], rho[i]
        stiff = work[STIFF_RZ, e]
        system[LOWER, i] = (force - turn) * r - work[STIFF_RR, e] - push * (zeta[i] - zeta[e]) - 4.0 * bend
        system[LOWER + 1, i] = push * (o + 2.0 * a) - turn * z - stiff
        system[LOWER + 2, i] = force * z - push * (2.0 * o + a) - stiff
        system[LOWER + 3, i] = -work[STIFF_ZZ, e] - 4.0 * bend
    # The node behind, through the element i, whose left corner this node is.
    for i in range(first, high):
        r, z = work[TANGENT_R, i], work[TANGENT_Z, i]
        force = across * work[RIGHT_CORNER + 3, i]
        turn = across * work[LEFT + 4, i]
        a, b = rho[i], rho[i + 1]
        stiff = work[STIFF_RZ, i]
        system[UPPER, i] = (turn - force) * r - work[STIFF_RR, i] - push * (zeta[i + 1] - zeta[i]) - 4.0 * bend
        system[UPPER + 1, i] = turn * z - push * (2.0 * a + b) - stiff
        system[UPPER + 2, i] = push * (a + 2.0 * b) - force * z - stiff
        system[UPPER + 3, i] = -work[STIFF_ZZ, i] - 4.0 * bend
    hoop_unit = 0.5 * h / (c.radius * c.radius)
    for e in range(low, last):
        i = e + 1
        system[DIAGONAL, i] = (
            (work[STIFF_RR, e] + work[STIFF_RR, i] + 6.0 * bend)
            + across * (work[RIGHT_CORNER + 3, e] + work[RIGHT_CORNER + 4, e]) * work[TANGENT_R, e]
            - across * (work[LEFT + 3, i] + work[LEFT + 4, i]) * work[TANGENT_R, i]
            + hoop_unit * (work[LEFT + 5, i] + work[RIGHT_CORNER + 5, e])
            - 2.0 * push * (zeta[i + 1] - zeta[e])
        )
        system[DIAGONAL + 3, i] = work[STIFF_ZZ, e] + work[STIFF_ZZ, i] + 6.0 * bend
    for e in range(low, last):
        i = e + 1
        stiff = work[STIFF_RZ, e] + work[STIFF_RZ, i] + push * (rho[i + 1] - rho[e])
        before, behind = across * work[TANGENT_Z, e], across * work[TANGENT_Z, i]
        system[DIAGONAL + 1, i] = stiff + work[RIGHT_CORNER + 4, e] * before - work[LEFT + 4, i] * behind
        system[DIAGONAL + 2, i] = stiff + work[RIGHT_CORNER + 3, e] * before - work[LEFT + 3, i] * behind
    # The nodes next to the clamped ends have one second difference fewer.
    for node, clamped in ((1, LOWER), (rho.size - 2, UPPER)):
        if first <= node <= last:
            for entry in (0, 3):
                system[DIAGONAL + entry, node] -= bend
                system[clamped + entry, node] += 2.0 * bend
    for block in (FARTHEST, LAST):
        for i in range(first, high):
            system[block, i] = bend
            system[block + 1, i] = 0.0
            system[block + 2, i] = 0.0
            system[block + 3, i] = bend
