"""Where the wall will be at the end of a step, guessed so well that Newton's method has little left to do.

Positions are extrapolated from their velocities. That misses the elements that the wave reaches in this very step:
their drive jumps, and they contract as fast as the dashpot lets them. The tension along the wall does not jump, so
each of these elements is given the stretch at which it carries, with its new drive, the tension that it carried
before. The nodes then slide along the extrapolated meridian to fit the new lengths, and touching nodes are put on the
pellet. The guess decides how long the iteration takes and nothing else.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from ..pellet.constants import PelletConstants
from ..pellet.shapes.sphere import reach
from ..wall.assembly import (
    DRIVE_C_LEFT,
    DRIVE_C_RIGHT,
    DRIVE_L_LEFT,
    DRIVE_L_RIGHT,
    HISTORY_HOOP,
    HISTORY_STRETCH,
)
from ..wall.constants import WallConstants
from ..wall.membrane import LARGEST_STRETCH, SMALLEST_STRETCH, nominal_tensions
from .arrays import WallArrays
from .problem import Unknowns

JUMP = 0.5
"""Change of drive in a step [mV] beyond which an element is treated by itself."""
CLOSE = 0.2
"""Tension error at which its stretch is good enough [mN/cm]."""
LONGEST_CHANGE = 0.05
"""Largest change of stretch in one of its iterations."""
SOFTEST = 0.05
"""Least stiffness of an element in these iterations, as a share of its dashpot's."""
ITERATIONS = 10


class Stretches(NamedTuple):
    """Longitudinal stretch of the elements (n - 1,) and circumferential stretch of the nodes (n,)."""

    axial: np.ndarray
    hoop: np.ndarray


@compiled
def axial_force(
    stretch: float,
    stretch_rate: float,
    hoops: tuple[float, float],
    hoop_rates: tuple[float, float],
    slope: float,
    longitudinal: tuple[float, float],
    circular: tuple[float, float],
    c: WallConstants,
) -> tuple[float, float]:
    """Axial force N_l [mN/cm] of an element, the mean of its two corners, and its derivative by the stretch.

    Pairs belong to the corners: hoop stretches, their rates [1/s], drives of both layers [mV]. slope: of the rates.
    """
    total = 0.0
    stiffness = 0.0
    for corner in range(2):
        n, _, dn, _, _, _ = nominal_tensions(
            stretch,
            hoops[corner],
            stretch_rate,
            hoop_rates[corner],
            slope,
            longitudinal[corner],
            circular[corner],
            c,
        )
        total += 0.5 * n
        stiffness += 0.5 * dn
    return total, stiffness


@compiled
def fit_lengths(
    guess: Unknowns,
    before: WallArrays,
    stretches: Stretches,
    known: np.ndarray,
    slope: float,
    c: WallConstants,
    pellet: PelletConstants,
) -> None:
    """Improve the extrapolated places of a guess where the drive jumps; touching nodes are put on the pellet.

    before, stretches: what the tensions of the step before were computed with. known, slope: as for `wall_forces`.
    """
    rho, zeta, density, centre = guess.rho, guess.zeta, guess.density, guess.scalars[1]
    old_stretch, old_hoop = stretches.axial, stretches.hoop
    old_stretch_rate, old_hoop_rate, old_drive = before.stretch_rate, before.hoop_rate, before.drive
    n = rho.size
    m = n - 1
    h = c.element_size
    shift = np.zeros(n)
    jumped = False
    for e in range(m):
        shift[e + 1] = shift[e]
        drives = (known[DRIVE_L_LEFT, e], known[DRIVE_L_RIGHT, e])
        old_drives = (old_drive[0, 2 * e, 0], old_drive[0, 2 * e + 1, 0])
        if not max(abs(drives[0] - old_drives[0]), abs(drives[1] - old_drives[1])) > JUMP:
            continue
        wanted, _ = axial_force(
            old_stretch[e],
            old_stretch_rate[e, 0],
            (old_hoop[e], old_hoop[e + 1]),
            (old_hoop_rate[e, 0], old_hoop_rate[e + 1, 0]),
            slope,
            old_drives,
            (old_drive[1, 2 * e, 0], old_drive[1, 2 * e + 1, 0]),
            c,
        )
        dr, dz = rho[e + 1] - rho[e], zeta[e + 1] - zeta[e]
        extrapolated = math.sqrt(dr * dr + dz * dz) / h
        hoops = (rho[e] / c.radius, rho[e + 1] / c.radius)
        rates = ((hoops[0] - known[HISTORY_HOOP, e]) * slope, (hoops[1] - known[HISTORY_HOOP, e + 1]) * slope)
        circular = (known[DRIVE_C_LEFT, e], known[DRIVE_C_RIGHT, e])
        stretch = extrapolated
        for _ in range(ITERATIONS):
            rate = (stretch - known[HISTORY_STRETCH, e]) * slope
            carried, stiffness = axial_force(stretch, rate, hoops, rates, slope, drives, circular, c)
            error = carried - wanted
            if abs(error) < CLOSE:
                break
            change = -error / max(stiffness, SOFTEST * c.viscosity * slope)
            stretch += min(max(change, -LONGEST_CHANGE), LONGEST_CHANGE)
        if stretch > SMALLEST_STRETCH and stretch < LARGEST_STRETCH:
            shift[e + 1] += (stretch - extrapolated) * h
            jumped = True
    if not jumped:
        return
    # The ends are clamped: what these elements gained all elements lose alike.
    excess = shift[m] / m
    old_rho, old_zeta = rho.copy(), zeta.copy()
    for i in range(1, m):
        moved = shift[i] - i * excess
        e = i if moved > 0.0 else i - 1
        dr, dz = old_rho[e + 1] - old_rho[e], old_zeta[e + 1] - old_zeta[e]
        share = moved / math.sqrt(dr * dr + dz * dz)
        rho[i] += share * dr
        zeta[i] += share * dz
        if density[i] > 0.0 and pellet.present:
            axial = zeta[i] - centre
            scale = pellet.shape.radius / reach(rho[i], axial, pellet.shape)
            rho[i] *= scale
            zeta[i] = centre + axial * scale
