"""Newton's method on the whole surface with the tension before the floor as an unknown of its own, Eqs. (90), (91).

An update that turns a stiff edge changes its length to second order, and times the dashpots' stiffness that is several
times the tension: in the plain method such errors decide which wall is slack and how stiff it is across. Here tensions
are those of the equations made linear, and whole updates are taken. A state is accepted by its true residual, so the
answer is that of the plain method to the tolerance.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.ring_blocks import pad
from ..wall.surface import add_edge_forces
from ..wall.surface_mixed import Corners, carry_tensions, load_mixed_edges, new_corners, new_mixed_forces
from .surface_equilibrium import forcing_of, solve_surface, tolerance_of
from .surface_problem import SurfaceProblem, SurfaceVerdict
from .surface_residual import Trial
from .surface_update import newton_update
from .verdicts import CONVERGED, NOT_CONVERGED, OUT_OF_RANGE, SINGULAR

Floats = NDArray[np.float64]

PATIENCE = 4
"""The method is given up for the line search when the merit has not fallen for so many iterations: it may circle."""
HOPELESS = 1e4
"""The same at so many times the first merit."""


class MixedTrial(Trial):
    """A state that the iteration tries, with its tensions.

    After `evaluate`, `worst` and `true_merit` are those of the equilibrium; residual, merit and edges those of the
    equations made linear.
    """

    def __init__(
        self, problem: SurfaceProblem, places: Floats, density: Floats, scalars: Floats, tensions: Floats
    ) -> None:
        super().__init__(problem, places, density, scalars)
        n, _, m = places.shape
        self.corners: Corners = new_corners(n, m)._replace(carried=tensions)
        self._forces = new_mixed_forces(n, m)
        self._true, self.true_merit = self.edges, math.inf
        self._missing = self._true._replace(
            axial_force=self._forces.axial_missing, hoop_force=self._forces.hoop_missing
        )
        self._carried = self._true._replace(
            axial_force=self._forces.axial_carried, hoop_force=self._forces.hoop_carried
        )

    def evaluate(self, tolerance: float) -> bool:
        """Residuals, merits and worst residual of the trial state; False when it is out of range."""
        self.edges, self.true_merit = self._true, math.inf
        if not super().evaluate(tolerance):
            return False
        self.edges, self.true_merit = self._carried, self.merit
        m = self.places.shape[2]
        others = self.merit**2 - float((self.residual**2).sum()) / (m * self.unit**2)
        add_edge_forces(self._missing, self.residual)
        self.residual[[0, -1]] = 0.0
        self.merit = math.sqrt(max(others, 0.0) + float((self.residual**2).sum()) / (m * self.unit**2))
        return math.isfinite(self.merit)

    def carry(self, change: Floats) -> None:
        """Let the tensions follow a change of places (n, 3, m), as the equations made linear have them."""
        pad(change, self.moved)
        carry_tensions(self._true, self.moved, self.problem.wall, self.corners)

    def _load(self) -> bool:
        p = self.problem
        return load_mixed_edges(
            self._true, p.stretch_history, p.hoop_history, p.step.slope, p.drive, p.wall, self.corners, self._forces
        )


def solve_mixed(
    places: Floats, density: Floats, scalars: Floats, tensions: Floats, problem: SurfaceProblem
) -> SurfaceVerdict:
    """Solve in place as `solve_surface` does, which takes over from the best state where whole updates lead nowhere.

    tensions (2, 4(n - 1), m): those before the floor to begin with, which are changed.
    """
    start = (places.copy(), density.copy(), scalars.copy())
    verdict = _whole_updates(places, density, scalars, tensions, problem)
    if verdict.code == CONVERGED:
        return verdict
    for array, first in zip((places, density, scalars), start, strict=True):
        array[...] = first
    rest = solve_surface(places, density, scalars, problem)
    return SurfaceVerdict(
        rest.code,
        verdict.iterations + rest.iterations,
        verdict.assemblies + rest.assemblies,
        verdict.krylov + rest.krylov,
    )


def _whole_updates(
    places: Floats, density: Floats, scalars: Floats, tensions: Floats, problem: SurfaceProblem
) -> SurfaceVerdict:
    """Whole updates until the state is accepted, singular, out of range, circling or at the limit of iterations."""
    trial = MixedTrial(problem, places, density, scalars, tensions)
    n, _, m = places.shape
    tolerance = tolerance_of(trial)
    blocks = np.empty((n, 9, 3, 3, m))
    iteration = krylov = since = 0
    lowest = last = first = math.inf
    while True:
        if not trial.evaluate(tolerance):
            return SurfaceVerdict(OUT_OF_RANGE, iteration, iteration + 1, krylov)
        if trial.worst <= tolerance:
            return SurfaceVerdict(CONVERGED, iteration, iteration + 1, krylov)
        first = trial.merit if iteration == 0 else first
        since = 0 if trial.merit < lowest else since + 1
        lowest = min(lowest, trial.merit)
        if iteration >= problem.max_iterations or since >= PATIENCE or trial.merit > HOPELESS * first:
            return SurfaceVerdict(NOT_CONVERGED, iteration, iteration + 1, krylov)
        target = max(forcing_of(trial.merit, last) * trial.merit, 0.3 * tolerance)
        last = trial.merit
        found = newton_update(trial, blocks, target)
        if found is None:
            return SurfaceVerdict(SINGULAR, iteration, iteration + 1, krylov)
        (change, density_change, scalar_change), used = found
        trial.carry(change)
        places += change
        density += density_change
        scalars += scalar_change
        krylov += used
        iteration += 1
