"""What the coupled step asks of the grid that the wall lives on.

A scheme is one module of functions (`schemes.column`, `schemes.surface`), and `WallScheme` says which. Histories of the
wall, their extrapolation and the solver are the scheme's own: the loop hands states over and gets states back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..tissue.surface import SurfaceOperator
from .balance import Momentum, Work
from .bookkeeping import ContactSummary, EndReactions
from .model import Layer, Model
from .state import PelletState, SheetState, State, WallState

Floats = NDArray[np.float64]


class Ahead(NamedTuple):
    """Stretch extrapolated to the middle of the coming step: along z, (n_z_wall, n_theta), and its smallest value.

    hoop: around the ring, on the whole surface.
    """

    axial: Floats
    least: float
    hoop: Floats | None = None


class Conduction(NamedTuple):
    """How a sheet conducts over a step: coefficients along z [1/ms], or the operator of a surface.

    operator: None where the cells of a surface do not conduct. ring_rate: what fluxes around the ring add [1/ms].
    """

    operator: Floats | SurfaceOperator | None
    ring_rate: float = 0.0


@dataclass(frozen=True)
class Solved:
    """What a step of the wall left behind and what it took; krylov: iterations of a surface's linear solver."""

    wall: WallState
    pellet: PelletState
    pressure: float
    iterations: int
    assemblies: int
    solves: int
    krylov: int = 0


class StepSummary(NamedTuple):
    """Balances over a step, and contact, axial forces of both ends and slack share at its end."""

    work: Work
    momentum: Momentum
    contact: ContactSummary
    ends: EndReactions


class WallScheme(Protocol):
    """One kind of grid: what of a step depends on it."""

    def muscle_drive(self, model: Model, layer: Layer, sheet: SheetState) -> Floats:
        """Force factor times drive [mV] of the half elements, (2 n_z_wall, n_theta), Eqs. (19) and (33)."""

    def stretches_ahead(self, model: Model, wall: WallState) -> Ahead:
        """Stretches that conduction sees in the coming step."""

    def conduction(self, model: Model, layer: Layer, ahead: Ahead) -> Conduction:
        """How a layer conducts on a wall so stretched, Eqs. (6), (11)."""

    def solve_wall(
        self, model: Model, wall: WallState, pellet: PelletState, pressure: float, drive: Floats, dt: float
    ) -> tuple[int, Solved | None]:
        """One implicit step dt [s] under a drive; None with the reason's code when it does not converge."""

    def receptor_stretch(self, model: Model, wall: WallState) -> Floats | None:
        """Radius of the rings over the pellet-free one, (n_z_wall + 1,); None where no receptor can be stretched."""

    def trigger_force(self, model: Model, sheet: SheetState, wall: WallState) -> Floats:
        """Active tension of the longitudinal layer at its cells, before any factor on force [mN/cm], Eq. (25)."""

    def trigger_tension(self, model: Model, wall: WallState) -> Floats:
        """Total tension of the longitudinal layer at its cells [mN/cm], Eq. (25)."""

    def stretch_fault(self, model: Model, wall: WallState) -> str | None:
        """What is wrong with the stretches of a wall, with its place; None if they are in range."""

    def work(self, model: Model, before: State, after: State) -> Work:
        """Work of every term between two states a step apart, Eq. (29)."""

    def contact(self, model: Model, state: State) -> ContactSummary:
        """Numbers about the contact of a state."""

    def summary(self, model: Model, before: State, after: State) -> StepSummary:
        """All that is recorded after a step."""
