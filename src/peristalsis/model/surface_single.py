"""The bordered tangent on the whole surface solved by GMRES in single precision, corrected in double, Eq. (94)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.constraint import project
from ..numerics.krylov import KrylovSolution, flexible_gmres
from ..numerics.ring_single import SingleFactors
from .surface_residual import Trial
from .surface_tangent import Borders, Tangent

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

MOST_KRYLOV = 80
MOST_CORRECTIONS = 4
"""A solution in single precision is corrected by one for its residual in double, so often at most."""


class _SingleSystem:
    """The bordered tangent as GMRES sees it: vectors of nodes, then scalars, weighed as in the merit."""

    def __init__(self, trial: Trial, tangent: Tangent, borders: Borders, factors: SingleFactors) -> None:
        self.tangent, self.borders, self.shape = tangent, borders, trial.places.shape
        self.present = trial.problem.pellet.present
        count, self.size = trial.scalars.size, borders.right.size
        self.wall_weight, self.weights = 1.0 / (trial.unit * math.sqrt(self.shape[2])), trial.weights
        self.columns = borders.columns.reshape(count, self.size)
        self.rows = borders.rows.reshape(count, self.size)
        self._factors = factors
        self._columns, self._rows = self.columns.astype(np.float32), self.rows.astype(np.float32)
        self._corner, self._weights = borders.corner.astype(np.float32), self.weights.astype(np.float32)
        self._cleaned = np.stack([self._factors.in_modes(c.reshape(self.shape)).ravel() for c in self._columns])
        self._schur = borders.corner - self._rows @ self._cleaned.T
        self.singular = not np.all(np.isfinite(self._schur)) or bool(abs(np.linalg.det(self._schur)) < 1e-300)

    def right(self) -> Floats:
        """The right-hand side."""
        return np.concatenate([self.wall_weight * self.borders.right.ravel(), self.weights * self.borders.scalar_right])

    def apply(self, vector: Singles) -> Singles:
        """The system times a vector."""
        scalars = vector[self.size :]
        image = np.empty_like(vector)
        moved = self._factors.times(vector[: self.size].reshape(self.shape)).ravel()
        moved += scalars @ self._columns
        np.multiply(moved, np.float32(self.wall_weight), out=image[: self.size])
        image[self.size :] = self._weights * (self._rows @ vector[: self.size] + self._corner @ scalars)
        return image

    def precondition(self, vector: Singles, scale: float) -> Singles:
        """The wall by itself, then the scalars."""
        field = vector[: self.size] * np.float32(1.0 / self.wall_weight)
        solution = np.empty_like(vector)
        bare = self._factors.precondition(field.reshape(self.shape)).ravel()
        scalars = np.linalg.solve(self._schur, vector[self.size :] / self.weights - self._rows @ bare)
        solution[self.size :] = scalars
        solution[: self.size] = bare - scalars.astype(np.float32) @ self._cleaned
        return solution

    def residual(self, vector: Floats) -> Floats:
        """The right-hand side less the system times a vector, in double precision."""
        scalars, field = vector[self.size :], vector[: self.size].reshape(self.shape)
        image = np.empty(vector.size)
        if self.present:
            # What a solution has along the normals of held nodes is taken out of it afterwards.
            field = field.copy()
            project(self.tangent.constraint, field)
        moved = self.tangent.times(field)
        if self.present:
            project(self.tangent.constraint, moved)
        image[: self.size] = self.wall_weight * (moved.ravel() + scalars @ self.columns)
        image[self.size :] = self.weights * (self.rows @ field.ravel() + self.borders.corner @ scalars)
        return np.asarray(self.right() - image)


def solve_in_single(trial: Trial, tangent: Tangent, borders: Borders, target: float) -> KrylovSolution | None:
    """The bordered tangent solved to a residual of `target`; None if a part of the preconditioner is singular."""
    factors = trial.single_solver().factor(tangent.operator, tangent.constraint)
    if factors is None:
        return None
    system = _SingleSystem(trial, tangent, borders, factors)
    if system.singular:
        return None
    left = system.right()
    solution, used = np.zeros_like(left), 0
    norm = float(np.linalg.norm(left))
    for _ in range(MOST_CORRECTIONS):
        # The vectors handed over are of length one: residuals of any size are within single precision.
        part = flexible_gmres(
            system.apply, system.precondition, (left / norm).astype(np.float32), target / norm, MOST_KRYLOV - used
        )
        used += part.iterations
        tried = solution + norm * part.solution.astype(np.float64)
        left = system.residual(tried)
        found = float(np.linalg.norm(left))
        if not found < norm:
            break
        solution, norm = tried, found
        if norm <= 1.1 * target or used >= MOST_KRYLOV:
            break
    return KrylovSolution(solution, norm, used)
