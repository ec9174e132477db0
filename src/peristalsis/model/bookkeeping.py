"""Kernels behind the numbers of every step: end reactions, slack, contact, and the work between two states.

They take the arrays of a `WallState` of one column as they are, and constants by `constants.packed`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.tube import lumen_volume
from ..numerics.compiled import INDEX, compiled
from ..numerics.reductions import total
from ..pellet.body import unpack_pellet
from ..pellet.constants import PelletConstants
from ..pellet.contact import smallest_gap
from ..wall.constants import WallConstants
from ..wall.membrane import TOTAL_CIRCULAR, TOTAL_LONGITUDINAL, tension_parts
from ..wall.unpacking import unpack_wall
from .arrays import WallArrays

STRETCH, HOOP, STRETCH_RATE, HOOP_RATE, DRIVES, RHO, ZETA = 0, 1, 2, 3, 4, 8, 9
ROWS = 10
"""Rows of a state taken apart: DRIVES holds the longitudinal layer's at left and right corners, then the circular's."""
AXIAL, CIRCUMFERENTIAL = 0, 2
"""Rows of the total tensions, (4, elements): at left and right corners each."""
PASSIVE, ACTIVE, VISCOUS, FLOOR = range(4)
"""Work on the wall by part: stored, by the muscle, lost in the dashpot, and what floor and folds add."""


class EndReactions(NamedTuple):
    """Axial force at the oral and the anal end [mN] and the share of slack corners."""

    oral: float
    anal: float
    slack: float


class ContactSummary(NamedTuple):
    """Normal force [mN], largest contact pressure [mN/cm^2], contact edges and least radius and gap [cm].

    Edges are nan without contact, the gap is infinite without a pellet. On the whole surface the radius of a ring is
    that of the circle with its area.
    """

    normal_force: float
    largest_pressure: float
    start: float
    end: float
    least_radius: float
    smallest_gap: float


class WallWork(NamedTuple):
    """Work on the wall over a step by part [mN cm], and the volume within the wall before and after it [cm^3]."""

    passive: float
    active: float
    viscous: float
    floor: float
    volume_before: float
    volume_after: float


class StepNumbers(NamedTuple):
    """What `wall_work` gives for a step, `reactions` and `touch` for its end."""

    work: WallWork
    ends: EndReactions
    contact: ContactSummary


@compiled
def unpack_state(arrays: WallArrays, wall: WallConstants) -> np.ndarray:
    """Contiguous rows of a state, (ROWS, n): lengths [cm], stretches, rates [1/s], drives [mV]."""
    position, stretch_rate, hoop_rate, drive = arrays.position, arrays.stretch_rate, arrays.hoop_rate, arrays.drive
    n = position.shape[0]
    rows = np.zeros((ROWS, n))
    for i in range(n):
        rows[RHO, i] = position[i, 0, 0]
        rows[ZETA, i] = position[i, 0, 2]
        rows[HOOP, i] = position[i, 0, 0] / wall.radius
        rows[HOOP_RATE, i] = hoop_rate[i, 0]
    for e in range(n - 1):
        dr, dz = rows[RHO, e + 1] - rows[RHO, e], rows[ZETA, e + 1] - rows[ZETA, e]
        rows[STRETCH, e] = math.sqrt(dr * dr + dz * dz) / wall.element_size
        rows[STRETCH_RATE, e] = stretch_rate[e, 0]
        for corner in range(2):
            rows[DRIVES + corner, e] = drive[0, 2 * e + corner, 0]
            rows[DRIVES + 2 + corner, e] = drive[1, 2 * e + corner, 0]
    return rows


@compiled
def _total_tensions(rows: np.ndarray, corner: int, wall: WallConstants, totals: np.ndarray) -> None:
    corner = corner & INDEX
    m = totals.shape[1]
    stretch, stretch_rate = rows[STRETCH, :m], rows[STRETCH_RATE, :m]
    hoop, hoop_rate = rows[HOOP, corner:], rows[HOOP_RATE, corner:]
    longitudinal, circular = rows[DRIVES + corner], rows[DRIVES + 2 + corner]
    axial, circumferential = totals[AXIAL + corner], totals[CIRCUMFERENTIAL + corner]
    for e in range(m):
        parts = tension_parts(
            stretch[e], hoop[e], stretch_rate[e], hoop_rate[e], longitudinal[e], circular[e], wall
        )  # fmt: skip
        axial[e] = parts[TOTAL_LONGITUDINAL]
        circumferential[e] = parts[TOTAL_CIRCULAR]


@compiled
def reactions(arrays: WallArrays, pressure: float, wall_numbers: np.ndarray) -> EndReactions:
    """Axial force at the oral and the anal end [mN] and the share of slack corners; see `fields.end_reactions`."""
    wall = unpack_wall(wall_numbers)
    rows = unpack_state(arrays, wall)
    totals = np.empty((4, arrays.position.shape[0] - 1))
    for corner in range(2):
        _total_tensions(rows, corner, wall, totals)
    return _reactions(rows, totals, arrays.velocity, pressure, wall)


@compiled
def _reactions(
    rows: np.ndarray, totals: np.ndarray, velocity: np.ndarray, pressure: float, wall: WallConstants
) -> EndReactions:
    m = totals.shape[1]
    slack = 0
    for e in range(m):
        for corner in range(2):
            if min(totals[AXIAL + corner, e], totals[CIRCUMFERENTIAL + corner, e]) <= wall.slack_blend:
                slack += 1
    forces = np.empty(2)
    bends, damps = wall.bending_stiffness / wall.element_size**3, wall.bending_viscosity / wall.element_size**3
    for end in range(2):
        e = 0 if end == 0 else m - 1
        nominal = 0.0
        for corner in range(2):
            across = rows[HOOP, e + corner] if wall.published else 1.0
            nominal += 0.5 * totals[AXIAL + corner, e] * across
        middle = 1 if end == 0 else m - 1
        bent = rows[ZETA, middle - 1] - 2.0 * rows[ZETA, middle] + rows[ZETA, middle + 1]
        bending = velocity[middle - 1, 0, 2] - 2.0 * velocity[middle, 0, 2] + velocity[middle + 1, 0, 2]
        regulariser = bends * bent + damps * bending
        dz = rows[ZETA, e + 1] - rows[ZETA, e]
        tension = nominal * dz / (rows[STRETCH, e] * wall.element_size)
        tension += -regulariser if end == 0 else regulariser
        a, b = rows[RHO, e], rows[RHO, e + 1]
        lumen = pressure * math.pi / 3.0 * (a * a + a * b + b * b)
        forces[end] = 2.0 * math.pi * wall.radius * tension - lumen
    return EndReactions(oral=forces[0], anal=forces[1], slack=slack / (2.0 * m))


@compiled
def touch(arrays: WallArrays, centre: float, pellet_numbers: np.ndarray, wall_numbers: np.ndarray) -> ContactSummary:
    """The contact of a state; constants by `constants.packed`."""
    wall = unpack_wall(wall_numbers)
    return _touch(unpack_state(arrays, wall), arrays.contact, centre, unpack_pellet(pellet_numbers), wall)


@compiled
def _touch(
    rows: np.ndarray, contact: np.ndarray, centre: float, pellet: PelletConstants, wall: WallConstants
) -> ContactSummary:
    rho, zeta = rows[RHO], rows[ZETA]
    n = rho.size
    normal = 0.0
    pressure = 0.0
    start = math.nan
    end = math.nan
    least = rho[0]
    for i in range(n):
        least = min(least, rho[i])
        if contact[i, 0] > 0.0:
            before = math.hypot(rho[i] - rho[i - 1], zeta[i] - zeta[i - 1])
            behind = math.hypot(rho[i + 1] - rho[i], zeta[i + 1] - zeta[i])
            stretch = 0.5 * (before + behind) / wall.element_size
            pressure = max(pressure, contact[i, 0] / (stretch * rho[i] / wall.radius))
            normal += contact[i, 0]
            if math.isnan(start):
                start = zeta[i]
            end = zeta[i]
    gap = smallest_gap(rho, zeta, centre, pellet.shape) if pellet.present else math.inf
    return ContactSummary(
        normal_force=normal * 2.0 * math.pi * wall.radius * wall.element_size,
        largest_pressure=pressure,
        start=start,
        end=end,
        least_radius=least,
        smallest_gap=gap,
    )


@compiled
def _corner_work(
    old: np.ndarray, new: np.ndarray, corner: int, wall: WallConstants, work: np.ndarray, totals: np.ndarray
) -> None:
    """Trapezoidal tension times change of stretch at one corner of every element, by part, (4, elements).

    totals: receives the total tensions of the new state, as `_total_tensions` writes them.
    """
    corner = corner & INDEX
    m = work.shape[1]
    stretch_0, stretch_1 = old[STRETCH, :m], new[STRETCH, :m]
    hoop_0, hoop_1 = old[HOOP, corner:], new[HOOP, corner:]
    stretch_rate_0, stretch_rate_1 = old[STRETCH_RATE], new[STRETCH_RATE]
    hoop_rate_0, hoop_rate_1 = old[HOOP_RATE, corner:], new[HOOP_RATE, corner:]
    longitudinal_0, longitudinal_1 = old[DRIVES + corner], new[DRIVES + corner]
    circular_0, circular_1 = old[DRIVES + 2 + corner], new[DRIVES + 2 + corner]
    passive, active, viscous, floor = work[0], work[1], work[2], work[3]
    axial, circumferential = totals[AXIAL + corner], totals[CIRCUMFERENTIAL + corner]
    published = wall.published
    for e in range(m):
        s_0, s_1, h_0, h_1 = stretch_0[e], stretch_1[e], hoop_0[e], hoop_1[e]
        a = tension_parts(s_0, h_0, stretch_rate_0[e], hoop_rate_0[e], longitudinal_0[e], circular_0[e], wall)
        b = tension_parts(s_1, h_1, stretch_rate_1[e], hoop_rate_1[e], longitudinal_1[e], circular_1[e], wall)
        half_l, half_c = 0.5 * (s_1 - s_0), 0.5 * (h_1 - h_0)
        l_0, l_1 = half_l * (h_0 if published else 1.0), half_l * (h_1 if published else 1.0)
        c_0, c_1 = half_c * (s_0 if published else 1.0), half_c * (s_1 if published else 1.0)
        p = (a[0] * l_0 + b[0] * l_1) + (a[4] * c_0 + b[4] * c_1)
        q = (a[1] * l_0 + b[1] * l_1) + (a[5] * c_0 + b[5] * c_1)
        r = (a[2] * l_0 + b[2] * l_1) + (a[6] * c_0 + b[6] * c_1)
        t = (a[3] * l_0 + b[3] * l_1) + (a[7] * c_0 + b[7] * c_1)
        passive[e] = p
        active[e] = q
        viscous[e] = r
        floor[e] = t - (p + q + r)
        axial[e] = b[TOTAL_LONGITUDINAL]
        circumferential[e] = b[TOTAL_CIRCULAR]


@compiled
def wall_work(old: WallArrays, new: WallArrays, wall_numbers: np.ndarray) -> WallWork:
    """Work on the wall between two states by part [mN cm], bending included; volumes of the lumen.

    Bending adds to what is stored (Eq. (16)), its viscosity to what is lost.
    """
    wall = unpack_wall(wall_numbers)
    totals = np.empty((4, old.position.shape[0] - 1))
    return _wall_work(unpack_state(old, wall), unpack_state(new, wall), old.velocity, new.velocity, wall, totals)


@compiled
def _wall_work(
    old: np.ndarray,
    new: np.ndarray,
    old_velocity: np.ndarray,
    new_velocity: np.ndarray,
    wall: WallConstants,
    totals: np.ndarray,
) -> WallWork:
    n = old_velocity.shape[0]
    work = np.empty((4, n - 1))
    out = np.zeros(4)
    for corner in range(2):
        _corner_work(old, new, corner, wall, work, totals)
        for part in range(4):
            out[part] += total(work[part])
    for part in range(4):
        out[part] *= math.pi * wall.radius * wall.element_size
    bent = 0.0
    damped = 0.0
    for axis in range(2):
        x, y = old[RHO + axis], new[RHO + axis]
        for i in range(1, n - 1):
            before = x[i - 1] - 2.0 * x[i] + x[i + 1]
            after = y[i - 1] - 2.0 * y[i] + y[i + 1]
            bent += after * after - before * before
            rate = old_velocity[i - 1, 0, 2 * axis] - 2.0 * old_velocity[i, 0, 2 * axis]
            rate += old_velocity[i + 1, 0, 2 * axis] + new_velocity[i - 1, 0, 2 * axis]
            rate += new_velocity[i + 1, 0, 2 * axis] - 2.0 * new_velocity[i, 0, 2 * axis]
            damped += 0.5 * rate * (after - before)
    unit = math.pi * wall.radius / wall.element_size**3
    out[PASSIVE] += unit * wall.bending_stiffness * bent
    out[VISCOUS] += 2.0 * unit * wall.bending_viscosity * damped
    return WallWork(
        passive=out[PASSIVE],
        active=out[ACTIVE],
        viscous=out[VISCOUS],
        floor=out[FLOOR],
        volume_before=lumen_volume(old[RHO], old[ZETA]),
        volume_after=lumen_volume(new[RHO], new[ZETA]),
    )


@compiled
def numbers_of_step(
    old: WallArrays,
    new: WallArrays,
    pressure: float,
    centre: float,
    pellet_numbers: np.ndarray,
    wall_numbers: np.ndarray,
) -> StepNumbers:
    """What `wall_work` gives of two states, `reactions` and `touch` of the new one.

    In one pass: the states are taken apart once and no tension is computed twice.
    """
    wall = unpack_wall(wall_numbers)
    before, after = unpack_state(old, wall), unpack_state(new, wall)
    totals = np.empty((4, old.position.shape[0] - 1))
    return StepNumbers(
        work=_wall_work(before, after, old.velocity, new.velocity, wall, totals),
        ends=_reactions(after, totals, new.velocity, pressure, wall),
        contact=_touch(after, new.contact, centre, unpack_pellet(pellet_numbers), wall),
    )
