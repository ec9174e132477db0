"""Method of lines, the wall: finite differences of the strong form (1) on a staggered grid, quasi-static.

Places (ρ, ζ) and q live at nodes, N_l at faces, N_c at nodes. Strains at a face use the mean radius of its two nodes,
those at a node the mean axial stretch of its two faces: no elements, no energy, no quadrature.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

# A trial step of Newton's method whose exponent (4) is beyond this is refused; e^60 mN/cm is no tension.
LARGEST_EXPONENT = 60.0


class Shell(NamedTuple):
    """What the compiled functions need of the constants."""

    radius: float
    viscosity: float
    c1: float
    c2: float
    c3: float
    c4: float
    c5: float
    c6: float
    c10: float
    published: bool
    blend: float
    slope: float
    fold_stretch: float
    fold_tension: float
    bending: float
    bending_viscosity: float
    l7: float
    l8: float
    l9: float
    r7: float
    r8: float
    r9: float


@njit(cache=True)
def positive(value: float, blend: float) -> float:
    """b P(T/b) of (14)."""
    if blend == 0.0:
        return max(value, 0.0)
    x = value / blend
    if x >= 1.0:
        return value
    if x <= -1.0:
        return 0.0
    return blend * (-(x**4) / 16.0 + 3.0 * x * x / 8.0 + x / 2.0 + 3.0 / 16.0)


@njit(cache=True)
def carried(elastic: float, others: float, stretch: float, shell: Shell) -> float:
    """Tension after (14), (15) and (36) from its elastic part and the sum of the others [mN/cm]."""
    if shell.blend == 0.0:
        return elastic + others
    total = positive(elastic, shell.blend) + others
    total = shell.slope * total + (1.0 - shell.slope) * positive(total, shell.blend)
    if stretch < shell.fold_stretch:
        total -= shell.fold_tension * (shell.fold_stretch / stretch - 1.0) ** 2
    return total


@njit(cache=True)
def residual(
    place: np.ndarray,
    speed: np.ndarray,
    pressure: float,
    contact: np.ndarray,
    drive_faces: np.ndarray,
    drive_nodes: np.ndarray,
    h: float,
    shell: Shell,
    out: np.ndarray,
) -> bool:
    """Right sides of the two equations (1) at the inner nodes [mN/cm^2]; False where a trial is out of bounds."""
    n = place.shape[0] - 1
    last_l = 0.0
    last_pull_r = 0.0
    last_pull_z = 0.0
    r0 = shell.radius
    for face in range(n):
        dr = (place[face + 1, 0] - place[face, 0]) / h
        dz = (place[face + 1, 1] - place[face, 1]) / h
        stretch_l = np.sqrt(dr * dr + dz * dz)
        stretch_c = 0.5 * (place[face, 0] + place[face + 1, 0]) / r0
        if stretch_l <= 1e-6 or stretch_c <= 1e-6:
            return False
        e_l = stretch_l - 1.0
        e_c = stretch_c - 1.0
        exponent = shell.c4 * e_l * e_l + shell.c5 * e_c * e_c + 2.0 * shell.c6 * e_l * e_c
        if exponent > LARGEST_EXPONENT:
            return False
        growth = 2.0 * shell.c10 * np.exp(exponent)
        elastic = shell.c1 * e_l + shell.c3 * e_c + growth * (shell.c4 * e_l + shell.c6 * e_c)
        rate = (dr * (speed[face + 1, 0] - speed[face, 0]) + dz * (speed[face + 1, 1] - speed[face, 1])) / (
            h * stretch_l
        )
        active = max(0.0, (shell.l7 * stretch_l + shell.l8) * stretch_l + shell.l9) * drive_faces[face]
        tension = carried(elastic, active + shell.viscosity * rate, stretch_l, shell)
        if shell.published:
            tension *= stretch_c
        pull_r = tension * dr / stretch_l
        pull_z = tension * dz / stretch_l
        if face > 0:
            i = face
            mean_l = 0.5 * (last_l + stretch_l)
            hoop = place[i, 0] / r0
            e_l = mean_l - 1.0
            e_c = hoop - 1.0
            exponent = shell.c4 * e_l * e_l + shell.c5 * e_c * e_c + 2.0 * shell.c6 * e_l * e_c
            if exponent > LARGEST_EXPONENT or hoop <= 1e-6:
                return False
            growth = 2.0 * shell.c10 * np.exp(exponent)
            elastic = shell.c2 * e_c + shell.c3 * e_l + growth * (shell.c5 * e_c + shell.c6 * e_l)
            active = max(0.0, (shell.r7 * hoop + shell.r8) * hoop + shell.r9) * drive_nodes[i]
            tension = carried(elastic, active + shell.viscosity * speed[i, 0] / r0, hoop, shell)
            if shell.published:
                tension *= mean_l
            push = (pressure + contact[i]) * hoop / (2.0 * h)
            out[i, 0] = (pull_r - last_pull_r) / h - tension / r0 + push * (place[i + 1, 1] - place[i - 1, 1])
            out[i, 1] = (pull_z - last_pull_z) / h - push * (place[i + 1, 0] - place[i - 1, 0])
        last_l = stretch_l
        last_pull_r = pull_r
        last_pull_z = pull_z
    out[0] = 0.0
    out[n] = 0.0
    b = shell.bending / h**4
    bv = shell.bending_viscosity / h**4
    for i in range(1, n):
        for k in range(2):
            moment = b * (place[i - 1, k] - 2.0 * place[i, k] + place[i + 1, k]) + bv * (
                speed[i - 1, k] - 2.0 * speed[i, k] + speed[i + 1, k]
            )
            out[i - 1, k] -= moment
            out[i, k] += 2.0 * moment
            out[i + 1, k] -= moment
    out[0] = 0.0
    out[n] = 0.0
    return True


@njit(cache=True)
def gaps(place: np.ndarray, centre: float, radius: float) -> np.ndarray:
    """Distance of every node from the sphere [cm], (12)."""
    return np.sqrt(place[:, 0] ** 2 + (place[:, 1] - centre) ** 2) - radius


@njit(cache=True)
def axial_force(place: np.ndarray, contact: np.ndarray, r0: float) -> float:
    """F_z = 2π r0 ∫ q λ_c ρ_z dz (13) by central differences [mN]."""
    total = 0.0
    for i in range(1, place.shape[0] - 1):
        total += contact[i] * place[i, 0] * 0.5 * (place[i + 1, 0] - place[i - 1, 0])
    return 2.0 * np.pi * total


@njit(cache=True)
def lumen(place: np.ndarray) -> float:
    """π ∫ ρ² dζ by the trapezoidal rule [cm^3]; the pellet is not taken off."""
    total = 0.0
    for i in range(place.shape[0] - 1):
        total += 0.5 * (place[i, 0] ** 2 + place[i + 1, 0] ** 2) * (place[i + 1, 1] - place[i, 1])
    return np.pi * total


@njit(cache=True)
def tangent(
    place: np.ndarray,
    speed: np.ndarray,
    pressure: float,
    contact: np.ndarray,
    drive_faces: np.ndarray,
    drive_nodes: np.ndarray,
    h: float,
    shell: Shell,
    lag: float,
    base: np.ndarray,
    centre: float,
    pellet_radius: float,
    touching: np.ndarray,
    band: np.ndarray,
) -> None:
    """Band matrix (LAPACK form, half width 8) of the unknowns (ρ, ζ, q) of the inner nodes by coloured differences.

    `speed` follows `place` as place/lag. Rows: both balances, then the closed gap or q = 0.
    """
    n = place.shape[0] - 1
    half = 8
    band[:] = 0.0
    moved = place.copy()
    quick = speed.copy()
    trial = np.zeros_like(place)
    # Small enough that the viscous tension changes by less than the blend (14), large enough against rounding.
    step = min(1e-8, 1e-4 * lag * h / shell.viscosity)
    for k in range(2):
        for colour in range(5):
            for j in range(1 + colour, n, 5):
                moved[j, k] += step
                quick[j, k] += step / lag
            residual(moved, quick, pressure, contact, drive_faces, drive_nodes, h, shell, trial)
            for j in range(1 + colour, n, 5):
                for i in range(max(1, j - 2), min(n, j + 3)):
                    for m in range(2):
                        row = 3 * (i - 1) + m
                        col = 3 * (j - 1) + k
                        band[half + row - col, col] = (trial[i, m] - base[i, m]) / step
                moved[j, k] = place[j, k]
                quick[j, k] = speed[j, k]
    for i in range(1, n):
        hoop = place[i, 0] / shell.radius / (2.0 * h)
        col = 3 * (i - 1) + 2
        band[half + 3 * (i - 1) - col, col] = hoop * (place[i + 1, 1] - place[i - 1, 1])
        band[half + 3 * (i - 1) + 1 - col, col] = -hoop * (place[i + 1, 0] - place[i - 1, 0])
        row = col
        if touching[i]:
            distance = np.sqrt(place[i, 0] ** 2 + (place[i, 1] - centre) ** 2)
            band[half + row - (col - 2), col - 2] = place[i, 0] / distance
            band[half + row - (col - 1), col - 1] = (place[i, 1] - centre) / distance
        else:
            band[half, col] = 1.0
