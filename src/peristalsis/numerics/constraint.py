"""Nodes on a surface that may move only across their normal: projections of fields and of blocks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .compiled import compiled


class Constraint(NamedTuple):
    """Nodes (n, m) that may move only across their unit `normal` (n, 3, m): `held` tells which, `rows` where any is."""

    held: np.ndarray
    rows: np.ndarray
    normal: np.ndarray


@compiled
def project(constraint: Constraint, field: np.ndarray) -> None:
    """Take the part along the normal out of `field` (n, 3, m) where nodes are held, in place."""
    held = constraint.held
    normal = constraint.normal
    for i in range(field.shape[0]):
        if not constraint.rows[i]:
            continue
        for j in range(field.shape[2]):
            if held[i, j]:
                along = (
                    normal[i, 0, j] * field[i, 0, j]
                    + normal[i, 1, j] * field[i, 1, j]
                    + normal[i, 2, j] * field[i, 2, j]
                )
                for a in range(3):
                    field[i, a, j] -= along * normal[i, a, j]


@compiled
def add_normal(constraint: Constraint, stiffness: np.ndarray, field: np.ndarray, out: np.ndarray) -> None:
    """Add stiffness (n, m) times the part of `field` along the normal of held nodes to `out`."""
    held = constraint.held
    normal = constraint.normal
    for i in range(field.shape[0]):
        if not constraint.rows[i]:
            continue
        for j in range(field.shape[2]):
            if held[i, j]:
                along = stiffness[i, j] * (
                    normal[i, 0, j] * field[i, 0, j]
                    + normal[i, 1, j] * field[i, 1, j]
                    + normal[i, 2, j] * field[i, 2, j]
                )
                for a in range(3):
                    out[i, a, j] += along * normal[i, a, j]


@compiled
def constrain(block: np.ndarray, constraint: Constraint, i: int, j: int, r: int, k: int) -> None:
    """Project a 3x3 block on the left by the normal of node (i, j), on the right by that of (r, k), where held."""
    normal = constraint.normal
    if constraint.held[i, j]:
        for b in range(3):
            along = normal[i, 0, j] * block[0, b] + normal[i, 1, j] * block[1, b] + normal[i, 2, j] * block[2, b]
            for a in range(3):
                block[a, b] -= along * normal[i, a, j]
    if constraint.held[r, k]:
        for a in range(3):
            along = normal[r, 0, k] * block[a, 0] + normal[r, 1, k] * block[a, 1] + normal[r, 2, k] * block[a, 2]
            for b in range(3):
                block[a, b] -= along * normal[r, b, k]
