"""An update of Newton's method on the whole surface: the bordered tangent solved by preconditioned GMRES, Eq. (40)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.column_solver import ColumnSolver
from ..numerics.constraint import add_normal, project
from ..numerics.krylov import KrylovSolution, flexible_gmres
from ..numerics.ring_solver import RingSolver
from .surface_problem import F, P
from .surface_residual import Trial
from .surface_single import MOST_KRYLOV, solve_in_single
from .surface_tangent import Borders, Tangent, borders_of, tangent_of

Floats = NDArray[np.float64]


class _System:
    """The bordered tangent as GMRES sees it: vectors of nodes, then scalars, weighed as in the merit.

    target: merit of the linear residual to reach.
    """

    def __init__(self, trial: Trial, tangent: Tangent, borders: Borders, target: float) -> None:
        self.tangent, self.borders, self.target = tangent, borders, target
        self.present, self.shape = trial.problem.pellet.present, trial.places.shape
        count, self.size = trial.scalars.size, borders.right.size
        self.wall_weight, self.weights = 1.0 / (trial.unit * math.sqrt(self.shape[2])), trial.weights
        self.columns, self.rows = borders.columns.reshape(count, self.size), borders.rows.reshape(count, self.size)
        self.solver = RingSolver(tangent.operator, tangent.constraint)
        self.lines: ColumnSolver | None = None
        self.calls = 0
        self.cleaned = np.zeros((count, self.size))
        for c, column in enumerate(borders.columns):
            self.cleaned[c] = self.solver.solve(column, 1e-9 * float(np.linalg.norm(column))).ravel()
        if not self.solver.singular:
            self.schur = borders.corner - self.rows @ self.cleaned.T

    @property
    def singular(self) -> bool:
        """Whether a part of the preconditioner has turned out to be."""
        if self.solver.singular or (self.lines is not None and self.lines.singular):
            return True
        return not np.all(np.isfinite(self.schur)) or bool(abs(np.linalg.det(self.schur)) < 1e-300)

    def right(self) -> Floats:
        """The right-hand side."""
        return np.concatenate([self.wall_weight * self.borders.right.ravel(), self.weights * self.borders.scalar_right])

    def apply(self, vector: Floats) -> Floats:
        """The system times a vector."""
        size, scalars = self.size, vector[self.size :]
        image = np.empty(vector.size)
        moved = self._constrained(vector[:size].reshape(self.shape)).ravel()
        image[:size] = self.wall_weight * (moved + scalars @ self.columns)
        image[size:] = self.weights * (self.rows @ vector[:size] + self.borders.corner @ scalars)
        return image

    def precondition(self, vector: Floats, scale: float) -> Floats:
        """The average first, which is all that a ring-uniform wall needs; columns before it from then on."""
        self.calls += 1
        size = self.size
        solution = np.empty(vector.size)
        field = vector[:size].reshape(self.shape) / self.wall_weight
        begun = np.zeros_like(field)
        if self.calls > 1:
            begun = self._smoothed(field)
            field = field - self._constrained(begun)
        bare = (begun + self.solver.solve(field, 0.1 * self.target / (self.wall_weight * scale))).ravel()
        solution[size:] = np.linalg.solve(self.schur, vector[size:] / self.weights - self.rows @ bare)
        solution[:size] = bare - solution[size:] @ self.cleaned
        return solution

    def _constrained(self, field: Floats) -> Floats:
        """The tangent between projections, with the averaged stiffness along the normals of held nodes."""
        if not self.present:
            return self.tangent.times(field)
        constraint = self.tangent.constraint
        free = field.copy()
        project(constraint, free)
        out = self.tangent.times(free)
        project(constraint, out)
        add_normal(constraint, self.solver.stiffness, field, out)
        return out

    def _smoothed(self, field: Floats) -> Floats:
        """One sweep over even and odd columns."""
        if self.lines is None:
            self.lines = ColumnSolver(self.tangent.operator, self.tangent.constraint, self.solver.stiffness)
        found = np.zeros_like(field)
        self.lines.solve(False, field, found)
        self.lines.solve(True, field - self._constrained(found), found)
        return found


def _solve_by_average(trial: Trial, tangent: Tangent, borders: Borders, target: float) -> KrylovSolution | None:
    """The bordered tangent solved in double precision; None if a part of the preconditioner is singular."""
    system = _System(trial, tangent, borders, target)
    if system.singular:
        return None
    found = flexible_gmres(system.apply, system.precondition, system.right(), target, MOST_KRYLOV)
    return None if system.singular else found


def newton_update(trial: Trial, blocks: Floats, target: float) -> tuple[tuple[Floats, Floats, Floats], int] | None:
    """Changes of places, density and scalars from the linearised equations, and Krylov iterations; None if singular.

    target: merit of the linear residual to reach.
    """
    tangent = tangent_of(trial, blocks)
    borders = borders_of(trial, tangent)
    if trial.problem.modes > 0:
        found = solve_in_single(trial, tangent, borders, target)
    else:
        found = _solve_by_average(trial, tangent, borders, target)
    if found is None or not np.all(np.isfinite(found.solution)):
        return None
    size = borders.right.size
    change = found.solution[:size].reshape(trial.places.shape).copy()
    scalar_change = found.solution[size:].copy()
    density_change = -trial.density.copy()
    if trial.problem.pellet.present:
        project(tangent.constraint, change)
        change += borders.prescribed
        for c, field in borders.along.items():
            change += scalar_change[c] * field
        forces = tangent.times_band(change) + trial.residual - scalar_change[P] * trial.gradient
        forces[:, 2] -= scalar_change[F] * borders.friction
        pressed = (trial.normal * forces).sum(axis=1) / trial.problem.wall.element_size
        density_change = np.where(trial.touching, pressed, density_change)
        density_change[[0, -1]] = -trial.density[[0, -1]]
    return (change, density_change, scalar_change), found.iterations
