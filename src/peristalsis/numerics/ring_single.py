"""A preconditioner for systems on a tube in single precision: columns, coupled low modes, columns again, Eq. (94).

Single precision halves what is read from memory, which bounds these loops; the systems themselves, and the residuals
by which their solutions are accepted, are in double precision.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .column_solver import Columns, ColumnSolver, take
from .compiled import compiled
from .constraint import Constraint, add_normal, project
from .coupled_band import Coupled, solve_coupled
from .ring_average import Scale, scale_of_nodes
from .ring_blocks import RingOperator, add_bending_of_row, add_stencil, pad
from .ring_coupled import CoupledModes

Singles = NDArray[np.float32]


class SingleOperator(NamedTuple):
    """A `RingOperator` and a `Constraint` in single precision, with the stiffness along held normals (n, m).

    turn (2, m): cosine and sine of the columns' angles.
    """

    blocks: np.ndarray
    bend_along: np.float32
    bend_around: np.float32
    tether: np.float32
    constraint: Constraint
    stiffness: np.ndarray
    turn: np.ndarray


class SingleWork(NamedTuple):
    """To work in: padded (n, 3, m + 2), bent (m + 2,), image and change (n, 3, m), hold (3, m), modes (n, b), block."""

    padded: np.ndarray
    bent: np.ndarray
    image: np.ndarray
    change: np.ndarray
    hold: np.ndarray
    modes: np.ndarray
    block: np.ndarray


class CoupledPart(NamedTuple):
    """The space of coupled modes: factors, fields around the ring (m, modes) and scale of the nodes (n, 3, m)."""

    factors: Coupled
    fields: np.ndarray
    inverse: np.ndarray


@compiled
def multiply_single(operator: SingleOperator, field: np.ndarray, work: SingleWork, out: np.ndarray) -> None:
    """The constrained operator times `field` (n, 3, m), whose end rows are zero, into `out`."""
    padded = work.padded
    n = field.shape[0]
    m = field.shape[2]
    rows = operator.constraint.rows
    pad(field, padded)
    project(operator.constraint, padded[:, :, 1 : m + 1])
    for i in range(n):
        if rows[i]:
            for a in range(3):
                padded[i, a, 0] = padded[i, a, m]
                padded[i, a, m + 1] = padded[i, a, 1]
    out[:, :, :] = np.float32(0.0)
    for i in range(1, n - 1):
        for a in range(3):
            add_stencil(operator.blocks, padded, i, a, out[i, a])
    for i in range(1, n - 1):
        add_bending_of_row(padded, i, operator.bend_along, operator.bend_around, work.bent, out)
        if operator.tether != np.float32(0.0):
            _add_tether(operator, padded[i], out[i])
    project(operator.constraint, out)
    add_normal(operator.constraint, operator.stiffness, field, out)


@compiled
def _add_tether(operator: SingleOperator, padded: np.ndarray, out: np.ndarray) -> None:
    """What a ring's mean displacement across the axis adds to its row of `out`."""
    m = out.shape[1]
    c = operator.turn[0]
    s = operator.turn[1]
    along = np.float32(0.0)
    across = np.float32(0.0)
    for j in range(m):
        along += c[j] * padded[0, j + 1] - s[j] * padded[1, j + 1]
        across += s[j] * padded[0, j + 1] + c[j] * padded[1, j + 1]
    along *= operator.tether / np.float32(m)
    across *= operator.tether / np.float32(m)
    for j in range(m):
        out[0, j] += c[j] * along + s[j] * across
        out[1, j] += c[j] * across - s[j] * along


@compiled
def add_coupled(modes: CoupledPart, right: np.ndarray, work: SingleWork, out: np.ndarray) -> None:
    """Add to `out` the solution for `right` (n, 3, m) in the space of coupled modes."""
    factors, fields, inverse = modes
    n = right.shape[0]
    m = right.shape[2]
    count = fields.shape[1]
    vectors = work.modes
    for i in range(1, n - 1):
        for a in range(3):
            y = vectors[i, a * count : (a + 1) * count]
            y[:] = np.float32(0.0)
            r = right[i, a]
            scale = inverse[i, a]
            for j in range(m):
                x = r[j] * scale[j]
                row = fields[j]
                for k in range(count):
                    y[k] += x * row[k]
    solve_coupled(factors, vectors, work.block)
    for i in range(1, n - 1):
        for a in range(3):
            x = vectors[i, a * count : (a + 1) * count]
            scale = inverse[i, a]
            y = out[i, a]
            for j in range(m):
                row = fields[j]
                total = np.float32(0.0)
                for k in range(count):
                    total += x[k] * row[k]
                y[j] += total * scale[j]


