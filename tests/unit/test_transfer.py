"""Transfer between grids: constants and integrals are kept, Eq. (33)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from peristalsis.geometry.grid import Grid
from peristalsis.numerics.transfer import average, interpolation, overlap, trigonometric


def edges(widths: list[float]) -> np.ndarray:
    """Cell edges from 0 to 1 with these relative widths."""
    ends = np.concatenate([[0.0], np.cumsum(widths)])
    return ends / ends[-1]


widths = st.lists(st.floats(0.05, 1.0), min_size=1, max_size=30)


@given(widths, widths, st.integers(0, 2**32 - 1))
def test_integral_and_constants_are_kept(source: list[float], target: list[float], seed: int) -> None:
    """Any two divisions of the same length: the integral passes over unchanged, and so does a constant."""
    a, b = edges(source), edges(target)
    weights = overlap(a, b)
    values, found = np.random.default_rng(seed).normal(size=(a.size - 1, 2)), np.empty((b.size - 1, 2))
    average(weights, values, found)
    assert np.diff(b) @ found == pytest.approx(np.diff(a) @ values, abs=1e-12)
    average(weights, np.full_like(values, 3.7), found)
    assert found == pytest.approx(3.7, rel=1e-14)


@given(widths, widths)
def test_averages_stay_between_the_extremes(source: list[float], target: list[float]) -> None:
    """No weight is negative: the depolarisation of a half element lies between those of its cells."""
    weights = overlap(edges(source), edges(target))
    assert weights.weights.min() >= 0.0
    assert np.all(np.diff(weights.start) >= 1)


@given(arrays(float, 12, elements=st.floats(-5, 5)))
def test_same_grid_changes_nothing(values: np.ndarray) -> None:
    line = np.linspace(0.0, 1.0, 13)
    found = np.empty((12, 1))
    average(overlap(line, line), values[:, None], found)
    assert np.array_equal(found[:, 0], values)


def test_interpolation_is_exact_for_lines_and_flat_outside() -> None:
    source, target = np.linspace(0.5, 9.5, 10), np.array([0.0, 0.5, 3.25, 9.5, 10.0])
    found = np.empty((5, 1))
    average(interpolation(source, target), (2.0 * source - 1.0)[:, None], found)
    assert found[:, 0] == pytest.approx([0.0, 0.0, 5.5, 18.0, 18.0], abs=1e-13)


def test_depolarised_length_reaches_the_wall_whole() -> None:
    """The shipped grids do not divide one another: the area under phi+ is the same on both."""
    grid = Grid(10.0, 1000, 800)
    values = np.random.default_rng(1).uniform(size=(1000, 1))
    found = np.empty((1600, 1))
    average(grid.cells_to_half_elements, values, found)
    assert found.sum() * 10.0 / 1600 == pytest.approx(values.sum() * 0.01, rel=1e-13)


@pytest.mark.parametrize(("sources", "targets"), [(16, 64), (8, 24), (7, 21), (5, 5)])
def test_fourier_series_is_exact_below_half_the_columns(sources: int, targets: int) -> None:
    """Every mode that the coarse ring can tell apart, in amplitude and phase."""
    coarse, fine = (2.0 * np.pi * np.arange(n) / n for n in (sources, targets))
    for mode in range(1, (sources + 1) // 2):
        found = trigonometric(0.3 + np.cos(mode * coarse - 0.4)[None, :], targets)
        assert found[0] == pytest.approx(0.3 + np.cos(mode * fine - 0.4), abs=1e-13)


@given(st.integers(3, 20), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_fourier_series_keeps_columns_and_the_mean(sources: int, ratio: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(3, sources))
    found = trigonometric(values, ratio * sources)
    assert found[:, ::ratio] == pytest.approx(values, abs=1e-12)
    assert found.mean(axis=1) == pytest.approx(values.mean(axis=1), abs=1e-13)


def test_fourier_series_leaves_a_uniform_ring_to_the_last_bit() -> None:
    found = trigonometric(np.full((2, 16), 0.1 + 0.2), 64)
    assert np.array_equal(found, np.full((2, 64), 0.1 + 0.2))


def test_fourier_series_of_columns_that_do_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="64 columns are not a multiple of 24"):
        trigonometric(np.zeros((1, 24)), 64)
