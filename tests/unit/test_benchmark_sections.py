"""Sections of the bench: made-up measurements of a known law give known figures and tables; pieces on tiny cases."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks import kernels, machine_limits
from benchmarks.clock import Spent, Timing
from benchmarks.ledger import Ledger
from benchmarks.parts import STEP
from benchmarks.process import Ended
from benchmarks.runs import FINEST, QUICK_FINEST, SAMPLES, stretch, tracked
from benchmarks.section import Bench, Effort, Figure, Findings
from benchmarks.sections import (
    baseline,
    explicit,
    growth,
    ions,
    memory,
    precision,
    roofline,
    surface,
    workers,
)
from peristalsis.inputs.config import Configuration
from peristalsis.model.state import State
from peristalsis.running.simulation import Simulation

COARSE = {"step.wall": "2 ms", "step.conduction": "0.25 ms", "grid.n_z": 200, "grid.n_z_wall": 100}


class Told(Bench):
    """A bench that measures nothing: every piece is what a function of its name says."""

    def __init__(self, answer: Callable[[str], Any], effort: Effort = "quick") -> None:
        super().__init__(effort, Ledger(None))
        self.answer = answer
        self.asked: list[str] = []

    def piece(self, name: str, measure: Callable[[], Any]) -> Any:
        self.asked.append(name)
        return json.loads(json.dumps(self.answer(name)))  # as a file would give it back


def figure(findings: Findings, what: str) -> Figure:
    return next(one for one in findings.figures if one.what == what)


def timing(cpu: float) -> dict[str, float]:
    return {"wall": 2.0 * cpu, "cpu": cpu, "least": cpu, "repeats": 3}


@pytest.fixture
def one_second(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every call is made once, and takes a second."""

    def in_turns(calls: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, Timing]:
        for call in calls.values():
            call()
        return {name: Timing(2.0, 1.0, 1.0, repeats) for name in calls}

    for section in (ions, roofline):
        monkeypatch.setattr(section, "in_turns", in_turns)


# --- growth -----------------------------------------------------------------------------------------

POWERS = {"cells along": 1.0, "columns": 1.5, "s": 0.9, "runs": 1.1 - 1e-9}


def grown(name: str) -> dict[str, Any]:
    size, what = re.fullmatch(r"growth, (\d+) (.+)", name).groups()  # type: ignore[union-attr]
    return timing(0.01 * int(size) ** POWERS[what]) | ({} if what == "runs" else {"steps": 7, "newton": 20})


@pytest.mark.parametrize("effort", ["quick", "full"])
def test_exponents_of_growth(effort: Effort) -> None:
    """Each series has its own; the one that grows faster than in proportion misses the aim."""
    bench = Told(grown, effort)
    found = growth.run(bench)
    assert [one.value for one in found.figures] == pytest.approx([1.0, 1.5, 0.9, 1.1], abs=1e-6)
    assert [one.met for one in found.figures] == [True, False, True, True]
    assert len(bench.asked) == sum(len(one.rows) for one in found.tables) == (24 if effort == "full" else 13)
    along = found.tables[0].rows
    assert along[0][0] == (100 if effort == "full" else 200)
    assert [row[3] for row in along] == pytest.approx([10.0] * len(along)), "milliseconds a cell"
    assert along[0][4:] == (7, 20)
    assert found.tables[3].rows[0][4:] == (None, None), "a batch counts no steps"
    *lines, proportion = found.plots[0].lines
    assert all(line.x[0] == line.y[0] == 1.0 for line in lines)
    assert lines[1].y[-1] == pytest.approx(lines[1].x[-1] ** 1.5)
    assert proportion.x == proportion.y == (1.0, max(line.x[-1] for line in lines))


@pytest.mark.parametrize(
    ("measure", "steps"),
    [(lambda: growth._along(100, 2), 100), (lambda: growth._time(1, 1), 200)],
    ids=["along", "time"],
)
def test_stretches_have_their_steps(measure: Callable[[], dict[str, Any]], steps: int) -> None:
    found = measure()
    assert found["steps"] == steps
    assert found["newton"] >= steps
    assert found["cpu"] >= found["least"] > 0.0


