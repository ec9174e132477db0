"""What a run is made of, with every constant in internal units: a frozen sum of parts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import PulseTrain
from ..control.reflex import Reflex
from ..control.sequence import Trigger
from ..geometry.grid import Grid
from ..tissue.cells import plant
from ..tissue.cells.plant import CellConstants
from ..tissue.conduction import EXPLICIT_LIMIT, largest_eigenvalue
from ..wall.membrane import WallConstants
from .equilibrium import LumenConstants, PelletConstants

Floats = NDArray[np.float64]

ACTIVATION_LEVEL = -40.0
"""A cell counts as activated when its potential rises through this level [mV]."""


@dataclass(frozen=True)
class Layer:
    """One muscle layer: conductances [mS/cm^2] (5, n_cells), diffusivity at stretch 1 [cm^2/s], muscle."""

    conductances: Floats
    diffusivity: float
    conducts: bool
    force_factor: float
    threshold: float


@dataclass(frozen=True)
class PacemakerCell:
    """An autonomous cell at the oral end: its constants, conductances (5, 1), coupling [mS/cm^2], width [cm]."""

    constants: CellConstants
    conductances: Floats
    coupling: float
    width: float


@dataclass(frozen=True)
class Model:
    """Parts and settings of a run. Steps: dt_wall [s] = substeps * dt_cell [ms].

    start_position: pellet centre before t = 0 [cm]. free_radius: of the pellet-free tube at p0 [cm], at the nodes.
    """

    grid: Grid
    cell: CellConstants
    longitudinal: Layer
    circular: Layer
    wall: WallConstants
    pellet: PelletConstants
    lumen: LumenConstants
    longitudinal_trains: tuple[PulseTrain, ...]
    circular_trains: tuple[PulseTrain, ...]
    pacemaker_cell: PacemakerCell | None
    trigger: Trigger
    reflex: Reflex
    inertia: bool
    second_order: bool
    dt_wall: float
    substeps: int
    exact_kinetics: bool
    tolerance: float
    max_newton: int
    max_halvings: int
    start_position: float
    free_radius: Floats

    @cached_property
    def _tables(self) -> dict[tuple[CellConstants, int], tuple[Floats, Floats]]:
        return {}

    def tables(self, constants: CellConstants, substeps: int) -> tuple[Floats, Floats]:
        """Gate tables for a whole and a half conduction step of dt_wall / substeps; made once, then kept."""
        key = (constants, substeps)
        if key not in self._tables:
            dt = self.dt_wall * 1e3 / substeps
            self._tables[key] = (plant.gate_table(dt, constants), plant.gate_table(0.5 * dt, constants))
        return self._tables[key]

    def stable_substeps(self, layer: Layer, stretch: Floats) -> int:
        """Conduction steps in a wall step: those asked for, or more where the explicit scheme needs them.

        stretch: longitudinal, of the elements; a shortened wall conducts better per undeformed length, Eq. (11).
        """
        rate = largest_eigenvalue(layer.diffusivity, self.grid.cell_size) / float(stretch.min())
        rate += 1e3 * self.cell.kinetics_rate * float(layer.conductances.sum(axis=0).max()) / self.cell.capacitance
        return max(self.substeps, math.ceil(rate * self.dt_wall / EXPLICIT_LIMIT))
