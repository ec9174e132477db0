"""The tube as a surface of bilinear patches: its volume, the gradient of the volume and its tangent, Eq. (18).

Nodes are padded fields in the frames of their columns (see `numerics.ring_blocks`). The volume under a bilinear
patch is the mean of those under its two triangulations, which makes the gradient a sum of cross products.
`polygon_factor` turns the polygon of m columns into the circle, so a ring-uniform tube holds exactly its frusta.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled

Floats = NDArray[np.float64]


def to_frames(position: Floats) -> Floats:
    """Nodes (rho, vartheta, zeta), shape (n, m, 3), as Cartesian places in the frames of their columns, (n, 3, m)."""
    angle = position[:, :, 1] - column_angles(position.shape[1])
    return np.stack([position[:, :, 0] * np.cos(angle), position[:, :, 0] * np.sin(angle), position[:, :, 2]], axis=1)


def from_frames(places: Floats) -> Floats:
    """The inverse of `to_frames`: vartheta lies within pi of its column's angle."""
    x, y = places[:, 0], places[:, 1]
    angle = np.arctan2(y, x) + column_angles(places.shape[2])
    return np.ascontiguousarray(np.stack([np.hypot(x, y), angle, places[:, 2]], axis=2))


def rates_to_frames(position: Floats, rate: Floats) -> Floats:
    """Rates of (rho, vartheta, zeta), (n, m, 3), at `position` as Cartesian velocities in frames, (n, 3, m)."""
    angle = position[:, :, 1] - column_angles(position.shape[1])
    c, s = np.cos(angle), np.sin(angle)
    out, around = rate[:, :, 0], position[:, :, 0] * rate[:, :, 1]
    return np.stack([c * out - s * around, s * out + c * around, rate[:, :, 2]], axis=1)


def rates_from_frames(places: Floats, velocity: Floats) -> Floats:
    """The inverse of `rates_to_frames`, at places (n, 3, m)."""
    rho = np.hypot(places[:, 0], places[:, 1])
    c, s = places[:, 0] / rho, places[:, 1] / rho
    out, around = c * velocity[:, 0] + s * velocity[:, 1], c * velocity[:, 1] - s * velocity[:, 0]
    return np.ascontiguousarray(np.stack([out, around / rho, velocity[:, 2]], axis=2))


def column_angles(columns: int) -> Floats:
    """Angles theta_j = 2 pi j/m of the columns [rad]."""
    return 2.0 * np.pi * np.arange(columns) / columns


@compiled
def polygon_factor(columns: int) -> float:
    """Area of a circle over that of the regular polygon of so many corners on it."""
    turn = 2.0 * math.pi / columns
    return turn / math.sin(turn)


def equivalent_radius(position: Floats) -> Floats:
    """Radius of the circle with the area of each ring across the axis [cm], shape (n,).

    position: nodes (rho, vartheta, zeta), (n, m, 3).
    """
    places = to_frames(position)
    m = places.shape[2]
    turn = 2.0 * math.pi / m
    x, y = places[:, 0], places[:, 1]
    nx, ny = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    c, s = math.cos(turn), math.sin(turn)
    area = 0.5 * (x * (s * nx + c * ny) - y * (c * nx - s * ny)).sum(axis=1) * polygon_factor(m)
    return np.asarray(np.sqrt(np.maximum(area, 0.0) / math.pi))


