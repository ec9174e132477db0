"""Work and precision: error of the pellet's track against processor time, one choice changed at a time."""

from __future__ import annotations

from typing import Any

from peristalsis.inputs.config import Configuration

from ..clock import Spent, Timing, plain
from ..runs import reference, track_error, tracked
from ..section import Bench, Figure, Findings, Line, Plot, Section, Table

Changes = dict[str, Any]


def run(bench: Bench) -> Findings:
    """Every point once (thrice with full effort, its time a median); the default among them."""
    converged = reference(bench)
    repeats = bench.repeats(1, 3)
    lines, rows = [], []

    def point(label: str, changes: Changes) -> tuple[float, float]:
        found = bench.piece(f"precision, {label}", lambda: _measured(changes, repeats))
        error = 10.0 * track_error(found, converged)
        transit = None if found["transit"] is None else 100.0 * (found["transit"] / converged["transit"] - 1.0)
        rows.append((label, found["cpu"], error, transit, found["steps"]))
        return float(found["cpu"]), error

    shipped = point("shipped", {})
    for name, choices in series(bench.full).items():
        points = [point(label, changes) for label, changes in choices]
        points.append(shipped) if name in THROUGH_DEFAULT else None
        points.sort()
        lines.append(Line(name, tuple(cpu for cpu, _ in points), tuple(error for _, error in points)))
    lines.append(Line("shipped", (shipped[0],), (shipped[1],), style="", marker="*"))
    better = [row[0] for row in rows if row[1] <= shipped[0] and row[2] <= shipped[1] and row[0] != "shipped"]
    note = f"also {', '.join(better)}" if better else "no other point is both quicker and nearer"
    head = ("baseline with", "solver, cpu (s)", "rms of the track (mm)", "transit (%)", "steps")
    figures = (
        Figure("error of the shipped baseline, rms", shipped[1], "mm", note="of 79 mm of travel"),
        Figure("points quicker and nearer than the shipped", float(len(better)), "", note=note),
    )
    plot = Plot(
        "precision",
        "Work and precision: every curve changes one choice of the shipped baseline",
        "solver, processor time (s)",
        "rms error of the pellet's track (mm)",
        tuple(lines),
    )
    until = converged["transit"]
    caption = f"Against the converged run ({converged['steps']} steps, transit {until:.5f} s)."
    return Findings(figures, (Table(caption, head, tuple(rows)),), plots=(plot,))


THROUGH_DEFAULT = ("conduction grid", "wall grid", "conduction step", "wall step, second order", "everything")
"""Series that the shipped run is a point of."""


def series(full: bool) -> dict[str, list[tuple[str, Changes]]]:
    """Series to (label, changes), without the shipped run."""
    shipped = Configuration()
    n, e = shipped.grid.n_z, shipped.grid.n_z_wall
    wall, cell = shipped.step.wall, shipped.step.conduction
    grids = (0.25, 0.5, 2.0) if full else (0.5,)
    found: dict[str, list[tuple[str, Changes]]] = {
        "conduction grid": [(f"{round(n * f)} cells", {"grid.n_z": round(n * f)}) for f in grids],
        "wall grid": [(f"{round(e * f)} elements", {"grid.n_z_wall": round(e * f)}) for f in grids],
        "conduction step": [
            (f"conduction step {cell * f:g} ms", {"step.conduction": f"{cell * f!r} ms"})
            for f in ((0.25, 0.5, 2.5, 5.0) if full else (2.5,))
        ],
        "wall step, second order": [
            (f"wall step {wall * f:g} ms", _steps(wall * f, cell)) for f in ((0.25, 0.5, 2.0) if full else (2.0,))
        ],
        "wall step, backward Euler": [
            (f"wall step {wall * f:g} ms, Euler", _steps(wall * f, cell) | {"step.scheme": "euler"})
            for f in ((0.125, 0.25, 0.5, 1.0, 2.0) if full else (1.0,))
        ],
        "everything": [
            (
                f"all grids x {f:g}, all steps / {f:g}",
                _steps(wall / f, cell / f) | {"grid.n_z": round(n * f), "grid.n_z_wall": round(e * f)},
            )
            for f in ((0.5, 0.75, 2.0) if full else (0.5,))
        ],
    }
    found["steps by error"] = [
        (f"steps by error, up to {longest:g} ms", _by_error(longest))
        for longest in ((2.0, 4.0, 8.0) if full else (8.0,))
    ]
    return found


def _by_error(longest: float) -> Changes:
    """Steps up to this length [ms], an eighth of it where it must be; their tolerance goes with its square."""
    return {
        "step.control": "error",
        "step.conduction": "1 ms",
        "step.longest": f"{longest!r} ms",
        "step.shortest": f"{0.125 * longest!r} ms",
        "step.tolerance": f"{0.005 * (longest / 8.0) ** 2!r} cm",
        "trigger.timing": "within",
    }


def _steps(wall: float, cell: float) -> Changes:
    """Steps [ms]; that of conduction is the whole part of that of the wall that is nearest to the one asked for."""
    return {"step.wall": f"{wall!r} ms", "step.conduction": f"{wall / max(1, round(wall / cell))!r} ms"}


def _measured(changes: Changes, repeats: int) -> dict[str, Any]:
    runs = [tracked(changes) for _ in range(repeats)]
    return runs[0] | plain(Timing.of([Spent(one["wall"], one["cpu"]) for one in runs]))


SECTION = Section(
    name="precision",
    title="Work and precision",
    about=(
        "Root mean square over time of the distance between the pellet's track and that of a converged run, against "
        "the solver's processor "
        "time. Each curve changes one choice and keeps the others as shipped, so it levels off where the others' "
        "errors begin; "
        "*everything* refines all four together."
    ),
    run=run,
    place=50,
)
