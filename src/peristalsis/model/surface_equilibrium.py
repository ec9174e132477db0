"""Wall on the whole surface, lumen and pellet in equilibrium at the end of a step: Newton's method with GMRES inside.

The axisymmetric counterpart is `equilibrium`: same unknowns, same residuals, same line search, same verdicts. Nodes
that touch move across their normal only; what the closed gap prescribes along it is put in beforehand, and the
equilibrium along the normal tells Q afterwards. The scalars border the tangent, in the Krylov space and in its
preconditioner (`numerics.ring_solver`), so that a ring-uniform step is an exact Newton step, Eq. (40).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import add_volume_tangent, column_angles, surface_volume, volume_gradient
from ..numerics.column_solver import ColumnSolver
from ..numerics.krylov import flexible_gmres
from ..numerics.ring_blocks import RingOperator, multiply, multiply_transposed, pad
from ..numerics.ring_solver import Constraint, RingSolver, add_normal, project
from ..pellet.friction import held_by_ends, sliding_velocity
from ..pellet.surface_contact import force_on_pellet, measure_contact, no_contact
from ..wall.constants import SurfaceConstants, WallConstants
from ..wall.surface import Edges, add_edge_forces, add_edge_tangent, load_edges, measure_edges, new_edges
from ..wall.surface_regularisers import (
    add_regulariser_forces,
    add_shear_tangent,
    bending_along,
    bending_around,
)
from .constants import LumenConstants, PelletConstants, Step
from .line_search import FIRST_ALLOWANCE, MEMORY, SMALLEST_STEP
from .verdicts import CONVERGED, GAP_SCALE, NOT_CONVERGED, OUT_OF_RANGE, ROUNDOFF, SINGULAR, TENSION_SCALE

Floats = NDArray[np.float64]

P, Z, F, X, Y = range(5)
"""Scalars: lumen pressure, axial place and force of the pellet, and its places across the axis where it is free."""
LOOSEST, TIGHTEST = 1e-2, 1e-3
"""Bounds of the relative residual to which a linear system is solved; in between it follows the Newton residual."""
MOST_KRYLOV = 80


class Sideways(NamedTuple):
    """A pellet free across the axis, in the frame of column 0: x = x_history + weight/friction [mN s/cm] * force."""

    friction: float
    x_history: float
    y_history: float
    weight: float


@dataclass(frozen=True)
class SurfaceProblem:
    """What a step is given. Fields (n, 3, m) in frames of columns; see `equilibrium.solve_equilibrium` for the rest.

    shear_history: of the patches, (n - 1, m). friction_weight: (n, m), sums to one or zero. sideways: None keeps the
    pellet on the axis.
    """

    history: Floats
    velocity_history: Floats
    stretch_history: Floats
    hoop_history: Floats
    shear_history: Floats
    drive: Floats
    friction_weight: Floats
    step: Step
    wall: WallConstants
    surface: SurfaceConstants
    pellet: PelletConstants
    lumen: LumenConstants
    sideways: Sideways | None
    tolerance: float
    gap_tolerance: float
    max_iterations: int


class SurfaceVerdict(NamedTuple):
    """The verdict's code (`equilibrium.REASONS`), Newton iterations, assemblies and Krylov iterations."""

    code: int
    iterations: int
    assemblies: int
    krylov: int


