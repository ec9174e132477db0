"""Fields that are not finite or out of bounds: tried again in parts, then a clean stop; never stored."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.inputs.build import build
from peristalsis.model import guards
from peristalsis.model.guards import advance_safely, violation
from peristalsis.model.initial import initial_state
from peristalsis.model.model import Model
from peristalsis.model.report import StepReport
from peristalsis.model.state import State
from peristalsis.model.step import advance
from peristalsis.results.result import Result
from peristalsis.running.runner import KeptRun
from peristalsis.running.simulation import Simulation
from peristalsis.storing.checkpoint import newest_of
from verification.exact.runs import PLAIN, configured

COARSE = {"grid.n_z": 60, "grid.n_z_wall": 40, "run.duration": "0.06 s", "output.interval": "10 ms"}
Spoil = Callable[[State], State]


def spoilt(record: Any, name: str, value: float, place: int) -> Any:
    """A copy of a record with one number of one of its arrays, or a plain number, replaced."""
    old = getattr(record, name)
    if isinstance(old, np.ndarray):
        changed = old.copy()
        changed.flat[place % changed.size] = value
    else:
        changed = value
    return record._replace(**{name: changed}) if hasattr(record, "_replace") else replace(record, **{name: changed})


def cases() -> dict[str, Spoil]:
    """R5: 60 places to spoil: every field of every part, with what cannot be and what cannot be true."""
    made: dict[str, Spoil] = {}

    def add(part: str, name: str, value: float, place: int) -> None:
        made[f"{part}.{name} {place} = {value:g}"] = lambda state: replace(
            state, **{part: spoilt(getattr(state, part), name, value, place)}
        )

    nan, inf = np.nan, np.inf
    for layer in ("longitudinal", "circular"):
        for value in (nan, inf, -inf, 1e4, -300.0):
            add(layer, "potential", value, 17)
        for place in (0, 70, 150, 239):
            add(layer, "gates", nan, place)
            add(layer, "gates", -1.0, place)
    add("longitudinal", "gates", 2.0, 5)
    add("pacemaker", "potential", nan, 0)
    for name in ("position", "velocity", "contact", "hoop_rate", "stretch_rate", "drive"):
        for value in (nan, inf):
            for place in (0, 31):
                add("wall", name, value, place)
    add("wall", "position", -1.0, 30)
    add("wall", "position", 1e6, 32)
    for name in ("position", "velocity", "axial_force"):
        for value in (nan, -inf):
            add("pellet", name, value, 0)
    add("trigger", "tension", nan, 3)
    add("reflex", "fired", nan, 0)
    made["pressure = nan"] = lambda state: replace(state, pressure=nan)
    made["pressure < 0"] = lambda state: replace(state, pressure=-1.0)
    return made


CASES = cases()


@pytest.fixture(scope="module")
def begun() -> tuple[Model, State]:
    """Model and state some steps after t = 0."""
    run = Simulation(configured(COARSE))
    run.advance("0.02 s")
    return run.model, run.state


def all_finite(result: Result) -> bool:
    """Whether all fields and numbers of every step are; places of a contact that there is not may be nan."""
    absent = {
        "activation_longitudinal",
        "activation_circular",
        "contact_start",
        "contact_end",
        "event_place",
        "wave_speed",
    }
    return all(
        bool(np.isfinite(values).all())
        for name, values in result.arrays.items()
        if values.dtype.kind == "f" and name not in absent
    )


def test_there_are_many_cases() -> None:
    assert len(CASES) >= 50


@pytest.mark.parametrize("case", CASES)
def test_every_spoilt_state_is_noticed(case: str, begun: tuple[Model, State]) -> None:
    model, state = begun
    assert violation(model, state) is None
    found = violation(model, CASES[case](state))
    assert found is not None
    assert " is " in found


@pytest.mark.parametrize("case", list(CASES)[::6])
def test_no_spoilt_state_is_stored(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """R5: status, a sentence with field and time, the history up to the step before, and nothing that is not finite."""

    def spoiling(model: Model, state: State) -> tuple[State, StepReport]:
        after, report = advance(model, state)
        return (CASES[case](after), report) if state.step * model.dt_wall > 0.0399 else (after, report)

    monkeypatch.setattr(guards, "advance", spoiling)
    run = Simulation(configured(COARSE))
    result = run.run()
    assert result.status == "diverged"
    assert " t = " in str(result.error)
    assert result.summary["steps"] == 20
    assert all_finite(result)


def test_a_state_spoilt_from_outside_is_not_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Simulation(configured(COARSE))
    run.advance("0.014 s")
    run.state = CASES["longitudinal.potential 17 = nan"](run.state)
    result = run.run()
    assert result.status == "diverged"
    assert all_finite(result)
    assert result.arrays["time"][-1] == pytest.approx(0.01)


def test_a_step_that_fails_once_is_made_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """What only the whole step spoils is repaired, said as an event, and no other step changes by a bit."""

    def spoiling(model: Model, state: State) -> tuple[State, StepReport]:
        after, report = advance(model, state)
        whole = model.dt_wall == 0.002
        return (replace(after, pressure=np.nan) if whole and state.step == 10 else after), report

    clean = Simulation(configured(COARSE)).run()
    monkeypatch.setattr(guards, "advance", spoiling)
    result = Simulation(configured(COARSE)).run()
    assert result.status == clean.status
    assert result.summary["steps"] == clean.summary["steps"] == 30
    kinds = list(result.arrays["event_kind"])
    assert kinds.count("step_halved") == 1
    words = result.arrays["event_words"][kinds.index("step_halved")]
    assert "lumen pressure is nan" in words
    assert "step.wall" in words
    before = result.arrays["time_step"] <= 0.0201
    place = "pellet_position"
    assert np.array_equal(result.arrays[place][before], clean.arrays[place][before])
    assert result.arrays[place][-1] == pytest.approx(clean.arrays[place][-1], abs=2e-4)


def test_parts_of_a_step_add_up(begun: tuple[Model, State], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two half steps of a good step agree with it to the error of the scheme, and its clock is right."""
    model, state = begun

    def refusing(one: Model, before: State) -> tuple[State, StepReport]:
        after, report = advance(one, before)
        return (replace(after, pressure=-1.0) if one.dt_wall == model.dt_wall else after), report

    whole, _ = advance(model, state)
    monkeypatch.setattr(guards, "advance", refusing)
    parts, report = advance_safely(model, state)
    assert parts.step == whole.step == state.step + 1
    assert report.wall_solves >= 2
    moved = np.abs(whole.wall.position - state.wall.position).max()
    assert 0.0 < np.abs(parts.wall.position - whole.wall.position).max() < 0.1 * moved
    risen = np.abs(whole.longitudinal.potential - state.longitudinal.potential).max()
    assert 0.0 < np.abs(parts.longitudinal.potential - whole.longitudinal.potential).max() < 0.1 * risen


