"""Wall, lumen and pellet in equilibrium at the end of a step: one Newton iteration over all of them.

Unknowns are the wall nodes, the contact densities Q, and three scalars: lumen pressure p, pellet centre Z and axial
force F. How far a state is from equilibrium is in `residual`, what an update follows from in `linearised`, how much of
it is made in `line_search`. Where the wave arrives and where contact begins or ends, `settling` first brings a stretch
of wall to rest by itself; the iteration over all unknowns alone decides about convergence.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.block_band import RIGHT, solve_blocks_in_place
from ..numerics.compiled import compiled
from ..pellet.body import unpack_pellet
from ..wall.assembly import HISTORY_HOOP, HISTORY_R, HISTORY_STRETCH, HISTORY_Z, set_drives
from ..wall.constants import WallConstants
from ..wall.unpacking import unpack_wall
from .constants import LumenConstants, PelletConstants, Step, packed, unpack_lumen
from .line_search import FIRST_ALLOWANCE, MEMORY, SHORTER, SMALLEST_STEP, go, go_part, keep, passes
from .linearised import Border, changes, linearise, scalar_changes
from .problem import (
    FORCE_ROW,
    KEPT_R,
    KNOWN,
    TANGENT,
    TOUCHES,
    VELOCITY_R,
    VELOCITY_Z,
    WEIGHT,
    Limits,
    Problem,
    Unknowns,
    Workspace,
    posed,
    workspace,
)
from .residual import balance, forces
from .rounding import at_rounding
from .settling import LOCAL_WORTH, settle_stretch
from .verdicts import (
    CONVERGED,
    NOT_CONVERGED,
    OUT_OF_RANGE,
    REASONS,
    ROUNDED,
    SINGULAR,
    TENSION_SCALE,
    Verdict,
)

__all__ = [
    "CONVERGED",
    "KNOWN",
    "NOT_CONVERGED",
    "OUT_OF_RANGE",
    "REASONS",
    "ROUNDED",
    "SINGULAR",
    "TENSION_SCALE",
    "History",
    "Limits",
    "LumenConstants",
    "PackedConstants",
    "PelletConstants",
    "Step",
    "Unknowns",
    "solve",
    "solve_equilibrium",
    "solve_packed",
    "workspace",
]

Floats = NDArray[np.float64]

STALLED = 3
"""Iterations without a residual half as large as the smallest before, after which rounding is asked for."""


class PackedConstants(NamedTuple):
    """The constants of wall, pellet and lumen as `constants.packed` makes them."""

    wall: np.ndarray
    pellet: np.ndarray
    lumen: np.ndarray


class History(NamedTuple):
    """Histories of Eq. (32): of places [cm] and velocities [cm/s] (inertia), (2, n); of stretches (n - 1,) and (n,)."""

    place: Floats
    velocity: Floats
    stretch: Floats
    hoop: Floats


@compiled
def solve(unknowns: Unknowns, problem: Problem, tables: Workspace) -> Verdict:
    """Solve in place; what stands in the tables beforehand does not matter."""
    density, scalars, pellet = unknowns.density, unknowns.scalars, problem.pellet
    work, system = tables.work, tables.system
    n = density.size
    # All other rows are written before they are read.
    work[TOUCHES] = 0.0
    system[RIGHT + 6] = 0.0
    system[RIGHT + 7] = 0.0
    system[:, n:] = 0.0
    first, last = min(1, n), n - 2
    columns = 4 if pellet.present and pellet.frame != 0.0 else 3
    border = Border(np.empty((3, 3)), np.zeros(3))
    old_scalars = scalars.copy()
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
            evaluated = forces(unknowns, problem, first, last, work)
        now = balance(unknowns, problem, evaluated, work)
        if now.within and now.worst <= problem.limits.tolerance:
            return Verdict(CONVERGED, iteration, evaluations, now.worst)
        # Line search: shorten the last update until the merit falls below the largest of the last ones. Where a
        # kink (slack, contact, sticking) lets no length pass, go on with the best one; only a small residual ends
        # the iteration.
        if iteration > 0 and not settled and not (now.within and passes(now.merit, merits)):
            if now.merit < best_merit:
                best_merit = now.merit
                best_length = length
            length *= SHORTER
            if length < SMALLEST_STEP:
                if not math.isfinite(best_merit):
                    return Verdict(OUT_OF_RANGE, iteration, evaluations, now.worst)
                length = best_length
                settled = True
            go_part(unknowns, old_scalars, border.changes, length, work)
            evaluated = False
            continue
        if not now.within:
            return Verdict(OUT_OF_RANGE, iteration, evaluations, now.worst)
        if iteration >= problem.limits.max_iterations:
            return Verdict(NOT_CONVERGED, iteration, evaluations, now.worst)
        if fresh and now.worst > LOCAL_WORTH:
            fresh = False
            if settle_stretch(unknowns, problem, now.worst, tables) > 0:
                settled = True
                continue
        stalled = 0 if now.worst < 0.5 * smallest else stalled + 1
        smallest = min(smallest, now.worst)
        if stalled >= STALLED and at_rounding(unknowns, problem, now, work):
            return Verdict(ROUNDED, iteration, evaluations, now.worst)
        merits[iteration % MEMORY] = now.merit
        if iteration == 0:
            merits[:] = FIRST_ALLOWANCE * now.merit
        border.matrix[:, :] = 0.0
        work[FORCE_ROW] = 0.0
        work[FORCE_ROW + 1] = 0.0
        force_right = -now.force + linearise(unknowns, problem, first, last, tables, border.matrix)
        if not solve_blocks_in_place(system, first, n - 2, columns):
            return Verdict(SINGULAR, iteration, evaluations, now.worst)
        if not scalar_changes(problem, now, force_right, columns, tables, border):
            return Verdict(SINGULAR, iteration, evaluations, now.worst)
        changes(density, border.changes, problem.wall.element_size, first, last, columns, tables)
        keep(unknowns, first, last, KEPT_R + first - 1, work)
        old_scalars[:] = scalars
        go(unknowns, border.changes, work)
        iteration += 1
        length = 1.0
        best_merit = math.inf
        settled = False
        evaluated = False
        fresh = True


@compiled
def solve_packed(
    unknowns: Unknowns,
    known: np.ndarray,
    constants: PackedConstants,
    step: Step,
    limits: Limits,
    tables: Workspace,
) -> Verdict:
    """`solve_equilibrium` on tables and packed constants; `known` has KNOWN rows and a column for every node."""
    wall, pellet = unpack_wall(constants.wall), unpack_pellet(constants.pellet)
    lumen = unpack_lumen(constants.lumen)
    return solve(unknowns, posed(unknowns, known, wall, pellet, lumen, step, limits), tables)


def solve_equilibrium(
    unknowns: Unknowns,
    history: History,
    drive: Floats,
    friction_weight: Floats,
    step: Step,
    wall: WallConstants,
    pellet: PelletConstants,
    lumen: LumenConstants,
    limits: Limits,
) -> Verdict:
    """Solve in place for the unknowns.

    drive: of half elements in both layers [mV], (2, 2n - 2). friction_weight: share of the friction reaction on each
    node (sums to one, or zero without contact). Unless the code is CONVERGED the arrays hold a trial state that must
    not be used.
    """
    known = np.zeros((KNOWN, unknowns.rho.size))
    known[HISTORY_R : HISTORY_Z + 1] = history.place
    known[VELOCITY_R : VELOCITY_Z + 1] = history.velocity
    known[HISTORY_STRETCH, :-1] = history.stretch
    known[HISTORY_HOOP] = history.hoop
    known[WEIGHT] = friction_weight
    known[TANGENT] = friction_weight  # looked at where the reaction is tangential, and then all of it is
    set_drives(drive[0], drive[1], known)
    # The copy can be written to, as the pellet's numbers in `wall_step.step_wall`: one compiled variant does for both.
    constants = PackedConstants(packed(wall), packed(pellet).copy(), packed(lumen))
    return solve_packed(unknowns, known, constants, step, limits, workspace(unknowns.rho.size))
