"""The equilibrium on the whole surface made linear: the wall's tangent, and the scalars that border it.

Nodes that touch move across their normal only; what the closed gap prescribes along it is put in beforehand, and the
equilibrium along the normal tells Q afterwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import add_volume_tangent
from ..numerics.constraint import Constraint, project
from ..numerics.ring_blocks import RingOperator, multiply, multiply_transposed
from ..wall.surface import add_edge_tangent
from ..wall.surface_regularisers import add_shear_tangent, bending_along, bending_around
from .surface_problem import F, P, Z
from .surface_residual import Trial

Floats = NDArray[np.float64]


class Tangent(NamedTuple):
    """Tangent of the forces on the nodes, and which of them move across their normal only.

    turn, excess (n, m): where a node moves across the normal, that turns: around the axis by `turn`, along the meridian
    by `excess` more. band: the rows that touching nodes reach. padded (n, 3, m + 2): to work in.
    """

    operator: RingOperator
    constraint: Constraint
    turn: Floats
    excess: Floats
    band: tuple[int, int]
    padded: Floats

    def times(self, field: Floats) -> Floats:
        """The tangent times a field (n, 3, m)."""
        return self._times(field, (0, field.shape[0]))

    def times_band(self, field: Floats) -> Floats:
        """The same for a field that vanishes where nothing touches; only the rows of the band are written."""
        return self._times(field, self.band)

    def times_transposed(self, field: Floats) -> Floats:
        """The transposed tangent times a field."""
        out = np.empty(field.shape)
        multiply_transposed(self.operator, field, self.padded, out)
        return out

    def _times(self, field: Floats, rows: tuple[int, int]) -> Floats:
        out = np.empty_like(field)
        multiply(self.operator, field, rows[0], rows[1], self.padded, out)
        return out


class Borders(NamedTuple):
    """What the scalars add to the tangent, and right-hand sides.

    columns (scalars, n, 3, m): of the scalars in the wall's rows; rows: of the scalars over the wall's unknowns;
    corner: of the scalars among each other. right (n, 3, m), scalar_right: right-hand sides. prescribed: what closes
    the gaps. along: how touching nodes follow the pellet, by the scalar of its place. friction (n, m): force on the
    nodes per F.
    """

    columns: Floats
    rows: Floats
    corner: Floats
    right: Floats
    scalar_right: Floats
    prescribed: Floats
    along: dict[int, Floats]
    friction: Floats


def tangent_of(trial: Trial, blocks: Floats) -> Tangent:
    """The tangent at a trial state; blocks (n, 9, 3, 3, m): to put it in."""
    problem, arc = trial.problem, trial.arc
    wall, pellet, step = problem.wall, problem.pellet, problem.step
    n, _, m = trial.places.shape
    h, normal, touching = wall.element_size, trial.normal, trial.touching
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
    touched = np.flatnonzero(trial.rows)
    band = (max(int(touched[0]) - 2, 0), min(int(touched[-1]) + 3, n)) if touched.size else (0, 0)
    return Tangent(operator, Constraint(touching, trial.rows, normal), turn, excess, band, np.empty((n, 3, m + 2)))


def borders_of(trial: Trial, tangent: Tangent) -> Borders:
    """The borders of the tangent at a trial state."""
    problem, pellet, count = trial.problem, trial.problem.pellet, trial.scalars.size
    n, _, m = trial.places.shape
    slope_p = -problem.lumen.exponent * trial.law / trial.volume * trial.arc
    borders = Borders(
        np.zeros((count, n, 3, m)),
        np.zeros((count, n, 3, m)),
        np.eye(count),
        -trial.residual,
        -trial.scalar_residual,
        np.zeros((n, 3, m)),
        {},
        pellet.frame * problem.friction_weight / trial.arc,
    )
    borders.columns[P] = -trial.gradient
    borders.rows[P] = -slope_p * trial.gradient
    if pellet.present:
        _add_pellet(trial, tangent, borders, slope_p)
        for field in (*borders.columns, *borders.rows, borders.right):
            project(tangent.constraint, field)
    for field in (*borders.columns, *borders.rows, borders.right):
        field[[0, -1]] = 0.0
    return borders


def _add_pellet(trial: Trial, tangent: Tangent, borders: Borders, slope_p: float) -> None:
    """What a pellet adds to the borders; slope_p: derivative of the gas law by the volume, per `arc`."""
    problem, pellet, step, arc = trial.problem, trial.problem.pellet, trial.problem.step, trial.arc
    h, normal, meridian, touching = problem.wall.element_size, trial.normal, trial.contact.meridian, trial.touching
    turn, excess, along = tangent.turn, tangent.excess, borders.along
    columns, rows, corner, scalar_right = borders.columns, borders.rows, borders.corner, borders.scalar_right
    closing = np.where(touching, -trial.gap, 0.0)
    borders.prescribed[...] = closing[:, None, :] * normal
    moved = tangent.times_band(borders.prescribed)
    free = ~touching * h * trial.density
    borders.right[...] -= moved + free[:, None, :] * normal
    columns[F, :, 2] = -borders.friction
    drag = -step.pellet_weight * pellet.frame * step.slope * problem.friction_weight
    rows[Z, :, 2] = drag
    corner[Z, F] = -step.pellet_weight * trial.speed_slope
    scalar_right[P] += slope_p * float((trial.gradient * borders.prescribed).sum())
    scalar_right[Z] -= float((drag * borders.prescribed[:, 2]).sum())
    across, pushed = {}, {}
    for c, axis in trial.axes.items():
        share = np.where(touching, (axis[None] * normal).sum(axis=1), 0.0)
        along[c] = share[:, None, :] * normal
        across[c] = turn[:, None, :] * (axis[None] - along[c])
        across[c] += (excess * (axis[None] * meridian).sum(axis=1))[:, None, :] * meridian
        pushed[c] = tangent.times_band(along[c])
        columns[c] = pushed[c] + across[c]
    for c, axis in trial.axes.items():
        corner[P, c] -= slope_p * float((trial.gradient * along[c]).sum())
        corner[Z, c] += float((drag * along[c][:, 2]).sum())
        # Row of the force along this axis: factor * (change of the sum of h Q n).
        row = F if c == Z else c
        sideways = problem.sideways
        factor = arc if sideways is None or c == Z else arc * sideways.weight / sideways.friction
        share = np.einsum("iaj,aj->ij", normal, axis)
        rows[row] = factor * (tangent.times_transposed(along[c]) + across[c])
        for d, other in trial.axes.items():
            corner[row, d] += factor * float((along[c] * pushed[d]).sum())
            corner[row, d] -= factor * float((across[c] * other[None]).sum())
        corner[row, P] -= factor * float((along[c] * trial.gradient).sum())
        corner[row, F] -= factor * float((along[c][:, 2] * borders.friction).sum())
        known = (along[c] * (moved + trial.residual)).sum() - (free * share).sum()
        scalar_right[row] -= factor * float(known)
