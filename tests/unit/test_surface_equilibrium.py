"""Verdicts of the solver on the whole surface: every way in which a step finds no equilibrium has its code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from peristalsis.model import surface_equilibrium, surface_step, surface_tangent, surface_update
from peristalsis.model.surface_equilibrium import SurfaceProblem, SurfaceVerdict, merit_of, solve_surface
from peristalsis.model.surface_residual import Trial
from peristalsis.model.surface_step import kinematics, try_surface_wall
from peristalsis.model.surface_update import newton_update
from peristalsis.model.verdicts import CONVERGED, NOT_CONVERGED, OUT_OF_RANGE, SINGULAR, Verdict
from peristalsis.wall.constants import SurfaceConstants
from verification.exact.runs import started
from verification.exact.surface_wall import widened

Floats = NDArray[np.float64]
COLUMNS = 4


class Posed(NamedTuple):
    """A step as the solver is handed it."""

    places: Floats
    density: Floats
    scalars: Floats
    problem: SurfaceProblem

    def solve(self, **changes: Any) -> SurfaceVerdict:
        """The verdict on this step with another problem; the arrays stay."""
        arrays = (self.places.copy(), self.density.copy(), self.scalars.copy())
        return solve_surface(*arrays, replace(self.problem, **changes))


def posed(pellet: bool = True) -> Posed:
    """The first step of a small tube whose muscle pulls."""
    kept: list[Posed] = []

    def noted(places: Floats, density: Floats, scalars: Floats, problem: SurfaceProblem) -> SurfaceVerdict:
        kept.append(Posed(places.copy(), density.copy(), scalars.copy(), problem))
        return SurfaceVerdict(NOT_CONVERGED, 0, 0, 0)

    model, state = started({"grid.n_z": 40, "grid.n_z_wall": 40, "pellet.enabled": pellet})
    wall = widened(state.wall, COLUMNS)
    drive = wall.drive + 1.0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(surface_step, "solve_surface", noted)
        code, found = try_surface_wall(
            model, wall, state.pellet, state.pressure, drive, 2e-3, SurfaceConstants(), mean_first=False
        )
    assert (code, found) == (NOT_CONVERGED, None)
    return kept[0]


@pytest.fixture(scope="module")
def step() -> Posed:
    return posed()


def test_the_step_itself_is_solved(step: Posed) -> None:
    verdict = step.solve()
    assert verdict.code == CONVERGED
    assert verdict.iterations > 0
    assert verdict.krylov >= verdict.iterations


def collapsed(places: Floats) -> Floats:
    """Every node of a ring at the place of the first."""
    return np.zeros_like(places)


def overstretched(places: Floats) -> Floats:
    """Wider than the exponent of the wall's energy allows."""
    return places * np.array([4.0, 4.0, 1.0])[None, :, None]


def torn(places: Floats) -> Floats:
    """Wider than any stretch that is looked at."""
    return places * np.array([60.0, 60.0, 1.0])[None, :, None]


@pytest.mark.parametrize("change", [collapsed, overstretched, torn])
def test_walls_out_of_range_have_no_merit(step: Posed, change: Callable[[Floats], Floats]) -> None:
    wrong = step._replace(places=change(step.places))
    assert wrong.solve() == (OUT_OF_RANGE, 0, 1, 0)
    assert merit_of(wrong.places, wrong.density, wrong.scalars, wrong.problem) == np.inf


def test_pellet_that_fills_the_tube_leaves_no_lumen(step: Posed) -> None:
    tube = np.pi * float(step.places[:, 0].max()) ** 2 * float(step.places[-1, 2].max())
    assert step.solve(pellet=step.problem.pellet._replace(volume=tube)) == (OUT_OF_RANGE, 0, 1, 0)


def test_forces_that_are_no_numbers_are_refused(step: Posed) -> None:
    assert step.solve(drive=np.full_like(step.problem.drive, np.nan)) == (OUT_OF_RANGE, 0, 1, 0)


def test_iterations_are_counted_to_their_limit(step: Posed) -> None:
    assert step.solve(max_iterations=0) == (NOT_CONVERGED, 0, 1, 0)
    one = step.solve(max_iterations=1, tolerance=1e-30)
    assert (one.code, one.iterations) == (NOT_CONVERGED, 1)


