"""An equilibrium as its solver is handed it: unknowns, what is given, and the tables that the solver works on."""

from __future__ import annotations

import math
import threading
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.block_band import PADDING, ROWS
from ..numerics.compiled import compiled
from ..wall.assembly import KNOWN_ROWS, WALL_ROWS
from ..wall.constants import WallConstants
from .constants import LumenConstants, PelletConstants, Step
from .verdicts import ROUNDOFF, TENSION_SCALE

Floats = NDArray[np.float64]

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


class Unknowns(NamedTuple):
    """Wall nodes rho, zeta [cm] (n,), contact densities Q [mN/cm^2] (n,), and the scalars p [mN/cm^2], Z [cm], F [mN].

    Solvers change them in place; the end nodes are held.
    """

    rho: np.ndarray
    zeta: np.ndarray
    density: np.ndarray
    scalars: np.ndarray


class Limits(NamedTuple):
    """When a solve ends: force residual over TENSION_SCALE, gap left at touching nodes [cm], iterations."""

    tolerance: float
    gap_tolerance: float
    max_iterations: int


class Problem(NamedTuple):
    """What a solve is given: tables of what is known (KNOWN, n), constants, formulas of the step, limits.

    unit: force on a node against which residuals are measured [mN/cm]; circumference: of the undeformed tube [cm].
    """

    known: np.ndarray
    wall: WallConstants
    pellet: PelletConstants
    lumen: LumenConstants
    step: Step
    limits: Limits
    unit: float
    circumference: float


class Workspace(NamedTuple):
    """Tables of a solver: `work` (WORK, n) and the linear system (ROWS, n + PADDING), see `block_band`."""

    work: np.ndarray
    system: np.ndarray


@compiled
def posed(
    unknowns: Unknowns,
    known: np.ndarray,
    wall: WallConstants,
    pellet: PelletConstants,
    lumen: LumenConstants,
    step: Step,
    limits: Limits,
) -> Problem:
    """The problem with its scales; its tolerance is not below what the rounding of the places leaves."""
    unit = TENSION_SCALE * wall.element_size / wall.radius
    # Positions are known to one part in 2^52 of the tube's length; the dashpot turns that into a force.
    length = unknowns.zeta[unknowns.zeta.size - 1]
    reach = ROUNDOFF * length / wall.element_size * wall.viscosity * step.slope / unit
    reachable = Limits(max(limits.tolerance, reach), limits.gap_tolerance, limits.max_iterations)
    return Problem(known, wall, pellet, lumen, step, reachable, unit, 2.0 * math.pi * wall.radius)


_kept = threading.local()


def workspace(n: int) -> Workspace:
    """Tables for n nodes, one pair a thread, kept: half a megabyte is not asked for every step."""
    if getattr(_kept, "nodes", 0) != n:
        _kept.nodes = n
        _kept.tables = Workspace(np.empty((WORK, n)), np.empty((ROWS, n + PADDING)))
    tables: Workspace = _kept.tables
    return tables
