"""A rubber tube: the wall's own kernels bound to another strain energy.

The compiled kernels of the wall bind Eq. (4). Their source is the same code uncompiled, so the assembly of forces
and tangent can be run with any energy, slowly.
"""

from __future__ import annotations

from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis.wall import assembly, membrane
from peristalsis.wall.constants import WallConstants

from .wall import assembled

Floats = NDArray[np.float64]


def energy_derivatives(l: float, c: float, c1: float, c2: float) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) of W = C1 (I1 - 3) + C2 (I2 - 3) at stretches l, c; incompressible."""
    a, b = 1.0 / (l * c) ** 2, (l * c) ** 2
    return (
        2.0 * c1 * (l - a / l) + 2.0 * c2 * (b / l - l**-3),
        2.0 * c1 * (c - a / c) + 2.0 * c2 * (b / c - c**-3),
        2.0 * c1 * (1.0 + 3.0 * a / l**2) + 2.0 * c2 * (c**2 + 3.0 * l**-4),
        4.0 * c1 * a / (l * c) + 4.0 * c2 * l * c,
        2.0 * c1 * (1.0 + 3.0 * a / c**2) + 2.0 * c2 * (l**2 + 3.0 * c**-4),
    )


def _uncompiled(function: Any, **others: Any) -> Any:
    """The Python function under a kernel, with some of the names that it calls replaced."""
    source = function.py_func
    return FunctionType(source.__code__, {**source.__globals__, **others})


def assemble(rho: Floats, zeta: Floats, pressure: float, wall: WallConstants, c1: float, c2: float) -> Any:
    """Residual (2n,) and dense tangent of a static Mooney-Rivlin tube under pressure, by the wall's assembly."""

    def law(l: float, c: float, _: object) -> tuple[float, float, float, float, float]:
        return energy_derivatives(l, c, c1, c2)

    before = _uncompiled(membrane.before_floor, passive_tension=law)
    tensions = _uncompiled(membrane.tensions, before_floor=before)
    nominal = _uncompiled(membrane.nominal_tensions, tensions=tensions)
    corners = _uncompiled(assembly.corner_tensions, nominal_tensions=nominal)
    forces = _uncompiled(assembly.wall_forces, corner_tensions=corners)
    return assembled(rho, zeta, wall, pressure=pressure, forces=forces)


def settle(rho: Floats, zeta: Floats, pressure: float, wall: WallConstants, c1: float, c2: float) -> int:
    """Static equilibrium in place by Newton's method with that tangent, ends held; returns the iterations."""
    free = slice(2, 2 * rho.size - 2)
    for iteration in range(30):
        residual, tangent = assemble(rho, zeta, pressure, wall, c1, c2)
        if np.abs(residual[free]).max() <= 1e-11 * pressure * wall.element_size:
            return iteration
        change = np.linalg.solve(tangent[free, free], -residual[free])
        rho[1:-1] += change[0::2]
        zeta[1:-1] += change[1::2]
    raise ValueError(f"no equilibrium in 30 iterations at {pressure:g} mN/cm^2; start nearer to it")