@compiled
def surface_volume(padded: np.ndarray) -> float:
    """Volume [cm^3] inside nodes (n, 3, m + 2) [cm] whose end rows are plane rings across the axis."""
    n = padded.shape[0]
    m = padded.shape[2] - 2
    turn = 2.0 * math.pi / m
    c = math.cos(0.5 * turn)
    s = math.sin(0.5 * turn)
    base = padded[0, 2, 1]
    total = 0.0
    for i in range(n - 1):
        for j in range(1, m + 1):
            ax = c * padded[i, 0, j] + s * padded[i, 1, j]
            ay = c * padded[i, 1, j] - s * padded[i, 0, j]
            az = padded[i, 2, j] - base
            bx = c * padded[i, 0, j + 1] - s * padded[i, 1, j + 1]
            by = c * padded[i, 1, j + 1] + s * padded[i, 0, j + 1]
            bz = padded[i, 2, j + 1] - base
            cx = c * padded[i + 1, 0, j + 1] - s * padded[i + 1, 1, j + 1]
            cy = c * padded[i + 1, 1, j + 1] + s * padded[i + 1, 0, j + 1]
            cz = padded[i + 1, 2, j + 1] - base
            dx = c * padded[i + 1, 0, j] + s * padded[i + 1, 1, j]
            dy = c * padded[i + 1, 1, j] - s * padded[i + 1, 0, j]
            dz = padded[i + 1, 2, j] - base
            # det(a, b, c + d) + det(c, d, a + b): the four triangles of the two triangulations.
            total += (ay * bz - az * by) * (cx + dx) + (az * bx - ax * bz) * (cy + dy) + (ax * by - ay * bx) * (cz + dz)
            total += (cy * dz - cz * dy) * (ax + bx) + (cz * dx - cx * dz) * (ay + by) + (cx * dy - cy * dx) * (az + bz)
    total /= 12.0
    cap = 0.0
    for j in range(1, m + 1):
        ax = c * padded[n - 1, 0, j] + s * padded[n - 1, 1, j]
        ay = c * padded[n - 1, 1, j] - s * padded[n - 1, 0, j]
        bx = c * padded[n - 1, 0, j + 1] - s * padded[n - 1, 1, j + 1]
        by = c * padded[n - 1, 1, j + 1] + s * padded[n - 1, 0, j + 1]
        cap += 0.5 * (ax * by - ay * bx)
    total += cap * (padded[n - 1, 2, 1] - base) / 3.0
    return polygon_factor(m) * total


@compiled
def volume_gradient(padded: np.ndarray, scale: float, gradient: np.ndarray) -> None:
    """scale * dV/dx of the inner nodes into `gradient` (n, 3, m); zero in the end rows.

    With b, c, d the other nodes of a patch in turn, relative to the node, dV/dx = 1/12 sum over its four patches of
    b x c + c x d + b x d.
    """
    n = padded.shape[0]
    m = padded.shape[2] - 2
    turn = 2.0 * math.pi / m
    c = math.cos(turn)
    s = math.sin(turn)
    factor = scale * polygon_factor(m) / 12.0
    gradient[0] = 0.0
    gradient[n - 1] = 0.0
    for i in range(1, n - 1):
        for j in range(m):
            x0 = padded[i, 0, j + 1]
            y0 = padded[i, 1, j + 1]
            z0 = padded[i, 2, j + 1]
            gx = 0.0
            gy = 0.0
            gz = 0.0
            for side in range(2):
                # Side 0: the columns j (toward +z) and j + 1; side 1: the columns j (toward -z) and j - 1.
                o = j + 2 if side == 0 else j
                t = s if side == 0 else -s
                up = i + 1 if side == 0 else i - 1
                down = i - 1 if side == 0 else i + 1
                bx = c * padded[i, 0, o] - t * padded[i, 1, o] - x0
                by = c * padded[i, 1, o] + t * padded[i, 0, o] - y0
                bz = padded[i, 2, o] - z0
                cx = c * padded[up, 0, o] - t * padded[up, 1, o] - x0
                cy = c * padded[up, 1, o] + t * padded[up, 0, o] - y0
                cz = padded[up, 2, o] - z0
                dx = padded[up, 0, j + 1] - x0
                dy = padded[up, 1, j + 1] - y0
                dz = padded[up, 2, j + 1] - z0
                ex = c * padded[down, 0, o] - t * padded[down, 1, o] - x0
                ey = c * padded[down, 1, o] + t * padded[down, 0, o] - y0
                ez = padded[down, 2, o] - z0
                fx = padded[down, 0, j + 1] - x0
                fy = padded[down, 1, j + 1] - y0
                fz = padded[down, 2, j + 1] - z0
                # Patch (b, c, d): b x (c + d) + c x d; patch (f, e, b): f x (e + b) + e x b.
                gx += by * (cz + dz) - bz * (cy + dy) + cy * dz - cz * dy
                gy += bz * (cx + dx) - bx * (cz + dz) + cz * dx - cx * dz
                gz += bx * (cy + dy) - by * (cx + dx) + cx * dy - cy * dx
                gx += fy * (ez + bz) - fz * (ey + by) + ey * bz - ez * by
                gy += fz * (ex + bx) - fx * (ez + bz) + ez * bx - ex * bz
                gz += fx * (ey + by) - fy * (ex + bx) + ex * by - ey * bx
            gradient[i, 0, j] = factor * gx
            gradient[i, 1, j] = factor * gy
            gradient[i, 2, j] = factor * gz


