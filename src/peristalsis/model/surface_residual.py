"""Residuals of the equilibrium on the whole surface at a trial state; those of one column are in `residual`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import column_angles, surface_volume, volume_gradient
from ..numerics.ring_blocks import pad
from ..numerics.ring_single import SingleSolver
from ..pellet.friction import held_by_ends, sliding_velocity
from ..pellet.surface_contact import force_on_pellet, measure_contact, no_contact
from ..wall.surface import Edges, add_edge_forces, load_edges, measure_edges, new_edges
from ..wall.surface_regularisers import add_regulariser_forces
from .surface_problem import F, P, SurfaceProblem, X, Y, Z
from .verdicts import GAP_SCALE, TENSION_SCALE

Floats = NDArray[np.float64]


class Trial:
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
        self._solver: SingleSolver | None = None
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
        if not self._load():
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

    def single_solver(self) -> SingleSolver:
        """What solves the linear systems of this solve in single precision; the same for all of them."""
        if self._solver is None:
            n, _, m = self.places.shape
            self._solver = SingleSolver(n, m, self.problem.modes)
        return self._solver

    def _load(self) -> bool:
        """Forces of the edges from the tensions at their corners; False where the law is not admissible."""
        p = self.problem
        return load_edges(self.edges, p.stretch_history, p.hoop_history, p.step.slope, p.drive, p.wall)

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
