"""The whole state of a run between two steps: pure data, copied, never changed in place."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import SourceState
from ..control.reflex import ReflexState
from ..control.sequence import TriggerState
from .arrays import WallArrays

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SheetState:
    """One muscle sheet: potential [mV] (n_z, n_theta_conduction), gates (states, ...), activation times [ms].

    first_activation and last_activation: first and latest rise through the activation level, nan before. muscle: states
    of the activation of its muscle, (states, n_z, n_theta_conduction), none for most.
    """

    potential: Floats
    gates: Floats
    first_activation: Floats
    last_activation: Floats
    muscle: Floats = field(default_factory=lambda: np.empty((0, 1, 1)))


@dataclass(frozen=True)
class WallState:
    """The wall: nodes as (rho [cm], vartheta [rad], zeta [cm]), shape (n_z_wall + 1, n_theta, 3), now and before.

    velocity: of (rho, vartheta, zeta) at both times. contact: force density per undeformed area [mN/cm^2],
    (n_z_wall + 1, n_theta). step_before: length of the step between the two positions [s], 0 at the start.
    stretch_rate: of the elements along z [1/s], (n_z_wall, n_theta); hoop_rate: of the ring, (n_z_wall + 1, n_theta),
    with one column of the node, with more of the edge from column j to j + 1.
    drive: force factor times phi+ of the longitudinal and the circular layer of the half elements [mV], (2,
    2 * n_z_wall, n_theta). The last three are those that the present tensions were computed with.
    """

    position: Floats
    position_before: Floats
    velocity: Floats
    velocity_before: Floats
    contact: Floats
    stretch_rate: Floats
    hoop_rate: Floats
    drive: Floats
    step_before: float

    @cached_property
    def arrays(self) -> WallArrays:
        """All arrays, as compiled calls take them."""
        return WallArrays(
            self.position,
            self.position_before,
            self.velocity,
            self.velocity_before,
            self.contact,
            self.stretch_rate,
            self.hoop_rate,
            self.drive,
        )


@dataclass(frozen=True)
class PelletState:
    """The pellet: centre along the tube [cm], velocity [cm/s], axial force of the wall [mN].

    dry, viscous: friction in the step before [mN], [mN s/cm]; slid: whether the pellet slid as that began. across: x
    and y of the centre in the frame of column 0 [cm]; (0, 0) while the pellet is kept on the axis.
    """

    position: float
    velocity: float
    axial_force: float
    dry: float = 0.0
    across: tuple[float, float] = (0.0, 0.0)
    viscous: float = 0.0
    slid: bool = False


@dataclass(frozen=True)
class MicroStep:
    """What the explicit scheme keeps besides, Eqs. (53)-(57): the nodes' rate half a micro-step ago, and its length.

    rate: of (rho, vartheta, zeta), (n_z_wall + 1, 1, 3). length: of the last micro-step [s].
    """

    rate: Floats
    length: float


@dataclass(frozen=True)
class State:
    """Everything that the next step depends on; time is step * dt, from the integer step."""

    step: int
    longitudinal: SheetState
    circular: SheetState
    pacemaker: SheetState
    wall: WallState
    pellet: PelletState
    pressure: float
    trigger: TriggerState
    reflex: ReflexState
    sources: tuple[SourceState, ...]
    network: SheetState | None = None
    micro_step: MicroStep | None = None
