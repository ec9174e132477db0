"""Batches in two processes against one."""

from __future__ import annotations

import os
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from peristalsis.many.batch import batch
from peristalsis.many.plan import read_plan
from peristalsis.storing.environment import processors

from ..section import Bench, Figure, Findings, Section, Table

AIM = 1.85
PLAN = """
[changes]
run.checkpoint = "0 s"
[grid]
pellet.viscous_friction = [{values}]
"""


def run(bench: Bench) -> Findings:
    """One and two processes in turns; the best of each."""
    if processors() < 2:
        return Findings(
            (), notes=("This process may use one processor only: two workers cannot be compared with one.",)
        )
    counts = {8: 5, 32: 2} if bench.full else {8: 2}
    figures, rows = [], []
    for count, repeats in counts.items():
        found = bench.piece(f"workers, {count} runs", partial(_turns, count, repeats))
        one, two = min(found["one"]), min(found["two"])
        busy = found["cpu_one"] / one
        figures.append(
            Figure(
                f"two workers over one, {count} baselines",
                one / two,
                "times",
                low=AIM,
                note=f"best of {len(found['one'])}, on the clock; the one had {100 * busy:.0f} % of a processor",
            )
        )
        ideal = found["cpu_one"] / (found["cpu_children"] / 2.0 + found["cpu_parent"])
        figures.append(
            Figure(
                f"the same by processor time, {count} baselines", ideal, "times", note="as if both processors were free"
            )
        )
        rows.append((count, one, two, one / two, found["cpu_one"], found["cpu_children"], found["cpu_parent"], ideal))
    head = (
        "runs",
        "one, wall (s)",
        "two, wall (s)",
        "ratio",
        "one, cpu (s)",
        "two, cpu of both (s)",
        "and of the first process (s)",
        "by cpu",
    )
    caption = "Whole baselines of a batch, results on disk: one process, and two that are started for it."
    return Findings(tuple(figures), (Table(caption, head, tuple(rows)),))


def _turns(count: int, repeats: int) -> dict[str, Any]:
    found: dict[str, list[tuple[float, float, float]]] = {"one": [], "two": []}
    for _ in range(repeats):
        for name, workers in (("one", 1), ("two", 2)):
            found[name].append(_batch(count, workers))
    one, two = (min(found[name]) for name in ("one", "two"))
    return {
        "one": [wall for wall, _, _ in found["one"]],
        "two": [wall for wall, _, _ in found["two"]],
        "cpu_one": one[1],
        "cpu_parent": two[1],
        "cpu_children": two[2],
    }


def _batch(count: int, workers: int) -> tuple[float, float, float]:
    """(seconds on the clock, of this processor, of the processes it started) of a batch."""
    values = ", ".join(f'"{200 + k} mN*s/cm"' for k in range(count))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "runs.toml"
        file.write_text(PLAN.format(values=values), encoding="utf-8")
        plan = read_plan(file)
        before = os.times()
        batch(plan, Path(folder) / "out", workers=workers)
        after = os.times()
    own = after.user + after.system - before.user - before.system
    children = after.children_user + after.children_system - before.children_user - before.children_system
    return after.elapsed - before.elapsed, own, children


SECTION = Section(
    name="workers",
    title="Two processes",
    about=(
        "`peristalsis batch` with one worker and with two, in turns. Two processes are started for every batch and "
        "load the kernels that one had compiled, which is part of the time."
    ),
    run=run,
    place=45,
)
