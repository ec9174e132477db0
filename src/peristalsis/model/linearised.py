"""The equilibrium made linear: tangent of the nodes, what borders it, and the changes that follow from a solution.

At a touching node the equilibrium along the normal only tells Q: it gives its place in the band to the closed gap. The
scalars border the banded tangent of the wall.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.block_band import COLUMNS, DIAGONAL, RIGHT
from ..numerics.compiled import INDEX, compiled
from ..numerics.reductions import dot
from ..numerics.small import solve_small_in_place
from ..wall.assembly import FORCE_R, FORCE_Z, VOLUME_R, VOLUME_Z, wall_tangent
from .problem import (
    BEND,
    BORDER,
    CHANGE_Q,
    CHANGE_R,
    ENTRIES,
    FORCE_ROW,
    GAP,
    NORMAL,
    NORMAL_R,
    NORMAL_Z,
    TANGENT,
    TOUCHES,
    WEIGHT,
    Problem,
    Unknowns,
    Workspace,
)
from .residual import Balance


class Border(NamedTuple):
    """What the scalars (p, Z, F) add to the tangent of the nodes: matrix (3, 3), and their changes (3,)."""

    matrix: np.ndarray
    changes: np.ndarray


@compiled
def linearise(
    unknowns: Unknowns, problem: Problem, first: int, last: int, tables: Workspace, border: np.ndarray
) -> float:
    """Linear system of the nodes first...last: tangent, and columns of 1, dp, dZ, dF on the right.

    At touching nodes the equilibrium along the normal is set aside in `work`. Its FORCE_ROW and border[2] receive the
    row of dF - dF_z; the right-hand side of that, without the residual, is returned.
    """
    rho, zeta, density, scalars = unknowns.rho, unknowns.zeta, unknowns.density, unknowns.scalars
    known, wall, pellet, step = problem.known, problem.wall, problem.pellet, problem.step
    work, system = tables.work, tables.system
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
    circumference = problem.circumference
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
def changes(
    density: np.ndarray,
    d_scalars: np.ndarray,
    element_size: float,
    first: int,
    last: int,
    columns: int,
    tables: Workspace,
) -> None:
    """Changes of rho, zeta and Q at the nodes first...last from the solved system and the change of the scalars."""
    work, system = tables.work, tables.system
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
def scalar_changes(
    problem: Problem, now: Balance, force_right: float, columns: int, tables: Workspace, border: Border
) -> bool:
    """Changes of the scalars from the solved columns of the nodes into border.changes; False when singular.

    force_right, border.matrix: from `linearise`; the matrix is used up.
    """
    known, pellet, lumen, step = problem.known, problem.pellet, problem.lumen, problem.step
    work, system = tables.work, tables.system
    matrix, right = border.matrix, border.changes
    n = known.shape[1]
    first = min(1, n)
    # Border unknowns (dp, dZ, dF); x = x0 - dp*x1 - dZ*x2 - dF*x3.
    pressure_slope = -lumen.exponent * now.law / now.volume * problem.circumference
    matrix[0, 0] = 1.0
    right[0] = -now.pressure
    matrix[1, 1] = 1.0
    right[1] = -now.centre
    matrix[2, 2] += 1.0
    right[2] = force_right if pellet.present else 0.0
    if pellet.present:
        matrix[1, 2] = -step.pellet_weight * now.speed_slope
        matrix[1, 1] += step.pellet_weight * now.speed_slope * now.pull_slope
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
            right[0] -= by_pressure
            right[1] -= by_centre
            right[2] -= by_force
        else:
            matrix[0, c - 1] -= by_pressure
            matrix[1, c - 1] -= by_centre
            matrix[2, c - 1] -= by_force
    return solve_small_in_place(matrix, right)
