"""One step of wall, lumen and pellet: what its answer fulfils, how fast it is found, and when it is taken for found."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from peristalsis.geometry.tube import lumen_volume
from peristalsis.model import problem
from peristalsis.model.constants import LumenConstants, PelletConstants, Step
from peristalsis.model.equilibrium import History, solve_equilibrium
from peristalsis.model.problem import GAP, TOUCHES, WORK, Limits, Problem
from peristalsis.model.residual import measure
from peristalsis.model.verdicts import CONVERGED, GAP_SCALE, TENSION_SCALE
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere
from peristalsis.pellet.shapes.sphere import volume
from peristalsis.wall.assembly import FORCE_R, FORCE_Z
from verification.exact.wall import COUPLED, settle, wall_constants

Floats = np.ndarray

LENGTH, ELEMENTS, SPHERE, CENTRE, PRESSURE = 3.0, 60, 1.0, 1.6, 3.0
WALL = wall_constants(ELEMENTS, LENGTH, passive=COUPLED, published=True, bending_stiffness=1e-3, bending_viscosity=1e-4)
CIRCUMFERENCE = 2.0 * np.pi * WALL.radius
DT = 0.02


@dataclass(frozen=True)
class Unknowns:
    """Nodes [cm], contact [mN/cm^2] and (p, Z, F)."""

    rho: Floats
    zeta: Floats
    density: Floats
    scalars: Floats

    def copy(self) -> "Unknowns":
        """The same numbers, to be written to."""
        return Unknowns(*(part.copy() for part in self.parts))

    @property
    def parts(self) -> tuple[Floats, ...]:
        """All arrays."""
        return self.rho, self.zeta, self.density, self.scalars

    def away_from(self, other: "Unknowns") -> Floats:
        """Largest difference of each kind, the scalars one by one."""
        fields = [np.abs(a - b).max() for a, b in zip(self.parts[:3], other.parts[:3], strict=True)]
        return np.array([*fields, *np.abs(self.scalars - other.scalars)])


@cache
def on_the_pellet() -> Unknowns:
    """A tube at rest around a pellet that is wider than it."""
    n, none = ELEMENTS + 1, np.zeros(ELEMENTS + 1)
    found = Unknowns(
        np.full(n, WALL.radius), np.linspace(0.0, 1.1 * LENGTH, n), none.copy(), np.array([PRESSURE, CENTRE, 0.0])
    )
    for radius in np.linspace(0.8, SPHERE, 8):
        code, *_ = solve_equilibrium(
            problem.Unknowns(*found.parts),
            History(np.zeros((2, n)), np.zeros((2, n)), np.ones(n - 1), np.ones(n)),
            np.zeros((2, 2 * n - 2)),
            none,
            Step(0.0, False, CENTRE, 0.0),
            WALL,
            pellet_of(Sphere(radius)),
            LumenConstants(PRESSURE, 1.0, 0.0),
            Limits(1e-9, 1e-10, 50),
        )
        assert code == CONVERGED
    assert (found.density > 0.0).sum() > 10
    return found


@dataclass(frozen=True)
class Squeeze:
    """A step in which muscle behind the pellet comes to pull, from the tube at rest around it."""

    frame: float = 1.0
    tangential: bool = True
    dry: float = 2.0
    inertia: bool = True

    @property
    def pellet(self) -> PelletConstants:
        """The pellet and its friction."""
        return pellet_of(Sphere(SPHERE), viscous=50.0, dry=self.dry, frame=self.frame, tangential=self.tangential)

    @property
    def weight(self) -> Floats:
        """Shares of the friction: of touching nodes, and of some on either side that do not touch."""
        touching = np.flatnonzero(on_the_pellet().density > 0.0)
        weight = np.zeros(ELEMENTS + 1)
        weight[touching[0] - 4 : touching[-1] + 5] = np.random.default_rng(6).uniform(0.5, 1.5, touching.size + 8)
        return weight / weight.sum()

    @property
    def lumen(self) -> LumenConstants:
        """Gas at its pressure in the tube at rest."""
        start = on_the_pellet()
        return LumenConstants(PRESSURE, lumen_volume(start.rho, start.zeta) - volume(Sphere(SPHERE)), 1.4)

    def solve(
        self, trial: Unknowns, tolerance: float = 1e-10, gap_tolerance: float = 1e-12, most: int = 40
    ) -> tuple[int, int]:
        """(code, iterations) from a trial state, which becomes the answer."""
        start = on_the_pellet()
        corners = np.repeat(start.zeta, 2)[1:-1]
        stretch = np.hypot(np.diff(start.rho), np.diff(start.zeta)) / WALL.element_size
        places, still = np.stack([start.rho, start.zeta]), np.zeros((2, ELEMENTS + 1))
        pulls = 0.3 * np.exp(-(((corners - 1.9) / 0.5) ** 2)), 2.0 * np.exp(-(((corners - 1.1) / 0.3) ** 2))
        code, iterations, *_ = solve_equilibrium(
            problem.Unknowns(*trial.parts),
            History(places, still, stretch, start.rho / WALL.radius),
            np.stack(pulls),
            self.weight,
            Step(1.0 / DT, self.inertia, CENTRE, DT),
            WALL,
            self.pellet,
            self.lumen,
            Limits(tolerance, gap_tolerance, most),
        )
        return code, iterations


@cache
def answer(squeeze: Squeeze) -> Unknowns:
    """The end of the step."""
    found = on_the_pellet().copy()
    code, iterations = squeeze.solve(found)
    assert code == CONVERGED
    assert iterations > 0
    return found


def beside(found: Unknowns, size: float) -> Unknowns:
    """A state at about this distance [cm] from another, on the same nodes of the pellet."""
    rng, trial, touching = np.random.default_rng(7), found.copy(), found.density > 0.0
    for places in (trial.rho, trial.zeta):
        places[1:-1] += size * rng.normal(size=ELEMENTS - 1)
    trial.density[touching] *= 1.0 + 100.0 * size * rng.normal(size=touching.sum())
    trial.scalars[:] += size * np.array([100.0, 3.0, 100.0])
    return trial


CASES = [
    Squeeze(),
    Squeeze(inertia=False),
    Squeeze(tangential=False),
    Squeeze(frame=0.0, tangential=False),
    Squeeze(dry=1e4),
]
NAMES = ["tangential", "massless", "axial", "at rest", "sticking"]


@pytest.mark.parametrize("squeeze", CASES, ids=NAMES)
def test_the_answer_is_in_balance(squeeze: Squeeze) -> None:
    """Lumen, force on the pellet and motion of the pellet, written here by hand; shares of free nodes count."""
    found, start = answer(squeeze), on_the_pellet()
    pressure, centre, force = found.scalars
    lumen, axial = squeeze.lumen, found.zeta - centre
    space = lumen_volume(found.rho, found.zeta) - volume(Sphere(SPHERE))
    assert pressure == pytest.approx(PRESSURE * (lumen.reference_volume / space) ** 1.4, rel=1e-9)
    pushed = -CIRCUMFERENCE * WALL.element_size * (found.density * axial / np.hypot(found.rho, axial)).sum()
    assert force == pytest.approx(pushed, rel=1e-8)
    sliding = np.sign(force) * max(0.0, abs(force) - squeeze.dry) / 50.0
    carried = float((squeeze.weight * (found.zeta - start.zeta)).sum()) / DT
    assert centre - CENTRE == pytest.approx(DT * (squeeze.frame * carried + sliding), abs=1e-11)
    free = (squeeze.weight > 0.0) & (found.density == 0.0)
    assert np.abs((squeeze.weight * (found.zeta - start.zeta))[free].sum()) > 1e-6


@pytest.mark.parametrize("squeeze", CASES, ids=NAMES)
def test_what_an_update_leaves_is_quadratic(squeeze: Squeeze) -> None:
    """Newton's method with the whole tangent: of a tenth of the distance, an update leaves a tenth of the share."""
    found = answer(squeeze).copy()
    squeeze.solve(found, 1e-14, 1e-15, 3)
    left = []
    for size in (1e-6, 1e-7):
        trial = beside(found, size)
        begin = trial.away_from(found)
        squeeze.solve(trial, 1e-14, 1e-15, 1)
        left.append(trial.away_from(found) / begin)
    assert left[0].max() <= 0.1
    assert (left[1] <= 0.12 * left[0]).all(), left


