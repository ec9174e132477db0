"""What a run is made of, with every constant in internal units: a frozen sum of parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import PulseTrain
from ..control.reflex import Reflex
from ..control.sequence import Trigger
from ..errors import DivergenceError
from ..geometry.grid import Grid
from ..numerics.stabilised import coefficients, stages_for
from ..tissue.cells import plant
from ..tissue.cells.plant import CellConstants
from ..tissue.conduction import largest_eigenvalue
from ..wall.membrane import WallConstants
from .constants import LumenConstants, PelletConstants, packed

Floats = NDArray[np.float64]

ACTIVATION_LEVEL = -40.0
"""A cell counts as activated when its potential rises through this level [mV]."""


def explicit_stages(rate: float, dt: float) -> Floats:
    """Coefficients of an explicit step of dt [ms] against a decay rate [1/ms]; DivergenceError if none will do."""
    stages = stages_for(rate * dt)
    if stages == 0:
        raise DivergenceError(
            f"step.conduction = {dt:g} ms is too long for a decay rate of {rate:.3g} /ms (conduction on finely "
            "divided wall); lower step.conduction or grid.n_z"
        )
    return coefficients(stages)


@dataclass(frozen=True)
class Layer:
    """One muscle layer: conductances [mS/cm^2] (5, n_cells), diffusivity at stretch 1 [cm^2/s], muscle."""

    conductances: Floats
    diffusivity: float
    conducts: bool
    force_factor: float
    threshold: float

    @cached_property
    def leakiness(self) -> float:
        """Largest sum of the conductances of a cell [mS/cm^2]."""
        return float(self.conductances.sum(axis=0).max())


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
    gap_tolerance: float
    max_newton: int
    max_halvings: int
    balance_tolerance: float
    start_position: float
    free_radius: Floats

    @property
    def dt_cell(self) -> float:
        """Step of conduction and kinetics [ms]."""
        return self.dt_wall * 1e3 / self.substeps

    @cached_property
    def tables(self) -> tuple[Floats, Floats]:
        """Gate tables of the tissue for a whole and a half step."""
        return plant.gate_table(self.dt_cell, self.cell), plant.gate_table(0.5 * self.dt_cell, self.cell)

    @cached_property
    def pacemaker_tables(self) -> tuple[Floats, Floats]:
        """Gate tables of the autonomous pacemaker cell for a whole and a half step."""
        constants = self.cell if self.pacemaker_cell is None else self.pacemaker_cell.constants
        return plant.gate_table(self.dt_cell, constants), plant.gate_table(0.5 * self.dt_cell, constants)

    @cached_property
    def packed(self) -> tuple[Floats, Floats, Floats]:
        """Constants of wall, pellet and lumen as flat arrays."""
        return packed(self.wall), packed(self.pellet), packed(self.lumen)

    def stages(self, layer: Layer, stretch: Floats | float, opened: float = 0.0) -> Floats:
        """Coefficients of the explicit step of a layer, with as many stages as stability asks for, Eq. (31).

        stretch: longitudinal, of the elements, or the smallest; a shortened wall conducts better per undeformed
        length, Eq. (11). opened: largest inhibitory conductance [mS/cm^2].
        """
        least = stretch if isinstance(stretch, float) else float(np.min(stretch))
        rate = (layer.leakiness * self.cell.kinetics_rate + opened) / self.cell.capacitance
        if layer.conducts:
            rate += largest_eigenvalue(layer.diffusivity * 1e-3, self.grid.cell_size) / least
        return explicit_stages(rate, self.dt_cell)