def test_columns_are_those_asked_for() -> None:
    found = growth._around(4, 1)
    assert (found["steps"], found["repeats"]) == (8, 1)


def test_batches_have_as_many_different_runs_as_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[set[str]] = []
    monkeypatch.setattr(
        growth, "batch", lambda plan, out: seen.append({point.configuration.digest() for point in plan.points})
    )
    assert growth._batch(3, 2)["repeats"] == 2
    assert [len(one) for one in seen] == [3, 3]


# --- workers ----------------------------------------------------------------------------------------


def test_two_workers_by_the_clock_and_by_the_processor() -> None:
    """The best of each; by processor time the first process works beside both."""
    took = {"one": [9.0, 8.0], "two": [5.0, 6.0], "cpu_one": 6.0, "cpu_parent": 0.5, "cpu_children": 7.0}
    bench = Told(lambda name: took, "full")
    found = workers.run(bench)
    assert bench.asked == ["workers, 8 runs", "workers, 32 runs"]
    clock = figure(found, "two workers over one, 8 baselines")
    assert (clock.value, clock.met) == (1.6, False)
    assert "best of 2" in clock.note
    assert "75 % of a processor" in clock.note
    assert figure(found, "the same by processor time, 32 baselines").value == 6.0 / 4.0
    assert found.tables[0].rows[1] == (32, 8.0, 5.0, 1.6, 6.0, 7.0, 0.5, 1.5)


def test_workers_that_halve_the_time_meet_the_aim() -> None:
    took = {"one": [8.0], "two": [4.2], "cpu_one": 8.0, "cpu_parent": 0.1, "cpu_children": 8.0}
    assert workers.run(Told(lambda name: took)).figures[0].met


def test_one_processor_compares_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "processors", lambda: 1)
    found = workers.run(Told(lambda name: pytest.fail("measured")))
    assert found.figures == ()
    assert "one processor only" in found.notes[0]