class _Trial:
    """A state that the iteration tries, and everything that is computed from it; one object serves a whole solve."""

    def __init__(self, problem: SurfaceProblem, places: Floats, density: Floats, scalars: Floats) -> None:
        n, _, m = places.shape
        self.problem = problem
        self.places, self.density, self.scalars = places, density, scalars
        self.padded, self.moved = np.empty((n, 3, m + 2)), np.empty((n, 3, m + 2))
        self.edges: Edges = new_edges(n, m)
        self.residual, self.gradient = np.empty((n, 3, m)), np.empty((n, 3, m))
        self.contact = no_contact(n, m)
        self.gap, self.normal = self.contact.gap, self.contact.normal
        self.touching, self.rows = self.contact.touching, self.contact.rows
        self.scalar_residual = np.zeros(scalars.size)
        self.volume = self.law = self.speed_slope = 0.0
        self.merit = self.worst = math.inf
        self.arc = 2.0 * math.pi * problem.wall.radius / m
        angles = column_angles(m)
        zero, one = np.zeros(m), np.ones(m)
        self.axes = {Z: np.stack([zero, zero, one])}
        if problem.sideways is not None:
            self.axes[X] = np.stack([np.cos(angles), -np.sin(angles), zero])
            self.axes[Y] = np.stack([np.sin(angles), np.cos(angles), zero])

    def evaluate(self, tolerance: float) -> bool:
        """Residuals, merit and worst residual of the trial state; False when it is out of range."""
        p = self.problem
        self.merit = self.worst = math.inf
        pad(self.places, self.padded)
        if not measure_edges(self.padded, p.wall, self.edges):
            return False
        if not load_edges(self.edges, p.stretch_history, p.hoop_history, p.step.slope, p.drive, p.wall):
            return False
        pad(self.places - p.history, self.moved)
        volume_gradient(self.padded, 1.0 / self.arc, self.gradient)
        np.multiply(self.gradient, -self.scalars[P], out=self.residual)
        add_edge_forces(self.edges, self.residual)
        add_regulariser_forces(
            self.padded, self.places, self.moved, p.shear_history, p.step.slope, p.wall, p.surface, self.residual
        )
        if p.step.inertia:
            mass = p.wall.surface_density * p.wall.element_size * p.step.slope
            self.residual += mass * ((self.places - p.history) * p.step.slope - p.velocity_history)
        self.residual[[0, -1]] = 0.0
        self.volume = surface_volume(self.padded) - (p.pellet.volume if p.pellet.present else 0.0)
        if not self.volume > 0.0:
            return False
        self.law = p.lumen.pressure * (p.lumen.reference_volume / self.volume) ** p.lumen.exponent
        self.scalar_residual[P] = self.scalars[P] - self.law
        contact_total = contact_worst = 0.0
        if p.pellet.present:
            contact_total, contact_worst = self._contact(tolerance)
        m = self.places.shape[2]
        errors = np.abs(self.residual) / self.unit
        scalar_errors = np.abs(self.scalar_residual) * self.weights
        total = float((errors * errors).sum() + contact_total) / m + float(scalar_errors @ scalar_errors)
        if not math.isfinite(total):
            return False
        self.merit = math.sqrt(total)
        self.worst = max(float(errors.max()), contact_worst, float(scalar_errors.max()))
        return True

    @property
    def unit(self) -> float:
        """Force on a node against which residuals are measured [mN/cm]."""
        return TENSION_SCALE * self.problem.wall.element_size / self.problem.wall.radius

    @property
    def weights(self) -> Floats:
        """Weights of the scalars' residuals in the merit."""
        circumference = 2.0 * math.pi * self.problem.wall.radius
        place = GAP_SCALE / TENSION_SCALE
        weights = [self.problem.wall.radius / TENSION_SCALE, place, 1.0 / (circumference * TENSION_SCALE), place, place]
        return np.array(weights[: self.scalars.size])

    def _contact(self, tolerance: float) -> tuple[float, float]:
        """Contact, friction and the pellet's equations; sum of squares and worst of the errors of gaps and Q."""
        p, s = self.problem, self.scalars
        h, frame = p.wall.element_size, p.pellet.frame
        x, y = (float(s[X]), float(s[Y])) if p.sideways is not None else (0.0, 0.0)
        measure_contact(
            self.places,
            self.density,
            x,
            y,
            float(s[Z]),
            p.pellet.shape,
            self.contact,
        )
        inner = slice(1, -1)
        self.residual -= h * self.density[:, None, :] * self.normal
        wall_velocity = 0.0
        if frame != 0.0:
            self.residual[:, 2] -= frame * p.friction_weight * s[F] / self.arc
            moved = self.places[:, 2] - p.history[:, 2]
            wall_velocity = float((p.friction_weight * moved).sum()) * p.step.slope
        fx, fy, fz = force_on_pellet(self.density, self.normal, self.arc * h)
        speed, self.speed_slope = sliding_velocity(float(s[F]), p.pellet.viscous, p.pellet.dry)
        self.scalar_residual[F] = s[F] - fz
        self.scalar_residual[Z] = s[Z] - p.step.pellet_history - p.step.pellet_weight * (frame * wall_velocity + speed)
        place = float(s[Z] - self.scalar_residual[Z])
        if held_by_ends(place, p.pellet.lowest, p.pellet.highest):
            self.scalar_residual[Z] = s[Z] - min(max(place, p.pellet.lowest), p.pellet.highest)
            self.speed_slope = 0.0
        if p.sideways is not None:
            give = p.sideways.weight / p.sideways.friction
            self.scalar_residual[X] = s[X] - p.sideways.x_history - give * fx
            self.scalar_residual[Y] = s[Y] - p.sideways.y_history - give * fy
        touching = self.touching[inner]
        gaps = np.abs(self.gap[inner][touching])
        open_density = np.abs(self.density[inner][~touching]) * p.wall.radius / TENSION_SCALE
        total = float(((GAP_SCALE / TENSION_SCALE * gaps) ** 2).sum() + (open_density**2).sum())
        worst = float(gaps.max(initial=0.0)) / p.gap_tolerance * tolerance
        return total, max(worst, float(open_density.max(initial=0.0)))


