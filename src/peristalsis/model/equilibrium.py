"""Wall, lumen and pellet in equilibrium at the end of a step: one Newton iteration over all of them.

Unknowns are the wall nodes, the contact densities Q, and three scalars: lumen pressure p, pellet centre Z and axial
force F. At a touching node the equilibrium along the normal only tells Q: it gives its place in the
band to the closed gap. The scalars border the banded tangent of the wall.

What makes the iteration long is local: a wall element that goes slack or taut where the wave arrives, a node that
joins or leaves the contact. So a stretch of wall around the large residuals is first brought to rest by itself, with
everything else held; the iteration over all unknowns then meets a smooth remainder, and it alone decides about
convergence.
"""

from __future__ import annotations

import math
import threading
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.tube import lumen_volume
from ..numerics.block_band import COLUMNS, DIAGONAL, PADDING, RIGHT, ROWS, solve_blocks_in_place
from ..numerics.compiled import INDEX, compiled
from ..numerics.reductions import dot, squares_and_largest
from ..numerics.small import solve_small_in_place
from ..pellet.body import unpack_pellet
from ..pellet.contact import AUGMENTATION
from ..pellet.friction import held_by_ends, sliding_velocity
from ..pellet.shapes.sphere import gap_and_normal
from ..wall.assembly import (
    FORCE_R,
    FORCE_Z,
    HISTORY_HOOP,
    HISTORY_R,
    HISTORY_STRETCH,
    HISTORY_Z,
    KNOWN_ROWS,
    VOLUME_R,
    VOLUME_Z,
    WALL_ROWS,
    set_drives,
    wall_forces,
    wall_tangent,
)
from ..wall.constants import WallConstants
from ..wall.unpacking import unpack_wall
from .constants import LumenConstants, PelletConstants, Step, packed, unpack_lumen
from .rounding import at_rounding

__all__ = ["LumenConstants", "PelletConstants", "Step", "solve_equilibrium", "solve_packed", "workspace"]

Floats = NDArray[np.float64]

TENSION_SCALE = 10.0
"""Tension against which force residuals are measured [mN/cm], about p0 r0."""
GAP_SCALE = 1.0e5
"""Weight of an open gap in the merit of the line search [mN/cm^3]: heavy, or a nearly slack wall refuses contact."""
ROUNDOFF = 16.0 * 2.0**-52
SCALAR_ROUNDING = 1e-13
"""Share of pressure and axial force that the rounding of the sums they follow from may take."""
LARGEST_ROUNDING = 1e-3
"""Rounding of the forces above this residual is no state of rest: of tensions beyond 1e9 mN/cm or so."""
SHORTER = 0.25
SMALLEST_STEP = 1.0 / 16.0
"""Lengths of the line search: 1, 1/4, 1/16. Where a kink spoils the whole update, one half as long does no better."""
MEMORY = 2
KINK_ALLOWANCE = 2.0
"""The line search asks for less than this times the largest of so many last merits: an update may pass a kink."""
FIRST_ALLOWANCE = 2.0
"""The first updates may raise the merit: they leave the kinks of the extrapolated guess."""

CONVERGED, NOT_CONVERGED, SINGULAR, OUT_OF_RANGE, ROUNDED = range(5)
"""ROUNDED: the iteration stands still at forces that are no more than rounding, Eq. (58), above the tolerance."""
REASONS = (
    "converged",
    "Newton iteration limit reached",
    "singular tangent (static instability of the wall)",
    "stretch out of range",
    "converged to the rounding of the forces",
)
STALLED = 3
"""Iterations without a residual half as large as the smallest before, after which rounding is asked for."""


