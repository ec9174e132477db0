"""The compiled kernels that are timed and counted by themselves, on data of their own; they are named here alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.model import ACTIVATION_LEVEL, Model
from peristalsis.numerics.block_band import PADDING, RIGHT, ROWS, solve_blocks_in_place
from peristalsis.tissue.cells import plant
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.sheet import advance_sheet
from peristalsis.wall.assembly import KNOWN_ROWS, WALL_ROWS, set_drives, wall_forces, wall_tangent

Floats = NDArray[np.float64]

SUBSTEPS = 8
"""Steps that a sheet is advanced by in one call."""
SLOPE = 500.0
"""Slope of the rates of Eq. (32) at a step of some milliseconds [1/s]."""


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
    state, cubed = np.full((4, cells), 0.3), np.empty((plant.INSTANT, cells))
    arguments = (
        potential,
        state,
        model.tables[0],
        exact,
        model.dt_cell,
        model.cell,
        cubed,
        model.longitudinal.conductances[:, :cells],
    )
    return Kernel("gates", plant.relax_gates, arguments, cells, 8.0 * (1 + 2 * 4 + 1))


def sheet(model: Model, cells: int, exact: bool, conducts: bool) -> Kernel:
    """A sheet over SUBSTEPS steps, a front every 200 cells: gates, currents, potential, conduction if it conducts."""
    potential = -62.0 + 80.0 * np.maximum(np.sin(np.linspace(0.0, np.pi * cells / 100.0, cells)), 0.0)
    layer = model.longitudinal
    coefficient = np.full(cells - 1 if conducts else 0, layer.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2)
    arguments = (
        SheetArrays(potential, np.full((4, cells), 0.3), np.full(cells, np.nan), np.full(cells, np.nan)),
        np.repeat(layer.conductances[:, :1], cells, axis=1),
        coefficient,
        Brought(np.zeros(cells), np.zeros(cells)),
        Steps(0.0, model.dt_cell, SUBSTEPS, 1, exact, ACTIVATION_LEVEL),
        model.stages(layer, 1.0),
        model.tables,
        model.cell,
    )
    name = "sheet" if conducts else "cell"
    return Kernel(name, advance_sheet, arguments, cells * SUBSTEPS, 8.0 * (2 + 2 * 4 + 5 + 2 + int(conducts)))


def wall(model: Model) -> tuple[Kernel, ...]:
    """What a Newton iteration of the axisymmetric wall is made of, on a wall with a gentle wave; `wall copy` is part of
    `wall solve`, which overwrites its system."""
    n = model.grid.n_z_wall + 1
    z = np.linspace(0.0, model.grid.element_size * (n - 1), n)
    rho, zeta = model.wall.radius * (1.3 + 0.2 * np.sin(z)), 1.05 * z
    known, work = np.ones((KNOWN_ROWS, n)), np.zeros((WALL_ROWS, n))
    known[0], known[1], known[3] = rho, zeta, rho / model.wall.radius
    drive = np.full(2 * (n - 1), 5.0)
    set_drives(drive, drive, known)
    system = np.zeros((ROWS, n + PADDING))
    wall_forces(rho, zeta, known, SLOPE, model.wall, 1, n - 2, work)
    wall_tangent(rho, zeta, 10.0, SLOPE, model.wall, 1, n - 2, work, system)
    system[RIGHT:] = 1.0
    pristine = system.copy()
    return (
        Kernel(
            "wall forces",
            wall_forces,
            (rho, zeta, known, SLOPE, model.wall, 1, n - 2, work),
            n,
            8.0 * (2 + KNOWN_ROWS + WALL_ROWS),
        ),
        Kernel(
            "wall tangent",
            wall_tangent,
            (rho, zeta, 10.0, SLOPE, model.wall, 1, n - 2, work, system.copy()),
            n,
            8.0 * (2 + WALL_ROWS + RIGHT),
        ),
        Kernel("wall solve", _solve, (pristine, system, n - 2), n, 8.0 * 2 * ROWS),
        Kernel("wall copy", np.copyto, (system.copy(), pristine), n, 8.0 * 2 * ROWS),
    )


def _solve(pristine: Floats, system: Floats, nodes: int) -> None:
    np.copyto(system, pristine)
    if not solve_blocks_in_place(system, 1, nodes, 3):
        raise ArithmeticError("the tangent of the bench's wall is singular; the bench is wrong")
