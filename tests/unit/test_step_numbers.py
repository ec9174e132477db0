"""Numbers of a step: work by part, ends, slack, contact, momentum, each against an independent calculation."""

from dataclasses import replace

import numpy as np
import pytest

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.bookkeeping import numbers_of_step, reactions, touch, wall_work
from peristalsis.model.constants import packed
from peristalsis.model.fields import end_reactions
from peristalsis.model.initial import initial_state
from peristalsis.model.state import WallState
from peristalsis.model.step import advance
from peristalsis.model.step_summary import momentum_of_step, work_of_step
from verification.exact.runs import IDLE, march, started
from verification.exact.wall import COUPLED, assembled, wall_constants

ELEMENTS = 24


def placed(rho: np.ndarray, zeta: np.ndarray, drive: np.ndarray, columns: int = 1) -> WallState:
    """A wall at rest with nodes at these places of one column; drives (2, 2n - 2)."""
    n = rho.size
    position = np.zeros((n, columns, 3))
    position[:, :, 0], position[:, :, 2] = rho[:, None], zeta[:, None]
    position[:, :, 1] = 2.0 * np.pi * np.arange(columns) / columns
    still, nodes, elements = np.zeros((n, columns, 3)), np.zeros((n, columns)), np.zeros((n - 1, columns))
    drives = np.repeat(drive[:, :, None], columns, axis=2)
    return WallState(position, position, still, still, nodes, elements, nodes, drives, 0.0)


@pytest.mark.parametrize("published", [False, True])
def test_work_on_the_wall_is_that_of_its_forces(published: bool) -> None:
    """All parts together are force times way of the nodes, whichever tension Eq. (35) means."""
    wall = wall_constants(ELEMENTS, 2.0, passive=COUPLED, published=published, bending_stiffness=1e-3)
    rng, n = np.random.default_rng(9), ELEMENTS + 1
    rho, zeta = 1.0 + 0.03 * rng.normal(size=n), 1.25 * np.linspace(0.0, 2.0, n)
    drive = rng.uniform(0.0, 0.5, (2, 2 * n - 2))
    way = rng.normal(size=(2, n))
    way[:, [0, -1]] = 0.0
    errors = []
    for size in (1e-4, 1e-5):
        places = [(rho + sign * size * way[0], zeta + sign * size * way[1]) for sign in (-1.0, 1.0)]
        found = wall_work(*(placed(*place, drive).arrays for place in places), packed(wall))
        total = found.passive + found.active + found.viscous + found.floor
        forces, _ = assembled(rho, zeta, wall, drives=(drive[0], drive[1]))
        exact = 2.0 * np.pi * wall.radius * float((forces.reshape(-1, 2).T * 2.0 * size * way).sum())
        errors.append(abs(total / exact - 1.0))
    assert errors[1] <= 1e-5
    assert errors[1] <= 0.05 * errors[0], "the trapezoidal rule must close in"


@pytest.mark.parametrize("columns", [1, 5])
@pytest.mark.parametrize(("along", "around"), [(0.95, 1.05), (1.05, 0.95)])
def test_slack_share_is_that_of_the_length_without_tension(columns: int, along: float, around: float) -> None:
    """A quarter of the tube compressed along itself, or around: slack where one tension alone is gone."""
    wall = wall_constants(ELEMENTS, 2.0)
    stretch = np.where(np.arange(ELEMENTS) < ELEMENTS // 4, along, 1.05)
    hoop = np.where(np.arange(ELEMENTS + 1) < ELEMENTS // 4, around, 1.05)
    steps = np.sqrt((stretch * wall.element_size) ** 2 - np.diff(hoop * wall.radius) ** 2)
    zeta = np.concatenate([[0.0], np.cumsum(steps)])
    state = placed(hoop * wall.radius, zeta, np.zeros((2, 2 * ELEMENTS)), columns)
    *_, share = end_reactions(state, wall, 0.0)
    assert share == pytest.approx(0.25, abs=0.6 / ELEMENTS), "to one corner"


def test_numbers_of_a_step_are_those_told_one_by_one() -> None:
    """The one pass after every step gives what each of its parts gives."""
    taken = march(0.3, {"grid.n_z_wall": 200})
    model, (before, after) = taken.model, taken.states[-2:]
    wall = packed(model.wall)
    old, new, centre = before.wall.arrays, after.wall.arrays, after.pellet.position
    numbers = numbers_of_step(old, new, after.pressure, centre, packed(model.pellet), wall)
    for name, alone in (
        ("work", wall_work(old, new, wall)),
        ("ends", reactions(new, after.pressure, wall)),
        ("contact", touch(new, centre, packed(model.pellet), wall)),
    ):
        together = getattr(numbers, name)
        assert together._fields == alone._fields
        assert together == pytest.approx(alone, rel=1e-12, abs=1e-12)
    assert numbers.contact.normal_force > 0.0


def test_pellet_dragged_across_the_axis_loses_force_times_way() -> None:
    """On the whole surface: its coefficient times the square of the way over the time of the step, added once."""
    model, state = started(IDLE, {"grid.n_z": 40, "grid.n_z_wall": 40, "grid.n_theta": 8, "pellet.sideways": "free"})
    coefficient = model.sideways_friction
    assert coefficient is not None
    aside = replace(state, pellet=replace(state.pellet, across=(0.003, -0.004)))
    kept, moved = (work_of_step(model, state, after).lost_pellet for after in (state, aside))
    assert moved - kept == pytest.approx(coefficient * 0.005**2 / model.dt_wall, rel=1e-12)
    assert moved > kept


def test_axial_momentum_balances_in_the_explicit_scheme() -> None:
    """Eq. (52) of a heavy wall without implicit solves: its own acceleration closes the balance."""
    heavy = {"solver.integrator": "explicit", "wall.surface_density": "26.14 g/cm^2"}
    changes = heavy | {"grid.n_z": 200, "grid.n_z_wall": 50}
    model, state, _ = initial_state(build(Configuration().with_changes(changes)))
    terms = []
    for _ in range(60):
        before, (state, _) = state, advance(model, state)
        terms.append(momentum_of_step(model, before, state))
    moving = max(abs(one.inertia) for one in terms)
    assert moving > 0.1
    assert max(abs(one.residual) for one in terms) <= 1e-5 * moving
