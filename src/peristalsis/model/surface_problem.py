"""An equilibrium of the wall on the whole surface as its solver is handed it, and the verdict that it returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..wall.constants import SurfaceConstants, WallConstants
from .constants import LumenConstants, PelletConstants, Step

Floats = NDArray[np.float64]

P, Z, F, X, Y = range(5)
"""Scalars: lumen pressure, axial place and force of the pellet, and its places across the axis where it is free."""


class Sideways(NamedTuple):
    """A pellet free across the axis, in the frame of column 0: x = x_history + weight/friction [mN s/cm] * force."""

    friction: float
    x_history: float
    y_history: float
    weight: float


@dataclass(frozen=True)
class SurfaceProblem:
    """What a step is given. Fields (n, 3, m) in frames of columns; see `equilibrium.solve_equilibrium` for the rest.

    shear_history: of the patches, (n - 1, m). friction_weight: (n, m), sums to one or zero. sideways: None keeps the
    pellet on the axis. modes: those around the ring that the preconditioner couples, in single precision; 0 for the
    average around the ring.
    """

    history: Floats
    velocity_history: Floats
    stretch_history: Floats
    hoop_history: Floats
    shear_history: Floats
    drive: Floats
    friction_weight: Floats
    step: Step
    wall: WallConstants
    surface: SurfaceConstants
    pellet: PelletConstants
    lumen: LumenConstants
    sideways: Sideways | None
    tolerance: float
    gap_tolerance: float
    max_iterations: int
    modes: int = 0


class SurfaceVerdict(NamedTuple):
    """The verdict's code (`equilibrium.REASONS`), Newton iterations, assemblies and Krylov iterations."""

    code: int
    iterations: int
    assemblies: int
    krylov: int
