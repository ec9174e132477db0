"""Forces on the wall's nodes for the explicit scheme: those of `membrane`, without the tangent, Eqs. (1), (18), (54).

Staggered differences along z: the longitudinal stretch and its rate belong to elements, the circumferential ones to
nodes, each element has two corners of weight h/2. Forces are per 2*pi*r0, i.e. [mN/cm], and add up.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.blend import fold_resistance
from ..numerics.compiled import compiled
from .constants import WallConstants
from .membrane import LARGEST_STRETCH, SMALLEST_STRETCH, carried, nominal_tensions, tensions
from .passive import admissible

INSIDE = -1
"""What `add_tension_forces` returns when every stretch is in range."""


@compiled
def add_tension_forces(
    rho: np.ndarray,
    zeta: np.ndarray,
    rho_rate: np.ndarray,
    zeta_rate: np.ndarray,
    drive_longitudinal: np.ndarray,
    drive_circular: np.ndarray,
    c: WallConstants,
    force_rho: np.ndarray,
    force_zeta: np.ndarray,
    stretch_rate: np.ndarray,
) -> int:
    """Add what the tensions pull with; INSIDE, or the first element whose stretch or hoop is out of range.

    rho, zeta [cm] and their rates [cm/s]: (n,). Drives of the half elements [mV]: (2n - 2,). stretch_rate [1/s]:
    of the elements, (n - 1,), written.
    """
    half = 0.5 * c.element_size
    inverse = 1.0 / c.element_size
    per_radius = 1.0 / c.radius
    for e in range(rho.size - 1):
        dr = rho[e + 1] - rho[e]
        dz = zeta[e + 1] - zeta[e]
        length = math.sqrt(dr * dr + dz * dz)
        stretch = length * inverse
        if not (SMALLEST_STRETCH < stretch < LARGEST_STRETCH):
            return e
        tr = dr / length
        tz = dz / length
        rate = (tr * (rho_rate[e + 1] - rho_rate[e]) + tz * (zeta_rate[e + 1] - zeta_rate[e])) * inverse
        stretch_rate[e] = rate
        axial = 0.0
        for corner in range(2):
            i = e + corner
            hoop = rho[i] * per_radius
            if not (SMALLEST_STRETCH < hoop < LARGEST_STRETCH and admissible(stretch, hoop, c.passive)):
                return e
            _, _, _, tl, pc, ac, _, _, _, _, _, _ = tensions(
                stretch,
                hoop,
                rate,
                rho_rate[i] * per_radius,
                0.0,
                drive_longitudinal[2 * e + corner],
                drive_circular[2 * e + corner],
                c,
            )
            # The same sum as that of `tensions`, rounded as this scheme has always rounded it.
            fold, _ = fold_resistance(hoop, c.fold_stretch, c.fold_tension)
            tc, _ = carried(c.viscosity * rho_rate[i] * per_radius, pc, ac, fold, c)
            axial += 0.5 * (tl * hoop if c.published else tl)
            force_rho[i] -= half * (tc * stretch if c.published else tc) * per_radius
        force_rho[e] += axial * tr
        force_zeta[e] += axial * tz
        force_rho[e + 1] -= axial * tr
        force_zeta[e + 1] -= axial * tz
    return INSIDE


@compiled
def add_bending_forces(
    rho: np.ndarray,
    zeta: np.ndarray,
    rho_rate: np.ndarray,
    zeta_rate: np.ndarray,
    c: WallConstants,
    force_rho: np.ndarray,
    force_zeta: np.ndarray,
) -> None:
    """Add the bending regulariser, Eq. (16)."""
    elastic = c.bending_stiffness / c.element_size**3
    viscous = c.bending_viscosity / c.element_size**3
    if elastic == 0.0 and viscous == 0.0:
        return
    for i in range(1, rho.size - 1):
        fr = elastic * (rho[i - 1] - 2.0 * rho[i] + rho[i + 1])
        fr += viscous * (rho_rate[i - 1] - 2.0 * rho_rate[i] + rho_rate[i + 1])
        fz = elastic * (zeta[i - 1] - 2.0 * zeta[i] + zeta[i + 1])
        fz += viscous * (zeta_rate[i - 1] - 2.0 * zeta_rate[i] + zeta_rate[i + 1])
        force_rho[i - 1] -= fr
        force_rho[i] += 2.0 * fr
        force_rho[i + 1] -= fr
        force_zeta[i - 1] -= fz
        force_zeta[i] += 2.0 * fz
        force_zeta[i + 1] -= fz


@compiled
def add_pressure_forces(
    rho: np.ndarray,
    zeta: np.ndarray,
    pressure: float,
    c: WallConstants,
    force_rho: np.ndarray,
    force_zeta: np.ndarray,
) -> None:
    """Add the lumen pressure [mN/cm^2], the derivative of the volume of frusta, Eq. (18)."""
    unit = pressure / (6.0 * c.radius)
    for e in range(rho.size - 1):
        a = rho[e]
        b = rho[e + 1]
        length = unit * (zeta[e + 1] - zeta[e])
        area = unit * (a * a + a * b + b * b)
        force_rho[e] += (2.0 * a + b) * length
        force_rho[e + 1] += (a + 2.0 * b) * length
        force_zeta[e] -= area
        force_zeta[e + 1] += area


@compiled
def largest_rates(
    rho: np.ndarray,
    zeta: np.ndarray,
    stretch_rate: np.ndarray,
    hoop_rate: np.ndarray,
    drive_longitudinal: np.ndarray,
    drive_circular: np.ndarray,
    c: WallConstants,
) -> tuple[float, float]:
    """Bounds on the wall's largest decay rate by its dashpots [1/s] and largest squared frequency [1/s^2].

    Element by element: no assembled matrix has a larger eigenvalue, with lumped masses, than one of its elements.
    An element of two nodes with half its mass each has 4/h^2 of whatever acts along it, or turns it.
    """
    h = c.element_size
    per_mass = 1.0 / c.surface_density
    decay = 0.0
    square = 0.0
    for e in range(rho.size - 1):
        stretch = math.hypot(rho[e + 1] - rho[e], zeta[e + 1] - zeta[e]) / h
        along = 0.0
        stiff = 0.0
        turn = 0.0
        around = 0.0
        ring = 0.0
        cross = 0.0
        for corner in range(2):
            i = e + corner
            hoop = rho[i] / c.radius
            nl, _, nll, nlc, ncl, ncc = nominal_tensions(
                stretch,
                hoop,
                stretch_rate[e],
                hoop_rate[i],
                0.0,
                drive_longitudinal[2 * e + corner],
                drive_circular[2 * e + corner],
                c,
            )
            along += 0.5 * c.viscosity * (hoop if c.published else 1.0)
            around = max(around, c.viscosity * (stretch if c.published else 1.0))
            stiff += 0.5 * abs(nll)
            turn += 0.5 * abs(nl) / stretch
            cross = max(cross, 2.0 * max(abs(nlc), abs(ncl)) / (h * c.radius))
            ring = max(ring, abs(ncc) / c.radius**2)
        decay = max(decay, 4.0 * along / h**2 + around / c.radius**2)
        square = max(square, 4.0 * max(stiff, turn) / h**2 + ring + cross)
    decay += 16.0 * c.bending_viscosity / h**4
    square += 16.0 * c.bending_stiffness / h**4
    return decay * per_mass, square * per_mass
