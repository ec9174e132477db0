"""Forces and tangent of the wall on the whole surface where the tension before the floor is an unknown, Eq. (90).

At each corner of a patch the tensions y along and around, before the floor of Eq. (15), stand beside the places; the
law that ties them to the stretches, y = x(stretches), is made linear together with the equilibrium and condensed out.
Corners are 4e + 2*(end of the edge along z) + (0 for the edge around j - 1, 1 for j), as in `surface.Edges`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.blend import floored, fold_resistance
from ..numerics.compiled import compiled, inlined
from .constants import WallConstants
from .membrane import before_floor
from .passive import admissible
from .surface import Edges, chord, wrap


class Corners(NamedTuple):
    """Tensions before the floor at all corners [mN/cm], along z and around the ring.

    carried (2, 4(n - 1), m): the unknowns y. law: x, what the law makes of the stretches. slopes (4, ...): of x along
    by the stretches along and around, of x around by both.
    """

    carried: np.ndarray
    law: np.ndarray
    slopes: np.ndarray


class MixedForces(NamedTuple):
    """Forces of the edges along z (n - 1, m + 2) and around (n, m + 2) [mN/cm]: two sets of them.

    missing: what the equilibrium made linear has beside the true forces. carried: those of the unknown tensions, which
    turn with their edges.
    """

    axial_missing: np.ndarray
    hoop_missing: np.ndarray
    axial_carried: np.ndarray
    hoop_carried: np.ndarray


def new_corners(rows: int, columns: int) -> Corners:
    """Room for the corners of so many rows and columns of nodes."""
    shape = (4 * (rows - 1), columns)
    return Corners(np.zeros((2, *shape)), np.zeros((2, *shape)), np.zeros((4, *shape)))


def new_mixed_forces(rows: int, columns: int) -> MixedForces:
    """Room for the forces of so many rows and columns of nodes."""
    along, around = (rows - 1, columns + 2), (rows, columns + 2)
    return MixedForces(np.zeros(along), np.zeros(around), np.zeros(along), np.zeros(around))


@inlined
def _law(
    stretch: float,
    hoop: float,
    rate: float,
    hoop_rate: float,
    rate_slope: float,
    drive_longitudinal: float,
    drive_circular: float,
    c: WallConstants,
) -> tuple[float, float, float, float, float, float]:
    """Tensions before the floor, along and around, and their slopes by the stretches."""
    pl, al, vl, pc, ac, vc, sll, scc, wlc, dpl, dpc = before_floor(
        stretch, hoop, rate, hoop_rate, rate_slope, drive_longitudinal, drive_circular, c
    )
    return vl + al + pl, vc + ac + pc, sll, dpl * wlc, dpc * wlc, scc


@compiled
def tensions_of_state(
    stretch: np.ndarray,
    hoop: np.ndarray,
    stretch_rate: np.ndarray,
    hoop_rate: np.ndarray,
    drive: np.ndarray,
    c: WallConstants,
    carried: np.ndarray,
) -> None:
    """Tensions before the floor of a state as it is kept into `carried` (2, 4(n - 1), m).

    Of the edges along z (n - 1, m) and around (n, m), [i, j] being the edge from column j to j + 1; drive: (2, 2n - 2,
    m) [mV].
    """
    m = stretch.shape[1]
    for e in range(stretch.shape[0]):
        for end in range(2):
            i = e + end
            for side in range(2):
                q = 4 * e + 2 * end + side
                for j in range(m):
                    k = j - 1 + side
                    if k < 0:
                        k = m - 1
                    xl, xc, _, _, _, _ = _law(
                        stretch[e, j],
                        hoop[i, k],
                        stretch_rate[e, j],
                        hoop_rate[i, k],
                        0.0,
                        drive[0, 2 * e + end, j],
                        drive[1, 2 * e + end, j],
                        c,
                    )
                    carried[0, q, j] = xl
                    carried[1, q, j] = xc


@compiled
def load_mixed_edges(
    edges: Edges,
    stretch_history: np.ndarray,
    hoop_history: np.ndarray,
    rate_slope: float,
    drive: np.ndarray,
    c: WallConstants,
    corners: Corners,
    forces: MixedForces,
) -> bool:
    """True forces of all edges, slopes of the equilibrium made linear and its forces; False outside the law.

    Arguments as in `surface.load_edges`; of `corners` the unknowns are read, the rest is written.
    """
    elements = edges.stretch.shape[0]
    m = edges.stretch.shape[1] - 2
    h = c.element_size
    width = chord(c, m)
    weight = 0.25 * h
    turned = 1.0 if c.published else 0.0
    y, x, dx = corners
    for field in (edges.axial_force, edges.axial_slope, forces.axial_missing, forces.axial_carried):
        field[:, :] = 0.0
    for field in (edges.hoop_force, edges.hoop_slope, forces.hoop_missing, forces.hoop_carried):
        field[:, :] = 0.0
    for e in range(elements):
        for end in range(2):
            i = e + end
            for side in range(2):
                q = 4 * e + 2 * end + side
                for j in range(m):
                    k = j + side
                    stretch = edges.stretch[e, j + 1]
                    hoop = edges.hoop[i, k]
                    if not admissible(stretch, hoop, c.passive):
                        return False
                    xl, xc, xll, xlc, xcl, xcc = _law(
                        stretch,
                        hoop,
                        (stretch - stretch_history[e, j]) * rate_slope,
                        (hoop - hoop_history[i, k - 1]) * rate_slope,
                        rate_slope,
                        drive[0, 2 * e + end, j],
                        drive[1, 2 * e + end, j],
                        c,
                    )
                    x[0, q, j] = xl
                    x[1, q, j] = xc
                    dx[0, q, j] = xll
                    dx[1, q, j] = xlc
                    dx[2, q, j] = xcl
                    dx[3, q, j] = xcc
                    fold_l, dfold_l = fold_resistance(stretch, c.fold_stretch, c.fold_tension)
                    fold_c, dfold_c = fold_resistance(hoop, c.fold_stretch, c.fold_tension)
                    across_l = hoop if c.published else 1.0
                    across_c = stretch if c.published else 1.0
                    true_l, _ = floored(xl, c.slack_blend, c.slack_slope)
                    true_c, _ = floored(xc, c.slack_blend, c.slack_slope)
                    tl, dl = floored(y[0, q, j], c.slack_blend, c.slack_slope)
                    tc, dc = floored(y[1, q, j], c.slack_blend, c.slack_slope)
                    edges.axial_force[e, j + 1] += (true_l + fold_l) * across_l
                    edges.hoop_force[i, k] += (true_c + fold_c) * across_c
                    forces.axial_missing[e, j + 1] += (tl + dl * (xl - y[0, q, j]) - true_l) * across_l
                    forces.hoop_missing[i, k] += (tc + dc * (xc - y[1, q, j]) - true_c) * across_c
                    forces.axial_carried[e, j + 1] += (tl + fold_l) * across_l
                    forces.hoop_carried[i, k] += (tc + fold_c) * across_c
                    edges.axial_slope[e, j + 1] += (dl * xll + dfold_l) * across_l
                    edges.hoop_slope[i, k] += (dc * xcc + dfold_c) * across_c
                    edges.lc[q, j + 1] = weight * (dl * xlc * across_l + turned * (tl + fold_l)) / (h * width)
                    edges.cl[q, j + 1] = weight * (dc * xcl * across_c + turned * (tc + fold_c)) / (h * width)
    for e in range(elements):
        _scale(edges.axial_force, e, weight / h)
        _scale(forces.axial_missing, e, weight / h)
        _scale(forces.axial_carried, e, weight / h)
        _scale(edges.axial_slope, e, weight / (h * h))
        for corner in range(4):
            wrap(edges.lc, 4 * e + corner)
            wrap(edges.cl, 4 * e + corner)
    for i in range(elements + 1):
        # The loop above has put the share of the edge m - 1 -> 0 seen from column 0 at its left copy.
        for field in (edges.hoop_force, forces.hoop_missing, forces.hoop_carried, edges.hoop_slope):
            field[i, m] += field[i, 0]
        _scale(edges.hoop_force, i, weight / width)
        _scale(forces.hoop_missing, i, weight / width)
        _scale(forces.hoop_carried, i, weight / width)
        _scale(edges.hoop_slope, i, weight / (width * width))
    return True


@compiled
def _scale(field: np.ndarray, row: int, factor: float) -> None:
    for j in range(1, field.shape[1] - 1):
        field[row, j] *= factor
    wrap(field, row)


@compiled
def carry_tensions(edges: Edges, change: np.ndarray, c: WallConstants, corners: Corners) -> None:
    """The unknown tensions after a change of places (padded, n, 3, m + 2): those of the law made linear."""
    n = change.shape[0]
    m = change.shape[2] - 2
    width = chord(c, m)
    along = np.empty((n - 1, m + 2))
    around = np.empty((n, m + 2))
    for e in range(n - 1):
        for j in range(m + 2):
            total = 0.0
            for a in range(3):
                total += edges.axial[e, a, j] * (change[e + 1, a, j] - change[e, a, j])
            along[e, j] = total / c.element_size
    for i in range(n):
        for j in range(1, m + 1):
            total = 0.0
            for a in range(3):
                total += edges.upper[i, a, j] * change[i, a, j + 1] - edges.lower[i, a, j] * change[i, a, j]
            around[i, j] = total / width
        wrap(around, i)
    y, x, dx = corners
    for e in range(n - 1):
        for end in range(2):
            for side in range(2):
                q = 4 * e + 2 * end + side
                for j in range(m):
                    l = along[e, j + 1]
                    r = around[e + end, j + side]
                    y[0, q, j] = x[0, q, j] + dx[0, q, j] * l + dx[1, q, j] * r
                    y[1, q, j] = x[1, q, j] + dx[2, q, j] * l + dx[3, q, j] * r
