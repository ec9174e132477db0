"""Wall, lumen and pellet in equilibrium at the end of a step: one Newton iteration over all of them.

Unknowns are the wall nodes, the contact densities Q, and three scalars: lumen pressure p, pellet centre Z and axial
force F. At a touching node the equilibrium along the normal only tells Q: it gives its place in the
band to the closed gap. The scalars border the banded tangent of the wall.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.tube import lumen_volume
from ..numerics.banded import HALF_WIDTH, solve_banded_in_place, solve_small_in_place
from ..numerics.compiled import compiled
from ..pellet.contact import AUGMENTATION
from ..pellet.friction import sliding_velocity
from ..pellet.sphere import gap_and_normal
from ..wall.membrane import WallConstants, assemble_pressure, assemble_wall

TENSION_SCALE = 10.0
"""Tension against which force residuals are measured [mN/cm], about p0 r0."""
GAP_SCALE = 1.0e5
"""Weight of an open gap in the merit of the line search [mN/cm^3]: heavy, or a nearly slack wall refuses contact."""
ROUNDOFF = 16.0 * 2.0**-52
SMALLEST_STEP = 1.0 / 16.0
MEMORY = 2
"""The line search asks for less than the largest of this many last merits."""
FIRST_ALLOWANCE = 2.0
"""The first updates may raise the merit: they leave the kinks of the extrapolated guess."""

CONVERGED, NOT_CONVERGED, SINGULAR, OUT_OF_RANGE = range(4)
REASONS = (
    "converged",
    "Newton iteration limit reached",
    "singular tangent (static instability of the wall)",
    "stretch out of range",
)


class PelletConstants(NamedTuple):
    """Pellet and friction: cm, mN, s. `frame` w is 0 for friction at rest, 1 against the moving wall, Eq. (27).

    tangential: the reaction on the wall lies in its tangent plane, as that of Eq. (51) does; else it is axial.
    """

    present: bool
    radius: float
    viscous: float
    dry: float
    frame: float
    volume: float
    tangential: bool = False


class LumenConstants(NamedTuple):
    """Adiabatic lumen, Eq. (17): p = pressure*(reference_volume/V)^exponent in mN/cm^2 and cm^3."""

    pressure: float
    reference_volume: float
    exponent: float


class Step(NamedTuple):
    """Formulas of one step: wall rates (history*, slope), pellet Z = pellet_history + pellet_weight*velocity."""

    slope: float
    inertia: bool
    pellet_history: float
    pellet_weight: float


@compiled
def solve_equilibrium(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    scalars: np.ndarray,
    history: np.ndarray,
    velocity_history: np.ndarray,
    stretch_history: np.ndarray,
    hoop_history: np.ndarray,
    drive_longitudinal: np.ndarray,
    drive_circular: np.ndarray,
    friction_weight: np.ndarray,
    step: Step,
    wall: WallConstants,
    pellet: PelletConstants,
    lumen: LumenConstants,
    tolerance: float,
    gap_tolerance: float,
    max_iterations: int,
) -> tuple[int, int, int]:
    """Solve in place for rho, zeta [cm], density Q [mN/cm^2] and scalars (p, Z, F).

    history: position history (2, n); velocity_history: the same for velocities (inertia). tolerance: force residual
    over TENSION_SCALE; gap_tolerance: gap left at touching nodes [cm]. friction_weight: share of the friction reaction
    on each node (sums to one, or zero without contact). Returns (code, iterations, assemblies); unless the code is
    CONVERGED the arrays hold a trial state that must not be used.
    """
    n = rho.size
    size = 2 * n
    h = wall.element_size
    circumference = 2.0 * math.pi * wall.radius
    unit = TENSION_SCALE * h / wall.radius
    # Positions are known to one part in 2^52 of the tube's length; the dashpot turns that into a force.
    reachable = ROUNDOFF * zeta[n - 1] / h * wall.viscosity * step.slope / unit
    tolerance = max(tolerance, reachable)
    residual = np.empty(size)
    matrix = np.empty((size + HALF_WIDTH, 2 * HALF_WIDTH + 1))
    gradient = np.empty(size)
    right = np.zeros((size + HALF_WIDTH, 4))
    columns = 4 if pellet.present and pellet.frame != 0.0 else 3
    normal_row = np.empty((n, 2 * HALF_WIDTH + 2))
    normal_border = np.empty((n, 4))
    force_row = np.empty(size)
    border = np.empty((3, 3))
    border_right = np.empty(3)
    touching = np.zeros(n, np.bool_)
    gap = np.empty(n)
    nr = np.empty(n)
    nz = np.empty(n)
    d_density = np.empty(n)
    old_rho = rho.copy()
    old_zeta = zeta.copy()
    old_density = density.copy()
    old_scalars = scalars.copy()
    d_scalars = np.zeros(3)
    merits = np.full(MEMORY, math.inf)
    length = 1.0
    merit = math.inf
    iteration = 0
    evaluations = 0
    best_merit = math.inf
    best_length = 1.0
    settled = False
    while True:
        # Residual and tangent at the trial state.
        evaluations += 1
        residual[:] = 0.0
        matrix[:, :] = 0.0
        ok = assemble_wall(
            rho,
            zeta,
            history,
            stretch_history,
            hoop_history,
            step.slope,
            drive_longitudinal,
            drive_circular,
            wall,
            residual,
            matrix,
        )
        if ok:
            assemble_pressure(rho, zeta, scalars[0], wall, gradient, residual, matrix)
            if step.inertia:
                mass = wall.surface_density * h * step.slope
                for i in range(1, n - 1):
                    vr = (rho[i] - history[0, i]) * step.slope
                    vz = (zeta[i] - history[1, i]) * step.slope
                    residual[2 * i] += mass * (vr - velocity_history[0, i])
                    residual[2 * i + 1] += mass * (vz - velocity_history[1, i])
                    matrix[2 * i, HALF_WIDTH] += mass * step.slope
                    matrix[2 * i + 1, HALF_WIDTH] += mass * step.slope
            for k in range(2):
                residual[k] = 0.0
                residual[size - 1 - k] = 0.0
            volume = lumen_volume(rho, zeta) - (pellet.volume if pellet.present else 0.0)
            ok = volume > 0.0
        total = 0.0
        worst = math.inf
        if ok:
            law = lumen.pressure * (lumen.reference_volume / volume) ** lumen.exponent
            axial = 0.0
            wall_velocity = 0.0
            worst = 0.0
            if pellet.present:
                for i in range(1, n - 1):
                    gap[i], nr[i], nz[i], _ = gap_and_normal(rho[i], zeta[i] - scalars[1], pellet.radius)
                    touching[i] = density[i] - AUGMENTATION * gap[i] > 0.0
                    q = h * density[i]
                    residual[2 * i] -= q * nr[i]
                    residual[2 * i + 1] -= q * nz[i] + pellet.frame * friction_weight[i] * scalars[2] / circumference
                    if pellet.tangential:
                        pull = pellet.frame * friction_weight[i] / (circumference * rho[i])
                        residual[2 * i] += pull * scalars[2] * (zeta[i] - scalars[1])
                        matrix[2 * i, HALF_WIDTH] -= pull * scalars[2] * (zeta[i] - scalars[1]) / rho[i]
                        matrix[2 * i, HALF_WIDTH + 1] += pull * scalars[2]
                    axial -= circumference * q * nz[i]
                    wall_velocity += friction_weight[i] * (zeta[i] - history[1, i]) * step.slope
                    if touching[i]:
                        error = GAP_SCALE * abs(gap[i]) / TENSION_SCALE
                        worst = max(worst, abs(gap[i]) / gap_tolerance * tolerance)
                    else:
                        error = wall.radius * abs(density[i]) / TENSION_SCALE
                        worst = max(worst, error)
                    total += error * error
            for k in range(size):
                error = abs(residual[k]) / unit
                total += error * error
                worst = max(worst, error)
            r_pressure = scalars[0] - law
            speed, speed_slope = sliding_velocity(scalars[2], pellet.viscous, pellet.dry)
            r_centre = 0.0
            r_force = 0.0
            if pellet.present:
                r_force = scalars[2] - axial
                r_centre = (
                    scalars[1] - step.pellet_history - step.pellet_weight * (pellet.frame * wall_velocity + speed)
                )
            for error in (
                abs(r_pressure) * wall.radius / TENSION_SCALE,
                abs(r_force) / (circumference * TENSION_SCALE),
                abs(r_centre) * GAP_SCALE / TENSION_SCALE,
            ):
                total += error * error
                worst = max(worst, error)
            ok = math.isfinite(total)
        merit = math.sqrt(total) if ok else math.inf
        if ok and worst <= tolerance:
            return CONVERGED, iteration, evaluations
        # Line search: shorten the last update until the merit falls below the largest of the last ones. Where a
        # kink (slack, contact, sticking) lets no length pass, go on with the best one; only a small residual ends
        # the iteration.
        highest = 0.0
        for m in merits:
            highest = max(highest, m)
        if iteration > 0 and not settled and not (ok and merit <= (1.0 - 1e-4 * length) * highest):
            if merit < best_merit:
                best_merit = merit
                best_length = length
            length *= 0.5
            if length < SMALLEST_STEP:
                if not math.isfinite(best_merit):
                    return OUT_OF_RANGE, iteration, evaluations
                length = best_length
                settled = True
            for i in range(n):
                rho[i] = old_rho[i] + length * right[2 * i, 0]
                zeta[i] = old_zeta[i] + length * right[2 * i + 1, 0]
                density[i] = old_density[i] + length * d_density[i]
            for k in range(3):
                scalars[k] = old_scalars[k] + length * d_scalars[k]
            continue
        if not ok:
            return OUT_OF_RANGE, iteration, evaluations
        if iteration >= max_iterations:
            return NOT_CONVERGED, iteration, evaluations
        merits[iteration % MEMORY] = merit
        if iteration == 0:
            merits[:] = FIRST_ALLOWANCE * merit
        best_merit = math.inf
        settled = False
        # Border the band: columns of dp, dZ, dF, and the rows of the scalars.
        border[:, :] = 0.0
        force_row[:] = 0.0
        for k in range(size):
            right[k, 0] = -residual[k]
            right[k, 1] = -gradient[k]
            right[k, 2] = 0.0
            right[k, 3] = 0.0
        right[size:, :] = 0.0
        force_right = -r_force
        if pellet.present:
            for i in range(1, n - 1):
                r = 2 * i
                right[r + 1, 3] = -pellet.frame * friction_weight[i] / circumference
                if pellet.tangential:
                    pull = pellet.frame * friction_weight[i] / (circumference * rho[i])
                    right[r, 2] = -pull * scalars[2]
                    right[r, 3] = pull * (zeta[i] - scalars[1])
                if not touching[i]:
                    right[r, 0] -= h * density[i] * nr[i]
                    right[r + 1, 0] -= h * density[i] * nz[i]
                    force_right += circumference * h * density[i] * nz[i]
                    continue
                # Keep the normal equilibrium aside, h*dQ = normal_row.dx + normal_border.(1, dp, dZ, dF).
                for k in range(2 * HALF_WIDTH + 1):
                    normal_row[i, k] = nr[i] * matrix[r, k]
                normal_row[i, 2 * HALF_WIDTH + 1] = 0.0
                for k in range(2 * HALF_WIDTH + 1):
                    normal_row[i, k + 1] += nz[i] * matrix[r + 1, k]
                for c in range(4):
                    normal_border[i, c] = nr[i] * right[r, c] + nz[i] * right[r + 1, c]
                turn = h * density[i] / (gap[i] + pellet.radius)
                # Tangential equilibrium in the second row, the closed gap in the first.
                for k in range(2 * HALF_WIDTH):
                    matrix[r + 1, k] = nr[i] * matrix[r + 1, k] - nz[i] * matrix[r, k + 1]
                matrix[r + 1, 2 * HALF_WIDTH] *= nr[i]
                matrix[r + 1, HALF_WIDTH - 1] += turn * nz[i]
                matrix[r + 1, HALF_WIDTH] -= turn * nr[i]
                for c in range(4):
                    right[r + 1, c] = nr[i] * right[r + 1, c] - nz[i] * right[r, c]
                    right[r, c] = 0.0
                right[r + 1, 2] += turn * nr[i]
                matrix[r, :] = 0.0
                matrix[r, HALF_WIDTH] = nr[i]
                matrix[r, HALF_WIDTH + 1] = nz[i]
                right[r, 0] = -gap[i]
                right[r, 2] = -nz[i]
                # Row of dF - dF_z = force_right, with dF_z = -circumference * d(h Q n_zeta).
                share = circumference * nz[i]
                for k in range(2 * HALF_WIDTH + 2):
                    if 0 <= r + k - HALF_WIDTH < size:
                        force_row[r + k - HALF_WIDTH] += share * normal_row[i, k]
                force_right += share * normal_border[i, 0]
                for c in range(3):
                    border[2, c] += share * normal_border[i, c + 1]
                swing = circumference * turn * nr[i]
                force_row[r] -= swing * nz[i]
                force_row[r + 1] += swing * nr[i]
                border[2, 1] -= swing * nr[i]
        for k in range(2):
            for row in (k, size - 1 - k):
                matrix[row, :] = 0.0
                matrix[row, HALF_WIDTH] = 1.0
                right[row, :] = 0.0
        if not solve_banded_in_place(matrix, right, columns):
            return SINGULAR, iteration, evaluations
        # Border unknowns (dp, dZ, dF); x = x0 - dp*x1 - dZ*x2 - dF*x3.
        pressure_slope = -lumen.exponent * law / volume * circumference
        border[0, 0] = 1.0
        border_right[0] = -r_pressure
        border[1, 1] = 1.0
        border_right[1] = -r_centre
        border[2, 2] += 1.0
        border_right[2] = force_right if pellet.present else 0.0
        if pellet.present:
            border[1, 2] = -step.pellet_weight * speed_slope
        for k in range(size):
            row_pressure = -pressure_slope * gradient[k]
            border_right[0] -= row_pressure * right[k, 0]
            for c in range(3):
                border[0, c] -= row_pressure * right[k, c + 1]
            if pellet.present:
                border_right[2] -= force_row[k] * right[k, 0]
                for c in range(3):
                    border[2, c] -= force_row[k] * right[k, c + 1]
        if pellet.present and pellet.frame != 0.0:
            for i in range(1, n - 1):
                row_wall = -step.pellet_weight * pellet.frame * friction_weight[i] * step.slope
                border_right[1] -= row_wall * right[2 * i + 1, 0]
                for c in range(3):
                    border[1, c] -= row_wall * right[2 * i + 1, c + 1]
        if not solve_small_in_place(border, border_right):
            return SINGULAR, iteration, evaluations
        for k in range(3):
            d_scalars[k] = border_right[k]
        for k in range(size):
            right[k, 0] -= d_scalars[0] * right[k, 1] + d_scalars[1] * right[k, 2] + d_scalars[2] * right[k, 3]
        old_rho[:] = rho
        old_zeta[:] = zeta
        old_density[:] = density
        old_scalars[:] = scalars
        for i in range(n):
            d_density[i] = -density[i]
            if touching[i]:
                change = -normal_border[i, 0]
                for c in range(3):
                    change += normal_border[i, c + 1] * d_scalars[c]
                for k in range(2 * HALF_WIDTH + 2):
                    if 0 <= 2 * i + k - HALF_WIDTH < size:
                        change += normal_row[i, k] * right[2 * i + k - HALF_WIDTH, 0]
                d_density[i] = change / h
        length = 1.0
        iteration += 1
        for i in range(n):
            rho[i] += right[2 * i, 0]
            zeta[i] += right[2 * i + 1, 0]
            density[i] += d_density[i]
        for k in range(3):
            scalars[k] += d_scalars[k]
