"""A stretch of wall around the large residuals, brought to rest by itself with everything else held.

What makes the iteration over all unknowns long is local: a wall element that goes slack or taut where the wave arrives,
a node that joins or leaves the contact. After this, that iteration meets a smooth remainder.
"""

from __future__ import annotations

import numpy as np

from ..numerics.block_band import solve_blocks_in_place
from ..numerics.compiled import compiled
from ..wall.assembly import FORCE_R, FORCE_Z
from .line_search import keep
from .linearised import changes, linearise
from .problem import CHANGE_Q, CHANGE_R, CHANGE_Z, LOCAL_Q, LOCAL_R, LOCAL_Z, Problem, Unknowns, Workspace
from .residual import forces, measure

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


@compiled
def settle_stretch(unknowns: Unknowns, problem: Problem, worst: float, tables: Workspace) -> int:
    """Bring the stretch of wall around the large residuals to rest with all else held; how many iterations it took.

    Keeps the best state it has seen, the first one included, and leaves the forces evaluated there.
    """
    rho, zeta, density = unknowns.rho, unknowns.zeta, unknowns.density
    work, system = tables.work, tables.system
    n = rho.size
    loud = LOCAL_SHARE * worst * problem.unit
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
    begin, _ = measure(density, problem, first, last, work)
    best = begin
    d_scalars = np.zeros(3)
    border = np.zeros((3, 3))
    keep(unknowns, first, last, LOCAL_R + columns - 1, work)
    kept = True
    taken = 0
    while taken < LOCAL_ITERATIONS:
        linearise(unknowns, problem, first, last, tables, border)
        if not solve_blocks_in_place(system, first, size, columns):
            break
        changes(density, d_scalars, problem.wall.element_size, first, last, columns, tables)
        taken += 1
        for i in range(first, last + 1):
            rho[i] += work[CHANGE_R, i]
            zeta[i] += work[CHANGE_Z, i]
            density[i] += work[CHANGE_Q, i]
        kept = False
        if not forces(unknowns, problem, outer_first, outer_last, work):
            break
        total, _ = measure(density, problem, first, last, work)
        if total < best:
            best = total
            kept = True
            keep(unknowns, first, last, LOCAL_R + columns - 1, work)
            if total <= LOCAL_GOAL * LOCAL_GOAL * begin:
                break
        elif not total < 100.0 * begin:
            break
    if not kept:
        for i in range(first, last + 1):
            rho[i], zeta[i], density[i] = work[LOCAL_R, i], work[LOCAL_Z, i], work[LOCAL_Q, i]
        forces(unknowns, problem, outer_first, outer_last, work)
    return taken
