"""What the evidence scripts share: runs by label, a table in Markdown, a panel of diameter maps."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import peristalsis as ps
from peristalsis.inputs.config import Configuration
from peristalsis.many.rows import Row, Step
from peristalsis.many.sweep import Measure, sweep

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for the packages beside it: benchmarks, verification
from verification.prose import wrapped

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "evidence"
DOUBLED = {"grid.n_z": 1400, "grid.n_z_wall": 1300}
HALVED = {"step.wall": "2.5 ms", "step.conduction": "0.5 ms"}
"""Grids and steps against which shipped ones are held."""


def run_all(cases: Mapping[str, tuple[str, Mapping[str, object]]]) -> dict[str, ps.Result]:
    """Run every case (label to scenario and changes), saying which on stderr."""
    results = {}
    for label, (scenario, changes) in cases.items():
        print(f"running {label} ...", file=sys.stderr, flush=True)
        results[label] = ps.run(scenario, dict(changes))
    return results


def made_or_kept(cases: Mapping[str, Configuration], folder: Path, measure: Measure, workers: int) -> dict[str, Row]:
    """The rows of all cases, made or kept in a folder; each that is made is told on stderr."""

    def tell(step: Step) -> None:
        if not step.kept:
            print(f"{step.done}/{step.count} {step.row.point.name}", file=sys.stderr, flush=True)

    return sweep(cases, folder, measure, workers, tell)


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table; floats to five digits, None as a dash."""

    def cell(value: object) -> str:
        if value is None:
            return "–"
        return f"{value:.5g}" if isinstance(value, float) else str(value)

    lines = [" | ".join(head), " | ".join("---" for _ in head)]
    lines += [" | ".join(cell(value) for value in row) for row in rows]
    return "\n".join(f"| {line} |" for line in lines) + "\n"


def save_text(name: str, text: str) -> None:
    """Write docs/evidence/NAME and show it."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / name).write_text(wrapped(text), encoding="utf-8")
    print(text)


def diameter_maps(name: str, results: Mapping[str, ps.Result], columns: int = 2) -> None:
    """Diameter maps of several runs in one picture, docs/evidence/NAME."""
    from matplotlib.figure import Figure

    from peristalsis.plots import style
    from peristalsis.plots.figures.diameter_map import panel

    rows = -(-len(results) // columns)
    with style.applied():
        figure = Figure(figsize=(4.6 * columns, 2.7 * rows), dpi=130, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (label, result) in zip(grid.flat, results.items(), strict=False):
            mesh = panel(axes, result)
            figure.colorbar(mesh, ax=axes, label="diameter (mm)")
            axes.set_title(label)
        for axes in grid.flat[len(results) :]:
            axes.set_visible(False)
        FOLDER.mkdir(parents=True, exist_ok=True)
        figure.savefig(FOLDER / name)
