"""What outputs are read from: one moment of a run, with what several of them need computed once."""

from __future__ import annotations

from functools import cached_property
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.balance import Momentum
from ..model.bookkeeping import ContactSummary, EndReactions
from ..model.friction import dry_friction_now, end_reaction, net_force, sliding_speed, viscous_friction_now
from ..model.model import Layer, Model
from ..model.report import StepReport
from ..model.state import SheetState, State, WallState
from ..model.step_summary import StepSummary
from ..names import CALCIUM
from ..wall import membrane
from .shown import shown_wall

Floats = NDArray[np.float64]

PARTS = {
    ("passive", "longitudinal"): membrane.PASSIVE_LONGITUDINAL,
    ("active", "longitudinal"): membrane.ACTIVE_LONGITUDINAL,
    ("total", "longitudinal"): membrane.TOTAL_LONGITUDINAL,
    ("passive", "circular"): membrane.PASSIVE_CIRCULAR,
    ("active", "circular"): membrane.ACTIVE_CIRCULAR,
    ("total", "circular"): membrane.TOTAL_CIRCULAR,
}
"""(part, layer) to its place among the tensions at a node."""


class Done(NamedTuple):
    """Work since t = 0 [mN cm], added up over the steps; `stored` holds the kinetic energy too."""

    active: float = 0.0
    gas: float = 0.0
    stored: float = 0.0
    lost_wall: float = 0.0
    lost_pellet: float = 0.0
    residual: float = 0.0


class Stretches(NamedTuple):
    """Stretch at the wall nodes, (n_z_wall + 1, n_theta_shown) each."""

    longitudinal: Floats
    circumferential: Floats


class Moment:
    """A state of a run and the model that made it: what fields and probes are read from.

    cells: of the probes, numbers along z; probes read the first column around.
    """

    def __init__(self, model: Model, state: State, cells: NDArray[np.int64] | None = None) -> None:
        self.model = model
        self.state = state
        self._cells = cells

    @property
    def _fields(self) -> ModuleType:
        return self.model.binding.module("model.fields")

    @cached_property
    def wall(self) -> WallState:
        """The wall on the columns on which it is shown."""
        return shown_wall(self.model.grid, self.state.wall)

    @cached_property
    def viscous_force(self) -> float:
        """Viscous friction on the pellet [mN]."""
        return -viscous_friction_now(self.model, self.state.pellet) * sliding_speed(self.model, self.state.pellet)

    @cached_property
    def end_reaction(self) -> float:
        """Axial force of a closed end on the pellet [mN], Eq. (60); zero at open ends and without a pellet."""
        return end_reaction(self.model, self.state.pellet) if self.model.pellet.present else 0.0

    @cached_property
    def dry_force(self) -> float:
        """Dry friction on the pellet [mN]: what wall, load, viscous friction and closed ends leave to it."""
        return -net_force(self.model, self.state.pellet) - self.viscous_force - self.end_reaction

    @property
    def dry_friction_limit(self) -> float:
        """Dry friction that sliding meets [mN], Eqs. (27), (50); zero without a pellet."""
        return dry_friction_now(self.model, self.state.pellet) if self.model.pellet.present else 0.0

    @cached_property
    def _tensions(self) -> Floats:
        found: Floats = self._fields.nodal_tensions(self._fields.corner_tensions(self.wall, self.model.wall))
        return found

    def tension(self, part: str, layer: str) -> Floats:
        """A tension at the wall nodes [mN/cm], (n_z_wall + 1, n_theta_shown); part: passive, active or total."""
        return self._tensions[..., PARTS[part, layer]]

    @cached_property
    def stretches(self) -> Stretches:
        """Both stretches at the wall nodes."""
        return Stretches(*self._fields.nodal_stretches(self.wall, self.model.wall))

    @property
    def contact_pressure(self) -> Floats:
        """Contact pressure at the wall nodes [mN/cm^2], (n_z_wall + 1, n_theta_shown)."""
        found: Floats = self._fields.contact_pressure(self.wall, self.model.wall)
        return found

    def sheet(self, layer: str) -> SheetState:
        """Cells of the longitudinal or the circular layer, or of the network."""
        if layer == "network":
            assert self.state.network is not None
            return self.state.network
        return self.state.longitudinal if layer == "longitudinal" else self.state.circular

    def layer(self, layer: str) -> Layer:
        """Constants of the longitudinal or the circular layer or the network, regions and protocols included."""
        if layer == "network":
            assert self.model.network is not None
            return self.model.network.sheet
        return self.model.longitudinal if layer == "longitudinal" else self.model.circular

    def gate(self, layer: str, gate: str) -> Floats:
        """A state of the layer's cell, (n_z, n_theta)."""
        return self.sheet(layer).gates[self.layer(layer).cell.states.index(gate)]

    def calcium(self, layer: str) -> Floats:
        """The state that is the calcium of the layer's cell, (n_z, n_theta)."""
        return self.gate(layer, next(name for name in CALCIUM if name in self.layer(layer).cell.states))

    def at_probes(self, field: Floats) -> Floats:
        """A field on cells (n_z, n_theta) at the probes, (n_probes,)."""
        return field[:, 0][self._cells]

    def conductance_at_probes(self, layer: str, channel: str) -> Floats:
        """Conductance of a channel of the layer's cell at the probes [mS/cm^2], (n_probes,)."""
        everywhere = self.layer(layer).conductances[self.layer(layer).cell.channels.index(channel)]
        return self.at_probes(everywhere.reshape(self.sheet(layer).potential.shape))


class StepMoment(Moment):
    """The end of a step: besides, what the step brought. Outputs over the steps are read from it.

    contact, ends, momentum: of the step's summary. done: work since t = 0.
    """

    def __init__(self, model: Model, state: State, summary: StepSummary, report: StepReport, done: Done) -> None:
        super().__init__(model, state)
        self.contact: ContactSummary = summary.contact
        self.ends: EndReactions = summary.ends
        self.momentum: Momentum = summary.momentum
        self.newton_iterations = report.newton_iterations
        self.parts = max(1, len(report.parts)) if report.wall_solves else 0
        self.rejected = report.rejected
        self.done = done
