"""What a run is made of, with every constant in internal units: a frozen sum of parts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import Source
from ..control.pulses import NO_PULSES, RING, Listed
from ..control.reflex import Reflex
from ..control.sequence import Trigger
from ..errors import DivergenceError
from ..geometry.grid import SUB_CELLS, Grid
from ..numerics.binding import SHIPPED, Binding
from ..numerics.stabilised import coefficients, stages_for
from ..pellet.friction import CONSTANT, FrictionLaw
from ..tissue.activation import SHIPPED_ACTIVATION, Activation
from ..tissue.bidomain import FULL, Elliptic
from ..tissue.cell import SHIPPED_CELL, Cell
from ..tissue.cells.plant import CellConstants
from ..tissue.conduction import largest_eigenvalue
from ..tissue.front_correction import correction, correction_table, shorter_foot
from ..tissue.records import Tables
from ..tissue.resolution import front_foot
from ..tissue.surface import Conductivities, stability_rate
from ..wall.constants import SurfaceConstants, WallConstants
from .constants import LumenConstants, PelletConstants

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
class Response:
    """Factors on what pacemaker, trigger and nerves bring to the cells of a layer: numbers, or (n_z, n_theta)."""

    pacemaker: Floats | float = 1.0
    trigger: Floats | float = 1.0
    excitation: Floats | float = 1.0
    inhibition: Floats | float = 1.0


@dataclass(frozen=True)
class Layer:
    """One muscle layer: conductances [mS/cm^2] (channels, n_cells), diffusivity at stretch 1 [cm^2/s], muscle.

    conductivities: those of both media along z and around, whose ratios count on the whole surface. force_factor: a
    number, or of the cells, (n_z, n_theta). conductivity: factor on the diffusivity, a number, or of the inner faces
    along z, (n_z - 1, n_theta); conductivity_around: of the faces around the ring, (n_z, n_theta). constants: of the
    cell, a NamedTuple of its own class.
    activation: what makes the drive of the muscle, with constants of its own, None for those of the threshold.
    calcium_state: row of the cell's calcium, -1 where none is read; calcium_scale: from its unit to uM.
    front_corrected: whether conduction between coarse cells is raised to the exact speed of fronts, Eq. (85).
    """

    conductances: Floats
    diffusivity: float
    conductivities: Conductivities
    conducts: bool
    force_factor: Floats | float
    threshold: float
    conductivity: Floats | float = 1.0
    conductivity_around: Floats | float = 1.0
    response: Response = Response()
    constants: Any = None
    cell: Cell = SHIPPED_CELL
    activation: Activation = SHIPPED_ACTIVATION
    muscle_constants: Any = None
    calcium_state: int = -1
    calcium_scale: float = 1.0
    front_corrected: bool = False

    @cached_property
    def shorter_foot(self) -> float:
        """By how much the foot of its front is shorter than in the tissue that the correction was measured on."""
        return shorter_foot(self.conductances)

    def front_law(self, cell_size: float, dt: float, around: bool = False) -> FrontLaw | None:
        """How conduction is corrected for cells of this size [cm], along z or around, and steps of dt [ms], Eq. (85).

        None where it is not, or the front of its cells was not measured.
        """
        if not (self.front_corrected and self.conducts and self.diffusivity > 0.0):
            return None
        share = self.conductivities.effective_around / self.conductivities.effective_axial if around else 1.0
        rate = self.constants.kinetics_rate
        feet = cell_size / front_foot(self.diffusivity * share, rate)
        return FrontLaw(feet * self.shorter_foot, correction_table(dt, rate))

    @cached_property
    def activation_constants(self) -> Any:
        """Constants of the activation, a NamedTuple of its own class."""
        own = self.muscle_constants
        return self.activation.constants(float(self.threshold)) if own is None else own

    @cached_property
    def leakiness(self) -> float:
        """Largest change of a cell's current with its potential [mS/cm^2]."""
        return self.cell.leakiness(self.conductances, self.constants)

    def tables(self, dt: float) -> Tables:
        """Tables of its cells for a whole and a half step of dt [ms]."""
        return self.cell.tables(dt, self.constants)

    @cached_property
    def best_conduction(self) -> float:
        """Largest factor on conduction along z."""
        return float(np.max(self.conductivity))

    @cached_property
    def force_of_cells(self) -> Floats:
        """Force factor of every cell, (n_cells,)."""
        return np.full(self.conductances.shape[1], 1.0) * np.ravel(self.force_factor)

    @cached_property
    def force_of_sub_cells(self) -> Floats:
        """Force factor of the parts of every cell of one column, (n_cells * SUB_CELLS,)."""
        return np.repeat(self.force_of_cells, SUB_CELLS)


@dataclass(frozen=True)
class PacemakerCell:
    """An autonomous cell of Plant's model: its constants, conductances (5, 1), coupling [mS/cm^2], width [cm].

    It is coupled to the stretch from `place` [cm] on, around the ring over `sector` centred at `angle` [rad].
    """

    constants: CellConstants
    conductances: Floats
    coupling: float
    width: float
    place: float = 0.0
    angle: float = 0.0
    sector: float = RING


