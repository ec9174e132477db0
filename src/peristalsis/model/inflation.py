"""The passive tube before t = 0: inflated to p0 and a pellet grown in it, on the way that works; or why none does.

First Newton's method alone goes up in pressure and radius. Where that fails the wall is let go with its own viscosity
from the last good state, in steps that lengthen until nothing moves (Eq. (59)): every step has a regular tangent, and
what it ends at is a stable state of rest. Where that fails too, steps of pressure or radius tell how far the tube goes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergenceError
from ..geometry.grid import Grid
from ..numerics.roots import find_root
from ..pellet.body import resized_pellet
from ..pellet.contact import room
from ..wall.assembly import HISTORY_HOOP, HISTORY_R, HISTORY_STRETCH, HISTORY_Z
from ..wall.membrane import nominal_tensions
from ..wall.passive import passive_tension
from . import refusal
from .constants import LumenConstants, Step, packed
from .equilibrium import PackedConstants, solve_packed
from .model import Model
from .problem import KNOWN, Limits, Unknowns, workspace
from .verdicts import CONVERGED, NOT_CONVERGED, ROUNDED

Floats = NDArray[np.float64]

LOPSIDED = 1e-2
"""Difference of the tube from its mirror image [cm] from which on it is one of several states of rest."""
AT_REST = (CONVERGED, ROUNDED)

END_LAYER = 0.3
"""Length over which the first guess of the inflated tube leaves its clamped ends [cm]."""
GENTLE_PRESSURE = 20.0
"""Pressure at which inflation begins [mN/cm^2], unless p0 is lower."""
SMALLEST_RADIUS = 1e-3
"""A pellet that begins to grow is this much smaller than the room it finds [cm]."""

GROWTH = 0.1
"""Rate at which a pellet grows in a wall that moves by its own viscosity [cm/s]."""
FINE = 3200
"""Elements from which the start is found on a quarter of them first."""
FIRST_STEP, SHORTEST_STEP = 1e-3, 1e-8
"""Steps [s] of a wall that moves by its own viscosity."""
FEW, MANY = 12, 25
"""Iterations below which such a step is doubled and above which it is shortened."""
STILL = 1.0
"""Step [s] from which a state of rest is tried."""
LOOSE = 1e-7
"""Residual to which the steps on the way are solved, unless more is asked for."""
MOST_ITERATIONS = 3000
"""Iterations after which such a wall is given up."""
FEWER_ITERATIONS, MOST_TO_TELL = 1000, 5000
"""The same where it only is to be told how far a tube gets, at each value and at all of them."""
LOWEST_SHARE, BISECTIONS = 1e-5, 4
"""Share of a refused pressure down to which one that starts is looked for, and how often the gap is then halved."""


@dataclass
class Tube:
    """The passive tube and a pellet held in place, as it is on its way to the start; `settle` changes it in place.

    astray: radius, axial place [cm] and speed [cm/s] of the nodes where a relaxation was last given up.
    residual: that of the last state of rest, where it is rounding above the tolerance; else 0. iterations: of Newton's
    method so far.
    """

    model: Model
    rho: Floats
    zeta: Floats
    contact: Floats
    scalars: Floats
    residual: float = 0.0
    iterations: int = 0
    astray: tuple[Floats, Floats, Floats] = field(init=False)
    _known: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.astray = self.rho, self.zeta, np.zeros(self.rho.size)
        self._known = np.zeros((KNOWN, self.rho.size))

    @classmethod
    def undeformed(cls, model: Model) -> Tube:
        """The cylinder of the reference, evenly shortened between ends that are held nearer than it is long."""
        grid = model.grid
        nodes = grid.nodes if grid.slack == 0.0 else grid.nodes * (grid.span / grid.length)
        n = nodes.size
        scalars = np.array([model.lumen.pressure, model.start_position, 0.0])
        return cls(model, np.full(n, model.wall.radius), nodes.copy(), np.zeros(n), scalars)

    def arrays(self) -> tuple[Floats, ...]:
        """All that `settle` changes."""
        return self.rho, self.zeta, self.contact, self.scalars

    def copies(self) -> list[Floats]:
        """What `restore` puts back."""
        return [array.copy() for array in self.arrays()]

    def restore(self, kept: list[Floats]) -> None:
        """Back to an earlier state."""
        for array, good in zip(self.arrays(), kept, strict=True):
            array[:] = good

    def settle(self, pressure: float, radius: float, step: float = 0.0, iterations: int = 100) -> int:
        """Equilibrium at a constant pressure around a pellet of this radius held in place (none if 0).

        step: time [s] in which the wall gets there from where it is, by its viscosity; 0: at rest. Returns the
        solver's code; after all but AT_REST the arrays are to be restored.
        """
        model, wall, known = self.model, self.model.wall, self._known
        self.scalars[0] = pressure
        sized = resized_pellet(model.pellet, max(radius, 1e-3))
        pellet = sized._replace(present=radius > 0.0, frame=0.0, volume=0.0)
        slope, tolerance = 0.0, model.tolerance
        known[HISTORY_R : HISTORY_Z + 1] = 0.0
        known[HISTORY_STRETCH], known[HISTORY_HOOP] = 1.0, 1.0
        if step > 0.0:
            slope, tolerance = 1.0 / step, max(tolerance, LOOSE)
            known[HISTORY_R], known[HISTORY_Z] = self.rho, self.zeta
            known[HISTORY_STRETCH, :-1] = np.hypot(np.diff(self.rho), np.diff(self.zeta)) / wall.element_size
            known[HISTORY_HOOP] = self.rho / wall.radius
        formula = Step(slope, False, model.start_position, 0.0)
        limits = Limits(tolerance, model.gap_tolerance, iterations)
        lumen = LumenConstants(pressure, 1.0, 0.0)
        # The copy can be written to, as the pellet's numbers of a step: one compiled variant does for both.
        constants = PackedConstants(packed(wall), packed(pellet).copy(), packed(lumen))
        unknowns = Unknowns(self.rho, self.zeta, self.contact, self.scalars)
        verdict = solve_packed(unknowns, known, constants, formula, limits, workspace(self.rho.size))
        self.iterations += verdict.iterations
        if step == 0.0:
            self.residual = verdict.residual if verdict.code == ROUNDED else 0.0
        return verdict.code

    def room(self) -> float:
        """Girth radius [cm] of the largest pellet of this shape that has room."""
        return float(room(self.rho, self.zeta, self.model.start_position, self.model.pellet.shape))


def inflate_and_insert(model: Model) -> tuple[Tube, Floats, list[str]]:
    """The tube at p0 around its pellet, the pellet-free radius [cm] at the nodes, and remarks for the user.

    Raises DivergenceError if the tube cannot be inflated or the pellet not be inserted, with the cause.
    """
    pressure, least = model.lumen.pressure, smoothing_pressure(model)
    tube, free, residual = _started(model, max(pressure, least))
    remarks = []
    if pressure < least:
        remarks.append(
            f"lumen.pressure = {pressure / 100.0:g} kPa is less than the {least / 100.0:.2g} kPa that hold slack wall "
            "open against the tension left by its smoothing, Eqs. (14) and (15): the run starts from the tube at that "
            "pressure, and its slack wall then closes slowly; raise the pressure, or lower wall.slack_blend"
        )
    if residual > 0.0:
        remarks.append(
            f"solver.residual_tolerance = {model.tolerance:g}: rounding leaves a residual of {residual:.2g} on "
            f"grid.n_z_wall = {model.grid.n_z_wall} elements of this wall, Eq. (58); the start is accepted there"
        )
    return tube, free[0], remarks


def _started(model: Model, pressure: float) -> tuple[Tube, list[Floats], float]:
    """(tube at a pressure around its pellet, the same without pellet, residual that is rounding)."""
    if model.grid.n_z_wall >= FINE:
        refined = _refined(model, pressure)
        if refined is not None:
            return refined
    tube = Tube.undeformed(model)
    if pressure > 0.0 and not _inflate(tube, pressure):
        raise DivergenceError(refusal.of_pressure(model, _largest_pressure(tube, pressure), tube.astray))
    free, residual = tube.copies(), tube.residual
    if model.pellet.present:
        _insert(tube, pressure, model.pellet.radius)
    return tube, free, max(residual, tube.residual)


def _refined(model: Model, pressure: float) -> tuple[Tube, list[Floats], float] | None:
    """The start on a fine grid from that on a quarter of its elements; None where it is not found so.

    Raises DivergenceError where there is none on the coarse grid.
    """
    grid = model.grid
    coarse = Grid(grid.length, grid.n_z, grid.n_z_wall // 4, 1, grid.n_theta_conduction, slack=grid.slack)
    wall = model.wall._replace(element_size=coarse.element_size)
    small, small_free, _ = _started(replace(model, grid=coarse, wall=wall), pressure)
    tube = Tube.undeformed(model)
    residual = 0.0
    stages = [(small_free, 0.0)]
    if model.pellet.present:
        stages.append((small.copies(), model.pellet.radius))
    free: list[Floats] = []
    for state, radius in stages:
        for k in range(2):
            tube.arrays()[k][:] = np.interp(grid.nodes, coarse.nodes, state[k])
        guess = tube.copies()
        if tube.settle(pressure, radius) not in AT_REST:
            tube.restore(guess)
            if not relax(tube, pressure, radius, FEWER_ITERATIONS):
                return None
        residual = max(residual, tube.residual)
        free = free or tube.copies()
    return tube, free, residual


def smoothing_pressure(model: Model) -> float:
    """Pressure [mN/cm^2] at which the undeformed tube is in equilibrium: the tension that (14) and (15) leave, / r0."""
    wall = model.wall
    return nominal_tensions(1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, wall)[1] / wall.radius


def _inflate(tube: Tube, pressure: float, most: int = MOST_ITERATIONS) -> bool:
    """The tube at a pressure: by Newton's method alone, or else from the undeformed tube by the wall's viscosity."""
    wall, nodes = tube.model.wall, tube.model.grid.nodes
    undeformed = tube.copies()
    gentle = min(pressure, GENTLE_PRESSURE)
    radius = inflated_radius(tube.model, gentle)
    if radius is not None:
        tube.rho += (radius - wall.radius) * (
            1.0 - np.exp(-nodes / END_LAYER) - np.exp(-(nodes[-1] - nodes) / END_LAYER)
        )
        tube.rho[0] = tube.rho[-1] = wall.radius
        if climb(lambda value: tube.settle(value, 0.0), tube, gentle, pressure, gentle)[0] >= pressure:
            return _is_even(tube) or _inflate_evenly(tube, pressure, undeformed, most)
    tube.restore(undeformed)
    return relax(tube, pressure, 0.0, most)


def _is_even(tube: Tube) -> bool:
    """Whether the tube is its own mirror image, as its wall, its ends and its pressure are."""
    return float(np.abs(tube.rho - tube.rho[::-1]).max()) < LOPSIDED


def _inflate_evenly(tube: Tube, pressure: float, undeformed: list[Floats], most: int) -> bool:
    """Let a tube that one leap of Newton's method has left lopsided be inflated gradually instead.

    A wall that the pressure lengthens beyond its clamped rings has several states of rest; which of the lopsided ones a
    leap ends in is chosen by rounding. The gradual way keeps the symmetry of the problem. If it fails, the first stays.
    """
    lopsided = tube.copies()
    tube.restore(undeformed)
    if not (relax(tube, pressure, 0.0, most) and _is_even(tube)):
        tube.restore(lopsided)
    return True


def _insert(tube: Tube, pressure: float, radius: float) -> None:
    """A pellet grown in the tube, in the same two ways. Raises DivergenceError if neither works."""
    free = tube.copies()
    start = min(radius, float(tube.rho.max()) - SMALLEST_RADIUS)
    reached = climb(lambda value: tube.settle(pressure, value), tube, start, radius, 0.02)[0]
    if reached >= radius:
        return
    if refusal.hoop_tension(tube.model.wall, radius) < refusal.LARGEST_TENSION:
        tube.restore(free)
        if relax(tube, pressure, radius):
            return
        tube.restore(free)
        reached = max(reached, _largest_radius(tube, pressure, radius))
    raise DivergenceError(refusal.of_pellet(tube.model, reached, tube.astray))


def relax(tube: Tube, pressure: float, radius: float, most: int = MOST_ITERATIONS) -> bool:
    """Let the wall go, at a pressure and around a pellet that grows to a radius, until it rests, Eq. (59).

    Leaves the last good state, at rest or not.
    """
    grown = 0.0 if radius == 0.0 else min(radius, (1.0 - 1e-6) * tube.room())
    step, tried = FIRST_STEP, 0.0
    speed = np.zeros(tube.rho.size)
    last = tube.iterations + most
    while tube.iterations < last and step > SHORTEST_STEP:
        kept, before = tube.copies(), tube.iterations
        larger = min(radius, grown + GROWTH * step)
        if tube.settle(pressure, larger, step, 40) not in AT_REST:
            tube.restore(kept)
            step *= 0.25
            continue
        speed = np.hypot(tube.rho - kept[0], tube.zeta - kept[1]) / step
        grown = larger
        taken = tube.iterations - before
        step *= 2.0 if taken < FEW else (0.7 if taken > MANY else 1.0)
        if grown == radius and step >= max(STILL, 2.0 * tried):
            kept, tried = tube.copies(), step
            if tube.settle(pressure, radius, 0.0, 60) in AT_REST:
                return True
            tube.restore(kept)
    tube.astray = tube.rho.copy(), tube.zeta.copy(), speed
    return False


def _largest_pressure(tube: Tube, pressure: float) -> float:
    """Largest pressure found at which the tube rests, below one at which it does not; minus infinity if none is."""
    undeformed = Tube.undeformed(tube.model).copies()

    def rests(value: float) -> bool:
        tube.restore(undeformed)
        return _inflate(tube, value, FEWER_ITERATIONS)

    low, high = 0.5 * pressure, pressure
    while not rests(low):
        low, high = 0.25 * low, low
        if low < LOWEST_SHARE * pressure:
            return -np.inf
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        if rests(middle):
            low = middle
        else:
            high = middle
    return low


def _largest_radius(tube: Tube, pressure: float, radius: float) -> float:
    """How large a pellet can be grown in a free tube at a pressure, on the way to a radius that finds no rest."""
    room = (1.0 - 1e-6) * tube.room()
    last = tube.iterations + MOST_TO_TELL

    def settle(value: float) -> int:
        most = min(FEWER_ITERATIONS, last - tube.iterations)
        return CONVERGED if relax(tube, pressure, value, most) else NOT_CONVERGED

    return climb(settle, tube, room, radius, (radius - room) / 8.0, 0.1)[0]


def climb(
    settle: Callable[[float], int], tube: Tube, start: float, target: float, step: float, finest: float = 1e-4
) -> tuple[float, int]:
    """Settle at `start`, then at growing values up to `target`, in steps that shrink where they fail.

    finest: share of `step` below which it gives up. Returns the value reached, minus infinity if not even the start
    was, and the last code of the solver.
    """
    least = finest * step
    kept = tube.copies()
    reached, value = -np.inf, start
    while True:
        code = settle(value)
        if code in AT_REST:
            kept = tube.copies()
            reached = value
            if reached >= target:
                return target, code
            value = min(target, reached + step)
            step *= 1.2
            continue
        tube.restore(kept)
        step *= 0.4
        if not np.isfinite(reached) or step < least:
            return reached, code
        value = min(target, reached + step)


def inflated_radius(model: Model, pressure: float) -> float | None:
    """Radius of the long passive tube at a pressure and longitudinal stretch 1: T_c = p rho (Laplace), Eq. (1).

    None if no stretch up to 4 holds it.
    """
    wall = model.wall

    def excess(stretch: float) -> float:
        return float(passive_tension(1.0, stretch, wall.passive)[1] - pressure * wall.radius * stretch)

    high = 1.0
    while excess(high) <= 0.0:
        high += 0.05
        if high > 4.0:
            return None
    return wall.radius * find_root(excess, 1.0, high)
