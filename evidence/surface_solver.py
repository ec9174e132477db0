"""The wall on the whole surface: linear solvers side by side, what a step costs, and what its regularisers move.

Writes docs/evidence/surface_solver.md. Takes about a quarter of an hour on one core. Times are of the processor.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as sl
from common import save_text, table
from numpy.typing import NDArray

from peristalsis import scenarios
from peristalsis.geometry.surface import column_angles
from peristalsis.inputs.build import build
from peristalsis.model import surface_update
from peristalsis.model.initial import initial_state
from peristalsis.model.model import Model
from peristalsis.model.scheme import Solved
from peristalsis.model.state import PelletState, State, WallState
from peristalsis.model.surface_step import try_surface_wall
from peristalsis.numerics.column_solver import ColumnSolver
from peristalsis.numerics.constraint import Constraint, add_normal, project
from peristalsis.numerics.krylov import flexible_gmres
from peristalsis.numerics.ring_blocks import RingOperator, multiply
from peristalsis.numerics.ring_solver import RingSolver
from peristalsis.wall.constants import SurfaceConstants

Floats = NDArray[np.float64]
Wall = tuple[WallState, PelletState, float]

DT = 2e-3
SPEED, PEAK, FOOT, TAIL = 4.2, 85.0, 0.03, 2.1
"""The synthetic wave, like the baseline's: speed [cm/s], drive [mV], lengths over which it rises and falls [cm]."""


def started(elements: int, columns: int) -> tuple[Model, Wall]:
    """Model and wall before t = 0: the baseline's tube and pellet, repeated in so many columns."""
    changes = {"grid.n_z": elements, "grid.n_z_wall": elements}
    model, state, _ = initial_state(build(scenarios.configuration("baseline", changes=changes)))
    return model, (widened(state, columns), state.pellet, state.pressure)


def widened(state: State, columns: int) -> WallState:
    """The axisymmetric wall in so many columns."""
    wall = state.wall
    fields = ("position", "position_before", "velocity", "velocity_before", "contact", "stretch_rate", "hoop_rate")
    wide = {name: np.repeat(getattr(wall, name), columns, axis=1) for name in fields}
    for name in fields[:2]:
        wide[name][:, :, 1] = column_angles(columns)
    return replace(wall, **wide, drive=np.repeat(wall.drive, columns, axis=2))


def drive(model: Model, moment: float, columns: int, point: bool) -> Floats:
    """Both layers under a wave from the oral end, all around or from one point of it; (2, 2 n_z_wall, columns) [mV]."""
    halves = 2 * model.grid.n_z_wall
    z = (np.arange(halves)[:, None, None] + (np.arange(4)[None, :, None] + 0.5) / 4.0) * 0.5 * model.grid.element_size
    angle = column_angles(columns)
    s = model.wall.radius * np.minimum(angle, 2.0 * np.pi - angle) * (1.0 if point else 0.0)
    behind = SPEED * moment - np.hypot(z, s[None, None, :])
    wave = PEAK * np.clip(behind / FOOT, 0.0, 1.0) * np.clip(1.0 - (behind / TAIL) ** 2, 0.0, None)
    return np.repeat(wave.mean(axis=1)[None], 2, axis=0)


class Counts:
    """What steps have cost."""

    def __init__(self) -> None:
        self.steps = self.newton = self.assemblies = self.krylov = self.halved = 0
        self.seconds = 0.0


def step(
    model: Model, known: Wall, wave: Floats, counts: Counts, dt: float = DT, depth: int = 8, **options: Any
) -> Solved:
    """One step, in halves where it does not converge."""
    surface = options.get("surface", SurfaceConstants())
    _, solved = try_surface_wall(model, *known, wave, dt, surface, mean_first=options.get("mean_first", True))
    if solved is None:
        if depth == 0:
            raise RuntimeError("no equilibrium")
        counts.halved += 1
        middle = 0.5 * (known[0].drive + wave)
        half = step(model, known, middle, counts, 0.5 * dt, depth - 1, **options)
        return step(model, (half.wall, half.pellet, half.pressure), wave, counts, 0.5 * dt, depth - 1, **options)
    counts.newton += solved.iterations
    counts.assemblies += solved.assemblies
    counts.krylov += solved.krylov
    return solved