def solve_surface(places: Floats, density: Floats, scalars: Floats, problem: SurfaceProblem) -> SurfaceVerdict:
    """Solve in place for places (n, 3, m) [cm], density Q (n, m) [mN/cm^2] and scalars (p, Z, F) or (p, Z, F, X, Y).

    The end rows of `places` are held. Unless the code is CONVERGED the arrays hold a trial state that must not be used.
    """
    wall, step = problem.wall, problem.step
    trial = _Trial(problem, places, density, scalars)
    n, _, m = places.shape
    reach = ROUNDOFF * float(places[-1, 2].max()) / wall.element_size * wall.viscosity * step.slope / trial.unit
    tolerance = max(problem.tolerance, reach)
    blocks = np.empty((n, 9, 3, 3, m))
    merits = np.full(MEMORY, math.inf)
    iteration = assemblies = krylov = 0
    length, best_merit, best_length, settled = 1.0, math.inf, 1.0, False
    last_merit = math.inf
    old: tuple[Floats, Floats, Floats] = (places, density, scalars)
    update: tuple[Floats, Floats, Floats] = old
    while True:
        assemblies += 1
        ok = trial.evaluate(tolerance)
        if ok and trial.worst <= tolerance:
            return SurfaceVerdict(CONVERGED, iteration, assemblies, krylov)
        # The line search of the axisymmetric solver: shorten until the merit falls below the largest of the last ones.
        if iteration > 0 and not settled and not (ok and trial.merit <= (1.0 - 1e-4 * length) * float(merits.max())):
            if trial.merit < best_merit:
                best_merit, best_length = trial.merit, length
            length *= 0.5
            if length < SMALLEST_STEP:
                if not math.isfinite(best_merit):
                    return SurfaceVerdict(OUT_OF_RANGE, iteration, assemblies, krylov)
                length, settled = best_length, True
            for array, start, change in zip((places, density, scalars), old, update, strict=True):
                array[...] = start + length * change
            continue
        if not ok:
            return SurfaceVerdict(OUT_OF_RANGE, iteration, assemblies, krylov)
        if iteration >= problem.max_iterations:
            return SurfaceVerdict(NOT_CONVERGED, iteration, assemblies, krylov)
        merits[iteration % MEMORY] = trial.merit
        if iteration == 0:
            merits[:] = FIRST_ALLOWANCE * trial.merit
        forcing = min(LOOSEST, max(TIGHTEST, 0.9 * (trial.merit / last_merit) ** 2)) if iteration else LOOSEST
        last_merit = trial.merit
        found = _newton_update(trial, blocks, max(forcing * trial.merit, 0.3 * tolerance))
        if found is None:
            return SurfaceVerdict(SINGULAR, iteration, assemblies, krylov)
        update, used = found
        krylov += used
        old = (places.copy(), density.copy(), scalars.copy())
        best_merit, length, settled = math.inf, 1.0, False
        iteration += 1
        for array, change in zip((places, density, scalars), update, strict=True):
            array += change


def merit_of(places: Floats, density: Floats, scalars: Floats, problem: SurfaceProblem) -> float:
    """Merit of a guess, by which guesses are compared; infinite when it is out of range."""
    trial = _Trial(problem, places, density, scalars)
    trial.evaluate(problem.tolerance)
    return trial.merit


