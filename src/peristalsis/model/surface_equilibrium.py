"""Wall on the whole surface, lumen and pellet in equilibrium at the end of a step: Newton's method with GMRES inside.

The axisymmetric counterpart is `equilibrium`: same unknowns, same residuals, same line search, same verdicts. The
scalars border the tangent (`surface_tangent`), in the Krylov space and in its preconditioner (`surface_update`), so
that a ring-uniform step is an exact Newton step, Eq. (40).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .line_search import FIRST_ALLOWANCE, MEMORY, SMALLEST_STEP
from .surface_problem import Sideways, SurfaceProblem, SurfaceVerdict
from .surface_residual import Trial
from .surface_update import newton_update
from .verdicts import CONVERGED, NOT_CONVERGED, OUT_OF_RANGE, ROUNDOFF, SINGULAR

__all__ = ["Sideways", "SurfaceProblem", "SurfaceVerdict", "merit_of", "solve_surface"]

Floats = NDArray[np.float64]

LOOSEST, TIGHTEST = 1e-2, 1e-3
"""Bounds of the relative residual to which a linear system is solved; in between it follows the Newton residual."""


def solve_surface(places: Floats, density: Floats, scalars: Floats, problem: SurfaceProblem) -> SurfaceVerdict:
    """Solve in place for places (n, 3, m) [cm], density Q (n, m) [mN/cm^2] and scalars (p, Z, F) or (p, Z, F, X, Y).

    The end rows of `places` are held. Unless the code is CONVERGED the arrays hold a trial state that must not be used.
    """
    trial = Trial(problem, places, density, scalars)
    n, _, m = places.shape
    tolerance = tolerance_of(trial)
    blocks = np.empty((n, 9, 3, 3, m))
    merits = np.full(MEMORY, math.inf)
    iteration = assemblies = krylov = 0
    length, best_merit, best_length, settled = 1.0, math.inf, 1.0, False
    last_merit = math.inf
    old: tuple[Floats, Floats, Floats] = (places, density, scalars)
    update: tuple[Floats, Floats, Floats] = old
    while True:
        assemblies += 1
        ok = trial.evaluate(tolerance)
        if ok and trial.worst <= tolerance:
            return SurfaceVerdict(CONVERGED, iteration, assemblies, krylov)
        # The line search of the axisymmetric solver: shorten until the merit falls below the largest of the last ones.
        if iteration > 0 and not settled and not (ok and trial.merit <= (1.0 - 1e-4 * length) * float(merits.max())):
            if trial.merit < best_merit:
                best_merit, best_length = trial.merit, length
            length *= 0.5
            if length < SMALLEST_STEP:
                if not math.isfinite(best_merit):
                    return SurfaceVerdict(OUT_OF_RANGE, iteration, assemblies, krylov)
                length, settled = best_length, True
            for array, start, change in zip((places, density, scalars), old, update, strict=True):
                array[...] = start + length * change
            continue
        if not ok:
            return SurfaceVerdict(OUT_OF_RANGE, iteration, assemblies, krylov)
        if iteration >= problem.max_iterations:
            return SurfaceVerdict(NOT_CONVERGED, iteration, assemblies, krylov)
        merits[iteration % MEMORY] = trial.merit
        if iteration == 0:
            merits[:] = FIRST_ALLOWANCE * trial.merit
        forcing = forcing_of(trial.merit, last_merit)
        last_merit = trial.merit
        found = newton_update(trial, blocks, max(forcing * trial.merit, 0.3 * tolerance))
        if found is None:
            return SurfaceVerdict(SINGULAR, iteration, assemblies, krylov)
        update, used = found
        krylov += used
        old = (places.copy(), density.copy(), scalars.copy())
        best_merit, length, settled = math.inf, 1.0, False
        iteration += 1
        for array, change in zip((places, density, scalars), update, strict=True):
            array += change


def tolerance_of(trial: Trial) -> float:
    """Largest residual at which a state is accepted: what was asked for, or what rounding of the places leaves."""
    wall, slope = trial.problem.wall, trial.problem.step.slope
    reach = ROUNDOFF * float(trial.places[-1, 2].max()) / wall.element_size * wall.viscosity * slope / trial.unit
    return max(trial.problem.tolerance, reach)


def forcing_of(merit: float, last: float) -> float:
    """Share of the merit to which a linear system is solved; last: the merit before, infinite at first."""
    return min(LOOSEST, max(TIGHTEST, 0.9 * (merit / last) ** 2)) if math.isfinite(last) else LOOSEST


def merit_of(places: Floats, density: Floats, scalars: Floats, problem: SurfaceProblem) -> float:
    """Merit of a guess, by which guesses are compared; infinite when it is out of range."""
    trial = Trial(problem, places, density, scalars)
    trial.evaluate(problem.tolerance)
    return trial.merit