def run(elements: int, columns: int, seconds: float, point: bool, **options: Any) -> tuple[Solved, Counts]:
    """March so long; the first step, which loads kernels, is not timed."""
    model, known = started(elements, columns)
    step(model, known, drive(model, DT, columns, point), Counts(), **options)
    counts = Counts()
    begin = time.process_time()
    for k in range(round(seconds / DT)):
        solved = step(model, known, drive(model, (k + 1) * DT, columns, point), counts, **options)
        known = (solved.wall, solved.pellet, solved.pressure)
        counts.steps += 1
    counts.seconds = time.process_time() - begin
    return solved, counts


class Recorder(RingSolver):
    """Keeps the tangents that Newton's method asks to be solved with; `sides` keeps their right-hand sides."""

    systems: list[tuple[RingOperator, Constraint]] = []  # noqa: RUF012
    sides: list[Floats] = []  # noqa: RUF012

    def __init__(self, operator: RingOperator, constraint: Constraint) -> None:
        super().__init__(operator, constraint)
        kept = Constraint(constraint.held.copy(), constraint.rows.copy(), constraint.normal.copy())
        self.systems.append((operator._replace(blocks=operator.blocks.copy(), tether=0.0), kept))


def _recording(apply: Any, precondition: Any, right: Floats, target: float, most: int) -> Any:
    Recorder.sides.append(right.copy())
    return flexible_gmres(apply, precondition, right, target, most)


def hard_system(elements: int, columns: int) -> tuple[RingOperator, Constraint, Floats]:
    """Tangent and right-hand side in the middle of a step of the point source, 20 ms after its start."""
    model, known = started(elements, columns)
    surface_update.RingSolver = Recorder  # type: ignore[misc]
    surface_update.flexible_gmres = _recording
    for k in range(10):
        Recorder.systems.clear()
        Recorder.sides.clear()
        solved = step(model, known, drive(model, (k + 1) * DT, columns, True), Counts())
        known = (solved.wall, solved.pellet, solved.pressure)
    surface_update.RingSolver = RingSolver  # type: ignore[misc]
    surface_update.flexible_gmres = flexible_gmres
    # The one whose right-hand side is nearest to a hundredth of the force scale: past the search, before the end.
    norms = [abs(np.log10(np.linalg.norm(side)) + 2.0) for side in Recorder.sides]
    chosen = int(np.argmin(norms))
    rows = elements + 1
    field = Recorder.sides[chosen][: rows * 3 * columns].reshape(rows, 3, columns)
    return (*Recorder.systems[chosen], field[1:-1].ravel())


