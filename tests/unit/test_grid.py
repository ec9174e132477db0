"""Columns of wall and cells around the ring, and the ways between them, Eqs. (33), (39)."""

import numpy as np
import pytest

from peristalsis.geometry.grid import Grid
from peristalsis.numerics.transfer import average, average_around, periodic_interpolation, periodic_overlap

RINGS = [(4, 4), (4, 12), (6, 24), (1, 8), (3, 6)]


@pytest.mark.parametrize(("wall", "cells"), RINGS)
def test_every_column_of_the_wall_is_a_column_of_cells(wall: int, cells: int) -> None:
    grid = Grid(10.0, 40, 20, wall, cells)
    assert grid.columns == pytest.approx(2.0 * np.pi * np.arange(wall) / wall)
    assert np.allclose(grid.cell_columns[:: cells // wall], grid.columns, atol=1e-14)
    assert grid.column_width(0.795) * cells == pytest.approx(2.0 * np.pi * 0.795)


def test_as_many_columns_of_cells_as_of_wall_unless_asked() -> None:
    assert Grid(10.0, 40, 20).n_theta_conduction == 1
    assert Grid(10.0, 40, 20, 6).n_theta_conduction == 6


@pytest.mark.parametrize("cells", [3, 10, 2])
def test_columns_that_do_not_fit_are_refused(cells: int) -> None:
    with pytest.raises(ValueError, match="not a multiple of n_theta = 4"):
        Grid(10.0, 40, 20, 4, cells)
    with pytest.raises(ValueError, match="not a multiple"):
        periodic_overlap(cells, 4)


@pytest.mark.parametrize(("wall", "cells"), RINGS)
def test_drive_keeps_constants_and_its_integral(wall: int, cells: int) -> None:
    """Each column of the wall takes the cells within half a column of it; the area under phi+ passes over whole."""
    grid = Grid(10.0, 50, 20, wall, cells)
    field = np.random.default_rng(1).uniform(size=(50, cells))
    halves = grid.half_elements_of_cells(field)
    assert halves.shape == (40, wall)
    assert halves.mean() == pytest.approx(field.mean(), rel=1e-13)
    assert np.allclose(grid.half_elements_of_cells(np.full((50, cells), 3.7)), 3.7, rtol=1e-14)


def test_drive_of_one_column_of_cells_reaches_only_its_neighbours() -> None:
    """Four cells to a column: three whole ones around its centre, and half of the one on either border."""
    weights = periodic_overlap(16, 4)
    found = np.empty((16, 4))
    average_around(weights, np.eye(16), found)
    assert found[:, 1].tolist() == [0, 0, 0.125, 0.25, 0.25, 0.25, 0.125, *[0] * 9]
    average_around(periodic_overlap(12, 4), np.eye(12), found[:12])
    assert found[:12, 0] == pytest.approx([1 / 3, 1 / 3, *[0] * 9, 1 / 3])


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_interpolation_around_the_ring_is_second_order(offset: float) -> None:
    errors = []
    for n in (12, 24, 48, 96):
        source = np.cos(2.0 * np.pi * (np.arange(n) + offset) / n)[None, :]
        found = np.empty((1, 16 * n))
        average_around(periodic_interpolation(n, 16 * n, offset), source, found)
        exact = np.cos(2.0 * np.pi * (np.arange(16 * n) + offset) / (16 * n))
        errors.append(np.abs(found[0] - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(orders - 2.0).max() <= 0.1


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_interpolation_onto_the_same_ring_changes_nothing(offset: float) -> None:
    field, found = np.random.default_rng(2).normal(size=(3, 7)), np.empty((3, 7))
    average_around(periodic_interpolation(7, 7, offset), field, found)
    assert np.array_equal(found, field)


@pytest.mark.parametrize(("wall", "cells"), RINGS)
def test_uniform_stretch_is_uniform_on_the_sheet(wall: int, cells: int) -> None:
    """Around the ring to the last bit where columns agree along it, so that no variation is made from none."""
    grid = Grid(10.0, 50, 20, wall, cells)
    rng = np.random.default_rng(3)
    elements, nodes = (np.repeat(rng.uniform(0.5, 1.5, (n, 1)), wall, axis=1) for n in (20, 21))
    for found, shape in (
        (grid.elements_at_faces(elements), (49, cells)),
        (grid.elements_at_cells(elements), (50, cells)),
        (grid.nodes_at_ring_faces(nodes), (50, cells)),
    ):
        assert found.shape == shape
        assert np.array_equal(found, np.repeat(found[:, :1], cells, axis=1))


def test_stretch_stands_where_it_is_taken() -> None:
    """Linear fields along z and first harmonics around, at their own places."""
    grid = Grid(10.0, 50, 20, 48, 96)
    along = (np.arange(20) + 0.5)[:, None] * grid.element_size
    faces = grid.elements_at_faces(along + np.cos(grid.columns))
    inner = slice(2, -2)
    expected = np.arange(1, 50)[:, None] * grid.cell_size + np.cos(grid.cell_columns)
    assert np.abs(faces - expected)[inner].max() <= 3e-3
    hoop = grid.nodes_at_ring_faces(grid.nodes[:, None] + np.sin(grid.columns + np.pi / 48))
    expected = grid.cells[:, None] + np.sin(grid.cell_columns + np.pi / 96)
    assert np.abs(hoop - expected).max() <= 3e-3


def test_one_column_is_what_it_was() -> None:
    """The axisymmetric transfers, bit for bit."""
    grid = Grid(10.0, 50, 20)
    field, stretch = np.random.default_rng(4).uniform(size=(50, 1)), np.random.default_rng(5).uniform(size=(20, 1))
    halves, faces = np.empty((40, 1)), np.empty((49, 1))
    average(grid.cells_to_half_elements, field, halves)
    average(grid.elements_to_faces, stretch, faces)
    assert np.array_equal(grid.half_elements_of_cells(field), halves)
    assert np.array_equal(grid.elements_at_faces(stretch), faces)
