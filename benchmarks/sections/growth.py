"""How cost grows: with cells along and around the tube, with simulated time, with the number of runs."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from peristalsis.many.batch import batch
from peristalsis.many.plan import read_plan

from ..clock import Stopwatch, Timing, exponent, plain
from ..runs import FINE, stretch
from ..section import Bench, Figure, Findings, Line, Plot, Section, Table

AIM = 1.1
ALONG_QUICK, ALONG = (200, 400, 800, 1600), (100, 200, 400, 800, 1600, 3200, 6400)
AROUND_QUICK, AROUND = (8, 16, 32), (4, 8, 16, 32, 64, 128)
TIMES_QUICK, TIMES = (3, 6, 12), (3, 6, 12, 24, 48)
COUNTS_QUICK, COUNTS = (1, 2, 4), (1, 2, 4, 8, 16, 32)

BUSY = {
    "grid.n_z": 200,
    "grid.n_z_wall": 160,
    "circular.active": 0.0,
    "pacemaker.kind": "periodic",
    "pacemaker.period": "3 s",
    "output.interval": "0.1 s",
}
"""A coarse tube whose pellet stays: a wave of the longitudinal layer every 3 s, for as long as is asked for."""

RUNS = """
[changes]
run.duration = "0.1 s"
grid.n_z = 200
grid.n_z_wall = 160
[grid]
pellet.viscous_friction = [{values}]
"""


def run(bench: Bench) -> Findings:
    """Four series, an exponent each."""
    full = bench.full
    series = {
        "cells along": [
            (n, bench.piece(f"growth, {n} cells along", partial(_along, n, bench.repeats(3, 5))))
            for n in (ALONG if full else ALONG_QUICK)
        ],
        "columns around": [
            (n, bench.piece(f"growth, {n} columns", partial(_around, n, bench.repeats(3, 5))))
            for n in (AROUND if full else AROUND_QUICK)
        ],
        "simulated time": [
            (n, bench.piece(f"growth, {n} s", partial(_time, n, bench.repeats(1, 3))))
            for n in (TIMES if full else TIMES_QUICK)
        ],
        "runs in a batch": [
            (n, bench.piece(f"growth, {n} runs", partial(_batch, n, bench.repeats(3, 5))))
            for n in (COUNTS if full else COUNTS_QUICK)
        ],
    }
    about = {
        "cells along": "wall elements in proportion, 0.8 a cell",
        "columns around": "ring-uniform waves, 100 cells along",
        "simulated time": "a wave every 3 s",
        "runs in a batch": "short runs to files, one process",
    }
    figures, tables, lines = [], [], []
    for name, points in series.items():
        sizes = [float(size) for size, _ in points]
        costs = [float(point["cpu"]) for _, point in points]
        fit = exponent(sizes, costs)
        figures.append(
            Figure(
                f"exponent, {name}",
                fit.value,
                "",
                high=AIM,
                note=f"± {fit.half_width:.2g} (95 %), {points[0][0]} to {points[-1][0]}; {about[name]}",
            )
        )
        rows = tuple(
            (size, point["cpu"], point["wall"], 1e3 * point["cpu"] / size, point.get("steps"), point.get("newton"))
            for size, point in points
        )
        head = (name, "cpu (s)", "wall (s)", "cpu for each (ms)", "steps", "Newton iterations")
        tables.append(Table(f"Cost against {name}: {about[name]}.", head, rows))
        scaled = tuple(size / sizes[0] for size in sizes)
        lines.append(
            Line(f"{name}: {fit.value:.2f} ± {fit.half_width:.2f}", scaled, tuple(c / costs[0] for c in costs))
        )
    most = max(max(line.x) for line in lines)
    lines.append(Line("in proportion", (1.0, most), (1.0, most), style="--", marker=""))
    plot = Plot(
        "growth", "Cost against size, both over the smallest: exponents", "size", "processor time", tuple(lines)
    )
    return Findings(tuple(figures), tuple(tables), plots=(plot,))


def _stretches(scenario: str, changes: Mapping[str, Any], duration: str, repeats: int) -> dict[str, Any]:
    found = [stretch(scenario, changes, duration) for _ in range(repeats)]
    return plain(Timing.of([one.solver for one in found])) | {"steps": found[0].steps, "newton": found[0].newton}


def _along(cells: int, repeats: int) -> dict[str, Any]:
    return _stretches("baseline", {**FINE, "grid.n_z": cells, "grid.n_z_wall": 4 * cells // 5}, "0.5 s", repeats)


def _around(columns: int, repeats: int) -> dict[str, Any]:
    changes = {"grid.n_z": 100, "grid.n_z_wall": 80, "grid.n_theta": columns, "output.interval": "0.1 s"}
    return _stretches("baseline", changes, "0.04 s", repeats)


def _time(seconds: int, repeats: int) -> dict[str, Any]:
    return _stretches("baseline", {**BUSY, "run.duration": f"{seconds} s"}, f"{seconds} s", repeats)


def _batch(runs: int, repeats: int) -> dict[str, Any]:
    values = ", ".join(f'"{200 + k} mN*s/cm"' for k in range(runs))
    spent = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "runs.toml"
            file.write_text(RUNS.format(values=values), encoding="utf-8")
            plan = read_plan(file)
            with Stopwatch() as watch:
                batch(plan, Path(folder) / "out")
            spent.append(watch.spent)
    return plain(Timing.of(spent))


SECTION = Section(
    name="growth",
    title="Growth of the cost",
    about=(
        "Processor time of the solver (of a whole batch, for the number of runs) against size. Exponents p of cost = a "
        "sizeᵖ by least squares of the logarithms, with the 95 % interval. Steps are the shipped ones at every size, "
        "so the sheets' explicit step takes more stages on finer grids. Cells along run with a residual tolerance of "
        "1e-7: beyond some 3000 wall elements rounding alone exceeds the shipped 1e-8."
    ),
    run=run,
    place=40,
)
