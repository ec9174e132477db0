"""One wall surface, two grids: conduction cells and wall nodes over Lagrangian (z, theta).

Arrays are indexed (n_z, n_theta), oral end first. n_theta = 1 is the axisymmetric model.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..numerics.transfer import Overlap, interpolation, overlap

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Grid:
    """Lagrangian grids of a tube of the given length [cm]: conduction cells, wall nodes, and the ways between.

    n_z conduction cells and n_z_wall wall elements (n_z_wall + 1 nodes) along z; n_theta columns around.
    """

    length: float
    n_z: int
    n_z_wall: int
    n_theta: int = 1

    @property
    def cell_size(self) -> float:
        """Length of a conduction cell along z [cm]."""
        return self.length / self.n_z

    @property
    def element_size(self) -> float:
        """Length of a wall element along z [cm]."""
        return self.length / self.n_z_wall

    @cached_property
    def cells(self) -> Floats:
        """Centres of the conduction cells [cm], shape (n_z,)."""
        return np.asarray((np.arange(self.n_z) + 0.5) * self.cell_size, dtype=np.float64)

    @cached_property
    def angles(self) -> Floats:
        """Centres of the columns around the tube [rad], shape (n_theta,); the first is at 0."""
        return np.asarray(2.0 * np.pi * np.arange(self.n_theta) / self.n_theta, dtype=np.float64)

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
    def _element_centres(self) -> Floats:
        return 0.5 * (self.nodes[1:] + self.nodes[:-1])
