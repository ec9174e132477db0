"""The explicit scheme: its forces, its orders, its limits from both sides, and how runs with it behave."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli.inputs import Input
from peristalsis.errors import ConfigurationError, DivergenceError
from peristalsis.inputs.build import build
from peristalsis.inputs.preflight import Effort, expected_effort
from peristalsis.model.explicit import marching as explicit_step
from peristalsis.model.explicit.limits import Limits, limits
from peristalsis.model.guards import advance_safely
from peristalsis.model.initial import initial_state
from peristalsis.model.model import ExplicitScheme, Model
from peristalsis.model.state import State
from peristalsis.model.step import advance
from peristalsis.storing.checkpoint import Checkpoints, newest
from peristalsis.storing.store import Workspace
from peristalsis.tissue.cells import plant
from peristalsis.tissue.explicit_sheet import Excitable, excite
from peristalsis.wall.explicit import INSIDE, add_bending_forces, add_pressure_forces, add_tension_forces
from verification.exact.runs import PLAIN, started
from verification.exact.wall import assembled

HEAVY = {"solver.integrator": "explicit", "wall.surface_density": "26.14 g/cm^2"}
SMALL = PLAIN | HEAVY | {"grid.n_z": 200, "grid.n_z_wall": 50}


def begun(changes: dict[str, Any]) -> tuple[Model, State]:
    """Model and state before t = 0."""
    model, state, _ = initial_state(build(ps.Configuration().with_changes(changes)))
    return model, state


def stepped(model: Model, dt: float, micro: int, predicted: bool = False) -> Model:
    """The model with wall steps of one conduction step of `micro` micro-steps of dt [s]."""
    assert model.explicit is not None
    scheme = model.explicit._replace(micro=micro, predicted=predicted)
    return replace(model, dt_wall=micro * dt, substeps=1, explicit=scheme)


@pytest.mark.parametrize("tension", ["published", "consistent"])
def test_forces_are_those_of_the_implicit_wall(tension: str) -> None:
    model, _ = begun(
        SMALL | {"wall.tension": tension, "wall.bending_viscosity": "0.01 mN*s*cm", "pellet.enabled": False}
    )
    wall, n, slope = model.wall, 51, 300.0
    rng = np.random.default_rng(1)
    rho, zeta = wall.radius * rng.uniform(0.15, 1.2, n), np.linspace(0.0, 8.0, n) + 0.05 * rng.standard_normal(n)
    rate = rng.standard_normal((2, n))
    drive = rng.uniform(0.0, 40.0, (2, 2 * n - 2))
    force, stretch_rate = np.zeros((2, n)), np.empty(n - 1)
    assert add_tension_forces(rho, zeta, *rate, *drive, wall, *force, stretch_rate) == INSIDE
    add_bending_forces(rho, zeta, *rate, wall, *force)
    add_pressure_forces(rho, zeta, 12.0, wall, *force)
    # The implicit wall forms rates from its past: give it one that has the same rates.
    before = np.stack([rho, zeta]) - rate / slope
    length = np.hypot(np.diff(rho), np.diff(zeta)) / wall.element_size
    histories = length - stretch_rate / slope, before[0] / wall.radius
    residual, _ = assembled(rho, zeta, wall, slope, histories, (drive[0], drive[1]), before, 12.0)
    inner = (force + residual.reshape(n, 2).T)[:, 1:-1]
    assert np.abs(inner).max() < 1e-11 * np.abs(residual).max()


RIPPLE = {
    "solver.integrator": "explicit",
    "grid.n_z": 40,
    "grid.n_z_wall": 40,
    "pellet.enabled": False,
    "pacemaker.kind": "none",
    "wall.tension": "consistent",
    "wall.slack_blend": "0 mN/cm",  # slack would bound what grows
}
ANY = Limits(*5 * (math.inf,))


def growth(ratio: float, predicted: bool, viscosity: str, count: int = 300) -> float:
    """Factor by which the fastest ripple of the resting tube grows in steps of `ratio` times the limit."""
    model, state = begun(RIPPLE | {"wall.viscosity": viscosity})
    assert model.explicit is not None
    model = replace(model, explicit=model.explicit._replace(predicted=predicted))
    still, ripple = state, np.zeros_like(state.wall.velocity)
    ripple[1:-1, 0, 2] = 1e-6 * (-1.0) ** np.arange(39)
    state = replace(state, wall=replace(state.wall, velocity=ripple))
    model = stepped(model, ratio * limits(model, still).wall, count, predicted)
    ends = [advance(model, one)[0].wall.velocity[:, 0, 2] for one in (still, state)]
    return float(np.abs(ends[1] - ends[0]).max() / 1e-6)


@pytest.mark.parametrize(
    ("predicted", "viscosity"),
    [(False, "33.3 mN*s/cm"), (True, "33.3 mN*s/cm"), (False, "1e-6 mN*s/cm"), (False, "0.05 mN*s/cm")],
    ids=["dashpot", "dashpot, predicted", "wave", "both"],
)
def test_limit_of_stability_from_both_sides(predicted: bool, viscosity: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explicit_step, "limits", lambda *_: ANY)  # or the step would be refused
    assert growth(0.9, predicted, viscosity) < 1.5
    with suppress(DivergenceError):  # it may grow until a stretch is out of range
        assert growth(1.1, predicted, viscosity, 150) > 100.0


def test_what_blows_up_is_caught_in_the_middle_of_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explicit_step, "limits", lambda *_: ANY)
    with pytest.raises(DivergenceError, match=r"wall position: a stretch went out of range near z = .*explicit steps"):
        growth(1.1, False, "33.3 mN*s/cm", 4000)


def test_dashpot_limit_is_that_of_the_documents() -> None:
    for density, expected in (("26.14 mg/cm^2", 3.92e-8), ("26.14 g/cm^2", 3.92e-5)):
        model, state = begun(
            RIPPLE | {"wall.surface_density": density, "grid.n_z_wall": 100, "lumen.pressure": "0 kPa"}
        )
        assert limits(model, state).dashpot == pytest.approx(expected, rel=0.005)


def test_step_beyond_the_limit_is_not_made_and_the_guard_says_so() -> None:
    model, state = begun(SMALL)
    beyond = stepped(model, 1.1 * limits(model, state).least, 400)
    with pytest.raises(DivergenceError, match=r"the explicit step of .* is beyond the limit"):
        advance(beyond, state)
    # Made in halves the same wall step is stable: the guard makes it so and tells.
    after, report = advance_safely(beyond, state)
    assert "beyond the limit" in report.halved
    assert np.isfinite(after.wall.position).all()


def test_step_within_the_limit_runs() -> None:
    model, state = begun(SMALL)
    within = stepped(model, 0.9 * limits(model, state).least, 100)
    for _ in range(5):
        state, report = advance_safely(within, state)
        assert report.halved == ""


WAVE = {
    "solver.integrator": "explicit",
    "grid.n_z": 8,
    "pellet.enabled": False,
    "pacemaker.kind": "none",
    "lumen.pressure": "0 kPa",
    "wall.tension": "consistent",
    "wall.slack_blend": "0 mN/cm",
    "wall.c3": "0 mN/cm",
    "wall.c10": "0 mN/cm",
    "wall.bending_stiffness": "0 mN*cm",
    "wall.bending_viscosity": "0 mN*s*cm",
}
AMPLITUDE, TIME = 0.1, 0.05


def wave_error(elements: int, micro: int, viscosity: float, predicted: bool, on_grid: bool) -> float:
    """Error of an axial standing wave of the tube, over its amplitude; the wall's equation is linear for it.

    on_grid: against the exact motion of the grid, so that only the error in time is left.
    """
    model, state = begun(WAVE | {"grid.n_z_wall": elements})
    model = replace(model, wall=model.wall._replace(viscosity=viscosity))
    h, density, stiffness = model.grid.element_size, model.wall.surface_density, model.wall.passive.c1
    q = math.pi / model.grid.length
    square = (2.0 / h * math.sin(0.5 * q * h)) ** 2 if on_grid else q * q
    shape = np.sin(q * model.grid.nodes)
    position = state.wall.position.copy()
    position[:, 0, 2] += AMPLITUDE * shape
    position[[0, -1]] = state.wall.position[[0, -1]]
    state = replace(state, wall=replace(state.wall, position=position, position_before=position))
    after, _ = advance(stepped(model, TIME / micro, micro, predicted), state)
    decay = 0.5 * viscosity * square / density
    omega = math.sqrt(stiffness * square / density - decay * decay)
    motion = math.exp(-decay * TIME) * (math.cos(omega * TIME) + decay / omega * math.sin(omega * TIME))
    found = after.wall.position[:, 0, 2] - model.grid.nodes
    return float(np.abs(found - AMPLITUDE * motion * shape).max() / AMPLITUDE)


def order(errors: list[float]) -> list[float]:
    """Observed orders between levels that halve the step."""
    return [math.log2(coarse / fine) for coarse, fine in pairwise(errors)]


@pytest.mark.parametrize(
    ("viscosity", "predicted", "micro", "expected", "largest"),
    [(0.0, False, 100, 2.0, 2e-5), (0.2, True, 800, 2.0, 1e-5), (0.2, False, 800, 1.0, 2e-3)],
    ids=["without viscosity", "viscous, predicted", "viscous, lagged"],
)
def test_order_in_time(viscosity: float, predicted: bool, micro: int, expected: float, largest: float) -> None:
    errors = [wave_error(16, micro * 2**k, viscosity, predicted, on_grid=True) for k in range(4)]
    assert all(abs(found - expected) < 0.1 for found in order(errors))
    assert errors[-1] < largest


def test_order_in_space() -> None:
    errors = [wave_error(n, 6000, 0.02, True, on_grid=False) for n in (16, 32, 64, 128)]
    assert all(abs(found - 2.0) < 0.1 for found in order(errors))
    assert errors[-1] < 1e-5


CELLS = plant.CellConstants(30.0, -75.0, -40.0, 0.5, 0.0003, 0.0085, 140.0, 12.5, 235.0, 1.0, 0.125)


def cable_error(cells: int, steps: int, on_grid: bool) -> float:
    """Error of a decaying mode of a passive cable of 1 cm after 20 ms, over its amplitude: E1."""
    diffusivity, leak, time, mode = 2e-4, 0.08, 20.0, 3.0 * math.pi
    h = 1.0 / cells
    z = (np.arange(cells) + 0.5) * h
    conductances = np.zeros((5, cells))
    conductances[plant.LEAK] = leak
    gates = np.zeros((4, cells))
    v = -40.0 + np.cos(mode * z)
    none = np.zeros(cells)
    spread = np.full(cells - 1, diffusivity / h**2)
    unset = np.full(cells, np.nan)
    sheet = Excitable(v, gates, unset, unset.copy(), conductances, spread, none, none, none, -55.0, 1)
    cubed, work, dt = np.zeros((1, cells)), np.empty((6, cells)), time / steps
    table = plant.gate_table(dt, CELLS)
    for step in range(steps):
        bad = excite(sheet, np.ones(cells - 1), step * dt, dt, CELLS, table, False, -20.0, cubed, work)
        assert bad < 0
    square = (2.0 / h * math.sin(0.5 * mode * h)) ** 2 if on_grid else mode**2
    rate = diffusivity * square + 0.125 * leak
    if on_grid and steps <= 8:  # Heun's own factor, to rounding
        factor = (1.0 - rate * dt + 0.5 * (rate * dt) ** 2) ** steps
        assert np.abs(v + 40.0 - factor * np.cos(mode * z)).max() < 1e-12
    return float(np.abs(v + 40.0 - math.exp(-rate * time) * np.cos(mode * z)).max())


def test_conduction_is_of_second_order_in_space_and_time() -> None:
    in_time = [cable_error(30, steps, on_grid=True) for steps in (8, 16, 32, 64)]
    in_space = [cable_error(cells, 4000, on_grid=False) for cells in (15, 30, 60, 120)]
    assert all(abs(found - 2.0) < 0.1 for found in (*order(in_time), *order(in_space)))


def test_nothing_moves_without_a_stimulus() -> None:
    """The contact's spring lets the pellet in by some micrometres; else the start is a rest."""
    result = ps.run("baseline", SMALL | {"pacemaker.kind": "none", "reflex.enabled": False, "run.duration": "0.1 s"})
    data = result.dataset
    assert result.status == "in_transit"
    assert np.ptp(data["pellet_position"].values) == 0.0
    assert np.abs(data["radius"].values - data["radius"].values[0]).max() < 2e-4
    assert result.arrays["smallest_gap"].min() > -1e-4


