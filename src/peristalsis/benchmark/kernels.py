"""The compiled kernels that are timed and counted by themselves, each on data of its own; their names live here alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..build import build
from ..config import Configuration
from ..model.model import ACTIVATION_LEVEL, Model
from ..numerics.banded import HALF_WIDTH, solve_banded_in_place
from ..tissue.cells import plant
from ..tissue.sheet import advance_sheet
from ..wall.membrane import assemble_wall

Floats = NDArray[np.float64]

SUBSTEPS = 8
"""Steps that a sheet is advanced by in one call."""


@dataclass(frozen=True)
class Kernel:
    """A kernel with its arguments. nodes: node-steps (or nodes, for the wall) of one call.

    compulsory: bytes of the arrays that a call must read or write at least once, for each of the nodes.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    nodes: int
    compulsory: float

    def __call__(self) -> object:
        """One call."""
        return self.function(*self.arguments)


def shipped_model(cells: int = 0, elements: int = 0) -> Model:
    """The baseline's model, on other grids if they are named."""
    changes = {"grid.n_z": cells, "grid.n_z_wall": elements}
    return build(Configuration().with_changes({key: value for key, value in changes.items() if value}))


def gates(model: Model, cells: int, exact: bool, shuffled: bool = False) -> Kernel:
    """All gates and m^3 of cells between -65 and 30 mV, in the order of a wave or in any."""
    potential = np.linspace(-65.0, 30.0, cells)
    if shuffled:
        np.random.default_rng(1).shuffle(potential)
    state, cubed = np.full((4, cells), 0.3), np.empty(cells)
    arguments = (potential, state, model.tables[0], exact, model.dt_cell, model.cell, cubed)
    return Kernel("gates", plant.relax_gates, arguments, cells, 8.0 * (1 + 2 * 4 + 1))


def sheet(model: Model, cells: int, exact: bool, conducts: bool) -> Kernel:
    """A sheet over SUBSTEPS steps with a front every 200 cells: gates, currents, potential, conduction if it conducts."""
    potential = -62.0 + 80.0 * np.maximum(np.sin(np.linspace(0.0, np.pi * cells / 100.0, cells)), 0.0)
    layer = model.longitudinal
    coefficient = np.full(cells - 1 if conducts else 0, layer.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2)
    arguments = (
        potential,
        np.full((4, cells), 0.3),
        np.full(cells, np.nan),
        np.full(cells, np.nan),
        np.repeat(layer.conductances[:, :1], cells, axis=1),
        coefficient,
        np.zeros(cells),
        np.zeros(cells),
        1,
        0.0,
        model.dt_cell,
        SUBSTEPS,
        model.stages(layer, np.ones(1)),
        *model.tables,
        exact,
        ACTIVATION_LEVEL,
        model.cell,
    )
    name = "sheet" if conducts else "cell"
    return Kernel(name, advance_sheet, arguments, cells * SUBSTEPS, 8.0 * (2 + 2 * 4 + 5 + 2 + conducts))


def wall(model: Model) -> tuple[Kernel, ...]:
    """What a Newton iteration of the axisymmetric wall is made of, on a wall with a gentle wave."""
    n = model.grid.n_z_wall + 1
    z = np.linspace(0.0, model.grid.element_size * (n - 1), n)
    rho, zeta = model.wall.radius * (1.3 + 0.2 * np.sin(z)), 1.05 * z
    residual, matrix = np.zeros(2 * n), np.zeros((2 * n + HALF_WIDTH, 2 * HALF_WIDTH + 1))
    drive = np.full(2 * (n - 1), 5.0)
    assembly = (
        rho,
        zeta,
        np.stack([rho, zeta]),
        np.full(n - 1, 1.1),
        rho / model.wall.radius,
        500.0,
        drive,
        drive,
        model.wall,
        residual,
        matrix,
    )
    band = np.zeros_like(matrix)
    band[: 2 * n, HALF_WIDTH] = 4.0
    band[: 2 * n, HALF_WIDTH - 2 : HALF_WIDTH] = band[: 2 * n, HALF_WIDTH + 1 : HALF_WIDTH + 3] = -1.0
    right = np.ones((2 * n + HALF_WIDTH, 4))

    def solve(system: Floats, columns: Floats) -> None:
        # Solved in place: the next call meets factors, which are as well-conditioned.
        solve_banded_in_place(system, columns, 3)

    return (
        Kernel("wall assembly", assemble_wall, assembly, n, 8.0 * (2 + 2 + 1 + 1 + 4 + 2 + 22)),
        Kernel("wall solve", solve, (band, right), n, 8.0 * 2 * (22 + 6)),
    )
