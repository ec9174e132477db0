"""Compiling in two processes at once: what the second one compiles, and that it is never needed."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.initial import initial_state, straight_state
from peristalsis.model.step import advance_tissue
from peristalsis.numerics.sources import PACKAGE, kernel_digest
from peristalsis.running import warm_up


class Started:
    """What was started in place of another process."""

    def __init__(self) -> None:
        self.words: list[list[str]] = []
        self.ended = 0

    def __call__(self, words: list[str], **more: Any) -> Any:
        self.words.append(words)
        return self

    def kill(self) -> None:
        self.ended += 1

    def wait(self) -> None:
        pass


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Started:
    """An empty cache, two processors, and no real process."""
    found = Started()
    monkeypatch.setattr(subprocess, "Popen", found)
    monkeypatch.setattr("peristalsis.numerics.compiled.CACHE_FOLDER", tmp_path)
    monkeypatch.setattr("peristalsis.storing.environment.processors", lambda: 2)
    return found


def test_second_process_compiles_into_an_empty_cache(started: Started) -> None:
    with warm_up._second_process() as helper:
        assert helper is not None
        assert started.ended == 0
    assert started.words == [[sys.executable, "-c", warm_up.TISSUE]]
    assert started.ended == 1, "it does not outlive the warm-up"


def test_second_process_ends_with_a_warm_up_that_fails(started: Started) -> None:
    with pytest.raises(KeyboardInterrupt), warm_up._second_process():
        raise KeyboardInterrupt
    assert started.ended == 1


@pytest.mark.parametrize("reason", ["cached", "no cache", "one processor"])
def test_no_second_process_where_it_cannot_help(
    started: Started, reason: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    if reason == "cached":
        folder = tmp_path / kernel_digest(PACKAGE / "tissue" / "sheet.py")
        (folder / "tissue_1").mkdir(parents=True)
        (folder / "tissue_1" / "sheet.advance_sheet-160.py311.1.nbc").touch()
    elif reason == "no cache":
        monkeypatch.setattr("peristalsis.numerics.compiled.CACHE_FOLDER", None)
    else:
        monkeypatch.setattr("peristalsis.storing.environment.processors", lambda: 1)
    with warm_up._second_process() as helper:
        assert helper is None
    assert started.words == []


def test_a_process_that_cannot_start_is_done_without(started: Started, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*words: Any, **more: Any) -> Any:
        raise OSError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", refused)
    with warm_up._second_process() as helper:
        assert helper is None


def test_folders_that_numba_makes_for_a_decorated_kernel_are_an_empty_cache(tmp_path: Path) -> None:
    source = """
import peristalsis.storing.environment
peristalsis.storing.environment.processors = lambda: 2
from peristalsis.running import warm_up
from peristalsis.tissue import sheet
with warm_up._second_process() as helper:
    print(helper is not None)
"""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    words = [sys.executable, "-c", source]
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.split() == ["True"]
    assert any(tmp_path.iterdir())


def test_what_has_been_compiled_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the names that numba gives its files."""
    monkeypatch.setattr("peristalsis.storing.environment.processors", lambda: 2)
    warm_up.compile_tissue()
    with warm_up._second_process() as helper:
        assert helper is None


def test_tissue_is_compiled_without_an_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or the second process would compile what the first one is at."""

    def unwanted(*words: Any, **more: Any) -> Any:
        raise AssertionError("the wall was solved for")

    monkeypatch.setattr("peristalsis.model.inflation.solve_packed", unwanted)
    monkeypatch.setattr("peristalsis.model.step.step_wall", unwanted)
    warm_up.compile_tissue()


def test_straight_tube_has_the_cells_of_the_state_at_rest() -> None:
    """Only the wall is not that of t = 0; a step of the tissue leaves the state alone."""
    model = build(Configuration().with_changes(warm_up.TINY))
    straight, (_, settled, _) = straight_state(model), initial_state(model)
    for layer in ("longitudinal", "circular"):
        assert np.array_equal(getattr(straight, layer).potential, getattr(settled, layer).potential)
    assert straight.wall.position.shape == settled.wall.position.shape
    assert np.all(straight.wall.position[:, :, 0] == model.wall.radius)
    before = straight.longitudinal.potential.copy()
    advance_tissue(model, straight)
    assert np.array_equal(straight.longitudinal.potential, before)


CAPSULE = {"pellet.shape": "capsule", "pellet.radius": "0.55 cm", "pellet.capsule.length": "2.6 cm"}


@pytest.fixture
def stepped(monkeypatch: pytest.MonkeyPatch) -> list[Configuration]:
    """Configurations whose first steps were asked for; nothing is compiled."""
    found: list[Configuration] = []
    monkeypatch.setattr(warm_up, "_step", found.append)
    monkeypatch.setattr(warm_up, "_second_process", contextlib.nullcontext)
    monkeypatch.setattr(warm_up, "_combinations", {})
    return found


def test_a_run_with_other_parts_warms_up_their_kernels_once(stepped: list[Configuration]) -> None:
    """Those of the package are left out, and the run's own numbers go in: its pellet fits its tube."""
    config = Configuration().with_changes({**CAPSULE, "wall.radius": "0.486 cm"})
    first = warm_up.warm_up_for(config)
    assert warm_up.warm_up_for(config.with_changes({"pellet.capsule.length": "3 cm"})) == first
    (small,) = stepped
    assert (small.pellet.shape, small.pellet.radius, small.wall.radius) == ("capsule", 0.55, 0.486)
    assert (small.grid.n_z, small.grid.n_theta) == (200, 1)
    warm_up.warm_up_for(config.with_changes({"grid.n_theta": 12, "grid.n_theta_conduction": 24}))
    warm_up.warm_up_for(config.with_changes({"wall.law": "neo_hookean"}))
    assert [one.grid.n_theta for one in stepped] == [1, 8, 1]


def test_shipped_parts_are_the_warm_up_of_all(stepped: list[Configuration], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, bool]] = []
    monkeypatch.setattr(warm_up, "warm_up", lambda **words: asked.append(words) or 3.0)
    assert warm_up.warm_up_for(Configuration().with_changes({"grid.n_theta": 8})) == 3.0
    assert asked == [{"surface": True, "explicit": False}]
    assert stepped == []


def test_other_parts_are_named_while_they_are_compiled(
    stepped: list[Configuration], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(warm_up, "QUIET_SECONDS", 0.0)
    monkeypatch.setattr(warm_up, "_step", lambda tiny: time.sleep(0.2))
    warm_up.warm_up_for(Configuration().with_changes({**CAPSULE, "wall.law": "neo_hookean"}))
    assert capsys.readouterr().err == (
        "peristalsis: preparing the kernels of law neo_hookean, shape capsule, which are compiled once, "
        "for about two minutes\n"
    )


def test_a_part_that_fails_fails_in_its_run(stepped: list[Configuration], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not before all other runs of a batch."""

    def failing(_: Configuration) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(warm_up, "_step", failing)
    assert warm_up.warm_up_for(Configuration().with_changes(CAPSULE)) >= 0.0