def _newton_update(trial: _Trial, blocks: Floats, target: float) -> tuple[tuple[Floats, Floats, Floats], int] | None:
    """Changes of places, density and scalars from the linearised equations, and Krylov iterations; None if singular.

    target: merit of the linear residual to reach.
    """
    problem, count = trial.problem, trial.scalars.size
    wall, pellet, step, arc = problem.wall, problem.pellet, problem.step, trial.arc
    n, _, m = trial.places.shape
    h, normal, touching = wall.element_size, trial.normal, trial.touching
    padded = np.empty((n, 3, m + 2))
    # Where a node moves across the normal, that turns: around the axis by `turn`, along the meridian by `excess` more.
    meridian = trial.contact.meridian
    turn = np.where(touching, h * trial.density / trial.contact.hoop, 0.0)
    excess = np.where(touching, h * trial.density / trial.contact.bend, 0.0) - turn
    blocks[...] = 0.0
    add_edge_tangent(trial.edges, blocks)
    add_shear_tangent(trial.padded, problem.shear_history, step.slope, wall, problem.surface, blocks)
    add_volume_tangent(trial.padded, -float(trial.scalars[P]) / arc, blocks)
    mass = wall.surface_density * h * step.slope**2 if step.inertia else 0.0
    for a in range(3):
        blocks[:, 4, a, a] += mass - turn
    if pellet.present:
        blocks[:, 4] += turn[:, None, None, :] * normal[:, :, None, :] * normal[:, None, :, :]
        blocks[:, 4] -= excess[:, None, None, :] * meridian[:, :, None, :] * meridian[:, None, :, :]
    operator = RingOperator(
        blocks,
        bending_along(wall, step.slope),
        bending_around(wall, problem.surface, step.slope, m),
        problem.surface.foundation * h,
    )
    constraint = Constraint(touching, trial.rows, normal)
    solver = RingSolver(operator, constraint)

    touched = np.flatnonzero(trial.rows)
    band = (max(int(touched[0]) - 2, 0), min(int(touched[-1]) + 3, n)) if touched.size else (0, 0)

    def times(field: Floats, rows_of: tuple[int, int] = (0, n)) -> Floats:
        out = np.empty_like(field)
        multiply(operator, field, rows_of[0], rows_of[1], padded, out)
        return out

    # Borders: columns of the scalars in the wall's rows, rows of the scalars over the wall's unknowns, and the corner.
    columns, rows, corner = np.zeros((count, n, 3, m)), np.zeros((count, n, 3, m)), np.eye(count)
    right, scalar_right = -trial.residual, -trial.scalar_residual
    prescribed = np.zeros((n, 3, m))
    slope_p = -problem.lumen.exponent * trial.law / trial.volume * arc
    columns[P] = -trial.gradient
    rows[P] = -slope_p * trial.gradient
    along: dict[int, Floats] = {}
    if pellet.present:
        closing = np.where(touching, -trial.gap, 0.0)
        prescribed = closing[:, None, :] * normal
        moved = times(prescribed, band)
        free = ~touching * h * trial.density
        right -= moved + free[:, None, :] * normal
        friction = pellet.frame * problem.friction_weight / arc
        columns[F, :, 2] = -friction
        drag = -step.pellet_weight * pellet.frame * step.slope * problem.friction_weight
        rows[Z, :, 2] = drag
        corner[Z, F] = -step.pellet_weight * trial.speed_slope
        scalar_right[P] += slope_p * float((trial.gradient * prescribed).sum())
        scalar_right[Z] -= float((drag * prescribed[:, 2]).sum())
        across, pushed = {}, {}
        for c, axis in trial.axes.items():
            share = np.where(touching, (axis[None] * normal).sum(axis=1), 0.0)
            along[c] = share[:, None, :] * normal
            across[c] = turn[:, None, :] * (axis[None] - along[c])
            across[c] += (excess * (axis[None] * meridian).sum(axis=1))[:, None, :] * meridian
            pushed[c] = times(along[c], band)
            columns[c] = pushed[c] + across[c]
        for c, axis in trial.axes.items():
            corner[P, c] -= slope_p * float((trial.gradient * along[c]).sum())
            corner[Z, c] += float((drag * along[c][:, 2]).sum())
            # Row of the force along this axis: factor * (change of the sum of h Q n).
            row = F if c == Z else c
            sideways = problem.sideways
            factor = arc if sideways is None or c == Z else arc * sideways.weight / sideways.friction
            share = np.einsum("iaj,aj->ij", normal, axis)
            transposed = np.empty((n, 3, m))
            multiply_transposed(operator, along[c], padded, transposed)
            rows[row] = factor * (transposed + across[c])
            for d, other in trial.axes.items():
                corner[row, d] += factor * float((along[c] * pushed[d]).sum())
                corner[row, d] -= factor * float((across[c] * other[None]).sum())
            corner[row, P] -= factor * float((along[c] * trial.gradient).sum())
            corner[row, F] -= factor * float((along[c][:, 2] * friction).sum())
            known = (along[c] * (moved + trial.residual)).sum() - (free * share).sum()
            scalar_right[row] -= factor * float(known)
        for fields in (columns, rows):
            for field in fields:
                project(constraint, field)
        project(constraint, right)
    for field in (*columns, *rows, right):
        field[[0, -1]] = 0.0

    size = right.size
    wall_weight = 1.0 / (trial.unit * math.sqrt(m))
    weights = trial.weights
    flat_columns, flat_rows = columns.reshape(count, size), rows.reshape(count, size)
    cleaned = np.zeros((count, size))
    for c in range(count):
        cleaned[c] = solver.solve(columns[c], 1e-9 * float(np.linalg.norm(columns[c]))).ravel()
    if solver.singular:
        return None
    schur = corner - flat_rows @ cleaned.T
    if not np.all(np.isfinite(schur)) or abs(np.linalg.det(schur)) < 1e-300:
        return None

    def constrained(field: Floats) -> Floats:
        if not pellet.present:
            return times(field)
        free_field = field.copy()
        project(constraint, free_field)
        out = times(free_field)
        project(constraint, out)
        add_normal(constraint, solver.stiffness, field, out)
        return out

    def apply(vector: Floats) -> Floats:
        scalars = vector[size:]
        image = np.empty(size + count)
        image[:size] = wall_weight * (constrained(vector[:size].reshape(n, 3, m)).ravel() + scalars @ flat_columns)
        image[size:] = weights * (flat_rows @ vector[:size] + corner @ scalars)
        return image

    lines: list[ColumnSolver] = []

    def smoothed(field: Floats) -> Floats:
        """One sweep over even and odd columns."""
        if not lines:
            lines.append(ColumnSolver(operator, constraint, solver.stiffness))
        found = np.zeros_like(field)
        lines[0].solve(False, field, found)
        lines[0].solve(True, field - constrained(found), found)
        return found

    calls = 0

    def precondition(vector: Floats, scale: float) -> Floats:
        """The average first, which is all that a ring-uniform wall needs; columns before it from then on."""
        nonlocal calls
        calls += 1
        solution = np.empty(size + count)
        field = vector[:size].reshape(n, 3, m) / wall_weight
        begun = np.zeros_like(field)
        if calls > 1:
            begun = smoothed(field)
            field = field - constrained(begun)
        bare = (begun + solver.solve(field, 0.1 * target / (wall_weight * scale))).ravel()
        solution[size:] = np.linalg.solve(schur, vector[size:] / weights - flat_rows @ bare)
        solution[:size] = bare - solution[size:] @ cleaned
        return solution

    start = np.concatenate([wall_weight * right.ravel(), weights * scalar_right])
    found = flexible_gmres(apply, precondition, start, target, MOST_KRYLOV)
    if solver.singular or (lines and lines[0].singular) or not np.all(np.isfinite(found.solution)):
        return None
    change = found.solution[:size].reshape(n, 3, m).copy()
    scalar_change = found.solution[size:].copy()
    density_change = -trial.density.copy()
    if pellet.present:
        project(constraint, change)
        change += prescribed
        for c, field in along.items():
            change += scalar_change[c] * field
        forces = times(change, band) + trial.residual - scalar_change[P] * trial.gradient
        forces[:, 2] -= scalar_change[F] * friction
        density_change = np.where(touching, (normal * forces).sum(axis=1) / h, density_change)
        density_change[[0, -1]] = -trial.density[[0, -1]]
    return (change, density_change, scalar_change), found.iterations
