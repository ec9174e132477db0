"""Linear solvers on the tube: exact where they say so, and GMRES for the rest."""

from itertools import pairwise

import numpy as np
import pytest

from peristalsis.numerics.column_solver import ColumnSolver
from peristalsis.numerics.constraint import Constraint, add_normal, project
from peristalsis.numerics.krylov import flexible_gmres
from peristalsis.numerics.ring_blocks import RingOperator
from peristalsis.numerics.ring_single import SingleFactors, SingleSolver
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


ROUNDING = 2e-5
"""Of sums in single precision over systems of this size, relative to the largest number."""


def close(found: np.ndarray, exact: np.ndarray) -> bool:
    return float(np.abs(found - exact).max()) <= ROUNDING * float(np.abs(exact).max())


def coupled(columns: int, modes: int, seed: int, tether: float = 3.0) -> RingOperator:
    """An operator whose stiffness varies around the ring in the lowest modes, as beside slack wall."""
    rng = np.random.default_rng(seed)
    angles = 2.0 * np.pi * np.arange(columns) / columns
    blocks = np.repeat(rng.normal(size=(N, 9, 3, 3, 1)), columns, axis=4)
    blocks[:, 4] += 25.0 * np.eye(3)[None, :, :, None]
    for k in range(1, modes + 1):
        for turn in (np.cos(k * angles), np.sin(k * angles)):
            blocks += 0.4 * rng.normal(size=(N, 9, 3, 3, 1)) * turn
    return RingOperator(blocks, 1.5, 0.7, tether)


def factors(operator: RingOperator, constraint: Constraint, modes: int) -> SingleFactors:
    made = SingleSolver(N, operator.blocks.shape[4], modes).factor(operator, constraint)
    assert made is not None
    return made


@pytest.mark.parametrize("columns", [5, 8, 16])
@pytest.mark.parametrize("held", [False, True])
def test_product_is_that_of_double_precision(columns: int, held: bool) -> None:
    operator = coupled(columns, 2, 1)
    constraint = banded(columns, 2) if held else free(columns)
    made = factors(operator, constraint, 1)
    field = inner(columns, 3)
    exact = constrained(operator, constraint, made.operator.stiffness.astype(float), field)
    assert close(made.times(field.astype(np.float32)), exact)


@pytest.mark.parametrize(("columns", "modes"), [(7, 3), (16, 3), (16, 7)])
def test_space_of_coupled_modes_is_solved_exactly(columns: int, modes: int) -> None:
    """Galerkin: of a field in the space, the operator's image leads back to it, whatever varies around the ring."""
    operator = coupled(columns, 4, 4)
    made = factors(operator, free(columns), modes)
    rng = np.random.default_rng(5)
    within = made.modes.inverse * (rng.normal(size=(N, 3, 2 * modes + 1)) @ made.modes.fields.T)
    within[[0, -1]] = 0.0
    assert close(made.in_modes(times(operator, within).astype(np.float32)), within)


def test_all_modes_are_the_whole_space() -> None:
    """With an odd number of columns the modes span every field, and what varies around the ring is solved at once."""
    operator, exact = coupled(9, 4, 6), inner(9, 7)
    made = factors(operator, free(9), 100)
    assert close(made.in_modes(times(operator, exact).astype(np.float32)), exact)
    assert close(made.precondition(times(operator, exact).astype(np.float32)), exact)


@pytest.mark.parametrize("held", [False, True])
def test_ring_uniform_fields_of_a_uniform_operator_are_exact(held: bool) -> None:
    """The mean alone, in contact and without. What bending couples apart stays free of normals, so it is left out."""
    operator = circulant(12, 8)._replace(tether=0.0)
    constraint = banded(12, 9) if held else free(12)
    if held:
        operator = operator._replace(bend_along=0.0, bend_around=0.0)
    made = factors(operator, constraint, 0 if not held else 2)
    exact = np.repeat(inner(1, 10), 12, axis=2)
    right = constrained(operator, constraint, made.operator.stiffness.astype(float), exact)
    assert close(made.in_modes(right.astype(np.float32)), exact)


def test_columns_that_do_not_see_one_another_need_no_modes() -> None:
    """Even and odd columns are then solved exactly before the modes, which find nothing left."""
    operator = coupled(8, 3, 11, tether=0.0)
    operator.blocks[:, [0, 2, 3, 5, 6, 8]] = 0.0
    operator = operator._replace(bend_around=0.0)
    exact = inner(8, 12)
    found = factors(operator, free(8), 1).precondition(times(operator, exact).astype(np.float32))
    assert close(found, exact)


def test_coupled_modes_save_iterations() -> None:
    """Stiff beside slack around the ring: fewer with every mode, and few in the end."""
    columns, rng = 32, np.random.default_rng(13)
    blocks = np.zeros((N, 9, 3, 3, columns))
    stiff = 1.0 + 200.0 * (np.cos(2.0 * np.pi * np.arange(columns) / columns) > 0.3)
    for a in range(3):
        for q, k in ((3, -1), (5, 1)):
            pull = 0.5 * (stiff + np.roll(stiff, -k)) * (20.0 if a < 2 else 1.0)
            blocks[:, q, a, a] -= pull
            blocks[:, 4, a, a] += pull
        for q, d in ((1, -1), (7, 1)):
            blocks[:, q, a, a] -= stiff
            blocks[:, 4, a, a] += stiff if abs(d) else 0.0
        blocks[:, 4, a, a] += 0.01
    operator = RingOperator(blocks, 0.0, 0.0, 0.0)
    right = rng.normal(size=(N, 3, columns)).astype(np.float32)
    right[[0, -1]] = 0.0
    counts = []
    for modes in (0, 2, 6):
        made = factors(operator, free(columns), modes)
        shape = right.shape
        found = flexible_gmres(
            lambda v, made=made, shape=shape: made.times(v.reshape(shape)).ravel(),  # type: ignore[misc]
            lambda v, _, made=made, shape=shape: made.precondition(v.reshape(shape)).ravel(),  # type: ignore[misc]
            right.ravel(),
            1e-3 * float(np.linalg.norm(right)),
            80,
        )
        assert found.solution.dtype == np.float32
        counts.append(found.iterations)
    assert counts[0] > counts[1] >= counts[2]
    assert counts[2] <= 8


def test_singular_operators_are_told() -> None:
    empty = RingOperator(np.zeros((N, 9, 3, 3, 8)), 0.0, 0.0, 0.0)
    assert SingleSolver(N, 8, 2).factor(empty, free(8)) is None
    broken = coupled(8, 2, 14)
    broken.blocks[3, 4] = np.nan
    assert SingleSolver(N, 8, 2).factor(broken, free(8)) is None