def test_follows_the_implicit_wall_with_inertia() -> None:
    """The same wall forces, two integrators, cells fine enough for both operators: one run."""
    changes = {"grid.n_z": 1000, "grid.n_z_wall": 50, "wall.surface_density": "26.14 g/cm^2", "run.duration": "0.6 s"}
    changes |= PLAIN | {"step.wall": "1 ms"}
    explicit = ps.run("baseline", HEAVY | changes)
    implicit = ps.run("baseline", changes | {"wall.inertia": True})
    apart = np.abs(explicit.arrays["pellet_position"] - implicit.arrays["pellet_position"]).max()
    travel = abs(implicit.arrays["pellet_position"][-1] - implicit.arrays["pellet_position"][0])
    assert travel > 0.1
    assert apart < 0.03 * travel
    assert explicit.summary["power_residual"] < 2e-3
    assert explicit.summary["momentum_residual"] < 1e-5
    assert explicit.arrays["newton_iterations"].max() == 0


WALL_FRAME = {"pellet.friction_frame": "wall"}


@pytest.mark.parametrize(
    ("changes", "power"),
    [(WALL_FRAME, 5e-3), ({"pellet.friction_coefficient": 0.1, "pellet.static_friction_factor": 1.5}, 5e-3)],
    ids=["moving wall", "Coulomb and static"],
)
def test_friction_laws_keep_the_balances(changes: dict[str, Any], power: float) -> None:
    result = ps.run("baseline", SMALL | changes | {"run.duration": "0.3 s"})
    assert result.status == "in_transit"
    assert result.arrays["pellet_velocity"].max() > 0.1
    assert result.summary["momentum_residual"] < 1e-5
    assert result.summary["power_residual"] < power


