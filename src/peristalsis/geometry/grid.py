"""One wall surface, two grids: conduction cells and wall nodes over Lagrangian (z, theta).

Arrays are indexed (n_z, n_theta), oral end first. n_theta = 1 is the axisymmetric model. Column j of n stands at
theta = 2 pi j/n on either grid, and its cells reach half a column to both sides; theta faces j + 1/2 lie between.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..numerics.transfer import (
    Overlap,
    average,
    average_around,
    interpolation,
    overlap,
    periodic_interpolation,
    periodic_overlap,
    reconstruction,
)

Floats = NDArray[np.float64]


SUB_CELLS = 4
"""Parts of a conduction cell in which the drive of muscle is looked at where it is reconstructed."""
POTENTIAL_POINTS, STRETCH_POINTS = 5, 4
"""Cells that a potential is reconstructed from, and elements that a stretch is."""


@dataclass(frozen=True)
class Grid:
    """Lagrangian grids of a tube of the given length [cm]: conduction cells, wall nodes, and the ways between.

    n_z conduction cells and n_z_wall wall elements (n_z_wall + 1 nodes) along z; n_theta columns of wall and
    n_theta_conduction columns of cells around, a multiple of these (0: as many). n_theta_shown: columns on which the
    wall is shown, a multiple too (0: as many). slack: by how much the ends are held nearer than the tube is long [cm].
    """

    length: float
    n_z: int
    n_z_wall: int
    n_theta: int = 1
    n_theta_conduction: int = 0
    n_theta_shown: int = 0
    slack: float = 0.0

    def __post_init__(self) -> None:
        for name, why in (
            ("n_theta_conduction", "columns of the wall would have no cells of their own"),
            ("n_theta_shown", "columns of the wall would not be shown in their places"),
        ):
            columns = getattr(self, name) or self.n_theta
            if columns % self.n_theta != 0:
                raise ValueError(
                    f"{name} = {columns} is not a multiple of n_theta = {self.n_theta}: {why}; "
                    f"use {self.n_theta * max(round(columns / self.n_theta), 1)}"
                )
            object.__setattr__(self, name, columns)

    @property
    def span(self) -> float:
        """Distance between the held ends [cm]."""
        return self.length - self.slack

    @property
    def is_surface(self) -> bool:
        """Whether the wall has columns around the ring; one column is the axisymmetric model."""
        return self.n_theta > 1

    @property
    def cell_size(self) -> float:
        """Length of a conduction cell along z [cm]."""
        return self.length / self.n_z

    @property
    def element_size(self) -> float:
        """Length of a wall element along z [cm]."""
        return self.length / self.n_z_wall

    def column_width(self, radius: float) -> float:
        """Width of a column of conduction cells on the undeformed tube of this radius [cm], an arc."""
        return 2.0 * np.pi * radius / self.n_theta_conduction

    @cached_property
    def columns(self) -> Floats:
        """Angles of the wall's columns [rad], shape (n_theta,)."""
        return np.asarray(2.0 * np.pi * np.arange(self.n_theta) / self.n_theta, dtype=np.float64)

    @cached_property
    def shown_columns(self) -> Floats:
        """Angles of the columns on which the wall is shown [rad], shape (n_theta_shown,)."""
        return np.asarray(2.0 * np.pi * np.arange(self.n_theta_shown) / self.n_theta_shown, dtype=np.float64)

    @cached_property
    def cell_columns(self) -> Floats:
        """Angles of the columns of conduction cells [rad], shape (n_theta_conduction,)."""
        return np.asarray(2.0 * np.pi * np.arange(self.n_theta_conduction) / self.n_theta_conduction, dtype=np.float64)

    @cached_property
    def cells(self) -> Floats:
        """Centres of the conduction cells [cm], shape (n_z,)."""
        return np.asarray((np.arange(self.n_z) + 0.5) * self.cell_size, dtype=np.float64)

    @cached_property
    def nodes(self) -> Floats:
        """Wall nodes [cm], shape (n_z_wall + 1,)."""
        return np.linspace(0.0, self.length, self.n_z_wall + 1)

    @cached_property
    def _cell_edges(self) -> Floats:
        return np.linspace(0.0, self.length, self.n_z + 1)

    @cached_property
    def cells_to_half_elements(self) -> Overlap:
        """Averages of cell values over the halves of the wall elements: one half for each corner."""
        return overlap(self._cell_edges, np.linspace(0.0, self.length, 2 * self.n_z_wall + 1))

    @cached_property
    def elements_to_cells(self) -> Overlap:
        """Element values at the conduction cells, linear between element centres."""
        return interpolation(self._element_centres, self.cells)

    @cached_property
    def elements_to_faces(self) -> Overlap:
        """Element values at the n_z - 1 inner faces of the conduction cells, linear between element centres."""
        return interpolation(self._element_centres, self._cell_edges[1:-1])

    @cached_property
    def cells_to_sub_cells(self) -> Overlap:
        """Averages over the SUB_CELLS parts of every cell, of a quartic through the averages over five cells."""
        edges = np.arange(self.n_z * SUB_CELLS + 1) / SUB_CELLS
        return reconstruction(self.n_z, edges[:-1], edges[1:], POTENTIAL_POINTS)

    @cached_property
    def sub_cells_to_half_elements(self) -> Overlap:
        """Averages of values of sub-cells over the halves of the wall elements."""
        edges = np.linspace(0.0, self.length, self.n_z * SUB_CELLS + 1)
        return overlap(edges, np.linspace(0.0, self.length, 2 * self.n_z_wall + 1))

    @cached_property
    def element_averages_to_cells(self) -> Overlap:
        """Values at the conduction cells, of a cubic through the averages over four elements."""
        places = self.cells / self.element_size
        return reconstruction(self.n_z_wall, places, places, STRETCH_POINTS)

    @cached_property
    def element_averages_to_faces(self) -> Overlap:
        """Values at the n_z - 1 inner faces of the conduction cells, of a cubic through averages over elements."""
        places = self._cell_edges[1:-1] / self.element_size
        return reconstruction(self.n_z_wall, places, places, STRETCH_POINTS)

    @cached_property
    def _element_centres(self) -> Floats:
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])

    @cached_property
    def nodes_to_cells(self) -> Overlap:
        """Values at the wall nodes at the conduction cells, linear between nodes."""
        return interpolation(self.nodes, self.cells)

    @cached_property
    def cell_columns_to_columns(self) -> Overlap:
        """Averages of cell columns over the wall's columns, half a column to both sides of each."""
        return periodic_overlap(self.n_theta_conduction, self.n_theta)

    @cached_property
    def columns_to_cell_columns(self) -> Overlap:
        """Values on the wall's columns at the cell columns, linear around the ring."""
        return periodic_interpolation(self.n_theta, self.n_theta_conduction)

    @cached_property
    def faces_to_cell_faces(self) -> Overlap:
        """Values at the wall's theta faces j + 1/2 at those of the cell columns, linear around the ring."""
        return periodic_interpolation(self.n_theta, self.n_theta_conduction, 0.5)

    @cached_property
    def columns_to_shown(self) -> Overlap:
        """Values on the wall's columns at those on which it is shown, linear around the ring."""
        return periodic_interpolation(self.n_theta, self.n_theta_shown)

    @cached_property
    def faces_to_shown(self) -> Overlap:
        """Values at the wall's theta faces j + 1/2 at those of the columns on which it is shown, linear around."""
        return periodic_interpolation(self.n_theta, self.n_theta_shown, 0.5)

    def half_elements_of_cells(self, field: Floats) -> Floats:
        """A field of cells on the wall: (n_z, n_theta_conduction) to the half elements, (2 n_z_wall, n_theta).

        Averages along z and around, Eqs. (33), (39): constants and the integral are kept.
        """
        coarse = np.empty((self.n_z, self.n_theta))
        average_around(self.cell_columns_to_columns, field, coarse)
        halves = np.empty((2 * self.n_z_wall, self.n_theta))
        average(self.cells_to_half_elements, coarse, halves)
        return halves

    def elements_at_faces(self, field: Floats) -> Floats:
        """A field of elements and wall columns at the inner z faces of the cells, shape (n_z - 1, n_theta_conduction).

        field: (n_z_wall, n_theta). Linear along z and around, Eqs. (33), (39): the axial stretch for conduction.
        """
        return self._spread(self.elements_to_faces, self.n_z - 1, self.columns_to_cell_columns, field)

    def elements_at_cells(self, field: Floats) -> Floats:
        """A field of elements and wall columns at the cells: (n_z_wall, n_theta) to (n_z, n_theta_conduction)."""
        return self._spread(self.elements_to_cells, self.n_z, self.columns_to_cell_columns, field)

    def nodes_at_ring_faces(self, field: Floats) -> Floats:
        """A field of nodes and theta faces at the theta faces of the cells, shape (n_z, n_theta_conduction).

        field: (n_z_wall + 1, n_theta); field[:, j] stands half a column past theta_j, as the hoop stretch between two
        columns does. Linear along z and around, Eq. (39).
        """
        return self._spread(self.nodes_to_cells, self.n_z, self.faces_to_cell_faces, field)

    def _spread(self, along: Overlap, rows: int, around: Overlap, field: Floats) -> Floats:
        coarse = np.empty((rows, self.n_theta))
        average(along, field, coarse)
        if self.n_theta_conduction == self.n_theta:
            return coarse
        fine = np.empty((rows, self.n_theta_conduction))
        average_around(around, coarse, fine)
        return fine