@pytest.mark.parametrize(("asked", "taken"), [(1e-5, True), (1e-9, False)])
def test_touching_nodes_are_as_near_as_asked(asked: float, taken: bool) -> None:
    """A gap of 1e-6 cm is accepted or closed by what is asked for gaps, however little is asked for forces."""
    squeeze, trial = Squeeze(), answer(Squeeze()).copy()
    touching = trial.density > 0.0
    for places, centre in ((trial.rho, 0.0), (trial.zeta, trial.scalars[1])):
        places[touching] += 1e-6 * (places[touching] - centre) / SPHERE
    code, iterations = squeeze.solve(trial, 1e-2, asked)
    assert code == CONVERGED
    assert (iterations == 0) is taken
    gap = np.hypot(trial.rho, trial.zeta - trial.scalars[1])[touching] - SPHERE
    assert np.abs(gap).max() <= asked


def test_residuals_are_weighed_by_their_units() -> None:
    """The sum has forces over 10 mN/cm of an element, and gaps and leftover contact on that scale; the largest, what
    acceptance allows of each."""
    n, unit, tolerance, gap_tolerance = 9, TENSION_SCALE * WALL.element_size / WALL.radius, 1e-3, 1e-6
    squeeze, step, limits = Squeeze(), Step(1.0 / DT, True, CENTRE, DT), Limits(tolerance, gap_tolerance, 5)
    known = np.zeros((problem.KNOWN, n))
    given = Problem(known, WALL, squeeze.pellet, squeeze.lumen, step, limits, unit, CIRCUMFERENCE)
    rng = np.random.default_rng(8)
    for forces, gaps, leftover in ((3.0, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 2.0), (1.0, 1e-3, 0.5)):
        work, density = np.full((WORK, n), np.nan), np.zeros(n)
        work[FORCE_R], work[FORCE_Z] = forces * rng.normal(size=(2, n))
        work[TOUCHES], work[GAP] = 0.0, gaps * rng.normal(size=n)
        work[TOUCHES, 3:5] = 1.0
        density[6] = leftover
        total, worst = measure(density, given, 1, n - 2, work)
        force = work[FORCE_R : FORCE_Z + 1, 1:-1] / unit
        gap, left = work[GAP, 3:5], leftover * WALL.radius / TENSION_SCALE
        squares = (force**2).sum() + (gap**2).sum() * (GAP_SCALE / TENSION_SCALE) ** 2 + left**2
        assert total == pytest.approx(squares, rel=1e-12)
        assert worst == pytest.approx(
            max(np.abs(force).max(), np.abs(gap).max() * tolerance / gap_tolerance, left), rel=1e-12
        )


def inflated(*pressures: float) -> tuple[Floats, list[int]]:
    """Radii of a tube under the last of these pressures [mN/cm^2], put on one after the other; iterations for each."""
    wall = wall_constants(ELEMENTS, 6.0, passive=COUPLED)
    rho, zeta = np.full(ELEMENTS + 1, wall.radius), np.linspace(0.0, 6.3, ELEMENTS + 1)
    return rho, [settle(rho, zeta, pressure, wall) for pressure in pressures]


@pytest.mark.parametrize("pressure", [25.0, 27.0])
def test_a_load_put_on_at_once_is_found_by_shorter_updates(pressure: float) -> None:
    """The whole first update passes far beyond a wall that stiffens; shortened, a few lead where a slow load does."""
    at_once, (count,) = inflated(pressure)
    slowly, _ = inflated(*np.linspace(2.0, pressure, 12))
    assert at_once.max() > 1.3 * at_once[0]
    assert at_once == pytest.approx(slowly, abs=1e-8)
    assert count <= 14
