"""Banded and small linear systems against numpy."""

import numpy as np
import pytest

from peristalsis.numerics.banded import HALF_WIDTH, solve_banded_in_place, solve_small_in_place


def banded(seed: int, n: int, columns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A full matrix with its band by rows, and right-hand sides, padded as the solver wants them."""
    rng = np.random.default_rng(seed)
    full = np.triu(np.tril(rng.normal(size=(n, n)), HALF_WIDTH), -HALF_WIDTH) + 12.0 * np.eye(n)
    band = np.zeros((n + HALF_WIDTH, 2 * HALF_WIDTH + 1))
    for i in range(n):
        for j in range(max(0, i - HALF_WIDTH), min(n, i + HALF_WIDTH + 1)):
            band[i, HALF_WIDTH + j - i] = full[i, j]
    right = np.zeros((n + HALF_WIDTH, 4))
    right[:n, :columns] = rng.normal(size=(n, columns))
    return full, right[:n, :columns].copy(), band, right


@pytest.mark.parametrize("n", [1, 2, 7, 60])
@pytest.mark.parametrize("columns", [1, 3, 4])
def test_unsymmetric_band_is_solved(n: int, columns: int) -> None:
    """Every column, also in systems smaller than the band is wide."""
    full, wanted, band, right = banded(n, n, columns)
    assert solve_banded_in_place(band, right, columns)
    assert np.abs(full @ right[:n, :columns] - wanted).max() <= 1e-12


def test_columns_not_asked_for_stay() -> None:
    """The fourth column costs time; when it is not wanted it is not touched."""
    _, _, band, right = banded(3, 20, 3)
    right[:20, 3] = 7.0
    solve_banded_in_place(band, right, 3)
    assert np.all(right[:20, 3] == 7.0)


@pytest.mark.parametrize("pivot", [0.0, np.nan, np.inf])
def test_bad_pivot_is_reported(pivot: float) -> None:
    """A singular tangent must come back as a verdict, not as an array of nan."""
    _, _, band, right = banded(4, 20, 2)
    band[0, HALF_WIDTH] = pivot
    assert not solve_banded_in_place(band, right, 2)


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
