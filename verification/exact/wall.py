"""The membrane written anew from Eqs. (2)-(5), fit for complex steps, and states of the tube with known answers.

Sources: Eq. (4) and its derivatives by hand; equilibrium of membranes of revolution after A. E. Green and
J. E. Adkins, Large Elastic Deformations (1960), ch. IV: the two first integrals of a uniform membrane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from peristalsis.errors import DivergenceError
from peristalsis.inputs.build import build
from peristalsis.model.constants import LumenConstants, Step
from peristalsis.model.equilibrium import History, solve_equilibrium
from peristalsis.model.problem import Limits, Unknowns
from peristalsis.model.verdicts import CONVERGED, REASONS, Verdict
from peristalsis.numerics.block_band import PADDING, ROWS
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere
from peristalsis.wall.active import ActiveConstants
from peristalsis.wall.assembly import (
    FORCE_R,
    FORCE_Z,
    HISTORY_HOOP,
    HISTORY_R,
    HISTORY_STRETCH,
    HISTORY_Z,
    KNOWN_ROWS,
    VOLUME_R,
    VOLUME_Z,
    WALL_ROWS,
    set_drives,
    wall_forces,
    wall_tangent,
)
from peristalsis.wall.constants import WallConstants
from peristalsis.wall.passive import PassiveConstants

from .runs import EXACT, configured

Floats = NDArray[np.float64]

NO_PELLET = pellet_of(Sphere(0.5), present=False)
Number = Any

TIGHT = PassiveConstants(10.4, 10.4, 2.59, 3.79, 12.7, 0.0, 10.0)
COUPLED = PassiveConstants(10.4, 8.3, 2.59, 3.79, 5.7, 1.3, 2.0)
"""All constants different and none zero, so that no term can hide."""
LONGITUDINAL = ActiveConstants(-40.0, 120.0, -50.0)
CIRCULAR = ActiveConstants(-25.0, 75.0, -31.2)


def wall_constants(elements: int, length: float = 10.0, /, **changes: Any) -> WallConstants:
    """A wall in the consistent convention without smoothing, floor and bending, as the exact problems want it."""
    return build(configured(EXACT)).wall._replace(**{"element_size": length / elements, **changes})


def energy(longitudinal: Number, circumferential: Number, c: PassiveConstants) -> Number:
    """Eq. (4), for real or complex stretches."""
    el, ec = longitudinal - 1.0, circumferential - 1.0
    quadratic = c.c1 * el**2 + 2.0 * c.c3 * el * ec + c.c2 * ec**2
    return 0.5 * quadratic + c.c10 * np.exp(c.c4 * el**2 + c.c5 * ec**2 + 2.0 * c.c6 * el * ec)


def gradient(longitudinal: Number, circumferential: Number, c: PassiveConstants) -> tuple[Number, Number]:
    """Eq. (3) by hand, for real or complex stretches."""
    el, ec = longitudinal - 1.0, circumferential - 1.0
    g = 2.0 * c.c10 * np.exp(c.c4 * el**2 + c.c5 * ec**2 + 2.0 * c.c6 * el * ec)
    return (
        c.c1 * el + c.c3 * ec + g * (c.c4 * el + c.c6 * ec),
        c.c3 * el + c.c2 * ec + g * (c.c6 * el + c.c5 * ec),
    )


def complex_step(function: Callable[[Number], Number], x: float) -> float:
    """Derivative without cancellation (Squire & Trapp, SIAM Rev. 40, 1998)."""
    return float(np.imag(function(complex(x, 1e-30))) / 1e-30)


def discrete_energy(x: NDArray[Any], c: WallConstants) -> Number:
    """Strain and bending energy per 2 pi r0 of nodes (rho_0, zeta_0, rho_1, ...), corner quadrature, Eq. (16)."""
    rho, zeta, h = x[0::2], x[1::2], c.element_size
    stretch = np.sqrt(np.diff(rho) ** 2 + np.diff(zeta) ** 2) / h
    total = (
        0.5
        * h
        * sum(energy(stretch[e], rho[e + k] / c.radius, c.passive) for e in range(stretch.size) for k in range(2))
    )
    second = (rho[:-2] - 2.0 * rho[1:-1] + rho[2:]) ** 2 + (zeta[:-2] - 2.0 * zeta[1:-1] + zeta[2:]) ** 2
    return total + 0.5 * c.bending_stiffness / h**3 * second.sum()


def discrete_volume(x: NDArray[Any]) -> Number:
    """Volume of the stack of frusta, Eq. (18), for real or complex nodes."""
    rho, zeta = x[0::2], x[1::2]
    areas = rho[:-1] ** 2 + rho[:-1] * rho[1:] + rho[1:] ** 2
    return np.pi / 3.0 * (areas * np.diff(zeta)).sum()


def assembled(
    rho: Floats,
    zeta: Floats,
    c: WallConstants,
    slope: float = 0.0,
    histories: tuple[Floats, Floats] | None = None,
    drives: tuple[Floats, Floats] | None = None,
    places: Floats | None = None,
    pressure: float = 0.0,
    forces: Callable[..., Any] = wall_forces,
) -> tuple[Floats, Floats]:
    """Residual (2n,) and dense tangent (2n, 2n) of the package's wall; without histories it is at rest where it is.

    Zero at the end nodes, which are clamped and have no equation. forces: what to call in place of `wall_forces`.
    """
    n = rho.size
    stretch_history, hoop_history = histories if histories is not None else (np.ones(n - 1), np.ones(n))
    active_l, active_c = drives if drives is not None else (np.zeros(2 * n - 2), np.zeros(2 * n - 2))
    known = np.zeros((KNOWN_ROWS, n))
    known[HISTORY_R : HISTORY_Z + 1] = np.stack([rho, zeta]) if places is None else places
    known[HISTORY_STRETCH, :-1], known[HISTORY_HOOP] = stretch_history, hoop_history
    set_drives(active_l, active_c, known)
    work, system = np.zeros((WALL_ROWS, n)), np.zeros((ROWS, n + PADDING))
    if not forces(rho, zeta, known, slope, c, 1, n - 2, work):
        raise ValueError("the trial state was refused: a stretch or an exponent is out of range")
    wall_tangent(rho, zeta, pressure, slope, c, 1, n - 2, work, system)
    residual = work[FORCE_R : FORCE_Z + 1] - pressure * work[VOLUME_R : VOLUME_Z + 1]
    return residual.T.ravel(), dense(system)


def dense(system: Floats) -> Floats:
    """The full matrix (2n, 2n) of block rows; rows of nodes that were not assembled are zero."""
    n = system.shape[1] - PADDING
    full = np.zeros((2 * n, 2 * n))
    for i in range(n):
        for block in range(5):
            j = i + block - 2
            if 0 <= j < n:
                full[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = system[4 * block : 4 * block + 4, i].reshape(2, 2)
    return full


@dataclass(frozen=True)
class InflatedTube:
    """A long straight tube at longitudinal stretch `stretch`, held by pressure and circular drive: T_c = p rho."""

    pressure: float
    wall: WallConstants
    stretch: float = 1.0
    drive: float = 0.0

    def hoop_stretch(self) -> float:
        """The stretch at which Laplace's law holds, in the tension convention of the wall."""
        r0, deformed = self.wall.radius, 1.0 if self.wall.published else self.stretch

        def excess(hoop: float) -> float:
            active = max(0.0, CIRCULAR.c7 * hoop**2 + CIRCULAR.c8 * hoop + CIRCULAR.c9)
            tension = gradient(self.stretch, hoop, self.wall.passive)[1] + self.drive * active
            return float(tension / deformed - self.pressure * r0 * hoop)

        return float(brentq(excess, 0.4, 2.2, xtol=1e-15, rtol=1e-15))


