"""Every output of a run: its own function against an independent evaluation, on a state made by hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import names
from peristalsis.errors import ConfigurationError
from peristalsis.model.model import Model
from peristalsis.model.report import StepReport
from peristalsis.model.state import SheetState, State
from peristalsis.model.step import advance
from peristalsis.names import FIELDS, OF_NETWORK, OUTPUTS, PROBE, PROBES, SCALARS, STEP, Output
from peristalsis.plots.figures import currents, force_budget
from peristalsis.running.events import Event
from peristalsis.running.observers import FieldRecorder, ProbeRecorder, ScalarRecorder
from verification.exact.runs import started

TINY = {"grid.n_z": 60, "grid.n_z_wall": 40, "run.duration": "0.02 s", "output.interval": "10 ms"}
CELLS = np.array([7, 31])


@pytest.fixture(scope="module")
def pair() -> tuple[Model, State, State]:
    """A model whose layers differ in every constant, and two states a step apart in which every array varies."""
    rng = np.random.default_rng(31)
    changes = {**TINY, "circular.threshold": "-48 mV", "circular.fast_calcium": "5 mS/cm^2"}
    changes["pellet.dry_friction"] = "2 mN"
    model, rest = started(changes)
    lengths = (60, 1)

    def sheet(offset: float) -> SheetState:
        gates = rng.uniform(0.1, 0.9, (4, *lengths))
        return SheetState(offset + rng.normal(size=lengths), gates, *rng.uniform(0.0, 900.0, (2, *lengths)))

    spread = rng.uniform(0.5, 1.5, (5, 60))
    model = replace(
        model,
        longitudinal=replace(model.longitudinal, conductances=model.longitudinal.conductances * spread),
        circular=replace(model.circular, conductances=model.circular.conductances * (2.0 - spread)),
    )
    before = replace(rest, longitudinal=sheet(-40.0), circular=sheet(-30.0))
    before, _ = advance(model, before)
    after, _ = advance(model, before)
    return model, before, after


def contact_nodes(state: State) -> np.ndarray:
    return np.flatnonzero(state.wall.contact[:, 0] > 0.0)


def expected_scalars(model: Model, before: State, after: State) -> dict[str, float]:
    """What the step leaves, from the arrays of both states by textbook formulas."""
    wall = after.wall
    rho, zeta = wall.position[:, 0, 0], wall.position[:, 0, 2]
    touching = contact_nodes(after)
    dt, size, radius = model.dt_wall, model.wall.element_size, model.wall.radius
    stretch = np.hypot(np.diff(rho), np.diff(zeta)) / size
    at_nodes = np.concatenate([stretch[:1], 0.5 * (stretch[1:] + stretch[:-1]), stretch[-1:]])
    density = wall.contact[:, 0]

    def volume(state: State) -> float:
        r, z = state.wall.position[:, 0, 0], state.wall.position[:, 0, 2]
        return float(np.pi / 3.0 * (np.diff(z) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2)).sum())

    eta = model.pellet.viscous
    speeds = np.array([before.pellet.velocity, after.pellet.velocity])
    return {
        "pellet_position": after.pellet.position,
        "pellet_velocity": after.pellet.velocity,
        "axial_force": after.pellet.axial_force,
        "normal_force": float(2.0 * np.pi * radius * size * density.sum()),
        "viscous_force": -eta * after.pellet.velocity,
        "dry_force": -after.pellet.axial_force + eta * after.pellet.velocity,
        "dry_friction_limit": model.pellet.dry,
        "lumen_pressure": after.pressure / 100.0,
        "max_contact_pressure": float((density / (at_nodes * rho / radius)).max()) / 100.0,
        "contact_start": float(zeta[touching[0]]),
        "contact_end": float(zeta[touching[-1]]),
        "min_diameter": 2.0 * float(rho.min()),
        "newton_iterations": 3.0,
        "step_parts": 1.0,
        "steps_rejected": 5.0,
        "work_gas": 0.5 * (before.pressure + after.pressure) * (volume(after) - volume(before)),
        "loss_pellet": 0.5 * dt * float((eta * speeds**2 + model.pellet.dry * np.abs(speeds)).sum()),
        "threshold_longitudinal": model.longitudinal.threshold,
        "threshold_circular": model.circular.threshold,
    }


def recorded(recorder: Any, model: Model, before: State, after: State) -> dict[str, Any]:
    """What a recorder keeps of the step from one state to the next."""
    recorder.start(model, before)
    recorder.see(model, before, after, StepReport(3, 3, 1, parts=(), rejected=5))
    return {name: values[-1] for name, values in recorder.columns().items()}


def test_every_scalar_is_what_its_name_says(pair: tuple[Model, State, State]) -> None:
    """Two that were swapped would differ: no two of them are equal here."""
    model, before, after = pair
    found = recorded(ScalarRecorder(), model, before, after)
    expected = expected_scalars(model, before, after)
    assert found.keys() == {output.name for output in SCALARS}
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=3e-3, abs=1e-12), name
    assert not np.isclose(after.pellet.velocity, 0.0)
    assert found.pop("end_reaction") == 0.0, "open ends; `test_ends` has a pellet that a closed one holds"
    for one, other in combinations(sorted(found), 2):
        assert found[one] != found[other], f"{one} and {other} cannot be told apart here"


def test_ends_balances_and_shares_are_what_their_names_say(pair: tuple[Model, State, State]) -> None:
    """Those that take an equation to say: the balance of forces, that of work, signs and sizes."""
    model, before, after = pair
    found = recorded(ScalarRecorder(), model, before, after)
    wall = after.wall
    rho, zeta = wall.position[:, 0, 0], wall.position[:, 0, 2]
    tension = recorded_fields(model, after)["tension_longitudinal"][:, 0]
    for name, end, neighbour in (("oral_reaction", 0, 1), ("anal_reaction", -1, -2)):
        slope = abs(zeta[neighbour] - zeta[end]) / np.hypot(zeta[neighbour] - zeta[end], rho[neighbour] - rho[end])
        hoop = 0.5 * (rho[end] + rho[neighbour]) / model.wall.radius if model.wall.published else 1.0
        area = np.pi / 3.0 * (rho[end] ** 2 + rho[end] * rho[neighbour] + rho[neighbour] ** 2)
        force = 2.0 * np.pi * model.wall.radius * tension[end] * slope * hoop - after.pressure * area
        assert found[name] == pytest.approx(force, rel=0.1), name
    assert 0.0 <= found["slack_share"] < 1.0
    gaps = np.hypot(rho, zeta - after.pellet.position) - model.pellet.radius
    assert found["smallest_gap"] == pytest.approx(gaps.min(), abs=2e-3)
    balance = found["anal_reaction"] - found["oral_reaction"] - found["axial_force"]
    assert found["momentum_residual"] == pytest.approx(balance, abs=1e-9)
    sinks = found["energy_wall"] + found["loss_wall"] + found["loss_pellet"]
    assert found["power_residual"] == pytest.approx(sinks - found["work_active"] - found["work_gas"], rel=1e-9)
    assert found["loss_wall"] > 0.0
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    squares = [(s.wall.stretch_rate**2).sum() + (s.wall.hoop_rate[1:-1] ** 2).sum() for s in (before, after)]
    dissipated = 0.5 * model.dt_wall * model.wall.viscosity * area * float(sum(squares))
    assert found["loss_wall"] == pytest.approx(dissipated, rel=0.2)


def recorded_fields(model: Model, state: State) -> dict[str, np.ndarray]:
    recorder = FieldRecorder(1)
    recorder.start(model, state)
    return {name: frames[0] for name, frames in recorder.frames.items()}


def test_every_field_is_what_its_name_says(pair: tuple[Model, State, State]) -> None:
    """Lengths and cells from the arrays; tensions from Eqs. (3) to (5), written out here."""
    model, _, state = pair
    found = recorded_fields(model, state)
    assert found.keys() == {output.name for output in FIELDS} - OF_NETWORK
    wall, c = state.wall, model.wall
    rho, zeta = wall.position[:, 0, 0], wall.position[:, 0, 2]
    stretch = np.hypot(np.diff(rho), np.diff(zeta)) / c.element_size
    hoop = rho / c.radius

    def at_nodes(left: np.ndarray, right: np.ndarray) -> np.ndarray:
        return np.concatenate([left[:1], 0.5 * (left[1:] + right[:-1]), right[-1:]])[:, None]

    def parts(corner: int) -> dict[str, np.ndarray]:
        around = hoop[corner : corner + stretch.size]
        along, circum = stretch - 1.0, around - 1.0
        p = c.passive
        growth = p.c10 * np.exp(p.c4 * along**2 + p.c5 * circum**2 + 2.0 * p.c6 * along * circum)
        axial = p.c1 * along + p.c3 * circum + 2.0 * growth * (p.c4 * along + p.c6 * circum)
        hooped = p.c3 * along + p.c2 * circum + 2.0 * growth * (p.c5 * circum + p.c6 * along)
        drive = wall.drive[:, corner::2, 0]
        muscle = [
            np.maximum(m.c7 * s**2 + m.c8 * s + m.c9, 0.0) for m, s in ((c.longitudinal, stretch), (c.circular, around))
        ]
        return {
            "passive_tension_longitudinal": np.maximum(axial, 0.0),
            "passive_tension_circumferential": np.maximum(hooped, 0.0),
            "active_tension_longitudinal": drive[0] * muscle[0],
            "active_tension_circumferential": drive[1] * muscle[1],
        }

    left, right = parts(0), parts(1)
    for name in left:
        expected = at_nodes(left[name], right[name])
        assert found[name] == pytest.approx(expected, rel=2e-2, abs=c.slack_blend), name
    for direction, rates in (("longitudinal", None), ("circumferential", wall.hoop_rate)):
        total = found[f"passive_tension_{direction}"] + found[f"active_tension_{direction}"]
        rate = at_nodes(wall.stretch_rate[:, 0], wall.stretch_rate[:, 0]) if rates is None else rates
        taut = total + c.viscosity * rate > 100.0  # well above the blend, at both corners
        assert taut.sum() >= 5
        assert found[f"tension_{direction}"][taut] == pytest.approx((total + c.viscosity * rate)[taut], rel=2e-2)
    exact = {
        "radius": rho,
        "angle": np.zeros_like(rho),
        "axial_position": zeta,
        "stretch_longitudinal": at_nodes(stretch, stretch)[:, 0],
        "stretch_circumferential": hoop,
        "contact_pressure": wall.contact[:, 0] / (at_nodes(stretch, stretch)[:, 0] * hoop) / 100.0,
        "potential_longitudinal": state.longitudinal.potential[:, 0],
        "potential_circular": state.circular.potential[:, 0],
        "calcium_longitudinal": state.longitudinal.gates[3, :, 0],
        "calcium_circular": state.circular.gates[3, :, 0],
    }
    for name, values in exact.items():
        assert found[name][:, 0] == pytest.approx(values, rel=1e-12), name
    for one, other in combinations(sorted(found), 2):
        assert found[one].shape != found[other].shape or not np.allclose(found[one], found[other]), (one, other)


def test_every_probe_row_is_what_its_name_says(pair: tuple[Model, State, State]) -> None:
    model, before, after = pair
    found = recorded(ProbeRecorder(CELLS), model, before, after)
    expected = {}
    for layer in ("longitudinal", "circular"):
        sheet, constants = getattr(after, layer), getattr(model, layer)
        expected[f"potential_{layer}_probe"] = sheet.potential[CELLS, 0]
        for k, gate in enumerate(("h", "n", "x", "calcium")):
            expected[f"{gate}_{layer}_probe"] = sheet.gates[k, CELLS, 0]
        for k, channel in enumerate(("fast_calcium", "slow_calcium", "potassium", "calcium_potassium", "leak")):
            expected[f"conductance_{channel}_{layer}_probe"] = constants.conductances[k, CELLS]
    assert found.keys() == expected.keys() == {output.name for output in PROBES}
    for name, values in expected.items():
        assert np.array_equal(found[name], values), name
    for one, other in combinations(sorted(found), 2):
        assert not np.array_equal(found[one], found[other]), (one, other)


def test_events_are_read_by_name() -> None:
    event = Event(1.0, "slip", 3.0, "why")
    assert {o.name: o.value(event) for o in names.EVENTS if o.value is not None} == {
        "event_time": 1.0,
        "event_place": 3.0,
        "event_kind": "slip",
        "event_words": "why",
    }


def test_only_coordinates_come_without_a_function() -> None:
    bare = {output.name for output in OUTPUTS.values() if output.value is None}
    assert bare == {output.name for output in names.COORDINATES}


@pytest.fixture
def own() -> Iterator[Output]:
    """An output from outside the package."""
    output = ps.register(
        Output(
            "own_kinetic_pressure", STEP, "kPa", "twice the lumen pressure", lambda now: 2.0 * now.state.pressure / 100
        )
    )
    yield output
    names.forget(output.name)


def test_registered_output_is_recorded_stored_and_read_back(own: Output, tmp_path: Path) -> None:
    """One call: it is in the arrays, the dataset, the file, and read back where nobody knows it."""
    result = ps.run("baseline", TINY)
    assert np.array_equal(result.arrays[own.name], 2.0 * result.arrays["lumen_pressure"])
    assert result.dataset[own.name].attrs == {"units": "kPa", "long_name": "twice the lumen pressure"}
    folder = result.save(tmp_path / "run")
    names.forget(own.name)
    try:
        back = ps.load(folder)
        assert np.array_equal(back.arrays[own.name], result.arrays[own.name])
        assert back.dataset[own.name].attrs["units"] == "kPa"
        assert back.save(tmp_path / "again")
    finally:
        ps.register(own)


@pytest.mark.parametrize(
    ("output", "why"),
    [
        (Output("radius", STEP, "cm", "taken", lambda now: 0.0), "is taken"),
        (Output("two words", STEP, "cm", "no name", lambda now: 0.0), "no identifier"),
        (Output("own", ("time", "event"), "cm", "odd", lambda now: 0.0), "one of the dimensions"),
        (Output("own", PROBE, "cm", "nothing"), "needs a function"),
    ],
)
def test_outputs_that_cannot_be_are_refused(output: Output, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        ps.register(output)


def test_output_that_is_gone_when_the_run_goes_on_is_a_sentence(pair: tuple[Model, State, State]) -> None:
    model, _, after = pair
    recorder = ScalarRecorder(names=("pellet_position", "gone"))
    with pytest.raises(ConfigurationError, match="output gone is not known here"):
        recorder.start(model, after)


def test_currents_are_those_that_the_model_had() -> None:
    """Fast calcium blocked by a region at one probe, and the leak by a protocol from 10 ms on: none is drawn."""
    blocked = {"name": "dead", "shape": "band", "z_from": "4 cm", "z_to": "6 cm", "fast_calcium": 0.0}
    changes = {**TINY, "output.probes": ["2 cm", "5 cm"], "regions": [blocked]}
    result = ps.run("baseline", changes)
    assert np.abs(currents.currents_at(result, "circular", 0)["fast_calcium"]).max() > 0.0
    assert np.abs(currents.currents_at(result, "circular", 1)["fast_calcium"]).max() == 0.0
    in_time = {**TINY, "protocols": ["longitudinal.leak: step 0.003 mS/cm^2 at 0 s, 0 mS/cm^2 at 10 ms"]}
    later = ps.run("baseline", in_time)
    leak = currents.currents_at(later, "longitudinal", 0)["leak"]
    assert np.abs(leak[later.arrays["time_step"] < 0.0099]).min() > 0.0
    assert np.abs(leak[later.arrays["time_step"] > 0.0121]).max() == 0.0


def test_limit_of_dry_friction_is_drawn_as_it_was() -> None:
    """A protocol halves it: the dotted lines of the figure follow."""
    result = ps.run("baseline", {**TINY, "protocols": ["pellet.dry_friction: step 20 mN at 0 s, 10 mN at 10 ms"]})
    lines = force_budget.draw(result).axes[1].lines
    drawn = np.asarray(lines[1].get_ydata())
    assert drawn[0] == 20.0
    assert drawn[-1] == 10.0
