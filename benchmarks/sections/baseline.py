"""The run that everybody makes first: solver, whole process, first process of all."""

from __future__ import annotations

import json
import statistics
import tempfile
from pathlib import Path
from typing import Any

from peristalsis.inputs.config import Configuration

from ..clock import Spent, Timing, plain
from ..process import code, measured
from ..runs import reference, track_error, tracked
from ..section import Bench, Figure, Findings, Section, Table

AIM = 0.25
"""Solver time aimed at [s], for 2.5 s of gut."""
GUT = 2.5

CENSUS = (
    "import json, peristalsis as ps; ps.run('baseline', {'run.duration': '0.1 s'});"
    "from benchmarks.census import census; print(json.dumps(vars(census())))"
)

PHASES = """
import json, tempfile, time
from pathlib import Path
found, last = [], (time.perf_counter(), time.process_time())
begun = last[1]
def phase(name):
    global last
    now = time.perf_counter(), time.process_time()
    found.append((name, now[0] - last[0], now[1] - last[1]))
    last = now
from peristalsis import scenarios
from peristalsis.running.runner import run
from peristalsis.running.simulation import Simulation
phase("imports for a run")
from peristalsis.running.warm_up import warm_up
warm_up()
phase("loading kernels")
simulation = Simulation(scenarios.configuration("baseline"))
phase("rest, inflation, insertion")
from benchmarks.parts import SOLVER, clocked
last = time.perf_counter(), time.process_time()
with clocked(SOLVER) as spent:
    result = simulation.run()
phase("the loop")
name, wall, cpu = found.pop()
solver = spent["solver"]
found += [("solver", solver.wall, solver.cpu), ("observers", wall - solver.wall, cpu - solver.cpu)]
result.dataset
phase("imports and tables of the result")
with tempfile.TemporaryDirectory() as folder:
    result.save(Path(folder) / "out")
phase("writing")
print(json.dumps([("interpreter", begun, begun), *found]))
"""
"""A run in a fresh process, phase by phase; the interpreter's start is known as processor time only."""


def run(bench: Bench) -> Findings:
    """Solver, error, whole process; with full effort also the first process on a machine."""
    configuration = Configuration()
    grid, step = configuration.grid, configuration.step
    runs = bench.piece("baseline, solver", lambda: _solver(bench.repeats()))
    process = bench.piece("baseline, whole process", lambda: _process(bench.repeats()))
    converged = reference(bench)
    node_steps = runs["steps"] * (2 * grid.n_z * round(step.wall / step.conduction) + grid.n_z_wall)
    per_gut = GUT / runs["until"]
    transit = runs["transit"]
    late = None if transit is None else 100.0 * (transit / converged["transit"] - 1.0)
    arrived = "none" if transit is None else f"{transit:.4f}"
    rms = 10.0 * track_error(runs, converged)
    figures = [
        Figure(
            "solver, 2.5 s of gut, cpu",
            runs["cpu"] * per_gut,
            "s",
            high=AIM,
            note=f"median of {runs['repeats']}; wall {runs['wall'] * per_gut:.3g} s",
        ),
        Figure("solver, a step", 1e3 * runs["cpu"] / runs["steps"], "ms", note=f"{runs['steps']} steps"),
        Figure(
            "solver, per node-step",
            1e9 * runs["cpu"] / node_steps,
            "ns",
            note="steps of the cells of both sheets, and of the wall's nodes",
        ),
        Figure("transit less converged", late, "%", note=f"{arrived} against {converged['transit']:.4f} s"),
        Figure("track, rms difference to converged", rms, "mm", note="of 79 mm of travel"),
        Figure(
            "whole process, warm, wall", process["wall"], "s", high=2.0, note=f"cpu {process['cpu']:.3g} s, no plots"
        ),
    ]
    spread: list[tuple[str, float, float]] = []
    if bench.full:
        first = bench.piece("baseline, first process", _first)
        figures += [
            Figure("first process, wall", first["wall"], "s", high=30.0, note="empty cache of kernels"),
            Figure("first process, cpu", first["cpu"], "s", high=30.0, note=f"{first['kernels']} kernels compiled"),
            Figure("kernels that the next process compiles", float(first["compiled_by_next"]), "", high=0.0),
        ]
        spread.append(("first process, empty cache", first["wall"], first["cpu"]))
    phases = bench.piece("baseline, phases of a process", lambda: _phases(bench.repeats()))
    spread.append(("warm process", process["wall"], process["cpu"]))
    spread += [(f"of it, {name}", wall, cpu) for name, wall, cpu in phases]
    head = ("`peristalsis run baseline --no-plots`", "wall (s)", "cpu (s)")
    caption = "Where a process spends its time; phases are medians over processes of their own."
    return Findings(tuple(figures), (Table(caption, head, tuple(spread)),))


def _solver(repeats: int) -> dict[str, Any]:
    runs = [tracked({}) for _ in range(repeats)]
    timing = Timing.of([Spent(one["wall"], one["cpu"]) for one in runs])
    return runs[0] | plain(timing)


def _command(more: dict[str, str], folder: Path) -> Any:
    words = ["-m", "peristalsis", "run", "baseline", "--no-plots", "--out", str(folder / "out"), "--overwrite"]
    return measured(words, more, folder)


def _process(repeats: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        _command({}, Path(folder))  # kernels are in the cache from here on
        return plain(Timing.of([_command({}, Path(folder)).spent for _ in range(repeats)]))


def _phases(repeats: int) -> list[tuple[str, float, float]]:
    """(phase, wall, cpu) as medians over processes."""
    runs = [json.loads(code(PHASES).output) for _ in range(repeats)]
    return [
        (phases[0][0], statistics.median(p[1] for p in phases), statistics.median(p[2] for p in phases))
        for phases in zip(*runs, strict=True)
    ]


def _first() -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        cache = {"NUMBA_CACHE_DIR": str(Path(folder) / "cache")}
        ended = _command(cache, Path(folder))
        files = sum(1 for _ in Path(folder, "cache").rglob("*.nbc"))
        second = json.loads(code(CENSUS, cache).output)
    return {
        "wall": ended.spent.wall,
        "cpu": ended.spent.cpu,
        "kernels": files,
        "compiled_by_next": second["compiled"],
        "loaded_by_next": second["loaded"],
    }


SECTION = Section(
    name="baseline",
    title="The baseline",
    about=(
        "The shipped baseline on shipped grids and steps, in this process (solver) and as a command that writes its "
        "result. The error is that of the "
        "same run: transit and track against a run on grids and steps four times finer (twice with `--quick`)."
    ),
    run=run,
    place=10,
)
