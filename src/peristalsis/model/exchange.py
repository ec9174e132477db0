"""What wall and sheets tell one another in a step, compiled: stretch to the sheets, drive to the wall, Eq. (33)."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled


@compiled
def stretch_ahead(
    position: np.ndarray, position_before: np.ndarray, element_size: float, ahead: float, out: np.ndarray
) -> float:
    """Longitudinal stretch of the elements `ahead` steps on, extrapolated, into `out`; returns the smallest.

    Positions as in `WallState`; out: (n_z_wall, n_theta). Never below half of the stretch now.
    """
    least = math.inf
    for j in range(position.shape[1]):
        for e in range(out.shape[0]):
            dr = position[e + 1, j, 0] - position[e, j, 0]
            dz = position[e + 1, j, 2] - position[e, j, 2]
            now = math.sqrt(dr * dr + dz * dz) / element_size
            dr = position_before[e + 1, j, 0] - position_before[e, j, 0]
            dz = position_before[e + 1, j, 2] - position_before[e, j, 2]
            before = math.sqrt(dr * dr + dz * dz) / element_size
            out[e, j] = max(now + ahead * (now - before), 0.5 * now)
            least = min(least, out[e, j])
    return least


@compiled
def stretches_receptors(position: np.ndarray, contact: np.ndarray, free_radius: np.ndarray, threshold: float) -> bool:
    """Whether a node that touches the pellet is wider than `threshold` times its pellet-free radius [cm], (n,)."""
    found = 0
    for i in range(contact.shape[0]):
        found += 1 if contact[i, 0] > 0.0 and position[i, 0, 0] / free_radius[i] > threshold else 0
    return found > 0


@compiled
def conduction_coefficient(
    start: np.ndarray, indices: np.ndarray, weights: np.ndarray, scale: float, stretch: np.ndarray, out: np.ndarray
) -> None:
    """`scale` over the stretch at the faces of the cells, (n_z - 1, n_theta); weights as in `numerics.transfer`."""
    for t in range(out.shape[0]):
        for j in range(out.shape[1]):
            total = 0.0
            for k in range(start[t], start[t + 1]):
                total += weights[k] * stretch[indices[k], j]
            out[t, j] = scale / total


@compiled
def drive_of_layer(
    start: np.ndarray,
    indices: np.ndarray,
    weights: np.ndarray,
    potential: np.ndarray,
    threshold: float,
    factor: np.ndarray,
    out: np.ndarray,
) -> None:
    """Force factor times phi+ [mV] of the half elements, (2 * n_z_wall, n_theta), from (n_z, n_theta) potentials.

    factor: of every cell, flattened.
    """
    n_theta = out.shape[1]
    source = np.empty(potential.shape)
    for cell in range(potential.shape[0]):
        for j in range(n_theta):
            source[cell, j] = factor[cell * n_theta + j] * max(potential[cell, j] - threshold, 0.0)
    for t in range(out.shape[0]):
        for j in range(n_theta):
            total = 0.0
            for k in range(start[t], start[t + 1]):
                total += weights[k] * source[indices[k], j]
            out[t, j] = total


@compiled
def active_force(
    start: np.ndarray,
    indices: np.ndarray,
    weights: np.ndarray,
    position: np.ndarray,
    element_size: float,
    potential: np.ndarray,
    threshold: float,
    muscle: np.ndarray,
    out: np.ndarray,
) -> None:
    """phi+ times the active tension of the longitudinal layer at the conduction cells [mN/cm], (n_z, n_theta).

    muscle: c7, c8, c9 of Eq. (5). This is what the trigger rule `active` reads, before any factor on the force.
    """
    elements = position.shape[0] - 1
    stretch = np.empty(elements)
    for j in range(out.shape[1]):
        for e in range(elements):
            dr = position[e + 1, j, 0] - position[e, j, 0]
            dz = position[e + 1, j, 2] - position[e, j, 2]
            stretch[e] = math.sqrt(dr * dr + dz * dz) / element_size
        for t in range(out.shape[0]):
            total = 0.0
            for k in range(start[t], start[t + 1]):
                total += weights[k] * stretch[indices[k]]
            force = max((muscle[0] * total + muscle[1]) * total + muscle[2], 0.0)
            out[t, j] = max(potential[t, j] - threshold, 0.0) * force