@dataclass(frozen=True)
class Network:
    """Interstitial cells on the grid of the layers, each coupled to the cells of both by gaps [mS/cm^2].

    sheet: their cells and conduction, as of a layer. load: share of the muscle's gap current that they carry.
    head_start: time for which the cells at the oral end have run when the run begins [s]; lag: by which it is shorter
    further on [s/cm].
    """

    sheet: Layer
    longitudinal: float
    circular: float
    load: float
    head_start: float = 0.0
    lag: float = 0.0


class ExplicitScheme(NamedTuple):
    """Settings of the explicit scheme, Eqs. (53)-(57).

    micro: wall steps in a conduction step, 0: as many as `safety` times the stability limit asks for, anew for every
    wall step. predicted: dashpots see rates carried on to now and not those of half a step ago. contact_stiffness:
    k_c [mN/cm^3].
    """

    micro: int
    safety: float
    predicted: bool
    contact_stiffness: float


class StepControl(NamedTuple):
    """How the length of a step follows its error: what it may be [cm], Eq. (102), and how often a step is halved."""

    tolerance: float
    halvings: int


class FrontLaw(NamedTuple):
    """Correction of conduction: cells per foot at stretch 1, and the factors of `tissue.front_correction`."""

    cells_per_foot: float
    table: Floats


@dataclass(frozen=True)
class Model:
    """Parts and settings of a run. Steps: dt_wall [s] = substeps * dt_cell [ms].

    start_position: pellet centre before t = 0 [cm]. free_radius: of the pellet-free tube at p0 [cm], at the nodes.
    surface, sideways_friction [mN s/cm]: of a wall on the whole surface; None keeps the pellet on the axis.
    control: of the length of the steps, of which dt_wall is then the longest; None keeps them as long as that.
    surface_tolerance, mixed_newton, coupled_modes: of its solver, where drive or wall vary around the ring.
    explicit: None for the implicit wall. stimuli_longitudinal, stimuli_circular: those at listed times. binding: of the
    kernels to the chosen law and shape. reconstructs: whether wall and sheets see one another between cells and
    elements, Eqs. (86)-(88). elliptic: of the bidomain on the whole surface.
    """

    grid: Grid
    longitudinal: Layer
    circular: Layer
    wall: WallConstants
    pellet: PelletConstants
    lumen: LumenConstants
    sources: tuple[Source, ...]
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
    start_position: float
    free_radius: Floats
    surface: SurfaceConstants
    sideways_friction: float | None
    surface_tolerance: float
    mixed_newton: bool
    coupled_modes: int
    friction: FrictionLaw = CONSTANT
    explicit: ExplicitScheme | None = None
    stimuli_longitudinal: Listed = NO_PULSES
    stimuli_circular: Listed = NO_PULSES
    network: Network | None = None
    binding: Binding = SHIPPED
    control: StepControl | None = None
    reconstructs: bool = False
    elliptic: Elliptic = FULL

    @cached_property
    def finer(self) -> Model:
        """The model with steps half as long; those of the cells stay as they are where they can."""
        parts = self.substeps // 2 if self.substeps % 2 == 0 else self.substeps
        return replace(self, dt_wall=0.5 * self.dt_wall, substeps=parts)

    @property
    def dt_cell(self) -> float:
        """Step of conduction and kinetics [ms]."""
        return self.dt_wall * 1e3 / self.substeps

    @property
    def cell(self) -> Any:
        """Constants of the cells of the longitudinal layer."""
        return self.longitudinal.constants

    @property
    def tables(self) -> Tables:
        """Tables of the longitudinal layer's cells for a whole and a half step."""
        return self.longitudinal.tables(self.dt_cell)

    def stages(self, layer: Layer, stretch: Floats | float, opened: float = 0.0, ring_rate: float = 0.0) -> Floats:
        """Coefficients of the explicit step of a layer, with as many stages as stability asks for, Eq. (31).

        stretch: longitudinal, of the elements, or the smallest; a shortened wall conducts better per undeformed
        length, Eq. (11).
        opened: largest inhibitory conductance [mS/cm^2]. ring_rate: what fluxes around the ring add [1/ms].
        """
        least = stretch if isinstance(stretch, float) else float(np.min(stretch))
        rate = (layer.leakiness * layer.constants.kinetics_rate + opened) / layer.constants.capacitance
        if layer.conducts:
            decay = largest_eigenvalue(layer.diffusivity * 1e-3, self.grid.cell_size)
            best = layer.best_conduction / least
            law = layer.front_law(self.grid.cell_size, self.dt_cell)
            if law is not None and best > 0.0:
                # The factor grows more slowly with the cells than conduction falls: the best faces stay the best.
                best *= correction(law.cells_per_foot / math.sqrt(best), law.table)
            rate += decay * best
        return explicit_stages(stability_rate(rate, ring_rate), self.dt_cell)
