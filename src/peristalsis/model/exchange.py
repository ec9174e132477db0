"""What wall and sheets tell one another in a step, compiled: stretch to the sheets, drive to the wall, Eq. (33)."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled, inlined
from ..numerics.transfer import Overlap, average
from ..wall.active import active_tension, unpack_active


@inlined
def _stretch(position: np.ndarray, e: int, j: int, element_size: float) -> float:
    """Longitudinal stretch of an element of a column."""
    dr = position[e + 1, j, 0] - position[e, j, 0]
    dz = position[e + 1, j, 2] - position[e, j, 2]
    return math.sqrt(dr * dr + dz * dz) / element_size


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
            now = _stretch(position, e, j, element_size)
            before = _stretch(position_before, e, j, element_size)
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
def drive_of_layer(
    start: np.ndarray,
    indices: np.ndarray,
    weights: np.ndarray,
    driven: np.ndarray,
    factor: np.ndarray,
    out: np.ndarray,
) -> None:
    """Force factor times drive [mV] of the half elements, (2 * n_z_wall, n_theta), from that of cells, (n_z, n_theta).

    factor: of every cell, flattened.
    """
    n_theta = out.shape[1]
    source = np.empty(driven.shape)
    for cell in range(driven.shape[0]):
        for j in range(n_theta):
            source[cell, j] = factor[cell * n_theta + j] * driven[cell, j]
    average(Overlap(start, indices, weights), source, out)


@compiled
def level_elements(halves: np.ndarray) -> None:
    """Give both halves of every element their mean, (2 * n_z_wall, n_theta), in place, Eq. (87)."""
    for e in range(halves.shape[0] // 2):
        for j in range(halves.shape[1]):
            mean = 0.5 * (halves[2 * e, j] + halves[2 * e + 1, j])
            halves[2 * e, j] = mean
            halves[2 * e + 1, j] = mean


@compiled
def active_force(
    start: np.ndarray,
    indices: np.ndarray,
    weights: np.ndarray,
    position: np.ndarray,
    element_size: float,
    driven: np.ndarray,
    muscle: np.ndarray,
    out: np.ndarray,
) -> None:
    """Drive times the active tension of the longitudinal layer at the conduction cells [mN/cm], (n_z, n_theta).

    muscle: the constants of the active law. This is what the trigger rule `active` reads, before any factor on force.
    """
    stretch = np.empty((position.shape[0] - 1, position.shape[1]))
    for e in range(stretch.shape[0]):
        for j in range(stretch.shape[1]):
            stretch[e, j] = _stretch(position, e, j, element_size)
    average(Overlap(start, indices, weights), stretch, out)
    active_force_at(out, driven, muscle, out)


@compiled
def active_force_at(stretch: np.ndarray, driven: np.ndarray, muscle: np.ndarray, out: np.ndarray) -> None:
    """`active_force` where the stretch at the cells is known; `out` may be `stretch` itself."""
    constants = unpack_active(muscle, 0)
    for t in range(out.shape[0]):
        for j in range(out.shape[1]):
            force, _ = active_tension(stretch[t, j], constants)
            out[t, j] = driven[t, j] * force