class System:
    """A constrained tangent as an operator, as a sparse matrix and as dense blocks of rings."""

    def __init__(self, operator: RingOperator, constraint: Constraint) -> None:
        self.operator, self.constraint = operator, constraint
        self.n, self.m = constraint.held.shape
        self.average = RingSolver(operator, constraint)
        self.padded = np.empty((self.n, 3, self.m + 2))

    def times(self, field: Floats) -> Floats:
        """The operator between projections, with a stiffness along held normals."""
        rest, out = field.copy(), np.empty_like(field)
        project(self.constraint, rest)
        multiply(self.operator, rest, 0, self.n, self.padded, out)
        project(self.constraint, out)
        add_normal(self.constraint, self.average.stiffness, field, out)
        return out

    def flat(self, vector: Floats) -> Floats:
        """`times` for vectors over the inner rows."""
        field = np.zeros((self.n, 3, self.m))
        field[1:-1] = vector.reshape(self.n - 2, 3, self.m)
        return self.times(field)[1:-1].ravel()

    def matrix(self) -> sp.csc_matrix:
        """Read off by colouring: columns of the matrix that share no row are taken together."""
        n, m = self.n, self.m
        around = next(k for k in range(5, m + 1) if m % k == 0)
        rows, columns, values = [], [], []
        index = np.arange(n * 3 * m).reshape(n, 3, m)
        for i0 in range(5):
            for a in range(3):
                for j0 in range(around):
                    field = np.zeros((n, 3, m))
                    field[i0::5, a, j0::around] = 1.0
                    field[[0, -1]] = 0.0
                    out = self.times(field)
                    i, b, j = np.nonzero(out)
                    source_i = i + (i0 - i + 2) % 5 - 2
                    source_j = (j + (j0 - j + 2) % around - 2) % m
                    rows.append(index[i, b, j])
                    columns.append(index[source_i, a, source_j])
                    values.append(out[i, b, j])
        size = n * 3 * m
        full = sp.csc_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size)
        )
        inner = index[1:-1].ravel()
        return full[inner][:, inner].tocsc()

    def fft(self) -> Callable[[Floats], Floats]:
        """The average around the ring."""
        solver = RingSolver(self.operator, self.constraint)

        def solve(vector: Floats) -> Floats:
            field = np.zeros((self.n, 3, self.m))
            field[1:-1] = vector.reshape(self.n - 2, 3, self.m)
            return solver.solve(field, 0.0)[1:-1].ravel()

        solve(np.ones((self.n - 2) * 3 * self.m))
        return solve

    def columns(self) -> Callable[[Floats], Floats]:
        """A sweep over even and odd columns."""
        lines = ColumnSolver(self.operator, self.constraint, self.average.stiffness)

        def solve(vector: Floats) -> Floats:
            field, found = np.zeros((self.n, 3, self.m)), np.zeros((self.n, 3, self.m))
            field[1:-1] = vector.reshape(self.n - 2, 3, self.m)
            lines.solve(False, field, found)
            lines.solve(True, field - self.times(found), found)
            return found[1:-1].ravel()

        return solve

    def rings(self, matrix: sp.csc_matrix) -> Callable[[Floats], Floats]:
        """Every ring on its own, dense."""
        size = 3 * self.m
        factors = [
            la.lu_factor(matrix[i * size : (i + 1) * size, i * size : (i + 1) * size].toarray())
            for i in range(self.n - 2)
        ]

        def solve(vector: Floats) -> Floats:
            parts = vector.reshape(-1, size)
            return np.concatenate([la.lu_solve(f, part) for f, part in zip(factors, parts, strict=True)])

        return solve

    def tridiagonal(self, matrix: sp.csc_matrix, kind: type) -> Callable[[Floats], Floats]:
        """Block-tridiagonal elimination along z, two dense rings a block (bending reaches two rings)."""
        size = 6 * self.m
        edges = [*range(0, matrix.shape[0], size), matrix.shape[0]]
        spans = [slice(a, b) for a, b in pairwise(edges)]
        blocks = [
            [
                matrix[spans[i], spans[k]].toarray().astype(kind) if 0 <= k < len(spans) else None
                for k in (i - 1, i, i + 1)
            ]
            for i in range(len(spans))
        ]
        factors: list[Any] = []
        multipliers: list[Any] = []
        diagonal = blocks[0][1]
        for i in range(len(spans)):
            factors.append(la.lu_factor(diagonal))
            if i + 1 < len(spans):
                lower = la.lu_solve(factors[i], blocks[i + 1][0].T, trans=1).T
                multipliers.append(lower)
                diagonal = blocks[i + 1][1] - lower @ blocks[i][2]

        def solve(vector: Floats) -> Floats:
            parts = [vector[s].astype(kind) for s in spans]
            for i in range(1, len(spans)):
                parts[i] -= multipliers[i - 1] @ parts[i - 1]
            for i in range(len(spans) - 1, -1, -1):
                if i + 1 < len(spans):
                    parts[i] -= blocks[i][2] @ parts[i + 1]
                parts[i] = la.lu_solve(factors[i], parts[i])
            return np.concatenate(parts).astype(np.float64)

        return solve


