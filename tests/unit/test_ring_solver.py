"""Linear solvers on the tube: exact where they say so, and GMRES for the rest."""

from itertools import pairwise

import numpy as np
import pytest

from peristalsis.numerics.column_solver import ColumnSolver
from peristalsis.numerics.constraint import Constraint, add_normal, project
from peristalsis.numerics.krylov import flexible_gmres
from peristalsis.numerics.ring_blocks import RingOperator
from peristalsis.numerics.ring_solver import RingSolver
from verification.exact.surface_wall import times

N = 12


def free(columns: int) -> Constraint:
    """No node is held."""
    return Constraint(np.zeros((N, columns), np.bool_), np.zeros(N, np.bool_), np.zeros((N, 3, columns)))


def banded(columns: int, seed: int) -> Constraint:
    """A band of rows that is held all around along one direction in the frames of the columns."""
    normal = np.random.default_rng(seed).normal(size=(N, 3, 1)) * np.ones((1, 1, columns))
    held = np.zeros((N, columns), np.bool_)
    held[4:8] = True
    return Constraint(held, held.any(axis=1), normal / np.linalg.norm(normal, axis=1, keepdims=True))


def circulant(columns: int, seed: int) -> RingOperator:
    """An operator with the same full, unsymmetric blocks in every column, and all its constant parts."""
    rng = np.random.default_rng(seed)
    blocks = rng.normal(size=(N, 9, 3, 3, 1)) * np.ones((1, 1, 1, 1, columns))
    blocks[:, 4] += 25.0 * np.eye(3)[None, :, :, None]
    return RingOperator(blocks, 1.5, 0.7, 3.0)


def inner(columns: int, seed: int) -> np.ndarray:
    """A field with held end rows."""
    field = np.random.default_rng(seed).normal(size=(N, 3, columns))
    field[[0, -1]] = 0.0
    return field


def constrained(operator: RingOperator, constraint: Constraint, stiffness: np.ndarray, field: np.ndarray) -> np.ndarray:
    """The operator between projections, with the given stiffness along the held normals."""
    rest = field.copy()
    project(constraint, rest)
    out = times(operator, rest)
    project(constraint, out)
    add_normal(constraint, stiffness, field, out)
    return out


@pytest.mark.parametrize("columns", [5, 8, 32])
@pytest.mark.parametrize("held", [False, True])
def test_average_of_a_uniform_operator_is_exact(columns: int, held: bool) -> None:
    """Every mode, with bending along, contact and without: one application is the solution.

    Bending around and the tether are averaged apart from held normals, so they are left out where there are some.
    """
    operator = circulant(columns, 1)
    constraint = banded(columns, 2) if held else free(columns)
    if held:
        operator = operator._replace(bend_around=0.0, tether=0.0)
    solver = RingSolver(operator, constraint)
    exact = inner(columns, 3)
    found = solver.solve(constrained(operator, constraint, solver.stiffness, exact), 0.0)
    assert not solver.singular
    assert np.abs(found - exact).max() <= 1e-11


def test_negligible_modes_are_let_be() -> None:
    """A right-hand side without variation around the ring costs the mean mode alone, and the answer is still exact."""
    operator, constraint = circulant(16, 4), free(16)
    solver = RingSolver(operator, constraint)
    exact = np.repeat(inner(1, 5), 16, axis=2)
    right = times(operator, exact)
    noise = 1e-9 * inner(16, 6)
    found = solver.solve(right + noise - noise.mean(axis=2, keepdims=True), 1e-6)
    assert np.abs(found - exact).max() <= 1e-9
    assert np.ptp(found, axis=2).max() <= 1e-12


def test_singular_average_is_told() -> None:
    solver = RingSolver(RingOperator(np.zeros((N, 9, 3, 3, 8)), 0.0, 0.0, 0.0), free(8))
    solver.solve(inner(8, 7), 0.0)
    assert solver.singular


@pytest.mark.parametrize("columns", [6, 7])
@pytest.mark.parametrize("held", [False, True])
def test_columns_alone_are_solved_exactly(columns: int, held: bool) -> None:
    """Where columns do not see one another, the even and the odd ones together are the solution."""
    rng = np.random.default_rng(8)
    blocks = rng.normal(size=(N, 9, 3, 3, columns))
    blocks[:, 4] += 25.0 * np.eye(3)[None, :, :, None]
    blocks[:, [0, 2, 3, 5, 6, 8]] = 0.0
    operator = RingOperator(blocks, 1.5, 0.0, 0.0)
    constraint = banded(columns, 9) if held else free(columns)
    stiffness = rng.uniform(10.0, 30.0, (N, columns))
    solver = ColumnSolver(operator, constraint, stiffness)
    exact, found = inner(columns, 10), np.zeros((N, 3, columns))
    right = constrained(operator, constraint, stiffness, exact)
    for odd in (False, True):
        solver.solve(odd, right, found)
    assert not solver.singular
    assert np.abs(found - exact).max() <= 1e-11


def test_gmres_solves_what_a_direct_solver_solves() -> None:
    rng = np.random.default_rng(11)
    matrix, right = rng.normal(size=(30, 30)) + 6.0 * np.eye(30), rng.normal(size=30)
    exact = np.linalg.solve(matrix, right)
    found = flexible_gmres(lambda v: matrix @ v, lambda v, _: v, right, 1e-12, 30)
    assert found.solution == pytest.approx(exact, abs=1e-10)
    assert found.residual == pytest.approx(np.linalg.norm(right - matrix @ found.solution), abs=1e-12)


def test_gmres_stops_where_it_is_told() -> None:
    """At the residual asked for, at the number of iterations allowed, and at once when nothing is left to do."""
    rng = np.random.default_rng(12)
    matrix, right = rng.normal(size=(40, 40)) + 8.0 * np.eye(40), rng.normal(size=40)
    rough = flexible_gmres(lambda v: matrix @ v, lambda v, _: v, right, 0.1, 40)
    assert 0.0 < rough.residual <= 0.1
    assert rough.iterations < 30
    assert flexible_gmres(lambda v: matrix @ v, lambda v, _: v, right, 1e-12, 5).iterations == 5
    assert flexible_gmres(lambda v: matrix @ v, lambda v, _: v, right, 100.0, 5).iterations == 0


def test_gmres_with_the_exact_inverse_takes_one_iteration() -> None:
    rng = np.random.default_rng(13)
    matrix, right = rng.normal(size=(20, 20)) + 6.0 * np.eye(20), rng.normal(size=20)
    found = flexible_gmres(lambda v: matrix @ v, lambda v, _: np.linalg.solve(matrix, v), right, 1e-10, 20)
    assert found.iterations == 1


def test_gmres_may_change_its_preconditioner() -> None:
    """Flexible: the preconditioner is another one in every iteration, and is told the size of what is left."""
    rng = np.random.default_rng(14)
    matrix, right = rng.normal(size=(20, 20)) + 6.0 * np.eye(20), rng.normal(size=20)
    sizes: list[float] = []

    def changing(vector: np.ndarray, size: float) -> np.ndarray:
        sizes.append(size)
        return vector * (1.0 + 0.3 * np.sin(len(sizes) + np.arange(20)))

    found = flexible_gmres(lambda v: matrix @ v, changing, right, 1e-10, 40)
    assert np.abs(matrix @ found.solution - right).max() <= 1e-9
    assert sizes[0] == pytest.approx(np.linalg.norm(right))
    assert all(later <= earlier for earlier, later in pairwise(sizes))
