"""How long a step of the explicit scheme may be, part by part, in the state that a run is in, Eq. (57)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...pellet.body import require_shape
from ...pellet.shapes.sphere import gap_and_normal
from ...tissue.explicit_sheet import HEUN_LIMIT
from ...wall.explicit import largest_rates
from ..fields import column, stretch_of_elements
from ..model import Layer, Model
from ..state import State


class Limits(NamedTuple):
    """Largest stable steps [s]: of the dashpots alone, of waves alone, of wall and contact, pellet and conduction."""

    dashpot: float
    wave: float
    wall: float
    pellet: float
    conduction: float

    @property
    def least(self) -> float:
        """The step that all parts can take [s]."""
        return min(self.wall, self.pellet, self.conduction)

    @property
    def shell(self) -> float:
        """The step that wall and pellet can take [s]: micro-steps are theirs, conduction has its own."""
        return min(self.wall, self.pellet)

    def words(self) -> str:
        """All of them in a line, for messages."""
        return (
            f"dashpots {1e3 * self.dashpot:.3g} ms, waves in the wall and contact {1e3 * self.wave:.3g} ms, both "
            f"{1e3 * self.wall:.3g} ms, pellet {1e3 * self.pellet:.3g} ms, conduction {1e3 * self.conduction:.3g} ms"
        )


def limits(model: Model, state: State, opened: float = 0.0) -> Limits:
    """Limits in a state; opened: largest conductance that stimuli add to a cell [mS/cm^2]."""
    require_shape(model.pellet)
    scheme, wall = model.explicit, state.wall
    if scheme is None:
        raise ValueError("the model has no explicit scheme: set solver.integrator = explicit")
    rho, zeta = column(wall.position, 0, 0), column(wall.position, 0, 2)
    decay, square = largest_rates(
        rho,
        zeta,
        column(wall.stretch_rate, 0),
        column(wall.hoop_rate, 0),
        np.ascontiguousarray(wall.drive[0, :, 0]),
        np.ascontiguousarray(wall.drive[1, :, 0]),
        model.wall,
    )
    pellet = math.inf
    if model.pellet.present:
        square += scheme.contact_stiffness / model.wall.surface_density
        pellet = _pellet_limit(model, state, scheme.contact_stiffness)
    lag = 2.0 if scheme.predicted else 1.0
    conduction = min(conduction_limit(model, layer, state, opened) for layer in (model.longitudinal, model.circular))
    dashpot = 2.0 / (lag * decay) if decay > 0.0 else math.inf
    wave = 2.0 / math.sqrt(square) if square > 0.0 else math.inf
    return Limits(dashpot, wave, damped_limit(lag * decay, square), pellet, conduction)


def damped_limit(decay: float, square: float) -> float:
    """Largest dt [s] with square*dt^2 + 2*decay*dt <= 4: central differences with a lagging dashpot (M10).

    decay [1/s], twice that of the dashpot if it sees predicted rates; square: of the largest frequency [1/s^2].
    """
    total = decay + math.sqrt(decay * decay + 4.0 * square)
    return 4.0 / total if total > 0.0 else math.inf


def conduction_limit(model: Model, layer: Layer, state: State, opened: float = 0.0) -> float:
    """Largest stable step of a layer's potential [s], by Heun's method on the three-point operator."""
    rate = layer.constants.kinetics_rate * layer.leakiness + opened
    rate /= layer.constants.capacitance
    if layer.conducts:
        shortest = float(stretch_of_elements(state.wall.position, model.wall.element_size).min())
        spread = 1e-3 * layer.diffusivity * float(np.max(layer.conductivity))
        rate += 4.0 * spread / (model.grid.cell_size**2 * shortest)
    return 1e-3 * HEUN_LIMIT / rate


def _pellet_limit(model: Model, state: State, stiffness: float) -> float:
    """Largest stable step of the pellet [s]: its friction against the springs of the nodes it touches, or nearly."""
    wall, pellet = model.wall, model.pellet
    area = 2.0 * math.pi * wall.radius * wall.element_size
    total = 0.0
    for rho, zeta in zip(state.wall.position[1:-1, 0, 0], state.wall.position[1:-1, 0, 2], strict=True):
        gap, _, axial, _, _ = gap_and_normal(rho, zeta - state.pellet.position, pellet.shape)
        if gap < 0.01 * pellet.radius:
            total += axial * axial
    return pellet.viscous / (stiffness * area * total) if total > 0.0 else math.inf
