"""The run that everybody makes first: solver, whole process, first process of all."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from ...config import Configuration
from ..clock import Spent, Timing, plain
from ..process import code, measured
from ..runs import reference, track_error, tracked
from ..section import Bench, Figure, Findings, Section, Table

AIM = 0.25
"""Solver time aimed at [s], for 2.5 s of gut."""
GUT = 2.5

CENSUS = (
    "import json, peristalsis as ps; ps.run('baseline', {'run.duration': '0.1 s'});"
    "from peristalsis.benchmark.census import census; print(json.dumps(vars(census())))"
)


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
        Figure("transit less converged", late, "%", note=f"{transit:.4f} against {converged['transit']:.4f} s"),
        Figure("track, rms difference to converged", rms, "mm", note="of 79 mm of travel"),
        Figure(
            "whole process, warm, wall", process["wall"], "s", high=2.0, note=f"cpu {process['cpu']:.3g} s, no plots"
        ),
    ]
    tables = []
    if bench.full:
        first = bench.piece("baseline, first process", _first)
        figures += [
            Figure("first process, wall", first["wall"], "s", high=30.0, note="empty cache of kernels"),
            Figure("first process, cpu", first["cpu"], "s", high=30.0, note=f"{first['kernels']} kernels compiled"),
            Figure("kernels that the next process compiles", float(first["compiled_by_next"]), "", high=0.0),
        ]
        spread = (("first, empty cache", first["wall"], first["cpu"]),)
    else:
        spread = ()
    rows = (*spread, ("warm", process["wall"], process["cpu"]), ("solver alone", runs["wall"], runs["cpu"]))
    tables.append(
        Table(
            "Where a process spends its time.", ("`peristalsis run baseline --no-plots`", "wall (s)", "cpu (s)"), rows
        )
    )
    return Findings(tuple(figures), tuple(tables))


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


def _first() -> dict[str, Any]:
    import json

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
        "The shipped baseline on shipped grids and steps, in this process (solver) and as a command that writes its result. The error is that of the "
        "same run: transit and track against a run on grids and steps four times finer (twice with `--quick`)."
    ),
    run=run,
    place=10,
)
