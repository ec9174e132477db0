"""How much memory a run takes: the most that a process of its own held."""

from __future__ import annotations

from functools import partial

from ..process import peak_bytes
from ..runs import FINE
from ..section import Bench, Figure, Findings, Section, Table

RUN = "import peristalsis as ps; ps.run('baseline', {changes!r})"
CASES = {
    "interpreter with numpy": "import numpy",
    "package and kernels, no run": "from peristalsis.running.warm_up import warm_up; warm_up()",
    "baseline": RUN.format(changes={}),
    "6400 cells, 5120 elements": RUN.format(
        changes={**FINE, "grid.n_z": 6400, "grid.n_z_wall": 5120, "run.duration": "0.2 s"}
    ),
    "surface, 200 x 64": RUN.format(
        changes={
            "grid.n_z": 200,
            "grid.n_z_wall": 200,
            "grid.n_theta": 64,
            "run.duration": "0.02 s",
            "output.interval": "5 ms",
        }
    ),
}


def run(bench: Bench) -> Findings:
    """One process a case."""
    peak = {name: bench.piece(f"memory, {name}", partial(peak_bytes, text)) for name, text in CASES.items()}
    floor = peak["package and kernels, no run"]
    figures = tuple(
        Figure(f"{name}, most resident", peak[name] / 1e6, "MB")
        for name in ("baseline", "6400 cells, 5120 elements", "surface, 200 x 64")
    )
    rows = tuple((name, value / 1e6, (value - floor) / 1e6) for name, value in peak.items())
    caption = "Largest resident memory of a fresh process that runs it and keeps its result."
    return Findings(figures, (Table(caption, ("process", "MB", "beyond package and kernels (MB)"), rows),))


SECTION = Section(
    name="memory",
    title="Memory",
    about=(
        "The largest resident memory of a process, as the system counts it. Outputs that a run records are part of it; "
        "they grow with time and fields."
    ),
    run=run,
    place=80,
)
