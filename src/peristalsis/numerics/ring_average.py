"""An operator on the tube, scaled by the roots of its diagonal and averaged over its columns, Eq. (40)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiled import compiled
from .constraint import Constraint, constrain
from .ring_blocks import RingOperator, bending_weight


class Scale(NamedTuple):
    """1/root of a constrained operator's diagonal (n, 3, m), and the stiffness put along held normals (n, m)."""

    inverse: np.ndarray
    stiffness: np.ndarray


class Averages(NamedTuple):
    """Means over the columns: near (n, 9, 3, 3), the stencil; far (n, 2, 3, 3), rows i - 2 and i + 2; around (n, 3, 3).

    around: factor of squared second differences around the ring.
    """

    near: np.ndarray
    far: np.ndarray
    around: np.ndarray


@compiled
def scale_of_nodes(operator: RingOperator, constraint: Constraint, scale: Scale) -> None:
    """The scale of the constrained operator into `scale`."""
    blocks = operator.blocks
    inverse, stiffness = scale.inverse, scale.stiffness
    n = inverse.shape[0]
    m = inverse.shape[2]
    block = np.empty((3, 3))
    inverse[0] = 0.0
    inverse[n - 1] = 0.0
    for i in range(1, n - 1):
        extra = operator.bend_along * bending_weight(i, i, n) + 6.0 * operator.bend_around
        for j in range(m):
            for a in range(3):
                for b in range(3):
                    block[a, b] = blocks[i, 4, a, b, j]
                block[a, a] += extra
            mean = (abs(block[0, 0]) + abs(block[1, 1]) + abs(block[2, 2])) / 3.0
            stiffness[i, j] = mean
            if constraint.held[i, j]:
                constrain(block, constraint, i, j, i, j)
                for a in range(3):
                    block[a, a] += mean * constraint.normal[i, a, j] ** 2
            for a in range(3):
                inverse[i, a, j] = 1.0 / math.sqrt(max(abs(block[a, a]), 1e-6 * mean))


@compiled
def constrained_block(
    operator: RingOperator,
    constraint: Constraint,
    stiffness: np.ndarray,
    node: tuple[int, int],
    q: int,
    extra: float,
    block: np.ndarray,
) -> None:
    """Block q of the stencil of a node (i, j), with `extra` on its diagonal, constrained, into `block` (3, 3).

    On the node's own block of a held node the stiffness (n, m) along its normal is put.
    """
    i, j = node
    m = stiffness.shape[1]
    for a in range(3):
        for b in range(3):
            block[a, b] = operator.blocks[i, q, a, b, j]
        block[a, a] += extra
    constrain(block, constraint, i, j, i + q // 3 - 1, (j + q % 3 - 1 + m) % m)
    if q == 4 and constraint.held[i, j]:
        for a in range(3):
            for b in range(3):
                block[a, b] += stiffness[i, j] * constraint.normal[i, a, j] * constraint.normal[i, b, j]


@compiled
def average_around(operator: RingOperator, constraint: Constraint, scale: Scale, averages: Averages) -> None:
    """Mean over the columns of the scaled, constrained operator into `averages`."""
    inverse, stiffness = scale.inverse, scale.stiffness
    near, far, around = averages.near, averages.far, averages.around
    blocks = operator.blocks
    n = inverse.shape[0]
    m = inverse.shape[2]
    block = np.empty((3, 3))
    near[:, :, :, :] = 0.0
    far[:, :, :, :] = 0.0
    around[:, :, :] = 0.0
    for i in range(1, n - 1):
        for q in range(9):
            r = i + q // 3 - 1
            if r < 1 or r > n - 2:
                continue
            o = q % 3 - 1
            extra = operator.bend_along * bending_weight(i, r, n) if o == 0 else 0.0
            if not (constraint.rows[i] or constraint.rows[r]):
                for a in range(3):
                    for b in range(3):
                        add = extra if a == b else 0.0
                        total = (blocks[i, q, a, b, 0] + add) * inverse[i, a, 0] * inverse[r, b, (o + m) % m]
                        for j in range(1, m - 1):
                            total += (blocks[i, q, a, b, j] + add) * inverse[i, a, j] * inverse[r, b, j + o]
                        total += (
                            (blocks[i, q, a, b, m - 1] + add) * inverse[i, a, m - 1] * inverse[r, b, (m - 1 + o) % m]
                        )
                        near[i, q, a, b] = total / m
                continue
            for j in range(m):
                k = (j + o + m) % m
                constrained_block(operator, constraint, stiffness, (i, j), q, extra, block)
                for a in range(3):
                    for b in range(3):
                        near[i, q, a, b] += block[a, b] * inverse[i, a, j] * inverse[r, b, k] / m
        for side in range(2):
            r = i - 2 if side == 0 else i + 2
            if operator.bend_along == 0.0 or r < 1 or r > n - 2:
                continue
            weight = operator.bend_along * bending_weight(i, r, n)
            for j in range(m):
                block[:, :] = 0.0
                for a in range(3):
                    block[a, a] = weight
                constrain(block, constraint, i, j, r, j)
                for a in range(3):
                    for b in range(3):
                        far[i, side, a, b] += block[a, b] * inverse[i, a, j] * inverse[r, b, j] / m
        for j in range(m):
            for a in range(3):
                around[i, a, a] += operator.bend_around * inverse[i, a, j] ** 2 / m
