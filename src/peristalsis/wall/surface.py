"""Internal forces of the wall on the whole surface and their tangent, Eq. (1) with (2)-(5), (14), (15), (35), (36).

Bilinear patches with corner quadrature along edges, Eq. (41): the longitudinal stretch belongs to the edges along z,
the circumferential one to those around the ring, and each corner of a patch joins one of either kind. Nodes are padded
fields in the frames of their columns (`numerics.ring_blocks`). The edge around the ring from column j to j + 1 has
the index j; in padded arrays column or edge j stands at j + 1. Forces are per arc 2 pi r0/m between columns, [mN/cm],
so that on a ring-uniform wall every number is that of `wall.membrane`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .constants import WallConstants
from .membrane import LARGEST_STRETCH, SMALLEST_STRETCH, nominal_tensions
from .passive import admissible, strain_energy


class Edges(NamedTuple):
    """Everything known of the edges of n rows and m columns, padded around the ring.

    Along z (n - 1, ..., m + 2): stretch, length [cm], unit vector in the column's frame; axial force [mN/cm] with its
    slope by the length [mN/cm^2]. Around (n, ..., m + 2): hoop (the stretch), its length, the unit vector in the frames
    of its lower and upper column, force and slope. lc, cl: slopes of the axial force by the hoop's length and the
    reverse at the four corners 4e + 2*(end of the edge along z) + (0 for the edge j - 1, 1 for j), (4(n - 1), m + 2).
    """

    stretch: np.ndarray
    axial_length: np.ndarray
    axial: np.ndarray
    axial_force: np.ndarray
    axial_slope: np.ndarray
    hoop: np.ndarray
    hoop_length: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    hoop_force: np.ndarray
    hoop_slope: np.ndarray
    lc: np.ndarray
    cl: np.ndarray


def new_edges(rows: int, columns: int) -> Edges:
    """Room for the edges of so many rows and columns of nodes."""
    along, around = (rows - 1, columns + 2), (rows, columns + 2)
    return Edges(
        np.zeros(along),
        np.zeros(along),
        np.zeros((rows - 1, 3, columns + 2)),
        np.zeros(along),
        np.zeros(along),
        np.zeros(around),
        np.zeros(around),
        np.zeros((rows, 3, columns + 2)),
        np.zeros((rows, 3, columns + 2)),
        np.zeros(around),
        np.zeros(around),
        np.zeros((4 * (rows - 1), columns + 2)),
        np.zeros((4 * (rows - 1), columns + 2)),
    )


@compiled
def chord(c: WallConstants, columns: int) -> float:
    """Undeformed distance between neighbouring columns [cm]: with it a circular ring has lambda_c = rho/r0 exactly."""
    return 2.0 * c.radius * math.sin(math.pi / columns)


@compiled
def measure_edges(padded: np.ndarray, c: WallConstants, edges: Edges) -> bool:
    """Lengths, unit vectors and stretches of all edges; False when a stretch leaves the allowed range."""
    n = padded.shape[0]
    m = padded.shape[2] - 2
    inverse = 1.0 / c.element_size
    for e in range(n - 1):
        for j in range(m + 2):
            dx = padded[e + 1, 0, j] - padded[e, 0, j]
            dy = padded[e + 1, 1, j] - padded[e, 1, j]
            dz = padded[e + 1, 2, j] - padded[e, 2, j]
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            stretch = length * inverse
            if not (SMALLEST_STRETCH < stretch < LARGEST_STRETCH):
                return False
            edges.axial_length[e, j] = length
            edges.stretch[e, j] = stretch
            edges.axial[e, 0, j] = dx / length
            edges.axial[e, 1, j] = dy / length
            edges.axial[e, 2, j] = dz / length
    ca = math.cos(math.pi / m)
    sa = math.sin(math.pi / m)
    inverse = 1.0 / chord(c, m)
    for i in range(n):
        for j in range(1, m + 1):
            # In the frame half-way between the two columns; exactly along y on a circular ring.
            dx = ca * (padded[i, 0, j + 1] - padded[i, 0, j]) - sa * (padded[i, 1, j + 1] + padded[i, 1, j])
            dy = sa * (padded[i, 0, j + 1] + padded[i, 0, j]) + ca * (padded[i, 1, j + 1] - padded[i, 1, j])
            dz = padded[i, 2, j + 1] - padded[i, 2, j]
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            stretch = length * inverse
            if not (SMALLEST_STRETCH < stretch < LARGEST_STRETCH):
                return False
            dx /= length
            dy /= length
            dz /= length
            edges.hoop_length[i, j] = length
            edges.hoop[i, j] = stretch
            edges.lower[i, 0, j] = ca * dx - sa * dy
            edges.lower[i, 1, j] = sa * dx + ca * dy
            edges.lower[i, 2, j] = dz
            edges.upper[i, 0, j] = ca * dx + sa * dy
            edges.upper[i, 1, j] = ca * dy - sa * dx
            edges.upper[i, 2, j] = dz
        wrap(edges.hoop_length, i)
        wrap(edges.hoop, i)
        for a in range(3):
            edges.lower[i, a, 0] = edges.lower[i, a, m]
            edges.lower[i, a, m + 1] = edges.lower[i, a, 1]
            edges.upper[i, a, 0] = edges.upper[i, a, m]
            edges.upper[i, a, m + 1] = edges.upper[i, a, 1]
    return True


@compiled
def wrap(field: np.ndarray, row: int) -> None:
    """Put the first and last inner entries of a padded row where they are repeated."""
    m = field.shape[1] - 2
    field[row, 0] = field[row, m]
    field[row, m + 1] = field[row, 1]


@compiled
def load_edges(
    edges: Edges,
    stretch_history: np.ndarray,
    hoop_history: np.ndarray,
    rate_slope: float,
    drive: np.ndarray,
    c: WallConstants,
) -> bool:
    """Forces of all edges and their slopes from the tensions at the corners; False where the law is not admissible.

    Histories from which rates are formed, Eq. (32): of the edges along z (n - 1, m) and around (n, m), [i, j] being
    the edge from column j to j + 1. drive: (2, 2n - 2, m) [mV], longitudinal and circular, of half elements.
    """
    elements = edges.stretch.shape[0]
    m = edges.stretch.shape[1] - 2
    h = c.element_size
    width = chord(c, m)
    weight = 0.25 * h
    edges.axial_force[:, :] = 0.0
    edges.axial_slope[:, :] = 0.0
    edges.hoop_force[:, :] = 0.0
    edges.hoop_slope[:, :] = 0.0
    for e in range(elements):
        for end in range(2):
            i = e + end
            for j in range(m):
                stretch = edges.stretch[e, j + 1]
                rate = (stretch - stretch_history[e, j]) * rate_slope
                for side in range(2):
                    k = j + side
                    hoop = edges.hoop[i, k]
                    if not admissible(stretch, hoop, c.passive):
                        return False
                    # The edge around at k in the padded row is that from column k - 1 to k.
                    nl, nc, nll, nlc, ncl, ncc = nominal_tensions(
                        stretch,
                        hoop,
                        rate,
                        (hoop - hoop_history[i, k - 1]) * rate_slope,
                        rate_slope,
                        drive[0, 2 * e + end, j],
                        drive[1, 2 * e + end, j],
                        c,
                    )
                    edges.axial_force[e, j + 1] += nl
                    edges.axial_slope[e, j + 1] += nll
                    edges.hoop_force[i, k] += nc
                    edges.hoop_slope[i, k] += ncc
                    edges.lc[4 * e + 2 * end + side, j + 1] = weight * nlc / (h * width)
                    edges.cl[4 * e + 2 * end + side, j + 1] = weight * ncl / (h * width)
    for e in range(elements):
        for j in range(1, m + 1):
            edges.axial_force[e, j] *= weight / h
            edges.axial_slope[e, j] *= weight / (h * h)
        wrap(edges.axial_force, e)
        wrap(edges.axial_slope, e)
        for corner in range(4):
            wrap(edges.lc, 4 * e + corner)
            wrap(edges.cl, 4 * e + corner)
    for i in range(elements + 1):
        # The loop above has put the share of the edge m - 1 -> 0 seen from column 0 at its left copy.
        edges.hoop_force[i, m] += edges.hoop_force[i, 0]
        edges.hoop_slope[i, m] += edges.hoop_slope[i, 0]
        for j in range(1, m + 1):
            edges.hoop_force[i, j] *= weight / width
            edges.hoop_slope[i, j] *= weight / (width * width)
        wrap(edges.hoop_force, i)
        wrap(edges.hoop_slope, i)
    return True


@compiled
def add_edge_forces(edges: Edges, residual: np.ndarray) -> None:
    """Add the forces of all edges on their nodes to `residual` (n, 3, m) [mN/cm]."""
    n = residual.shape[0]
    m = residual.shape[2]
    for i in range(n):
        around = edges.hoop_force[i]
        for a in range(3):
            y = residual[i, a]
            upper = edges.upper[i, a]
            lower = edges.lower[i, a]
            for j in range(m):
                y[j] += around[j] * upper[j] - around[j + 1] * lower[j + 1]
            if i > 0:
                force = edges.axial_force[i - 1]
                t = edges.axial[i - 1, a]
                for j in range(m):
                    y[j] += force[j + 1] * t[j + 1]
            if i < n - 1:
                force = edges.axial_force[i]
                t = edges.axial[i, a]
                for j in range(m):
                    y[j] -= force[j + 1] * t[j + 1]


@compiled
def add_edge_tangent(edges: Edges, blocks: np.ndarray) -> None:
    """Add the derivative of `add_edge_forces` by the nodes to the stencil blocks (n, 9, 3, 3, m)."""
    n = blocks.shape[0]
    m = blocks.shape[4]
    stiff = np.empty(m + 2)
    geometric = np.empty(m + 2)
    for i in range(n):
        for j in range(m + 2):
            geometric[j] = edges.hoop_force[i, j] / edges.hoop_length[i, j]
            stiff[j] = edges.hoop_slope[i, j] - geometric[j]
        _add_turned(geometric, blocks[i, 3], blocks[i, 4], blocks[i, 5])
        for a in range(3):
            la = edges.lower[i, a]
            ua = edges.upper[i, a]
            for b in range(3):
                lb = edges.lower[i, b]
                ub = edges.upper[i, b]
                before = blocks[i, 3, a, b]
                own = blocks[i, 4, a, b]
                after = blocks[i, 5, a, b]
                for j in range(m):
                    # Column j is the lower end of the padded edge j + 1 and the upper end of the edge j.
                    right = stiff[j + 1] * la[j + 1]
                    left = stiff[j] * ua[j]
                    own[j] += right * lb[j + 1] + left * ub[j]
                    after[j] -= right * ub[j + 1]
                    before[j] -= left * lb[j]
    for e in range(n - 1):
        for j in range(m + 2):
            geometric[j] = edges.axial_force[e, j] / edges.axial_length[e, j]
            stiff[j] = edges.axial_slope[e, j] - geometric[j]
        for a in range(3):
            ta = edges.axial[e, a]
            for b in range(3):
                tb = edges.axial[e, b]
                same = 1.0 if a == b else 0.0
                own = blocks[e, 4, a, b]
                other = blocks[e + 1, 4, a, b]
                up = blocks[e, 7, a, b]
                down = blocks[e + 1, 1, a, b]
                for j in range(m):
                    value = stiff[j + 1] * ta[j + 1] * tb[j + 1] + geometric[j + 1] * same
                    own[j] += value
                    other[j] += value
                    up[j] -= value
                    down[j] -= value
        _add_corners(edges, e, 0, blocks)
        _add_corners(edges, e, 1, blocks)


@compiled
def _add_turned(geometric: np.ndarray, before: np.ndarray, own: np.ndarray, after: np.ndarray) -> None:
    """Isotropic stiffness of the edges around a row: minus the turn by one column towards either neighbour."""
    m = own.shape[2]
    c = math.cos(2.0 * math.pi / m)
    s = math.sin(2.0 * math.pi / m)
    for a in range(3):
        y = own[a, a]
        for j in range(m):
            y[j] += geometric[j] + geometric[j + 1]
    for j in range(m):
        left = geometric[j]
        right = geometric[j + 1]
        after[0, 0, j] -= right * c
        after[0, 1, j] += right * s
        after[1, 0, j] -= right * s
        after[1, 1, j] -= right * c
        after[2, 2, j] -= right
        before[0, 0, j] -= left * c
        before[0, 1, j] -= left * s
        before[1, 0, j] += left * s
        before[1, 1, j] -= left * c
        before[2, 2, j] -= left


@compiled
def _add_corners(edges: Edges, e: int, end: int, blocks: np.ndarray) -> None:
    """What edges along z and around do to one another at the corners of row e + end, for the edges from row e."""
    m = blocks.shape[4]
    i = e + end
    k = e + 1 - end
    sign = 1.0 if end == 1 else -1.0
    to = 3 * (k - i)
    ll = edges.lc[4 * e + 2 * end]
    lr = edges.lc[4 * e + 2 * end + 1]
    cl = edges.cl[4 * e + 2 * end]
    cr = edges.cl[4 * e + 2 * end + 1]
    for a in range(3):
        ta = edges.axial[e, a]
        ua = edges.upper[i, a]
        la = edges.lower[i, a]
        for b in range(3):
            tb = edges.axial[e, b]
            ub = edges.upper[i, b]
            lb = edges.lower[i, b]
            near0 = blocks[i, 3, a, b]
            near1 = blocks[i, 4, a, b]
            near2 = blocks[i, 5, a, b]
            # Axial force by the nodes of row i: the same on the other end k, with the opposite sign.
            far0 = blocks[k, 3 - to, a, b]
            far1 = blocks[k, 4 - to, a, b]
            far2 = blocks[k, 5 - to, a, b]
            for j in range(m):
                t = sign * ta[j + 1]
                own = t * (ll[j + 1] * ub[j] - lr[j + 1] * lb[j + 1])
                left = -t * ll[j + 1] * lb[j]
                right = t * lr[j + 1] * ub[j + 1]
                near0[j] += left
                near1[j] += own
                near2[j] += right
                far0[j] -= left
                far1[j] -= own
                far2[j] -= right
            # Hoop force at row i by the edges along z of the columns j - 1, j, j + 1.
            far0 = blocks[i, 3 + to, a, b]
            far1 = blocks[i, 4 + to, a, b]
            far2 = blocks[i, 5 + to, a, b]
            for j in range(m):
                own = sign * tb[j + 1] * (cl[j + 1] * ua[j] - cr[j + 1] * la[j + 1])
                left = sign * tb[j] * cr[j] * ua[j]
                right = -sign * tb[j + 2] * cl[j + 2] * la[j + 1]
                near0[j] += left
                near1[j] += own
                near2[j] += right
                far0[j] -= left
                far1[j] -= own
                far2[j] -= right


@compiled
def stored_energy(edges: Edges, c: WallConstants) -> float:
    """Strain energy of the passive wall without blends, Eq. (4), by corners [mN cm]."""
    elements = edges.stretch.shape[0]
    m = edges.stretch.shape[1] - 2
    total = 0.0
    for e in range(elements):
        for end in range(2):
            for j in range(1, m + 1):
                for side in range(2):
                    total += strain_energy(edges.stretch[e, j], edges.hoop[e + end, j - 1 + side], c.passive)
    return total * 0.25 * c.element_size * 2.0 * math.pi * c.radius / m
