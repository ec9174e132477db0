"""Compiling in two processes at once: what the second one compiles, and that it is never needed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.initial import initial_state, straight_state
from peristalsis.model.step import advance_sheets
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
sheet.advance_sheet.dispatcher  # numba makes its folder with its object
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
    monkeypatch.setattr("peristalsis.model.schemes.column.step_wall", unwanted)
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
    advance_sheets(model, straight)
    assert np.array_equal(straight.longitudinal.potential, before)


# --- what is said ----------------------------------------------------------------------------------


def test_kernels_that_are_compiled_are_counted_and_said_seldom(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that are loaded are counted and not said."""
    clock = iter([100.0, 100.0, 101.9, 102.0, 102.0])
    monkeypatch.setattr(warm_up.time, "monotonic", lambda: next(clock))
    said: list[str] = []
    progress = warm_up.Progress(3, said.append)
    for name, compiled in (("one", False), ("two", True), ("three", True), ("four", True)):
        progress.see(name, compiled)
    assert [line.partition("kernel ")[2] for line in said] == [
        "2 of 3, once on this machine (two)",
        "4 of 4, once on this machine (four)",
    ]
    assert (progress.ready, progress.compiled) == (4, 3)


COUNT = """
import json
from peristalsis.running.warm_up import KERNELS, _compile
found = [_compile(1, integrator) for integrator in ("implicit", "explicit")]
print(json.dumps([KERNELS[False, "implicit"], KERNELS[False, "explicit"], *(one.kernels for one in found)]))
"""


def test_the_number_of_kernels_is_the_one_that_is_said() -> None:
    """Where this fails the equations have more or fewer kernels than before: change `warm_up.KERNELS`."""
    done = subprocess.run([sys.executable, "-c", COUNT], capture_output=True, text=True, check=True)
    column, explicit, *found = json.loads(done.stdout)
    assert found == [column, explicit]


def test_only_what_a_user_calls_is_counted(tmp_path: Path) -> None:
    """A kernel that another one calls is compiled with it."""
    program = """
import numpy as np
from peristalsis.numerics.kept import watched
from peristalsis.numerics.compiled import compiled
seen = []
inner = compiled(lambda x: x + 1.0)
def whole(x):
    return 2.0 * inner(x)
outer = compiled(whole)
with watched(lambda name, compiled: seen.append((name, compiled))):
    outer(1.0), outer(2.0), outer(1)
outer(1j)
print(seen)
"""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == "[('whole', True), ('whole', True)]"