def test_reaction_of_coulomb_friction_is_tangential_and_balanced() -> None:
    changes = SMALL | WALL_FRAME | {"pellet.friction_coefficient": 0.1, "step.wall": "0.5 ms", "run.duration": "0.3 s"}
    result = ps.run("baseline", changes)
    assert result.status == "in_transit"
    assert result.summary["momentum_residual"] < 1e-5


def bits(value: Any) -> list[bytes]:
    """Every number of a state, as bytes."""
    if is_dataclass(value):
        return [part for field in fields(value) for part in bits(getattr(value, field.name))]
    if isinstance(value, tuple):
        return [part for one in value for part in bits(one)]
    return [np.asarray(value).tobytes()]


def test_a_step_leaves_the_state_before_it_untouched_and_is_reproducible() -> None:
    model, state = begun(SMALL)
    for _ in range(30):
        state, _ = advance(model, state)
    kept = bits(state)
    once, again = advance(model, state)[0], advance(model, state)[0]
    assert bits(state) == kept
    assert bits(once) == bits(again)
    assert bits(once) != kept


@pytest.mark.parametrize("step", ["0 ms", "0.1 ms"])
def test_resumed_runs_are_bitwise_equal(step: str, tmp_path: Path) -> None:
    configuration = ps.Configuration().with_changes(SMALL | {"run.duration": "0.1 s", "step.explicit": step})
    whole = ps.Simulation(configuration)
    whole.run()
    first = ps.Simulation(configuration)
    first.advance("42 ms")
    Checkpoints(Workspace(tmp_path, tmp_path)).write(first.time, first.checkpoint())
    found = newest(tmp_path)
    assert found is not None
    second = ps.Simulation(configuration)
    second.restore(found)
    result = second.run()
    assert bits(second.state) == bits(whole.state)
    for name, values in whole.result().arrays.items():
        if values.dtype != object:
            assert np.array_equal(values, result.arrays[name], equal_nan=True), name


