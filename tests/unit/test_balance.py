"""Work of a step, term by term, Eq. (29)."""

from dataclasses import replace

import numpy as np
import pytest

from peristalsis.model.balance import Momentum, Work
from peristalsis.model.step_summary import momentum_of_step, work_of_step
from verification.exact.runs import EXACT, IDLE, march, moved, started
from verification.exact.wall import discrete_energy, discrete_volume


def test_residual_is_stored_and_lost_less_given() -> None:
    """Each term once, with its sign."""
    assert Work(1.0, 10.0, 100.0, 1000.0, 1e4, 1e5).residual == 1e5 + 1e4 + 1000 + 100 - 10 - 1


def test_stored_energy_and_gas_are_differences_of_their_potentials() -> None:
    """Consistent convention: the passive work of a small deformation is that of W, the gas that of p V^1.4."""
    model, state = started(EXACT, IDLE)
    errors = []
    for size in (1e-2, 1e-3):
        position = state.wall.position.copy()
        position[1:-1, 0, 0] *= 1.0 + size * np.sin(np.pi * model.grid.nodes[1:-1] / 10.0)
        other = moved(state, position)
        work = work_of_step(model, state, other)
        x, y = (s.wall.position[:, 0, [0, 2]].ravel() for s in (state, other))
        unit = 2.0 * np.pi * model.wall.radius
        exact = unit * (discrete_energy(y, model.wall) - discrete_energy(x, model.wall))
        errors.append(abs(work.stored / exact - 1.0))
        v0, v1 = (discrete_volume(z) - model.pellet.volume for z in (x, y))
        gas = 10.0 * v0 / 0.4 * (1.0 - (v0 / v1) ** 0.4)
        assert work.gas == pytest.approx(gas, rel=1e-9)
        assert work.active == 0.0
    assert errors[1] <= 1e-4
    assert errors[1] <= 0.05 * errors[0], "the trapezoidal rule must close in"


def test_friction_takes_what_the_pellet_is_given() -> None:
    """Loss of the pellet = trapezoidal integral of F v, from the states alone."""
    taken = march(0.4)
    dt = taken.model.dt_wall
    lost = sum(
        work_of_step(taken.model, a, b).lost_pellet for a, b in zip(taken.states[1:-1], taken.states[2:], strict=True)
    )
    power = [s.pellet.axial_force * s.pellet.velocity for s in taken.states[1:]]
    assert lost == pytest.approx(float(np.trapezoid(power, dx=dt)), rel=1e-9)
    assert lost > 0.0


def test_held_pressure_does_linear_work() -> None:
    """Exponent 0 keeps the pressure: the gas gives p dV. Exponent 1 is the isothermal limit of both sides."""
    model, state = started(EXACT, IDLE, {"pellet.enabled": False, "lumen.adiabatic_exponent": 0.0})
    position = state.wall.position.copy()
    position[1:-1, 0, 0] *= 1.01
    work = work_of_step(model, state, moved(state, position))
    before, after = (discrete_volume(p[:, 0, [0, 2]].ravel()) for p in (state.wall.position, position))
    assert work.gas == pytest.approx(10.0 * (after - before), rel=1e-9)
    near, _ = started(EXACT, IDLE, {"pellet.enabled": False, "lumen.adiabatic_exponent": 1.0})
    isothermal = work_of_step(near, state, moved(state, position))
    assert isothermal.gas == pytest.approx(10.0 * before * np.log(after / before), rel=1e-9)


HEAVY = {"wall.inertia": True, "wall.surface_density": "26140 mg/cm^2", "pellet.friction_frame": "wall"}


def test_axial_momentum_balances_on_the_grid() -> None:
    """Eq. (52) with every term there: inertia of a heavy wall, and its share of the friction; 1e-9 of the largest."""
    taken = march(0.4, HEAVY, {"grid.n_z_wall": 200})
    terms = [momentum_of_step(taken.model, a, b) for a, b in zip(taken.states[:-1], taken.states[1:], strict=True)]
    largest = max(abs(value) for one in terms for value in one)
    assert largest > 50.0
    assert max(abs(one.residual) for one in terms) <= 1e-9 * largest


@pytest.mark.parametrize("term", Momentum._fields)
def test_axial_momentum_notices_a_wrong_sign(term: str) -> None:
    """Any one term with its sign turned leaves a thousand times the residual."""
    taken = march(0.4, HEAVY, {"grid.n_z_wall": 200})
    terms = [momentum_of_step(taken.model, a, b) for a, b in zip(taken.states[:-1], taken.states[1:], strict=True)]
    right = max(abs(one.residual) for one in terms)
    wrong = max(abs(one._replace(**{term: -getattr(one, term)}).residual) for one in terms)
    assert wrong > 1e3 * right


def test_cut_step_with_inertia_has_no_momentum() -> None:
    """What its rate is made of is gone; a number would be made up."""
    taken = march(0.02, HEAVY, {"grid.n_z_wall": 100})
    before, after = taken.states[-2:]
    cut = replace(after, wall=replace(after.wall, step_before=0.5 * taken.model.dt_wall))
    assert np.isnan(momentum_of_step(taken.model, before, cut).residual)
    assert np.isfinite(momentum_of_step(taken.model, before, after).residual)