def compared(elements: int, columns: int) -> str:
    """A table of ways to solve one hard system to 1e-3 of its right-hand side."""
    operator, constraint, right = hard_system(elements, columns)
    system = System(operator, constraint)
    matrix = system.matrix()
    scale = np.sqrt(np.abs(matrix.diagonal()))
    scaled = sp.diags(1.0 / scale) @ matrix @ sp.diags(1.0 / scale)

    def after(first: Callable[[Floats], Floats], second: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
        def solve(vector: Floats) -> Floats:
            begun = first(vector)
            return begun + second(vector - system.flat(begun))

        return solve

    def incomplete() -> Callable[[Floats], Floats]:
        factor = sl.spilu(
            scaled.tocsc(), drop_tol=1e-3, fill_factor=6, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0
        )
        return lambda vector: factor.solve(vector / scale) / scale

    ways: dict[str, Callable[[], Callable[[Floats], Floats]]] = {
        "sparse LU (SuperLU, minimum degree)": lambda: (
            sl.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve
        ),
        "block-tridiagonal, dense rings, float64": lambda: system.tridiagonal(matrix, np.float64),
        "block-tridiagonal, dense rings, float32": lambda: system.tridiagonal(matrix, np.float32),
        "incomplete LU (threshold 1e-3)": incomplete,
        "rings alone": lambda: system.rings(matrix),
        "columns alone": system.columns,
        "average around the ring": system.fft,
        "columns, then the average (used)": lambda: after(system.columns(), system.fft()),
    }
    rows = []
    for name, make in ways.items():
        begin = time.process_time()
        precondition = make()
        prepared = time.process_time() - begin
        begin = time.process_time()
        found = flexible_gmres(
            system.flat, lambda v, _, p=precondition: p(v), right, 1e-3 * float(np.linalg.norm(right)), 150
        )
        rows.append(
            (
                name,
                prepared,
                found.iterations,
                time.process_time() - begin,
                found.residual <= 1e-3 * np.linalg.norm(right),
            )
        )
    head = ("preconditioner of GMRES", "to prepare (s)", "iterations", "to solve (s)", "converged")
    return table(head, [(*row[:4], "yes" if row[4] else "no") for row in rows])


def costs() -> str:
    """A table of what steps cost at 200 x 64."""
    rows = []
    for label, seconds, point, options in (
        ("wave all around", 0.4, False, {}),
        ("wave all around, without the mean first", 0.1, False, {"mean_first": False}),
        ("wave from a point", 0.06, True, {}),
    ):
        _, counts = run(200, 64, seconds, point, **options)
        per = [value / counts.steps for value in (counts.newton, counts.assemblies, counts.krylov)]
        rows.append((label, seconds, *per, counts.halved, counts.seconds / seconds))
    head = (
        "drive",
        "simulated (s)",
        "Newton a step",
        "assemblies a step",
        "Krylov a step",
        "steps cut in two",
        "seconds per simulated second",
    )
    return table(head, rows)


def regularisers() -> str:
    """A table of what the constants of the surface move in 0.05 s of the point source."""
    shipped = SurfaceConstants()
    rows = []
    for label, surface in {
        "shipped": shipped,
        "shear viscosity x 10": shipped._replace(shear_viscosity=10.0 * shipped.shear_viscosity),
        "shear viscosity / 10": shipped._replace(shear_viscosity=0.1 * shipped.shear_viscosity),
        "bending around x 10": shipped._replace(
            bending_stiffness_around=10.0 * shipped.bending_stiffness_around,
            bending_viscosity_around=10.0 * shipped.bending_viscosity_around,
        ),
        "no bending around": shipped._replace(bending_stiffness_around=0.0, bending_viscosity_around=0.0),
        "foundation x 10": shipped._replace(foundation=10.0 * shipped.foundation),
        "foundation / 10": shipped._replace(foundation=0.1 * shipped.foundation),
    }.items():
        solved, counts = run(100, 32, 0.05, True, surface=surface)
        rho, angle = solved.wall.position[:, :, 0], solved.wall.position[:, :, 1]
        aside = float(np.abs((rho * np.exp(1j * angle)).mean(axis=1)).max())
        rows.append((label, 10.0 * aside, 10.0 * float(rho.min()), solved.pressure, counts.newton / counts.steps))
    head = ("constants", "a ring's centre aside (mm)", "smallest radius (mm)", "pressure (mN/cm^2)", "Newton a step")
    return table(head, rows)


def main() -> None:
    """Make the three tables."""
    parts = [
        "# Solving for the wall on the whole surface\n",
        "Made by `python evidence/surface_solver.py`. Times are of the processor.\n",
        "## One hard system, to 1e-3\n\nFrom the point source after 20 ms, wall slack on one side. 100 x 32:\n\n"
        + compared(100, 32),
        "200 x 64:\n\n" + compared(200, 64),
        "## Steps of 2 ms at 200 x 64\n\n" + costs(),
        "## What the regularisers move\n\n100 x 32, 0.05 s of the point source.\n\n" + regularisers(),
        f"Largest memory of the whole script: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB.\n",
    ]
    save_text("surface_solver.md", "\n".join(parts))


if __name__ == "__main__":
    main()