def test_one_and_two_workers_run_the_same_in_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Times are those that the system tells; processor times are those of the best turn."""
    seen: list[tuple[int, tuple[str, ...]]] = []
    told = iter([(0.0, 0.0, 9.0), (1.0, 0.0, 5.0), (0.0, 0.0, 8.0), (2.0, 3.0, 4.0)])
    clock = [0.0, 0.0, 0.0]

    def run_batch(plan: Any, out: Path, workers: int) -> None:
        seen.append((workers, tuple(point.configuration.digest() for point in plan.points)))
        own, children, elapsed = next(told)
        clock[:] = clock[0] + own, clock[1] + children, clock[2] + elapsed

    def times() -> SimpleNamespace:
        own, children, elapsed = clock
        return SimpleNamespace(user=own, system=0.0, children_user=0.0, children_system=children, elapsed=elapsed)

    monkeypatch.setattr(workers, "batch", run_batch)
    monkeypatch.setattr(workers.os, "times", times)
    found = workers._turns(3, 2)
    assert [count for count, _ in seen] == [1, 2, 1, 2]
    assert len({points for _, points in seen}) == 1
    assert len(set(seen[0][1])) == 3
    assert (found["one"], found["two"]) == ([9.0, 8.0], [5.0, 4.0])
    assert (found["cpu_one"], found["cpu_parent"], found["cpu_children"]) == (0.0, 2.0, 3.0)


# --- the whole surface --------------------------------------------------------------------------------


def test_parts_of_the_surface_add_up() -> None:
    """Columns of a row are seconds for a simulated second, and their sum is the whole."""
    parts = {part: 0.1 * (k + 1) for k, part in enumerate(STEP)}
    took = {"steps": 10, "simulated": 0.02, "cpu": 2.0, "parts": parts, "newton": 30, "krylov": 55}
    bench = Told(lambda name: took)
    found = surface.run(bench)
    assert bench.asked == [f"surface, {case}" for case in surface.CASES]
    assert [one.value for one in found.figures] == pytest.approx([100.0] * 3)
    assert "first 0.02 s" in found.figures[0].note
    row = found.tables[0].rows[0]
    assert len(row) == len(found.tables[0].head)
    assert row[3 : 3 + len(STEP)] == pytest.approx([5.0, 10.0, 15.0, 20.0])
    assert row[-4:] == pytest.approx([50.0, 100.0, 3.0, 5.5])


def test_box_ends_with_its_time_or_with_half_a_second() -> None:
    """A box that is used up at once holds one step, a large one the steps after the first of half a second."""
    short = surface._boxed("baseline", COARSE, 1e-9)
    assert (short["steps"], short["simulated"]) == (1, 0.002)
    whole = surface._boxed("baseline", COARSE, math.inf)
    assert whole["steps"] == 249
    assert whole["newton"] >= whole["steps"]
    assert whole["krylov"] == 0, "one column is solved directly"
    assert set(whole["parts"]) == set(STEP)
    assert sum(whole["parts"].values()) < whole["cpu"]


# --- the baseline -------------------------------------------------------------------------------------

TRACK = {"transit": 2.0, "until": 2.0, "places": np.linspace(0.0, 8.0, SAMPLES).tolist(), "steps": 1000}


def shifted(by: float, **more: Any) -> dict[str, Any]:
    """A track [cm] that lies everywhere off by so much."""
    return TRACK | {"places": (np.linspace(0.0, 8.0, SAMPLES) + by).tolist()} | more


def of_the_baseline(name: str) -> Any:
    return {
        "baseline, solver": shifted(0.03, transit=2.1, **timing(0.16)),
        "baseline, whole process": timing(0.9),
        "converged track": TRACK,
        "baseline, first process": {"wall": 31.0, "cpu": 29.0, "kernels": 50, "compiled_by_next": 0},
        "baseline, phases of a process": [["interpreter", 0.1, 0.2], ["solver", 0.3, 0.4]],
    }[name]


def test_baseline_is_scaled_to_the_gut_and_compared_with_the_converged_run() -> None:
    found = baseline.run(Told(of_the_baseline))
    solver = figure(found, "solver, 2.5 s of gut, cpu")
    assert solver.value == pytest.approx(0.16 * 2.5 / 2.0)
    assert solver.met
    assert figure(found, "solver, a step").value == pytest.approx(0.16)
    grid, step = Configuration().grid, Configuration().step
    each = 1000 * (2 * grid.n_z * step.wall / step.conduction + grid.n_z_wall)
    assert figure(found, "solver, per node-step").value == pytest.approx(0.16e9 / each)
    late = figure(found, "transit less converged")
    assert late.value == pytest.approx(5.0)
    assert late.note == "2.1000 against 2.0000 s"
    assert figure(found, "track, rms difference to converged").value == pytest.approx(0.3)
    assert found.tables[0].rows == (
        ("warm process", 1.8, 0.9),
        ("of it, interpreter", 0.1, 0.2),
        ("of it, solver", 0.3, 0.4),
    )
    assert not any("first process" in one.what for one in found.figures)


def test_first_process_belongs_to_the_full_bench() -> None:
    found = baseline.run(Told(of_the_baseline, "full"))
    assert figure(found, "first process, wall").met is False
    assert figure(found, "first process, cpu").met is True
    assert figure(found, "kernels that the next process compiles").met is True
    assert found.tables[0].rows[0] == ("first process, empty cache", 31.0, 29.0)


def test_baseline_that_never_arrives_has_no_transit() -> None:
    stays = {"baseline, solver": shifted(0.0, transit=None, **timing(0.1))}
    found = baseline.run(Told(lambda name: stays.get(name) or of_the_baseline(name)))
    late = figure(found, "transit less converged")
    assert (late.value, late.note) == (None, "none against 2.0000 s")


def test_solver_is_measured_as_often_as_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = iter([{"wall": float(k), "cpu": 0.5 * k, "steps": 9} for k in (3, 1, 8)])
    monkeypatch.setattr(baseline, "tracked", lambda changes: next(runs))
    assert baseline._solver(3) == {"wall": 3.0, "cpu": 1.5, "least": 0.5, "repeats": 3, "steps": 9}


def test_warm_process_is_not_the_one_that_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    words: list[list[str]] = []

    def command(given: list[str], more: Mapping[str, str], folder: Path) -> Ended:
        words.append(given)
        assert folder.is_dir()
        return Ended(Spent(99.0 if len(words) == 1 else 1.0, 0.5), "")

    monkeypatch.setattr(baseline, "measured", command)
    assert baseline._process(2) == {"wall": 1.0, "cpu": 0.5, "least": 0.5, "repeats": 2}
    assert len(words) == 3
    assert words[0][:5] == ["-m", "peristalsis", "run", "baseline", "--no-plots"]


def test_phases_are_medians_over_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    outputs = iter([[("a", k, 2 * k), ("b", 10 * k, 0)] for k in (1, 5, 2)])
    monkeypatch.setattr(baseline, "code", lambda text: Ended(Spent(0.0, 0.0), json.dumps(next(outputs))))
    assert baseline._phases(3) == [("a", 2, 4), ("b", 20, 0)]


def test_first_process_has_a_cache_of_its_own_and_leaves_it_to_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    caches: list[Path] = []

    def first(words: list[str], more: Mapping[str, str], folder: Path) -> Ended:
        cache = Path(more["NUMBA_CACHE_DIR"])
        assert not cache.exists()
        (cache / "sub").mkdir(parents=True)
        for name in ("one.nbc", "sub/two.nbc", "one.nbi"):
            (cache / name).touch()
        caches.append(cache)
        return Ended(Spent(30.0, 20.0), "")

    def next_one(text: str, more: Mapping[str, str]) -> Ended:
        assert Path(more["NUMBA_CACHE_DIR"]) == caches[0]
        assert caches[0].is_dir()
        return Ended(Spent(1.0, 1.0), '{"compiled": 0, "loaded": 12}')

    monkeypatch.setattr(baseline, "measured", first)
    monkeypatch.setattr(baseline, "code", next_one)
    expected = {"wall": 30.0, "cpu": 20.0, "kernels": 2, "compiled_by_next": 0, "loaded_by_next": 12}
    assert baseline._first() == expected


# --- shared runs --------------------------------------------------------------------------------------


def test_track_of_a_run_that_does_not_arrive_ends_with_the_run() -> None:
    found = tracked({**COARSE, "run.duration": "0.1 s"})
    assert found["transit"] is None
    assert found["until"] == pytest.approx(0.1)
    assert found["steps"] == 50
    assert len(found["places"]) == SAMPLES
    assert found["cpu"] > 0.0


def test_stretch_reports_what_was_simulated() -> None:
    found = stretch("baseline", COARSE, "10 ms")
    assert (found.steps, found.simulated) == (5, pytest.approx(0.01))
    assert found.newton >= 5
    assert found.solver.wall <= found.loop.wall


@pytest.mark.parametrize("changes", [FINEST, QUICK_FINEST])
def test_converged_runs_are_finer_in_everything(changes: Mapping[str, Any]) -> None:
    shipped, fine = Configuration(), Configuration().with_changes(dict(changes))
    times = 4 if changes is FINEST else 2
    assert (fine.grid.n_z, fine.grid.n_z_wall) == (times * shipped.grid.n_z, times * shipped.grid.n_z_wall)
    assert (fine.step.wall, fine.step.conduction) == (shipped.step.wall / times, shipped.step.conduction / times)


# --- work and precision -------------------------------------------------------------------------------


@pytest.mark.parametrize(("cpu", "by", "better"), [(0.5, 0.01, 1.0), (0.5, 0.03, 0.0), (1.5, 0.01, 0.0)])
def test_points_that_beat_the_shipped_one_are_named(cpu: float, by: float, better: float) -> None:
    """Quicker and nearer, both: here at most the one with half of the cells."""

    def answer(name: str) -> dict[str, Any]:
        if name == "converged track":
            return TRACK
        if name == "precision, 350 cells":
            return shifted(by, transit=None, **timing(cpu))
        return shifted(0.02 if name == "precision, shipped" else 0.5, transit=2.02, **timing(1.0))

    found = precision.run(Told(answer))
    assert [one.value for one in found.figures] == pytest.approx([0.2, better])
    assert found.figures[1].note == ("also 350 cells" if better else "no other point is both quicker and nearer")
    rows = {row[0]: row for row in found.tables[0].rows}
    assert rows["shipped"] == pytest.approx(("shipped", 1.0, 0.2, 1.0, 1000))
    assert rows["350 cells"][2:4] == (pytest.approx(10.0 * by), None)
    assert "1000 steps, transit 2.00000 s" in found.tables[0].caption
    lines = {line.label: line for line in found.plots[0].lines}
    assert list(lines["conduction grid"].x) == sorted([1.0, cpu]), "the shipped point is on the curve"
    assert len(lines["wall step, backward Euler"].x) == 1, "and not on this one"
    assert lines["shipped"].marker == "*"


@pytest.mark.parametrize("full", [False, True])
def test_choices_are_possible_and_change_one_thing(full: bool) -> None:
    shipped = Configuration().digest()
    seen: set[str] = set()
    for name, choices in precision.series(full).items():
        assert len(choices) >= (3 if full else 1)
        for label, changes in choices:
            text = Configuration().with_changes(changes).digest()
            assert text not in seen | {shipped}, label
            seen.add(text)
            if name.endswith("grid"):
                assert len(changes) == 1
    assert set(precision.THROUGH_DEFAULT) < set(precision.series(full))


def test_precision_is_of_the_first_run_and_its_cost_a_median(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = iter([{"wall": w, "cpu": w, "steps": 5 + w} for w in (4.0, 2.0, 3.0)])
    monkeypatch.setattr(precision, "tracked", lambda changes: next(runs))
    assert precision._measured({}, 3) == {"wall": 3.0, "cpu": 3.0, "least": 2.0, "repeats": 3, "steps": 9.0}


# --- memory -------------------------------------------------------------------------------------------


def test_memory_is_counted_beyond_the_package() -> None:
    held = {f"memory, {name}": 1e6 * (k + 1) for k, name in enumerate(memory.CASES)}
    found = memory.run(Told(held.__getitem__))
    assert [one.value for one in found.figures] == [3.0, 4.0, 5.0]
    assert [row[1:] for row in found.tables[0].rows] == [(1, -1), (2, 0), (3, 1), (4, 2), (5, 3)]


@pytest.mark.parametrize("text", memory.CASES.values(), ids=memory.CASES.keys())
def test_memory_is_of_runs_that_exist(text: str) -> None:
    compile(text, "case", "exec")
    changes = re.search(r"'baseline', (.*)\)$", text)
    if changes is not None:
        assert Configuration().with_changes(eval(changes[1])).wall.length == 10.0


# --- roofline -----------------------------------------------------------------------------------------

PARTS = ("gates", "cell", "sheet", "wall forces", "wall tangent", "wall solve")


def of_the_roofline(name: str) -> dict[str, Any]:
    if name == "roofline, counts":
        counts = {"add": 30.0, "multiply": 50.0, "divide": 10.0, "root": 10.0, "load": 6.0, "store": 4.0, "depth": 11.0}
        return dict.fromkeys(PARTS, counts)
    limits = {
        "peak": 1e10,
        "cache": 1e10,
        "memory": 0.0,
        "link": 1e-9,
        "divide": 2e-9,
        "division": 5e-9,
        "tables": 6e-8,
    }
    return limits | dict.fromkeys(PARTS, 1e-7) | {f"{part}, bytes": 80.0 for part in PARTS}


def test_fractions_of_the_nearest_limit() -> None:
    """100 flops at 10 a ns, 20 divisions of 2 ns, 80 bytes at 10 a ns, tables of 60 ns; all kernels take 100 ns."""
    found = roofline.run(Told(of_the_roofline))
    nearest = {row[0]: (row[7], row[8], row[9]) for row in found.tables[1].rows}
    for name in ("gates", "cell", "sheet"):
        assert nearest[name] == ("reading the tables", pytest.approx(60.0), pytest.approx(60.0))
    for name in ("wall forces", "wall tangent", "wall solve"):
        assert nearest[name] == ("divisions and roots", pytest.approx(40.0), pytest.approx(40.0))
    gates = found.tables[1].rows[0]
    assert gates[1:7] == pytest.approx((100.0, 20.0, 80.0, 80.0, 100.0, 1.0))
    assert figure(found, "cell, of its nearest limit").value == pytest.approx(60.0)
    assert figure(found, "cell, of its nearest limit").note == "reading the tables"
    machine_table = dict(found.tables[0].rows)
    assert machine_table["additions and multiplications, in registers"] == "10 Gflop/s"
    assert machine_table["triad, 192 MB (in memory)"] == "with --full"


def test_chain_of_the_solve_is_a_limit_of_its_own() -> None:
    """Ten operations of 8 ns and a division wait for each other."""

    def answer(name: str) -> dict[str, Any]:
        return of_the_roofline(name) | ({} if name.endswith("counts") else {"link": 8e-9, "memory": 2e9})

    found = roofline.run(Told(answer, "full"))
    solve = found.tables[1].rows[-1]
    assert solve[0] == "wall solve"
    assert solve[7:9] == ("chain of dependent operations", pytest.approx(85.0))
    assert dict(found.tables[0].rows)["triad, 192 MB (in memory)"] == "2 GB/s"


@pytest.mark.parametrize("full", [False, True])
def test_limits_are_work_over_time(one_second: None, monkeypatch: pytest.MonkeyPatch, full: bool) -> None:
    monkeypatch.setattr(roofline, "IN_MEMORY", 1000)
    found = roofline._measured(1, full)
    assert found["peak"] == 2 * machine_limits.PAIRS * 512 * roofline.ROUNDS
    assert found["cache"] == 24 * roofline.IN_CACHE
    assert found["memory"] == (24_000 if full else 0.0)
    assert found["link"] == 0.5 / roofline.LENGTH
    assert found["divide"] == 1.0 / (512 * roofline.ROUNDS)
    assert found["division"] == 1.0 / roofline.LENGTH - found["link"]
    assert found["gates"] == 1e-3
    assert found["sheet"] == 1e-3 / kernels.SUBSTEPS
    assert found["wall solve"] == 0.0, "without the copy that it begins with"
    model = kernels.shipped_model()
    sheet = kernels.sheet(model, 10, exact=False, conducts=True)
    assert found["sheet, bytes"] == sheet.compulsory / kernels.SUBSTEPS
    assert found["gates, bytes"] == kernels.gates(model, 10, exact=False).compulsory


def test_singular_wall_of_the_bench_is_noticed() -> None:
    solve = next(kernel for kernel in kernels.wall(kernels.shipped_model(64, 64)) if kernel.name == "wall solve")
    pristine, system, nodes = solve.arguments
    solve()
    with pytest.raises(ArithmeticError, match="singular"):
        solve.function(0.0 * pristine, system, nodes)


# --- ions ---------------------------------------------------------------------------------------------


def of_the_ions(name: str) -> dict[str, Any]:
    if name == "ions, rates":
        return {
            kernel: {"nodes": 1000, "cells": 1000, **timing(cpu * (4.0 if "exact" in kernel else 1.0))}
            for what, cpu in (("gates", 1e-5), ("cell", 2e-5), ("sheet", 2.5e-5))
            for kernel in (what, f"{what}, exact", f"{what}, many", f"{what}, many, shuffled")
        }
    if name == "ions, error of the tables":
        return {
            "largest": 2e-4,
            "rows": [["longitudinal", 2e-4, 1e-5, 1e-6, 0.01], ["circular", 1e-4, 1e-5, 0.0, None]],
        }
    assert name == "ions, Myokit"
    return {
        "version": "1.2",
        "cells": 1000,
        "step": 0.25,
        "duration": 400.0,
        "ratio": 7.0,
        "ratio_exact": 3.0,
        "cable": [["peristalsis, tables", 10.0, 5.0], ["peristalsis, exponentials", 30.0, 5.0], ["Myokit", 50.0, None]],
        "agreement": [[0.02, 0.4], [0.01, 0.2]],
        "extrapolated": 1e-3,
    }


def test_rates_of_the_ions(monkeypatch: pytest.MonkeyPatch) -> None:
    """100 million a second with tables, four times as many as with exponentials; an error above the aim is a miss."""
    monkeypatch.setattr("benchmarks.myokit_cable.missing", lambda: "it is not here.")
    found = ions.run(Told(of_the_ions))
    assert figure(found, "gates with tables, one thread").value == pytest.approx(100.0)
    assert figure(found, "gates with tables, one thread").met
    over = figure(found, "gates with tables over exponentials")
    assert (over.value, over.met) == (pytest.approx(4.0), False)
    assert figure(found, "largest error of the tables").met is False
    rows = {row[0]: row[1:] for row in found.tables[0].rows}
    assert rows["cell, tables"] == pytest.approx((1000, 20.0, 50.0))
    assert rows["sheet, exact"] == pytest.approx((1000, 100.0, 10.0))
    assert found.notes == ("Myokit was not measured: it is not here.",)


def test_ions_beside_myokit(monkeypatch: pytest.MonkeyPatch) -> None:
    """A node-step of 50 ns there, 40 million a second here: twice."""
    monkeypatch.setattr("benchmarks.myokit_cable.missing", lambda: None)
    found = ions.run(Told(of_the_ions, "full"))
    assert figure(found, "sheet over Myokit's 1-D simulation").value == pytest.approx(2.0)
    assert figure(found, "with a wave on its way").value == 7.0
    assert "A cable of 1000 cells, steps of 0.25 ms, 400 ms" in found.tables[2].caption
    assert found.tables[2].rows[2] == ("Myokit", 50.0, None)
    assert found.tables[3].rows == ((0.02, 0.4), (0.01, 0.2))
    assert "second order in space" in found.notes[0]


def test_rates_are_of_all_kernels(one_second: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ions, "MANY", 3000)
    found = ions._rates(2)
    assert set(of_the_ions("ions, rates")) >= set(found) >= {"gates, many, shuffled", "sheet, exact"}
    assert found["gates, many"] == {"nodes": 3000, "cells": 3000} | {
        "wall": 2.0,
        "cpu": 1.0,
        "least": 1.0,
        "repeats": 2,
    }
    assert found["sheet"]["nodes"] == 1000 * kernels.SUBSTEPS


@pytest.mark.parametrize("ended", [False, True])
def test_error_of_the_tables(monkeypatch: pytest.MonkeyPatch, ended: bool) -> None:
    """By layer largest, rms over all steps, largest before the wave, shift of activation; small and not nothing."""
    seen: dict[bool, list[tuple[Any, Any]]] = {False: [], True: []}

    class Ending(Simulation):
        def advance(self, duration: str) -> State:  # type: ignore[override]
            state = super().advance(duration)
            self.stopped = "made up" if ended else None
            potentials = (state.longitudinal.potential.copy(), state.circular.potential.copy())
            seen[bool(self.model.exact_kinetics)].append(potentials)
            return state

    monkeypatch.setattr(ions, "Simulation", Ending)
    found = ions._table_error("0.1 s")
    assert [row[0] for row in found["rows"]] == ["longitudinal", "circular"]
    differences = np.array(seen[False]) - np.array(seen[True])
    assert len(differences) == (1 if ended else 20)
    for layer, (_, largest, rms, early, _) in enumerate(found["rows"]):
        assert rms == pytest.approx(np.sqrt(np.mean(differences[:, layer] ** 2)))
        assert 0.0 < largest == np.abs(differences[:, layer]).max() < 1e-2
        assert early <= largest
    assert found["largest"] == max(row[1] for row in found["rows"])
    shifts = [row[4] for row in found["rows"]]
    assert shifts == [None, None] if ended else all(0.0 <= shift < 0.1 for shift in shifts)


# --- the explicit scheme --------------------------------------------------------------------------------


def test_a_checkout_has_the_evidence() -> None:
    assert explicit.run(Told(lambda name: None)).figures


def test_installation_without_the_evidence_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(explicit, "EVIDENCE", tmp_path / "explicit.md")
    assert "not part of this installation" in explicit.run(Told(lambda name: None)).notes[0]