@compiled
def add_volume_tangent(padded: np.ndarray, scale: float, blocks: np.ndarray) -> None:
    """Add scale * d2V/dx2 to stencil blocks (n, 9, 3, 3, m) of the inner rows.

    With the neighbours of a node numbered around it, p_k turns its gradient by dp_k x v_k, where v_k is the difference
    of the neighbours next to it, and, for those on the node's own row or column, of the next but one as well.
    """
    n = padded.shape[0]
    m = padded.shape[2] - 2
    turn = 2.0 * math.pi / m
    c = math.cos(turn)
    s = math.sin(turn)
    factor = scale * polygon_factor(m) / 12.0
    around = np.empty((8, 3, m))
    spin = np.empty((3, m))
    total = np.empty((3, m))
    step_i = (0, 1, 1, 1, 0, -1, -1, -1)
    step_j = (1, 1, 0, -1, -1, -1, 0, 1)
    for i in range(1, n - 1):
        for k in range(8):
            o = 1 + step_j[k]
            t = s * step_j[k]
            cc = c if step_j[k] != 0 else 1.0
            x = padded[i + step_i[k], 0][o : o + m]
            y = padded[i + step_i[k], 1][o : o + m]
            z = padded[i + step_i[k], 2][o : o + m]
            for j in range(m):
                around[k, 0, j] = cc * x[j] - t * y[j]
                around[k, 1, j] = cc * y[j] + t * x[j]
                around[k, 2, j] = z[j]
        total[:, :] = 0.0
        for k in range(8):
            reach = 2 if k % 2 == 0 else 1
            share = factor if reach == 2 else 0.0
            for a in range(3):
                v = spin[a]
                add = total[a]
                after = around[(k + 1) % 8, a]
                before = around[(k + 7) % 8, a]
                after2 = around[(k + reach) % 8, a]
                before2 = around[(k + 8 - reach) % 8, a]
                for j in range(m):
                    value = factor * (after[j] - before[j]) + share * (after2[j] - before2[j])
                    v[j] = value
                    add[j] += value
            q = 3 * (step_i[k] + 1) + step_j[k] + 1
            _add_spin(blocks[i, q], spin, c if step_j[k] != 0 else 1.0, s * step_j[k], 1.0)
        # The node itself moves against all its neighbours.
        _add_spin(blocks[i, 4], total, 1.0, 0.0, -1.0)


@compiled
def _add_spin(block: np.ndarray, spin: np.ndarray, c: float, t: float, sign: float) -> None:
    """Add d -> sign * d x spin to a block (3, 3, m), where d is given in a frame turned by (c, t); spin: (3, m)."""
    for a, b, w in ((0, 0, t), (0, 1, c), (1, 0, -c), (1, 1, t)):
        y = block[a, b]
        z = spin[2]
        for j in range(y.size):
            y[j] += sign * w * z[j]
    across = spin[0]
    along = spin[1]
    y = block[0, 2]
    for j in range(y.size):
        y[j] -= sign * along[j]
    y = block[1, 2]
    for j in range(y.size):
        y[j] += sign * across[j]
    y = block[2, 0]
    for j in range(y.size):
        y[j] += sign * (along[j] * c - across[j] * t)
    y = block[2, 1]
    for j in range(y.size):
        y[j] -= sign * (along[j] * t + across[j] * c)
