"""Block-banded and small linear systems against numpy, and the exponential of the vector loops."""

import math

import numpy as np
import pytest

from peristalsis.numerics.block_band import DIAGONAL, PADDING, RIGHT, ROWS, solve_blocks_in_place
from peristalsis.numerics.exponential import exponential
from peristalsis.numerics.small import solve_small_in_place


def blocks(seed: int, n: int) -> np.ndarray:
    """Random block rows, diagonally heavy, with right-hand sides."""
    rng = np.random.default_rng(seed)
    system = rng.normal(size=(ROWS, n + PADDING))
    system[[DIAGONAL, DIAGONAL + 3]] += 12.0
    return system


def full(system: np.ndarray, first: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Full matrix and right-hand sides of n nodes from `first` on."""
    matrix, right = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 4))
    for i in range(n):
        column = system[:, first + i]
        right[2 * i : 2 * i + 2] = column[RIGHT:].reshape(4, 2).T
        for block in range(5):
            j = i + block - 2
            if 0 <= j < n:
                matrix[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = column[4 * block : 4 * block + 4].reshape(2, 2)
    return matrix, right


@pytest.mark.parametrize("n", [1, 2, 3, 60])
@pytest.mark.parametrize("columns", [1, 3, 4])
@pytest.mark.parametrize("first", [0, 4])
def test_unsymmetric_blocks_are_solved(n: int, columns: int, first: int) -> None:
    """Every column, any part of a longer system, and systems shorter than their rows."""
    system = blocks(n, first + n)
    matrix, right = full(system, first, n)
    before = system[:, :first].copy()
    assert solve_blocks_in_place(system, first, n, columns)
    solved = full(system, first, n)[1]
    assert np.abs(matrix @ solved - right)[:, :columns].max() <= 1e-12
    assert np.array_equal(system[:, :first], before), "nodes before the part are not touched"


def test_columns_not_asked_for_stay() -> None:
    """The later columns cost time; when they are not wanted they are not touched."""
    for columns in (1, 3):
        system = blocks(3, 20)
        system[RIGHT + 2 * columns :] = 7.0
        assert solve_blocks_in_place(system, 0, 20, columns)
        assert np.all(system[RIGHT + 2 * columns :] == 7.0)


@pytest.mark.parametrize("entry", [0.0, np.nan, np.inf])
def test_bad_block_is_reported(entry: float) -> None:
    """A singular tangent must come back as a verdict, not as an array of nan."""
    system = blocks(4, 20)
    system[DIAGONAL : DIAGONAL + 4, 0] = entry
    assert not solve_blocks_in_place(system, 0, 20, 3)


def test_small_system_with_a_zero_on_the_diagonal() -> None:
    """The border has no diagonal dominance: rows must be exchanged."""
    rng = np.random.default_rng(0)
    for n in (1, 2, 3, 5):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
        if n > 1:
            matrix[0, 0] = 0.0
        solution, work = right.copy(), matrix.copy()
        assert solve_small_in_place(work, solution)
        assert np.abs(matrix @ solution - right).max() <= 1e-12


def test_singular_small_system_is_reported() -> None:
    assert not solve_small_in_place(np.zeros((3, 3)), np.ones(3))


def test_exponential_is_the_exponential() -> None:
    """Within 1e-15 of the library's, relative, and exact where it must be."""
    for x in np.linspace(-700.0, 700.0, 4001):
        assert exponential(float(x)) == pytest.approx(math.exp(x), rel=1e-15)
    assert exponential(0.0) == 1.0