def test_step_beyond_the_limit_is_refused_beforehand() -> None:
    with pytest.raises(ConfigurationError, match=r"step.explicit = 0.2 ms exceeds 0.13\d* ms.*use at most 0.12"):
        ps.Simulation(ps.Configuration().with_changes(SMALL | {"step.explicit": "0.2 ms"}))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grid.n_theta": 8}, "axisymmetric wall only; use solver.integrator = implicit"),
        ({"step.explicit": "1.3 ms"}, "longer than step.conduction"),
        ({"step.explicit": "1e-9 ms", "run.duration": "1000 s", "output.interval": "1 s"}, "such steps"),
        ({"solver.integrator": "expl"}, "not one of implicit, explicit"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        ps.Configuration().with_changes(HEAVY | changes)


def test_effort_is_foreseen() -> None:
    configuration = ps.Configuration().with_changes(SMALL | {"run.duration": "2 s"})
    model, state = begun(SMALL)
    found = expected_effort(configuration, model, state)
    assert found.step <= 0.9 * found.limits.shell
    assert found.count == pytest.approx(2.0 / found.step, rel=1e-9)
    assert 1e-7 < found.seconds < 1e-3
    assert "us, about" in found.words()
    fine = replace(model, explicit=ExplicitScheme(50_000, 0.9, False, 2e6))
    assert expected_effort(configuration, fine, state).seconds < 1e-3


def test_cells_of_the_explicit_scheme_are_judged_by_their_own_error() -> None:
    def warned(changes: dict[str, Any]) -> bool:
        from peristalsis.inputs import preflight

        found = preflight.remarks(ps.Configuration().with_changes(changes))
        return any("conduction cells" in remark for remark in found)

    assert not warned({})
    assert warned(HEAVY)
    assert not warned(HEAVY | {"grid.n_z": 1200})


def test_integrator_is_an_option_of_the_command() -> None:
    assert Input("baseline", integrator="explicit").configuration().solver.integrator == "explicit"
    assert Input("baseline").configuration().solver.integrator == "implicit"
    with pytest.raises(ConfigurationError, match="set by --set and --integrator is given as well"):
        Input("baseline", settings=("solver.integrator=implicit",), integrator="explicit").configuration()


def test_models_without_the_scheme_have_no_limits() -> None:
    model, state = started({"grid.n_z": 40, "grid.n_z_wall": 40})
    for ask in (lambda: limits(model, state), lambda: expected_effort(ps.Configuration(), model, state)):
        with pytest.raises(ValueError, match=r"set solver\.integrator = explicit"):
            ask()


@pytest.mark.parametrize(("count", "said"), [(9e4, "90 s"), (6e6, "1e+02 min"), (1.08e7, "3 h")])
def test_long_efforts_are_told_in_minutes_and_hours(count: float, said: str) -> None:
    allowed = SimpleNamespace(words=lambda: "all")
    words = Effort(allowed, 1e-6, count, 1e-3).words()  # type: ignore[arg-type]
    assert f"about {said} on this machine" in words
    assert "steps of 0.001 ms (limits at t = 0: all)" in words


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (explicit_step.LONGITUDINAL, "longitudinal potential left -200...150 mV at z = 2.62 cm, t = 0.5 s: lower"),
        (explicit_step.CIRCULAR, "circular potential left -200...150 mV at z = 2.62 cm, t = 0.5 s: lower"),
        (explicit_step.STRETCH, "a stretch went out of range near z = 7.5 cm, t = 0.5 s, with explicit steps of 2 ms"),
        (None, "wall position: the tube has no volume left, t = 0.5 s, with explicit steps of 2 ms"),
    ],
)
def test_complaints_name_place_and_cure(code: int | None, words: str) -> None:
    """The longest element is the one that went out of range."""
    model, state = begun(SMALL | {"grid.n_z": 40, "grid.n_z_wall": 40})
    place = state.wall.position[:, 0, [0, 2]].T.copy()
    place[1, 31:] += 5.0
    shell = SimpleNamespace(place=place)
    allowed = limits(model, state)
    code = -1 if code is None else code
    said = explicit_step._complaint(model, shell, code, 10, 0.5, 2e-3, allowed)  # type: ignore[arg-type]
    assert words in said
    assert "lower step." in said
