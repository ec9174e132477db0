"""What a page is shown of a run at one moment, as few numbers as a picture needs, in single precision.

A frame is little-endian float32 throughout: the scalars of `SCALARS`, the currents of both layers at the probe, then
the wall's radius, axial position and contact pressure at some nodes, and the potentials of both layers at some cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..inputs.build import cell_of_layer
from ..inputs.config import Configuration
from ..inputs.drugs import amount
from ..inputs.shape import shape_of
from ..names import KPA, OUTPUTS
from ..results.moment import Moment
from ..running.observers import read_off
from ..running.simulation import Simulation

POINTS = 220
"""Most nodes or cells of a frame: 0.5 mm apart in the shipped tube, finer than a pixel on most screens."""

SCALARS = (
    "pellet_position",
    "pellet_velocity",
    "axial_force",
    "normal_force",
    "viscous_force",
    "dry_force",
    "end_reaction",
    "lumen_pressure",
    "max_contact_pressure",
    "min_diameter",
)
LAYERS = ("longitudinal", "circular")


@dataclass(frozen=True)
class Camera:
    """Takes frames of one run: which nodes, which cells, where the currents are read.

    nodes, cells: numbers of those that are shown. currents: names of the channels by layer.
    """

    nodes: NDArray[np.int64]
    cells: NDArray[np.int64]
    probe: NDArray[np.int64]
    currents: dict[str, tuple[str, ...]]
    kinetics: dict[str, tuple[Any, Any]]

    @classmethod
    def of(cls, simulation: Simulation) -> Camera:
        """The one that suits a run."""
        grid, configuration = simulation.model.grid, simulation.configuration
        kinetics = {layer: cell_of_layer(configuration, layer)[:2] for layer in LAYERS}
        middle = np.array([grid.n_z // 2])
        return cls(
            _spread(grid.nodes.size),
            _spread(grid.n_z),
            middle,
            {layer: tuple(kinetics[layer][0].channels) for layer in LAYERS},
            kinetics,
        )

    def header(self, simulation: Simulation) -> dict[str, Any]:
        """What a page must know to read and draw the frames of a run: names, numbers of points, sizes and units."""
        configuration, grid = simulation.configuration, simulation.model.grid
        present = simulation.model.pellet.present
        return {
            "scalars": [
                {"name": name, "unit": OUTPUTS[name].unit, "label": OUTPUTS[name].long_name} for name in SCALARS
            ],
            "currents": {layer: list(names) for layer, names in self.currents.items()},
            "nodes": int(self.nodes.size),
            "cells": int(self.cells.size),
            "length": float(configuration.wall.length),
            "tube_radius": float(configuration.wall.radius),
            "pellet_radius": float(configuration.pellet.radius) if present else 0.0,
            "pellet_outline": _outline(configuration) if present else [],
            "probe": float(grid.cells[self.probe[0]]),
            "cell_places": [round(float(place), 4) for place in grid.cells[self.cells]],
            "duration": float(configuration.run.duration),
            "thresholds": {layer: float(getattr(configuration, layer).threshold) for layer in LAYERS},
            "scenario": configuration.scenario,
            "reading": configuration.reading,
            "drugs": [f"{agent} {amount(dose)}" for agent, dose in _given(configuration).items()],
        }

    def take(self, simulation: Simulation) -> bytes:
        """The frame of a run as it stands."""
        now = Moment(simulation.model, simulation.state, self.probe)
        scalars = simulation.latest()
        wall = simulation.state.wall.position[self.nodes, 0]
        parts = [
            [simulation.time, *(scalars[name] for name in SCALARS)],
            *(self._currents(now, layer) for layer in LAYERS),
            wall[:, 0],
            wall[:, 2],
            np.asarray(now.contact_pressure)[self.nodes, 0] / KPA,
            *(now.sheet(layer).potential[self.cells, 0] for layer in LAYERS),
        ]
        return np.concatenate([np.ravel(part) for part in parts]).astype("<f4").tobytes()

    def _currents(self, now: Moment, layer: str) -> NDArray[np.float64]:
        """Currents of a layer at the probe [uA/cm^2], one for each channel."""
        cell, constants = self.kinetics[layer]
        potential = now.at_probes(now.sheet(layer).potential)
        states = np.stack([now.at_probes(row) for row in now.sheet(layer).gates])
        names = tuple(f"conductance_{name}_{layer}_probe" for name in cell.channels)
        found = cell.kernels.currents(potential, states, np.stack(read_off(names, now)), constants)
        return np.array([float(found[name][0]) for name in cell.channels])


def _spread(count: int) -> NDArray[np.int64]:
    """At most POINTS numbers below `count`, evenly, the first and the last among them."""
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, POINTS))).astype(np.int64))


def _given(configuration: Configuration) -> dict[str, float]:
    """Agents with their concentrations [nM], each once however many targets it has."""
    return {dose.agent: dose.concentration for dose in configuration.drugs}


def _outline(configuration: Configuration) -> list[list[float]]:
    """The pellet's outline [cm], (points, 2): along the axis from its centre, and its radius there."""
    axial, radii = shape_of(configuration).outline(61)
    return np.column_stack([axial, radii]).round(4).tolist()