def test_the_last_good_checkpoint_is_kept_with_the_result(tmp_path: Path) -> None:
    config = configured(COARSE, {"pacemaker.onset": "0.02 s", "pacemaker.intensity": "1000 uA/cm^2"})
    with KeptRun(config, tmp_path / "run") as kept:
        result = kept.begin().run()
        kept.save(result)
    assert result.status == "diverged"
    found = newest_of(tmp_path / "run")
    assert found.head.step == result.summary["steps"]
    again = KeptRun(config, tmp_path / "run", resume=True)
    assert again.finished is not None
    assert again.finished.status == "diverged", "a run that diverged diverges again: it is not run a second time"


def test_a_resting_state_passes(begun: tuple[Model, State]) -> None:
    from peristalsis.inputs.build import build

    for changes in ({}, {"pacemaker.kind": "cell"}, {"pellet.enabled": False}, {"lumen.pressure": "0.05 kPa"}):
        model, state, _ = initial_state(build(configured(COARSE, changes)))
        assert violation(model, state) is None


def test_a_wall_that_bows_across_the_axis_is_let_be() -> None:
    """On the whole surface a tube pulled aside by more than its radius is as sound as a straight one."""
    model, state, _ = initial_state(build(configured(COARSE | {"grid.n_theta": 8})))
    places = state.wall.position
    aside = 1.2 * model.wall.radius * np.sin(np.pi * places[:, :, 2] / model.grid.length) ** 2
    place = places[:, :, 0] * np.exp(1j * places[:, :, 1]) + aside
    bowed = np.stack([np.abs(place), np.angle(place), places[:, :, 2]], axis=2)
    assert bowed[:, :, 0].min() < 0.2 * model.wall.radius
    assert violation(model, replace(state, wall=replace(state.wall, position=bowed))) is None
    folded = bowed.copy()
    folded[20] = folded[19]
    found = violation(model, replace(state, wall=replace(state.wall, position=folded)))
    assert found is not None
    assert "stretch" in found


def test_a_stimulus_beyond_the_channels_is_blamed_and_not_the_step() -> None:
    """A lasting excitation meets cells whose channels have closed again: no step is short enough for it."""
    reflex = {
        "threshold": 1.0153,
        "oral_length": "5.8806 cm",
        "anal_length": "0.053842 cm",
        "delay": "0.18323 s",
        "refractory": "0.76489 s",
        "excitation_intensity": "6.7472 uA/cm^2",
        "excitation_duration": "0.072587 s",
        "inhibition_conductance": "0.10286 mS/cm^2",
        "inhibition_duration": "0.059912 s",
    }
    changes = {f"reflex.{name}": value for name, value in reflex.items()}
    result = Simulation(
        ps.configuration(reading="stretched", changes={**PLAIN, **changes, "run.duration": "1.1 s"})
    ).run()
    assert re.search(r"a stimulus of 6\.747 .* lower .*reflex\.excitation_intensity", result.summary["error"])