LOCAL_SHARE = 0.01
"""Nodes with a residual above this share of the largest belong to the stretch that is solved by itself."""
LOCAL_MARGIN = 16
"""Nodes added to it on either side."""
LOCAL_WIDTH = 0.4
"""A stretch longer than this share of the wall is left to the iteration over all unknowns."""
LOCAL_ITERATIONS = 4
LOCAL_GOAL = 0.003
"""The stretch is left when its residual fell to this share."""
LOCAL_WORTH = 0.1
"""Largest residual below which the iteration over all unknowns needs no help."""
KNOWN = KNOWN_ROWS + 4
VELOCITY_R, VELOCITY_Z, WEIGHT, TANGENT = range(KNOWN_ROWS, KNOWN)
"""Rows of `known` beyond those of the wall: histories of the velocities [cm/s] (inertia), shares of the friction, and
what of these lies along the meridian."""
GAP, NORMAL_R, NORMAL_Z, TOUCHES = range(WALL_ROWS, WALL_ROWS + 4)
CHANGE_R, CHANGE_Z, CHANGE_Q, KEPT_R, KEPT_Z, KEPT_Q = range(WALL_ROWS + 4, WALL_ROWS + 10)
LOCAL_R, LOCAL_Z, LOCAL_Q = range(WALL_ROWS + 10, WALL_ROWS + 13)
FORCE_ROW = WALL_ROWS + 13  # derivatives of the pellet's force by rho and zeta
BORDER = WALL_ROWS + 15  # along the normal of touching nodes: 1, dp, dZ, dF
NORMAL = WALL_ROWS + 19  # along the normal of touching nodes: the ten entries of the tangent
ENTRIES = 10
BEND = NORMAL + ENTRIES  # radius of curvature of the contact along the meridian, Eq. (71)
WORK = BEND + 1
"""Rows of `work` beyond those of the wall: contact at the nodes, changes in an iteration, states to go back to, and
what the row of the pellet's force is made of."""


class Settings(NamedTuple):
    """What a solve is asked for: formulas of the step, tolerances, limit of iterations; and scales that follow."""

    step: Step
    tolerance: float
    gap_tolerance: float
    max_iterations: int
    unit: float
    circumference: float


@compiled
def _forces(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    scalars: np.ndarray,
    known: np.ndarray,
    wall: WallConstants,
    pellet: PelletConstants,
    settings: Settings,
    first: int,
    last: int,
    work: np.ndarray,
) -> bool:
    """Residual forces on the nodes first...last, and where they touch the pellet; False out of range."""
    step = settings.step
    if not wall_forces(rho, zeta, known, step.slope, wall, first, last, work):
        return False
    first, high = first & INDEX, (last + 1) & INDEX
    for i in range(first, high):
        work[FORCE_R, i] -= scalars[0] * work[VOLUME_R, i]
        work[FORCE_Z, i] -= scalars[0] * work[VOLUME_Z, i]
    h = wall.element_size
    if step.inertia:
        mass = wall.surface_density * h * step.slope
        for i in range(first, high):
            work[FORCE_R, i] += mass * ((rho[i] - known[HISTORY_R, i]) * step.slope - known[VELOCITY_R, i])
            work[FORCE_Z, i] += mass * ((zeta[i] - known[HISTORY_Z, i]) * step.slope - known[VELOCITY_Z, i])
    if pellet.present:
        reaction = pellet.frame * scalars[2] / settings.circumference
        for i in range(first, high):
            axial = zeta[i] - scalars[1]
            work[TOUCHES, i] = 0.0
            work[FORCE_Z, i] -= reaction * known[WEIGHT, i]
            rubbed = pellet.tangential and known[TANGENT, i] != 0.0
            if density[i] == 0.0 and not rubbed and (axial < -pellet.oral or axial > pellet.anal):
                continue
            gap, normal_r, normal_z, bend, _ = gap_and_normal(rho[i], axial, pellet.shape)
            work[GAP, i] = gap
            work[NORMAL_R, i] = normal_r
            work[NORMAL_Z, i] = normal_z
            work[BEND, i] = bend
            if rubbed:
                work[FORCE_R, i] += reaction * known[TANGENT, i] * normal_z / normal_r
            if density[i] - AUGMENTATION * gap > 0.0:
                work[TOUCHES, i] = 1.0
            q = h * density[i]
            work[FORCE_R, i] -= q * normal_r
            work[FORCE_Z, i] -= q * normal_z
    return True