def test_search_that_finds_nothing_within_range_ends(step: Posed, monkeypatch: pytest.MonkeyPatch) -> None:
    """However short the step, the trial is out of range: halved down to the smallest, then given up."""

    def nowhere(trial: Trial, blocks: Floats, target: float) -> Any:
        return tuple(np.full_like(field, np.nan) for field in (trial.places, trial.density, trial.scalars)), 3

    monkeypatch.setattr(surface_equilibrium, "newton_update", nowhere)
    verdict = step.solve()
    halvings = int(np.ceil(np.log2(1.0 / surface_equilibrium.SMALLEST_STEP)))
    assert (verdict.code, verdict.iterations, verdict.krylov) == (OUT_OF_RANGE, 1, 3)
    assert verdict.assemblies == pytest.approx(2 + halvings, abs=1)


def test_singular_systems_are_noticed(step: Posed, monkeypatch: pytest.MonkeyPatch) -> None:
    """Borders that are no numbers, an average without stiffness, and a solution that is no number."""
    n, _, m = step.places.shape
    trial = Trial(step.problem, step.places.copy(), step.density.copy(), step.scalars.copy())
    assert trial.evaluate(1e-8)
    blocks = np.empty((n, 9, 3, 3, m))
    assert newton_update(trial, blocks, 1e-8) is not None
    trial.speed_slope = np.nan
    assert newton_update(trial, blocks, 1e-8) is None
    with monkeypatch.context() as patch:
        patch.setattr(surface_tangent, "add_edge_tangent", lambda edges, blocks: blocks.fill(np.nan))
        assert step.solve().code == SINGULAR

    real = surface_update.flexible_gmres

    def nothing(apply: Any, precondition: Any, start: Floats, target: float, most: int) -> Any:
        return real(apply, precondition, start, target, most)._replace(solution=np.full_like(start, np.nan))

    monkeypatch.setattr(surface_update, "flexible_gmres", nothing)
    assert step.solve() == (SINGULAR, 0, 1, 0)


@pytest.mark.parametrize("pellet", [True, False])
def test_inertia_adds_mass_times_acceleration(pellet: bool) -> None:
    """To the residual of every node but the held ones, and nothing else."""
    given = posed(pellet)
    rng = np.random.default_rng(5)
    moved, velocity = (given.places + 1e-3 * rng.normal(size=given.places.shape), rng.normal(size=given.places.shape))
    moved[[0, -1]] = given.places[[0, -1]]
    left = []
    wall = given.problem.wall._replace(surface_density=0.05)
    for inertia in (False, True):
        timed = replace(
            given.problem, wall=wall, velocity_history=velocity, step=given.problem.step._replace(inertia=inertia)
        )
        trial = Trial(timed, moved, given.density, given.scalars)
        assert trial.evaluate(1e-8)
        left.append(trial.residual.copy())
    slope = given.problem.step.slope
    acceleration = slope * ((moved - given.problem.history) * slope - velocity)
    expected = 0.05 * wall.element_size * acceleration
    assert np.allclose((left[1] - left[0])[1:-1], expected[1:-1], rtol=1e-9, atol=1e-9)
    assert not left[1][[0, -1]].any()


def test_surfaces_out_of_range_are_refused_before_anything_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wall whose nodes have met has no stretches, and no step begins from it."""
    model, state = started({"grid.n_z": 40, "grid.n_z_wall": 40})
    wall = widened(state.wall, COLUMNS)
    assert kinematics(model, np.zeros((41, 3, COLUMNS))) is None
    met = replace(wall, position=np.zeros_like(wall.position))
    monkeypatch.setattr(surface_step, "solve_surface", lambda *words: pytest.fail("solved"))
    found = try_surface_wall(model, met, state.pellet, state.pressure, wall.drive, 2e-3, SurfaceConstants())
    assert found == (OUT_OF_RANGE, None)


def test_mean_that_has_no_equilibrium_leaves_the_guess(monkeypatch: pytest.MonkeyPatch) -> None:
    """The axisymmetric solver helps where it can; where it fails, the surface begins from its own guess."""
    model, state = started({"grid.n_z": 40, "grid.n_z_wall": 40})
    wall = widened(state.wall, COLUMNS)
    words = (model, wall, state.pellet, state.pressure, wall.drive + 1.0, 2e-3, SurfaceConstants())
    _, alone = try_surface_wall(*words, mean_first=False)
    real = surface_step.solve_equilibrium

    def given_up(*arguments: Any) -> Verdict:
        real(*arguments)  # what it leaves in its arrays must not be used
        return Verdict(NOT_CONVERGED, 9, 9, 1.0)

    monkeypatch.setattr(surface_step, "solve_equilibrium", given_up)
    _, found = try_surface_wall(*words)
    assert alone is not None
    assert found is not None
    assert np.array_equal(found.wall.position, alone.wall.position)
    assert found.krylov == alone.krylov
