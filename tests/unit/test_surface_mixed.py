"""Newton's method with tensions as unknowns, and systems in single precision: one answer with the plain way."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.model import surface_mixed, surface_step
from peristalsis.model.model import Model
from peristalsis.model.scheme import Solved
from peristalsis.model.state import State
from peristalsis.model.surface_residual import Trial
from peristalsis.model.surface_step import kinematics, try_surface_wall
from peristalsis.model.verdicts import CONVERGED
from peristalsis.numerics.ring_blocks import pad
from peristalsis.running.simulation import Simulation
from peristalsis.wall.constants import SurfaceConstants
from peristalsis.wall.surface import load_edges, measure_edges, new_edges
from peristalsis.wall.surface_mixed import (
    carry_tensions,
    load_mixed_edges,
    new_corners,
    new_mixed_forces,
    tensions_of_state,
)
from verification.exact.runs import started
from verification.exact.surface_wall import widened

COLUMNS = 8


class Start(NamedTuple):
    """A state of a coupled run, and the drive at the end of its next step."""

    model: Model
    state: State
    drive: Any


@pytest.fixture(scope="module")
def start() -> Start:
    """A short tube that a pacemaker on one side has begun to pull together: rates, and slack beside taut wall."""
    given = {"grid.n_z": 60, "grid.n_z_wall": 40, "grid.n_theta": COLUMNS, "grid.n_theta_conduction": 32}
    simulation = Simulation(scenarios.configuration("point_pacemaker", changes=given))
    state = simulation.advance("60 ms")
    after = simulation.advance("2 ms")
    assert float(np.ptp(state.wall.position[:, :, 0], axis=1).max()) > 1e-3
    return Start(simulation.model, state, after.wall.drive)


def solved(start: Start, **changes: Any) -> Solved:
    model, state, drive = start
    code, found = try_surface_wall(
        replace(model, **changes), state.wall, state.pellet, state.pressure, drive, 2e-3, model.surface
    )
    assert code == CONVERGED
    assert found is not None
    return found


def test_answer_is_that_of_the_plain_method(start: Start) -> None:
    """At the tolerance of one column: every way to solve the step ends in one place."""
    tight = {"surface_tolerance": 1e-8}
    plain = solved(start, mixed_newton=False, coupled_modes=0, **tight)
    for changes in ({"mixed_newton": True, "coupled_modes": 0}, {"mixed_newton": True, "coupled_modes": 3}):
        found = solved(start, **changes, **tight)
        assert float(np.abs(found.wall.position - plain.wall.position).max()) <= 1e-8
        assert found.pellet.position == pytest.approx(plain.pellet.position, abs=1e-10)
        assert found.pressure == pytest.approx(plain.pressure, rel=1e-8)


def test_tolerance_of_the_surface_is_for_steps_that_vary(start: Start) -> None:
    """A loose one saves iterations and stays near; a ring-uniform step has that of one column, whatever is asked."""
    near = solved(start, surface_tolerance=1e-8)
    loose = solved(start, surface_tolerance=1e-2)
    assert loose.krylov < near.krylov
    assert 0.0 < float(np.abs(loose.wall.position - near.wall.position).max()) <= 1e-3
    round_model, fresh = started({"grid.n_z": 40, "grid.n_z_wall": 40})
    begun = replace(fresh, wall=widened(fresh.wall, COLUMNS))
    uniform = Start(replace(round_model, surface=SurfaceConstants()), begun, begun.wall.drive + 1.0)
    one, other = (solved(uniform, surface_tolerance=t) for t in (1e-8, 1e-2))
    assert np.array_equal(one.wall.position, other.wall.position)


def test_coupled_modes_save_krylov_iterations(start: Start) -> None:
    counts = [solved(start, coupled_modes=modes, surface_tolerance=1e-8).krylov for modes in (0, 3)]
    assert counts[1] < 0.6 * counts[0]


def test_line_search_takes_over_where_whole_updates_lead_nowhere(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    tight = {"surface_tolerance": 1e-8, "coupled_modes": 0}
    plain = surface_step.solve_surface
    used: list[int] = []

    def noted(*words: Any) -> Any:
        used.append(1)
        return plain(*words)

    monkeypatch.setattr(surface_mixed, "solve_surface", noted)
    usual = solved(start, **tight)
    assert not used
    monkeypatch.setattr(surface_mixed, "PATIENCE", 0)
    rescued = solved(start, **tight)
    assert used == [1]
    assert float(np.abs(rescued.wall.position - usual.wall.position).max()) <= 1e-8
    assert rescued.assemblies > 1


@pytest.mark.parametrize("published", [True, False])
def test_equations_made_linear_touch_the_true_ones(start: Start, published: bool) -> None:
    """With the tensions that the law makes of the stretches, forces and slopes are those of the plain method."""
    model, state, _ = start
    wall = model.wall._replace(published=published)
    places = surface_step.to_frames(state.wall.position)
    n, _, m = places.shape
    now = kinematics(model, places)
    assert now is not None
    padded, plain, mixed = np.empty((n, 3, m + 2)), new_edges(n, m), new_edges(n, m)
    corners, forces = new_corners(n, m), new_mixed_forces(n, m)
    pad(places, padded)
    assert measure_edges(padded, wall, plain)
    assert measure_edges(padded, wall, mixed)
    slope = 500.0
    history, hoops = now.stretch - state.wall.stretch_rate / slope, now.hoop - state.wall.hoop_rate / slope
    assert load_edges(plain, history, hoops, slope, state.wall.drive, wall)
    rates = (state.wall.stretch_rate, state.wall.hoop_rate)
    tensions_of_state(now.stretch, now.hoop, *rates, state.wall.drive, wall, corners.carried)
    assert load_mixed_edges(mixed, history, hoops, slope, state.wall.drive, wall, corners, forces)
    assert corners.carried == pytest.approx(corners.law, rel=1e-9, abs=1e-9)
    for name in ("axial_force", "hoop_force", "axial_slope", "hoop_slope", "lc", "cl"):
        one, other = getattr(plain, name), getattr(mixed, name)
        assert other == pytest.approx(one, rel=1e-9, abs=1e-9 * float(np.abs(one).max())), name
    largest = float(np.abs(plain.hoop_force).max())
    assert float(np.abs(forces.axial_missing).max()) <= 1e-9 * largest
    assert forces.hoop_carried == pytest.approx(plain.hoop_force, abs=1e-9 * largest)


def test_tensions_follow_their_law_to_first_order(start: Start) -> None:
    """What is carried along a small change of places differs from the law there to second order."""
    model, state, _ = start
    places = surface_step.to_frames(state.wall.position)
    n, _, m = places.shape
    now = kinematics(model, places)
    assert now is not None
    slope, drive = 500.0, state.wall.drive
    change = np.random.default_rng(3).normal(size=places.shape)
    change[[0, -1]] = 0.0
    errors = []
    for size in (1e-5, 1e-6):
        padded, edges = np.empty((n, 3, m + 2)), new_edges(n, m)
        corners, ahead, forces = new_corners(n, m), new_corners(n, m), new_mixed_forces(n, m)
        pad(places, padded)
        measure_edges(padded, model.wall, edges)
        load_mixed_edges(edges, now.stretch, now.hoop, slope, drive, model.wall, corners, forces)
        pad(size * change, padded)
        carry_tensions(edges, padded, model.wall, corners)
        pad(places + size * change, padded)
        measure_edges(padded, model.wall, edges)
        load_mixed_edges(edges, now.stretch, now.hoop, slope, drive, model.wall, ahead, forces)
        errors.append(float(np.abs(corners.carried - ahead.law).max()))
        assert float(np.abs(ahead.law - corners.law).max()) > 100.0 * errors[-1]
    assert errors[1] <= 0.02 * errors[0]


def test_residual_that_decides_is_the_true_one(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    """A state is accepted by the forces of the law, whatever the carried tensions say."""
    kept: list[Any] = []
    whole = surface_mixed.solve_mixed

    def noted(places: Any, density: Any, scalars: Any, tensions: Any, problem: Any) -> Any:
        verdict = whole(places, density, scalars, tensions, problem)
        trial = Trial(problem, places.copy(), density.copy(), scalars.copy())
        assert trial.evaluate(problem.tolerance)
        kept.append(trial.worst)
        return verdict

    monkeypatch.setattr(surface_step, "solve_mixed", noted)
    solved(start, surface_tolerance=1e-6)
    assert kept[0] <= 1e-6
