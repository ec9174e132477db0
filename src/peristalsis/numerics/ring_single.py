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
from .constraint import Constraint
from .coupled_band import Coupled, solve_coupled
from .ring_average import Scale, scale_of_nodes
from .ring_blocks import RingOperator, pad
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
    held: np.ndarray
    rows: np.ndarray
    normal: np.ndarray
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
def _project(operator: SingleOperator, field: np.ndarray, shift: int) -> None:
    """Take the part along the normal of held nodes out of a field whose column j stands at j + shift."""
    normal = operator.normal
    for i in range(field.shape[0]):
        if not operator.rows[i]:
            continue
        for j in range(operator.held.shape[1]):
            if operator.held[i, j]:
                k = j + shift
                along = (
                    normal[i, 0, j] * field[i, 0, k]
                    + normal[i, 1, j] * field[i, 1, k]
                    + normal[i, 2, j] * field[i, 2, k]
                )
                for a in range(3):
                    field[i, a, k] -= along * normal[i, a, j]


@compiled
def multiply_single(operator: SingleOperator, field: np.ndarray, work: SingleWork, out: np.ndarray) -> None:
    """The constrained operator times `field` (n, 3, m), whose end rows are zero, into `out`."""
    padded, bent = work.padded, work.bent
    blocks, along, around = operator.blocks, operator.bend_along, operator.bend_around
    n = field.shape[0]
    m = field.shape[2]
    two = np.float32(2.0)
    pad(field, padded)
    _project(operator, padded, 1)
    for i in range(n):
        if operator.rows[i]:
            for a in range(3):
                padded[i, a, 0] = padded[i, a, m]
                padded[i, a, m + 1] = padded[i, a, 1]
    out[0] = np.float32(0.0)
    out[n - 1] = np.float32(0.0)
    for i in range(1, n - 1):
        for a in range(3):
            y = out[i, a]
            y[:] = np.float32(0.0)
            for d in range(3):
                x0 = padded[i + d - 1, 0]
                x1 = padded[i + d - 1, 1]
                x2 = padded[i + d - 1, 2]
                l0 = blocks[i, 3 * d, a, 0]
                l1 = blocks[i, 3 * d, a, 1]
                l2 = blocks[i, 3 * d, a, 2]
                c0 = blocks[i, 3 * d + 1, a, 0]
                c1 = blocks[i, 3 * d + 1, a, 1]
                c2 = blocks[i, 3 * d + 1, a, 2]
                r0 = blocks[i, 3 * d + 2, a, 0]
                r1 = blocks[i, 3 * d + 2, a, 1]
                r2 = blocks[i, 3 * d + 2, a, 2]
                for j in range(m):
                    y[j] += (
                        l0[j] * x0[j]
                        + l1[j] * x1[j]
                        + l2[j] * x2[j]
                        + c0[j] * x0[j + 1]
                        + c1[j] * x1[j + 1]
                        + c2[j] * x2[j + 1]
                        + r0[j] * x0[j + 2]
                        + r1[j] * x1[j + 2]
                        + r2[j] * x2[j + 2]
                    )
    for i in range(1, n - 1):
        for a in range(3):
            here = padded[i, a]
            before = padded[i - 1, a]
            after = padded[i + 1, a]
            y = out[i, a]
            if along != np.float32(0.0):
                lower = out[i - 1, a]
                upper = out[i + 1, a]
                for j in range(m):
                    bent[j] = along * (before[j + 1] - two * here[j + 1] + after[j + 1])
                    y[j] -= two * bent[j]
                if i > 1:
                    for j in range(m):
                        lower[j] += bent[j]
                if i < n - 2:
                    for j in range(m):
                        upper[j] += bent[j]
            if around != np.float32(0.0):
                for j in range(m):
                    bent[j + 1] = around * (here[j] - two * here[j + 1] + here[j + 2])
                bent[0] = bent[m]
                bent[m + 1] = bent[1]
                for j in range(m):
                    y[j] += bent[j] - two * bent[j + 1] + bent[j + 2]
        if operator.tether != np.float32(0.0):
            _add_tether(operator, padded[i], out[i])
    _project(operator, out, 0)
    _add_normal(operator, field, out)


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
def _add_normal(operator: SingleOperator, field: np.ndarray, out: np.ndarray) -> None:
    """The stiffness along the normal of held nodes."""
    normal = operator.normal
    for i in range(field.shape[0]):
        if not operator.rows[i]:
            continue
        for j in range(field.shape[2]):
            if operator.held[i, j]:
                along = operator.stiffness[i, j] * (
                    normal[i, 0, j] * field[i, 0, j]
                    + normal[i, 1, j] * field[i, 1, j]
                    + normal[i, 2, j] * field[i, 2, j]
                )
                for a in range(3):
                    out[i, a, j] += along * normal[i, a, j]


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
                constraint.held,
                constraint.rows,
                constraint.normal.astype(np.float32),
                self._scale.stiffness.astype(np.float32),
                self._turn,
            ),
            self._columns,
            CoupledPart(self._coupled.factors, self._coupled.fields, inverse),
            self._work,
        )