@compiled
def _measure(
    density: np.ndarray, wall: WallConstants, settings: Settings, first: int, last: int, work: np.ndarray
) -> tuple[float, float]:
    """(sum of squares, largest) of the scaled residuals at the nodes first...last, as acceptance sees the largest."""
    first, high = first & INDEX, (last + 1) & INDEX
    open_unit = wall.radius / TENSION_SCALE
    gap_unit = GAP_SCALE / TENSION_SCALE
    gap_weight = settings.tolerance / settings.gap_tolerance
    squares_r, loudest_r = squares_and_largest(work[FORCE_R], first, high)
    squares_z, loudest_z = squares_and_largest(work[FORCE_Z], first, high)
    total = (squares_r + squares_z) / (settings.unit * settings.unit)
    worst = max(loudest_r, loudest_z) / settings.unit
    for i in range(first, high):
        if work[TOUCHES, i] != 0.0:
            error = gap_unit * abs(work[GAP, i])
            worst = max(worst, abs(work[GAP, i]) * gap_weight)
        elif density[i] != 0.0:
            error = open_unit * abs(density[i])
            worst = max(worst, error)
        else:
            continue
        total += error * error
    return total, worst


@compiled
def _linearise(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    scalars: np.ndarray,
    known: np.ndarray,
    wall: WallConstants,
    pellet: PelletConstants,
    settings: Settings,
    first: int,
    last: int,
    work: np.ndarray,
    system: np.ndarray,
    border: np.ndarray,
) -> float:
    """Linear system of the nodes first...last: tangent, and columns of 1, dp, dZ, dF on the right.

    At touching nodes the equilibrium along the normal is set aside in `work`. Its FORCE_ROW and border[2] receive the
    row of dF - dF_z; the right-hand side of that, without the residual, is returned.
    """
    step = settings.step
    wall_tangent(rho, zeta, scalars[0], step.slope, wall, first, last, work, system)
    first, high = first & INDEX, (last + 1) & INDEX
    h = wall.element_size
    for i in range(first, high):
        system[RIGHT, i] = -work[FORCE_R, i]
        system[RIGHT + 1, i] = -work[FORCE_Z, i]
        system[RIGHT + 2, i] = -work[VOLUME_R, i]
        system[RIGHT + 3, i] = -work[VOLUME_Z, i]
        system[RIGHT + 4, i] = 0.0
        system[RIGHT + 5, i] = 0.0
    if step.inertia:
        mass = wall.surface_density * h * step.slope * step.slope
        for i in range(first, high):
            system[DIAGONAL, i] += mass
            system[DIAGONAL + 3, i] += mass
    force_right = 0.0
    if not pellet.present:
        return force_right
    circumference = settings.circumference
    if pellet.frame != 0.0:
        for i in range(first, high):
            system[RIGHT + 6, i] = 0.0
            system[RIGHT + 7, i] = -pellet.frame * known[WEIGHT, i] / circumference
    if pellet.tangential:
        for i in range(first, high):
            if known[TANGENT, i] == 0.0:
                continue
            nr, nz = work[NORMAL_R, i], work[NORMAL_Z, i]
            pull = pellet.frame * known[TANGENT, i] / (circumference * nr)
            turn = pull * scalars[2] / (work[BEND, i] * nr)
            system[DIAGONAL, i] -= turn * nz
            system[DIAGONAL + 1, i] += turn * nr
            system[RIGHT + 4, i] = -turn * nr
            system[RIGHT + 6, i] = pull * nz
    for i in range(first, high):
        nr, nz = work[NORMAL_R, i], work[NORMAL_Z, i]
        if work[TOUCHES, i] == 0.0:
            if density[i] != 0.0:
                system[RIGHT, i] -= h * density[i] * nr
                system[RIGHT + 1, i] -= h * density[i] * nz
                force_right += circumference * h * density[i] * nz
            continue
        # Keep the normal equilibrium aside, h*dQ = NORMAL.dx + BORDER.(1, dp, dZ, dF); the tangential one takes the
        # second row, the closed gap the first.
        turn = h * density[i] / work[BEND, i]
        share = circumference * nz
        for k in range(ENTRIES + COLUMNS):
            # Right-hand sides continue the blocks: two numbers for every column.
            above = 4 * (k // 2) + k % 2 if k < ENTRIES else RIGHT + 2 * (k - ENTRIES)
            below = above + 2 if k < ENTRIES else above + 1
            along_r, along_z = system[above, i], system[below, i]
            work[NORMAL + k if k < ENTRIES else BORDER + k - ENTRIES, i] = nr * along_r + nz * along_z
            system[below, i] = nr * along_z - nz * along_r
            system[above, i] = 0.0
        system[DIAGONAL + 2, i] += turn * nz
        system[DIAGONAL + 3, i] -= turn * nr
        system[RIGHT + 5, i] += turn * nr
        system[DIAGONAL, i] = nr
        system[DIAGONAL + 1, i] = nz
        system[RIGHT, i] = -work[GAP, i]
        system[RIGHT + 4, i] = -nz
        # Row of dF - dF_z, with dF_z = -circumference * d(h Q n_zeta).
        for k in range(ENTRIES):
            node = i + k // 2 - 2
            if 0 <= node < rho.size:
                work[FORCE_ROW + k % 2, node] += share * work[NORMAL + k, i]
        force_right += share * work[BORDER, i]
        for c in range(3):
            border[2, c] += share * work[BORDER + 1 + c, i]
        swing = circumference * turn * nr
        work[FORCE_ROW, i] -= swing * nz
        work[FORCE_ROW + 1, i] += swing * nr
        border[2, 1] -= swing * nr
    return force_right


@compiled
def _changes(
    density: np.ndarray,
    d_scalars: np.ndarray,
    element_size: float,
    first: int,
    last: int,
    columns: int,
    system: np.ndarray,
    work: np.ndarray,
) -> None:
    """Changes of rho, zeta and Q at the nodes first...last from the solved system and the change of the scalars."""
    first, high = first & INDEX, (last + 1) & INDEX
    for a in range(2):
        for i in range(first, high):
            work[CHANGE_R + a, i] = system[RIGHT + a, i]
        for c in range(1, columns):
            for i in range(first, high):
                work[CHANGE_R + a, i] -= d_scalars[c - 1] * system[RIGHT + 2 * c + a, i]
    for i in range(first, high):
        work[CHANGE_Q, i] = -density[i]
        if work[TOUCHES, i] != 0.0:
            total = -work[BORDER, i]
            for c in range(3):
                total += work[BORDER + 1 + c, i] * d_scalars[c]
            for k in range(ENTRIES):
                node = i + k // 2 - 2
                if first <= node < high:
                    total += work[NORMAL + k, i] * work[CHANGE_R + k % 2, node]
            work[CHANGE_Q, i] = total / element_size


@compiled
def _settle_stretch(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    scalars: np.ndarray,
    known: np.ndarray,
    wall: WallConstants,
    pellet: PelletConstants,
    settings: Settings,
    worst: float,
    work: np.ndarray,
    system: np.ndarray,
) -> int:
    """Bring the stretch of wall around the large residuals to rest with all else held; how many iterations it took.

    Keeps the best state it has seen, the first one included, and leaves the forces evaluated there.
    """
    n = rho.size
    loud = LOCAL_SHARE * worst * settings.unit
    low, high = n, 0
    for i in range(1, n - 1):
        if abs(work[FORCE_R, i]) > loud or abs(work[FORCE_Z, i]) > loud:
            low = min(low, i)
            high = i
    first = max(1, low - LOCAL_MARGIN)
    last = min(n - 2, high + LOCAL_MARGIN)
    size = last - first + 1
    if size < 1 or size > LOCAL_WIDTH * n:
        return 0
    # Two nodes beyond the stretch feel it move, through bending.
    outer_first, outer_last = max(1, first - 2), min(n - 2, last + 2)
    columns = min(1, n)  # not a literal, for which the callee would be compiled once more
    begin, _ = _measure(density, wall, settings, first, last, work)
    best = begin
    d_scalars = np.zeros(3)
    border = np.zeros((3, 3))
    _keep(rho, zeta, density, first, last, LOCAL_R + columns - 1, work)
    kept = True
    taken = 0
    while taken < LOCAL_ITERATIONS:
        _linearise(
            rho, zeta, density, scalars, known, wall, pellet, settings, first, last, work, system, border
        )  # fmt: skip
        if not solve_blocks_in_place(system, first, size, columns):
            break
        _changes(density, d_scalars, wall.element_size, first, last, columns, system, work)
        taken += 1
        for i in range(first, last + 1):
            rho[i] += work[CHANGE_R, i]
            zeta[i] += work[CHANGE_Z, i]
            density[i] += work[CHANGE_Q, i]
        kept = False
        if not _forces(
            rho, zeta, density, scalars, known, wall, pellet, settings, outer_first, outer_last, work
        ):  # fmt: skip
            break
        total, _ = _measure(density, wall, settings, first, last, work)
        if total < best:
            best = total
            kept = True
            _keep(rho, zeta, density, first, last, LOCAL_R + columns - 1, work)
            if total <= LOCAL_GOAL * LOCAL_GOAL * begin:
                break
        elif not total < 100.0 * begin:
            break
    if not kept:
        for i in range(first, last + 1):
            rho[i], zeta[i], density[i] = work[LOCAL_R, i], work[LOCAL_Z, i], work[LOCAL_Q, i]
        _forces(rho, zeta, density, scalars, known, wall, pellet, settings, outer_first, outer_last, work)
    return taken


@compiled
def _keep(
    rho: np.ndarray, zeta: np.ndarray, density: np.ndarray, first: int, last: int, row: int, work: np.ndarray
) -> None:
    for i in range(first, last + 1):
        work[row, i], work[row + 1, i], work[row + 2, i] = rho[i], zeta[i], density[i]


@compiled
def solve_packed(
    rho: np.ndarray,
    zeta: np.ndarray,
    density: np.ndarray,
    scalars: np.ndarray,
    known: np.ndarray,
    wall_numbers: np.ndarray,
    pellet_numbers: np.ndarray,
    lumen_numbers: np.ndarray,
    settings_numbers: np.ndarray,
    work: np.ndarray,
    system: np.ndarray,
) -> tuple[int, int, int]:
    """`solve_equilibrium` on tables and packed constants; `known` has KNOWN rows and a column for every node.

    settings_numbers: slope, inertia, pellet_history, pellet_weight of `Step`, tolerance, gap_tolerance, max_iterations;
    where the code is ROUNDED, the tolerance is overwritten by the residual that was reached.
    work, system: `workspace(n)`; what stands in them beforehand does not matter.
    """
    wall, pellet, lumen = unpack_wall(wall_numbers), unpack_pellet(pellet_numbers), unpack_lumen(lumen_numbers)
    s = settings_numbers
    step = Step(s[0], s[1] != 0.0, s[2], s[3])
    n = rho.size
    h = wall.element_size
    circumference = 2.0 * math.pi * wall.radius
    unit = TENSION_SCALE * h / wall.radius
    # Positions are known to one part in 2^52 of the tube's length; the dashpot turns that into a force.
    tolerance = max(s[4], ROUNDOFF * zeta[n - 1] / h * wall.viscosity * step.slope / unit)
    settings = Settings(step, tolerance, s[5], int(s[6]), unit, circumference)
    # All other rows are written before they are read.
    work[TOUCHES] = 0.0
    system[RIGHT + 6] = 0.0
    system[RIGHT + 7] = 0.0
    system[:, n:] = 0.0
    first, last = min(1, n), n - 2
    columns = 4 if pellet.present and pellet.frame != 0.0 else 3
    border = np.empty((3, 3))
    border_right = np.empty(3)
    old_scalars = scalars.copy()
    d_scalars = np.zeros(3)
    merits = np.full(MEMORY, math.inf)
    length = 1.0
    iteration = 0
    evaluations = 0
    best_merit = math.inf
    best_length = 1.0
    settled = False  # the state is not to be judged by the line search
    evaluated = False  # forces belong to the state
    fresh = True  # the stretch of large residuals has not been looked at since the last update
    smallest = math.inf  # residual so far
    stalled = 0
    while True:
        if not evaluated:
            evaluations += 1
            evaluated = _forces(rho, zeta, density, scalars, known, wall, pellet, settings, first, last, work)
        ok = evaluated
        total = 0.0
        worst = math.inf
        law = r_pressure = r_force = r_centre = speed_slope = volume = 0.0
        if ok:
            volume = lumen_volume(rho, zeta) - (pellet.volume if pellet.present else 0.0)
            ok = volume > 0.0
        if ok:
            law = lumen.pressure * (lumen.reference_volume / volume) ** lumen.exponent
            total, worst = _measure(density, wall, settings, first, last, work)
            r_pressure = scalars[0] - law
            if pellet.present:
                speed, speed_slope = sliding_velocity(scalars[2], pellet.viscous, pellet.dry)
                axial = 0.0
                wall_velocity = 0.0
                for i in range(1, n - 1):
                    if density[i] != 0.0:
                        axial -= circumference * h * density[i] * work[NORMAL_Z, i]
                        wall_velocity += known[WEIGHT, i] * (zeta[i] - known[HISTORY_Z, i]) * step.slope
                    elif known[WEIGHT, i] != 0.0:
                        wall_velocity += known[WEIGHT, i] * (zeta[i] - known[HISTORY_Z, i]) * step.slope
                r_force = scalars[2] - axial
                r_centre = (
                    scalars[1] - step.pellet_history - step.pellet_weight * (pellet.frame * wall_velocity + speed)
                )
                if held_by_ends(scalars[1] - r_centre, pellet.lowest, pellet.highest):
                    r_centre = scalars[1] - min(max(scalars[1] - r_centre, pellet.lowest), pellet.highest)
                    speed_slope = 0.0
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
        if iteration > 0 and not settled and not (ok and merit <= KINK_ALLOWANCE * highest):
            if merit < best_merit:
                best_merit = merit
                best_length = length
            length *= SHORTER
            if length < SMALLEST_STEP:
                if not math.isfinite(best_merit):
                    return OUT_OF_RANGE, iteration, evaluations
                length = best_length
                settled = True
            for i in range(first, n - 1):
                rho[i] = work[KEPT_R, i] + length * work[CHANGE_R, i]
                zeta[i] = work[KEPT_Z, i] + length * work[CHANGE_Z, i]
                density[i] = work[KEPT_Q, i] + length * work[CHANGE_Q, i]
            for k in range(3):
                scalars[k] = old_scalars[k] + length * d_scalars[k]
            evaluated = False
            continue
        if not ok:
            return OUT_OF_RANGE, iteration, evaluations
        if iteration >= settings.max_iterations:
            return NOT_CONVERGED, iteration, evaluations
        if fresh and worst > LOCAL_WORTH:
            fresh = False
            taken = _settle_stretch(
                rho, zeta, density, scalars, known, wall, pellet, settings, worst, work, system
            )  # fmt: skip
            if taken > 0:
                settled = True
                continue
        stalled = 0 if worst < 0.5 * smallest else stalled + 1
        smallest = min(smallest, worst)
        if stalled >= STALLED and worst < LARGEST_ROUNDING:
            apart = abs(r_pressure) > max(tolerance * TENSION_SCALE / wall.radius, SCALAR_ROUNDING * abs(law))
            force_unit = circumference * TENSION_SCALE
            apart = apart or abs(r_force) > max(tolerance * force_unit, SCALAR_ROUNDING * abs(scalars[2]))
            centre_rounding = ROUNDOFF * max(abs(scalars[1]), zeta[n - 1])
            apart = apart or abs(r_centre) > max(tolerance * TENSION_SCALE / GAP_SCALE, centre_rounding)
            for i in range(first, n - 1):
                if work[TOUCHES, i] != 0.0:
                    apart = apart or abs(work[GAP, i]) > max(settings.gap_tolerance, centre_rounding)
                else:
                    apart = apart or abs(density[i]) * wall.radius > tolerance * TENSION_SCALE
            if not apart and at_rounding(
                rho, zeta, density, scalars[0], step.slope, wall, tolerance * unit, work
            ):  # fmt: skip
                s[4] = worst
                return ROUNDED, iteration, evaluations
        merits[iteration % MEMORY] = merit
        if iteration == 0:
            merits[:] = FIRST_ALLOWANCE * merit
        best_merit = math.inf
        settled = False
        border[:, :] = 0.0
        work[FORCE_ROW] = 0.0
        work[FORCE_ROW + 1] = 0.0
        force_right = -r_force + _linearise(
            rho, zeta, density, scalars, known, wall, pellet, settings, first, last, work, system, border
        )
        if not solve_blocks_in_place(system, first, n - 2, columns):
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
        for c in range(columns):
            column_r, column_z = system[RIGHT + 2 * c], system[RIGHT + 2 * c + 1]
            by_pressure = -dot(work[VOLUME_R], column_r, first, n - 1) - dot(work[VOLUME_Z], column_z, first, n - 1)
            by_force = by_centre = 0.0
            if pellet.present:
                by_force = dot(work[FORCE_ROW], column_r, first, n - 1)
                by_force += dot(work[FORCE_ROW + 1], column_z, first, n - 1)
                if pellet.frame != 0.0:
                    by_centre = -dot(known[WEIGHT], column_z, first, n - 1)
                    by_centre *= step.pellet_weight * pellet.frame * step.slope
            by_pressure *= pressure_slope
            if c == 0:
                border_right[0] -= by_pressure
                border_right[1] -= by_centre
                border_right[2] -= by_force
            else:
                border[0, c - 1] -= by_pressure
                border[1, c - 1] -= by_centre
                border[2, c - 1] -= by_force
        if not solve_small_in_place(border, border_right):
            return SINGULAR, iteration, evaluations
        d_scalars[:] = border_right
        _changes(density, d_scalars, h, first, last, columns, system, work)
        _keep(rho, zeta, density, first, last, KEPT_R + first - 1, work)
        old_scalars[:] = scalars
        length = 1.0
        iteration += 1
        for i in range(first, n - 1):
            rho[i] += work[CHANGE_R, i]
            zeta[i] += work[CHANGE_Z, i]
            density[i] += work[CHANGE_Q, i]
        for k in range(3):
            scalars[k] += d_scalars[k]
        evaluated = False
        fresh = True


_kept = threading.local()


def workspace(n: int) -> tuple[Floats, Floats]:
    """Tables for `solve_packed` with n nodes, one pair a thread, kept: half a megabyte is not asked for every step."""
    if getattr(_kept, "nodes", 0) != n:
        _kept.nodes = n
        _kept.tables = np.empty((WORK, n)), np.empty((ROWS, n + PADDING))
    tables: tuple[Floats, Floats] = _kept.tables
    return tables


def solve_equilibrium(
    rho: Floats,
    zeta: Floats,
    density: Floats,
    scalars: Floats,
    history: Floats,
    velocity_history: Floats,
    stretch_history: Floats,
    hoop_history: Floats,
    drive_longitudinal: Floats,
    drive_circular: Floats,
    friction_weight: Floats,
    step: Step,
    wall: WallConstants,
    pellet: PelletConstants,
    lumen: LumenConstants,
    tolerance: float,
    gap_tolerance: float,
    max_iterations: int,
) -> tuple[int, int, int]:
    """Solve in place for rho, zeta [cm], density Q [mN/cm^2] and scalars (p, Z, F).

    history: position history (2, n); velocity_history: the same for velocities (inertia). drives: of half elements
    [mV], (2n - 2,). tolerance: force residual over TENSION_SCALE; gap_tolerance: gap left at touching nodes [cm].
    friction_weight: share of the friction reaction on each node (sums to one, or zero without contact). Returns
    (code, iterations over all unknowns, assemblies of the whole wall); unless the code is CONVERGED the arrays hold a
    trial state that must not be used.
    """
    known = np.zeros((KNOWN, rho.size))
    known[HISTORY_R : HISTORY_Z + 1] = history
    known[VELOCITY_R : VELOCITY_Z + 1] = velocity_history
    known[HISTORY_STRETCH, :-1] = stretch_history
    known[HISTORY_HOOP] = hoop_history
    known[WEIGHT] = friction_weight
    known[TANGENT] = friction_weight  # looked at where the reaction is tangential, and then all of it is
    set_drives(drive_longitudinal, drive_circular, known)
    settings = np.array([*step, tolerance, gap_tolerance, max_iterations], dtype=np.float64)
    # The copy can be written to, as the pellet's numbers in `wall_step.step_wall`: one compiled variant does for both.
    constants = packed(wall), packed(pellet).copy(), packed(lumen)
    code, iterations, assemblies = solve_packed(
        rho, zeta, density, scalars, known, *constants, settings, *workspace(rho.size)
    )
    return code, iterations, assemblies