def axial_invariants(rho: Floats, zeta: Floats, pressure: float, c: WallConstants) -> tuple[Floats, Floats]:
    """The two first integrals per element: axial force F [mN], and W - lambda_l W_l [mN/cm] (consistent only)."""
    h = c.element_size
    dr, dz = np.diff(rho), np.diff(zeta)
    stretch = np.hypot(dr, dz) / h
    hoops = np.stack([rho[:-1], rho[1:]]) / c.radius
    nominal = gradient(stretch, hoops, c.passive)[0]
    if c.published:
        nominal = nominal * hoops
    force = 2.0 * np.pi * c.radius * nominal.mean(axis=0) * dz / (h * stretch)
    force -= pressure * np.pi / 3.0 * (rho[:-1] ** 2 + rho[:-1] * rho[1:] + rho[1:] ** 2)
    middle = hoops.mean(axis=0)
    return force, energy(stretch, middle, c.passive) - stretch * gradient(stretch, middle, c.passive)[0]


def settle(rho: Floats, zeta: Floats, pressure: float, wall: WallConstants, drive: float = 0.0) -> int:
    """Static equilibrium at constant pressure, in place; the end nodes stay where they are. Newton iterations it took.

    The tolerance is what rounding leaves: positions to one part in 2^52, over h twice for a force on a node.
    """
    n = rho.size
    tolerance = max(1e-12, 1e-14 * zeta[-1] / wall.element_size**2)
    two, drives = np.zeros((2, n)), np.zeros((2, 2 * n - 2))
    drives[1] = drive
    verdict = solve_equilibrium(
        Unknowns(rho, zeta, np.zeros(n), np.array([pressure, 0.0, 0.0])),
        History(two, two, np.ones(n - 1), np.ones(n)),
        drives,
        np.zeros(n),
        Step(0.0, False, 0.0, 0.0),
        wall,
        NO_PELLET,
        LumenConstants(pressure, 1.0, 0.0),
        Limits(tolerance, 1e-12, 100),
    )
    _require(verdict)
    return verdict.iterations


def _require(verdict: Verdict) -> None:
    """Raise DivergenceError unless there is an equilibrium."""
    if verdict.code != CONVERGED:
        raise DivergenceError(f"no equilibrium after {verdict.iterations} iterations: {REASONS[verdict.code]}")


def relax(rho: Floats, zeta: Floats, pressure: float, wall: WallConstants, duration: float, steps: int) -> None:
    """Viscous motion without inertia at constant pressure, in place, by backward Euler; the end nodes stay.

    Raises DivergenceError where a step finds no equilibrium.
    """
    n, slope = rho.size, steps / duration
    for _ in range(steps):
        stretch = np.hypot(np.diff(rho), np.diff(zeta)) / wall.element_size
        verdict = solve_equilibrium(
            Unknowns(rho, zeta, np.zeros(n), np.array([pressure, 0.0, 0.0])),
            History(np.stack([rho, zeta]), np.zeros((2, n)), stretch, rho / wall.radius),
            np.zeros((2, 2 * n - 2)),
            np.zeros(n),
            Step(slope, False, 0.0, 0.0),
            wall,
            NO_PELLET,
            LumenConstants(pressure, 1.0, 0.0),
            Limits(1e-11, 1e-12, 100),
        )
        _require(verdict)