@compiled
def improve_half(
    columns: Columns, wide: bool, odd: bool, right: np.ndarray, image: np.ndarray, work: SingleWork, out: np.ndarray
) -> None:
    """Add to the odd or the even columns of `out` the solution for what is left, right - image; wide: as there.

    `column_solver.solve_columns` in one pass over the vectors: at this size reading them is what it costs.
    """
    diagonal, lower, upper, lower2, upper2 = columns
    n = right.shape[0]
    m = right.shape[2]
    evens = (m + 1) // 2
    first = evens if odd else 0
    last = m if odd else evens
    shift = 1 if odd else 0
    change = work.change
    hold = work.hold
    for i in range(1, n - 1):
        for a in range(3):
            w = change[i, a]
            r = right[i, a]
            s = image[i, a]
            for k in range(last - first):
                w[first + k] = r[2 * k + shift] - s[2 * k + shift]
        if i > 1:
            take(lower[i], change[i - 1], first, last, change[i])
        if wide and i > 2:
            take(lower2[i], change[i - 2], first, last, change[i])
    for i in range(n - 2, 0, -1):
        if i < n - 2:
            take(upper[i], change[i + 1], first, last, change[i])
        if wide and i < n - 3:
            take(upper2[i], change[i + 2], first, last, change[i])
        hold[:, :] = np.float32(0.0)
        take(diagonal[i], change[i], first, last, hold)
        for a in range(3):
            w = change[i, a]
            y = out[i, a]
            h = hold[a]
            for k in range(last - first):
                w[first + k] = -h[first + k]
                y[2 * k + shift] -= h[first + k]


@compiled
def precondition_single(
    operator: SingleOperator, columns: Columns, modes: CoupledPart, right: np.ndarray, work: SingleWork, out: np.ndarray
) -> None:
    """An approximate solution for `right` (n, 3, m) into `out`: even columns, odd ones, modes, odd, even."""
    wide = operator.bend_along != np.float32(0.0)
    image = work.image
    out[:, :, :] = np.float32(0.0)
    image[:, :, :] = np.float32(0.0)
    improve_half(columns, wide, False, right, image, work, out)
    multiply_single(operator, out, work, image)
    improve_half(columns, wide, True, right, image, work, out)
    multiply_single(operator, out, work, image)
    for i in range(right.shape[0]):
        for a in range(3):
            x = right[i, a]
            y = image[i, a]
            for j in range(y.size):
                y[j] = x[j] - y[j]
    add_coupled(modes, image, work, out)
    multiply_single(operator, out, work, image)
    improve_half(columns, wide, True, right, image, work, out)
    multiply_single(operator, out, work, image)
    improve_half(columns, wide, False, right, image, work, out)


class SingleFactors(NamedTuple):
    """An operator with its preconditioner."""

    operator: SingleOperator
    columns: Columns
    modes: CoupledPart
    work: SingleWork

    def times(self, field: Singles) -> Singles:
        """The constrained operator times a field (n, 3, m)."""
        out = np.empty_like(field)
        multiply_single(self.operator, field, self.work, out)
        return out

    def precondition(self, right: Singles) -> Singles:
        """An approximate solution for a right-hand side (n, 3, m)."""
        out = np.empty_like(right)
        precondition_single(self.operator, self.columns, self.modes, right, self.work, out)
        return out

    def in_modes(self, right: Singles) -> Singles:
        """The solution in the space of coupled modes alone."""
        out = np.zeros_like(right)
        add_coupled(self.modes, right, self.work, out)
        return out


class SingleSolver:
    """Preconditioners of operators of one shape (n rows, m columns), made one after the other in the same arrays.

    modes: coupled are as many as asked for, and no more than columns carry.
    """

    def __init__(self, n: int, m: int, modes: int) -> None:
        self._scale = Scale(np.zeros((n, 3, m)), np.zeros((n, m)))
        self._coupled = CoupledModes(n, m, min(modes, (m - 1) // 2))
        self._columns = Columns(*(np.zeros((n, 3, 3, m), np.float32) for _ in range(5)))
        self._blocks = np.zeros((n, 9, 3, 3, m), np.float32)
        angles = 2.0 * math.pi * np.arange(m) / m
        self._turn = np.stack([np.cos(angles), np.sin(angles)]).astype(np.float32)
        shape, size = (n, 3, m), 3 * self._coupled.fields.shape[1]
        self._work = SingleWork(
            np.zeros((n, 3, m + 2), np.float32),
            np.zeros(m + 2, np.float32),
            np.zeros(shape, np.float32),
            np.zeros(shape, np.float32),
            np.zeros((3, m), np.float32),
            np.zeros((n, size), np.float32),
            np.zeros(size, np.float32),
        )

    def factor(self, operator: RingOperator, constraint: Constraint) -> SingleFactors | None:
        """The factors of an operator, which hold until the next ones are made; None where a part is singular."""
        scale_of_nodes(operator, constraint, self._scale)
        lines = ColumnSolver(operator, constraint, self._scale.stiffness)
        if lines.singular or not self._coupled.factor(operator, constraint, self._scale):
            return None
        for part, source in zip(self._columns, lines.columns, strict=True):
            part[...] = source
        self._blocks[...] = operator.blocks
        inverse = self._scale.inverse.astype(np.float32)
        return SingleFactors(
            SingleOperator(
                self._blocks,
                np.float32(operator.bend_along),
                np.float32(operator.bend_around),
                np.float32(operator.tether),
                constraint._replace(normal=constraint.normal.astype(np.float32)),
                self._scale.stiffness.astype(np.float32),
                self._turn,
            ),
            self._columns,
            CoupledPart(self._coupled.factors, self._coupled.fields, inverse),
            self._work,
        )
