"""What keeps the wall on the whole surface regular, Eqs. (16), (42), (43): small, stated, and zero where it must be.

Bending along z is that of the axisymmetric wall. Added on the surface: bending around the ring and a shear viscosity,
both zero for ring-uniform motion without twist, and a weak foundation (the mesentery) that holds the centres of rings.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from ..numerics.ring_blocks import add_bending, add_tether
from .constants import SurfaceConstants, WallConstants
from .surface import chord


@compiled
def bending_along(c: WallConstants, rate_slope: float) -> float:
    """Weight of squared second differences along z [mN/cm^2], per arc, Eq. (16)."""
    return (c.bending_stiffness + c.bending_viscosity * rate_slope) / c.element_size**3


@compiled
def bending_around(c: WallConstants, s: SurfaceConstants, rate_slope: float, columns: int) -> float:
    """Weight of squared second differences around the ring [mN/cm^2], per arc, Eq. (42)."""
    arc = 2.0 * math.pi * c.radius / columns
    factor = s.bending_stiffness_around + s.bending_viscosity_around * rate_slope
    return factor * c.element_size / arc**4


@compiled
def add_regulariser_forces(
    padded: np.ndarray,
    places: np.ndarray,
    moved: np.ndarray,
    shear_history: np.ndarray,
    rate_slope: float,
    c: WallConstants,
    s: SurfaceConstants,
    residual: np.ndarray,
) -> None:
    """Add bending, shear viscosity and foundation to `residual` (n, 3, m) [mN/cm].

    padded, places: nodes, padded and not; moved: padded difference from the history, velocity over rate_slope.
    shear_history: of the patches' shear, (n - 1, m), as `patch_shear` gives it.
    """
    m = residual.shape[2]
    arc = 2.0 * math.pi * c.radius / m
    add_bending(
        padded,
        c.bending_stiffness / c.element_size**3,
        s.bending_stiffness_around * c.element_size / arc**4,
        residual,
    )
    if rate_slope > 0.0:
        along = c.bending_viscosity * rate_slope / c.element_size**3
        around = s.bending_viscosity_around * rate_slope * c.element_size / arc**4
        add_bending(moved, along, around, residual)
        if s.shear_viscosity > 0.0:
            _add_shear(padded, shear_history, rate_slope, c, s, residual)
    if s.foundation != 0.0:
        add_tether(places, s.foundation * c.element_size, residual)


@compiled
def patch_shear(padded: np.ndarray, c: WallConstants, shear: np.ndarray) -> None:
    """Shear lambda_l lambda_c e_l . e_c of every patch into (n - 1, m): the difference of its squared diagonals."""
    m = shear.shape[1]
    ca = math.cos(math.pi / m)
    sa = math.sin(math.pi / m)
    scale = 1.0 / (4.0 * c.element_size * chord(c, m))
    for e in range(shear.shape[0]):
        for j in range(m):
            px, py, pz = _diagonal(padded, e, e + 1, j + 1, ca, sa)
            qx, qy, qz = _diagonal(padded, e + 1, e, j + 1, ca, sa)
            shear[e, j] = scale * (px * px + py * py + pz * pz - qx * qx - qy * qy - qz * qz)


@compiled
def _diagonal(padded: np.ndarray, start: int, stop: int, j: int, ca: float, sa: float) -> tuple[float, float, float]:
    """From row `start` of padded column j to row `stop` of the next, in the frame half-way."""
    return (
        ca * (padded[stop, 0, j + 1] - padded[start, 0, j]) - sa * (padded[stop, 1, j + 1] + padded[start, 1, j]),
        sa * (padded[stop, 0, j + 1] + padded[start, 0, j]) + ca * (padded[stop, 1, j + 1] - padded[start, 1, j]),
        padded[stop, 2, j + 1] - padded[start, 2, j],
    )


@compiled
def _add_shear(
    padded: np.ndarray,
    history: np.ndarray,
    rate_slope: float,
    c: WallConstants,
    s: SurfaceConstants,
    residual: np.ndarray,
) -> None:
    n = residual.shape[0]
    m = residual.shape[2]
    ca = math.cos(math.pi / m)
    sa = math.sin(math.pi / m)
    unit = 1.0 / (4.0 * c.element_size * chord(c, m))
    # Weight of a patch per arc is h; the force along a diagonal d is +-2 unit d times the viscous stress.
    factor = 2.0 * unit * c.element_size * s.shear_viscosity * rate_slope
    for e in range(n - 1):
        for j in range(m):
            k = j + 1 if j < m - 1 else 0
            px, py, pz = _diagonal(padded, e, e + 1, j + 1, ca, sa)
            qx, qy, qz = _diagonal(padded, e + 1, e, j + 1, ca, sa)
            shear = unit * (px * px + py * py + pz * pz - qx * qx - qy * qy - qz * qz)
            f = factor * (shear - history[e, j])
            residual[e, 0, j] -= f * (ca * px - sa * py)
            residual[e, 1, j] -= f * (sa * px + ca * py)
            residual[e, 2, j] -= f * pz
            residual[e + 1, 0, k] += f * (ca * px + sa * py)
            residual[e + 1, 1, k] += f * (ca * py - sa * px)
            residual[e + 1, 2, k] += f * pz
            residual[e + 1, 0, j] += f * (ca * qx - sa * qy)
            residual[e + 1, 1, j] += f * (sa * qx + ca * qy)
            residual[e + 1, 2, j] += f * qz
            residual[e, 0, k] -= f * (ca * qx + sa * qy)
            residual[e, 1, k] -= f * (ca * qy - sa * qx)
            residual[e, 2, k] -= f * qz


@compiled
def add_shear_tangent(
    padded: np.ndarray,
    history: np.ndarray,
    rate_slope: float,
    c: WallConstants,
    s: SurfaceConstants,
    blocks: np.ndarray,
) -> None:
    """Add the derivative of the shear viscosity's forces to the stencil blocks (n, 9, 3, 3, m)."""
    n = blocks.shape[0]
    m = blocks.shape[4]
    if s.shear_viscosity <= 0.0 or rate_slope <= 0.0:
        return
    ca = math.cos(math.pi / m)
    sa = math.sin(math.pi / m)
    turn_c = math.cos(2.0 * math.pi / m)
    turn_s = math.sin(2.0 * math.pi / m)
    unit = 1.0 / (4.0 * c.element_size * chord(c, m))
    stiff = c.element_size * s.shear_viscosity * rate_slope
    # Derivative of the shear by the four nodes of each patch, and the viscous stress over the patch.
    slope = np.empty((4, 3, m))
    force = np.empty(m)
    shifted_force = np.empty(m)
    row = (0, 0, 1, 1)
    side = (0, 1, 1, 0)
    sign = (1.0, -1.0, 1.0, -1.0)
    for e in range(n - 1):
        for j in range(m):
            px, py, pz = _diagonal(padded, e, e + 1, j + 1, ca, sa)
            qx, qy, qz = _diagonal(padded, e + 1, e, j + 1, ca, sa)
            shear = unit * (px * px + py * py + pz * pz - qx * qx - qy * qy - qz * qz)
            force[j] = 2.0 * unit * stiff * (shear - history[e, j])
            d = 2.0 * unit
            slope[0, 0, j] = -d * (ca * px - sa * py)
            slope[0, 1, j] = -d * (sa * px + ca * py)
            slope[0, 2, j] = -d * pz
            slope[2, 0, j] = d * (ca * px + sa * py)
            slope[2, 1, j] = d * (ca * py - sa * px)
            slope[2, 2, j] = d * pz
            slope[3, 0, j] = d * (ca * qx - sa * qy)
            slope[3, 1, j] = d * (sa * qx + ca * qy)
            slope[3, 2, j] = d * qz
            slope[1, 0, j] = -d * (ca * qx + sa * qy)
            slope[1, 1, j] = -d * (ca * qy - sa * qx)
            slope[1, 2, j] = -d * qz
        for p in range(4):
            for r in range(4):
                q = 3 * (row[r] - row[p] + 1) + side[r] - side[p] + 1
                o = side[p]
                for a in range(3):
                    for b in range(3):
                        # Node p stands in column j + o: that of the last patch wraps around.
                        y = blocks[e + row[p], q, a, b]
                        shifted = y[o:m]
                        left = slope[p, a]
                        right = slope[r, b]
                        for j in range(m - o):
                            shifted[j] += stiff * left[j] * right[j]
                        if o == 1:
                            y[0] += stiff * left[m - 1] * right[m - 1]
        for p in range(4):
            # The node itself and the other end of the diagonal, turned by one column.
            o = side[p]
            t = turn_s if o == 0 else -turn_s
            own = blocks[e + row[p], 4]
            far = blocks[e + row[p], 3 * (2 if row[p] == 0 else 0) + (2 if o == 0 else 0)]
            for j in range(m):
                k = j - o if j >= o else m - 1
                shifted_force[j] = sign[p] * force[k]
            for a in range(3):
                y = own[a, a]
                for j in range(m):
                    y[j] += shifted_force[j]
            for a, b, w in ((0, 0, turn_c), (0, 1, -t), (1, 0, t), (1, 1, turn_c), (2, 2, 1.0)):
                y = far[a, b]
                for j in range(m):
                    y[j] -= w * shifted_force[j]
