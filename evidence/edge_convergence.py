"""Whether the runs that decide claims under `edge` stay on their side of the edge on finer grids and steps.

`python evidence/edge_convergence.py [FOLDER [WORKERS]]` keeps finished runs in FOLDER (out/paper unless said
otherwise) and writes docs/paper/edge_convergence.md. Some eighty runs, ten minutes on one core.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from common import DOUBLED, HALVED, ROOT, made_or_kept, table, wrapped

from peristalsis.scoring import sources

SOURCE = sources.get("paper")
assert SOURCE.space is not None
EDGE = SOURCE.space.edge
PAGE = ROOT / "docs" / "paper" / "edge_convergence.md"
RUNS = (
    *("baseline", "eta_x2", "dry_200", "fig3e", "dry_565", "fig3g", "fig4b", "fig4c", "pressure_1"),
    *(
        f"fig5_{channel}_{state}"
        for channel in ("slow_calcium", "fast_calcium", "calcium_potassium")
        for state in ("decreased", "increased")
    ),
    *("fig7b", "fig7c", "pellet_x1.05", "ratio_1.02", "ratio_1.08"),
)
WAYS: Mapping[str, Mapping[str, Any]] = {
    "as shipped": {},
    "doubled grids": DOUBLED,
    "halved steps": HALVED,
    "both": {**DOUBLED, **HALVED},
}
HEAD = """# Runs at the edge, on finer grids and steps

Made by `python evidence/edge_convergence.py`: runs that decide claims under the reading `edge`, as shipped, on doubled
grids, with halved steps, and with both. Below each transit stands how the pellet travels. The norm lies 0.3 % of the
force above the edge, and the edge itself moves with the grid, so a run that slips and is caught again may be caught by
another wave. What follows from it: [the regime of the paper](regimes.md#how-sure).

"""


def main() -> None:
    """Run, and write the table."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper") / "runs"
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    cases = {
        f"{run}, {way}": SOURCE.runs[run].configuration("edge", changes)
        for run in RUNS
        for way, changes in WAYS.items()
    }

    rows = made_or_kept(cases, folder, SOURCE.measure, workers)
    found = {name: (EDGE.regime(row.summary), row.summary.get("transit_s")) for name, row in rows.items()}
    lines, same = [], 0
    for run in RUNS:
        regimes = {found[f"{run}, {way}"][0] for way in WAYS}
        same += len(regimes) == 1
        lines.append([run, *(_cell(*found[f"{run}, {way}"]) for way in WAYS)])
    text = HEAD + f"**{same} of {len(lines)} runs travel the same way on all four.**\n\n"
    PAGE.write_text(wrapped(text + table(["run", *WAYS], lines)), encoding="utf-8")


def _cell(regime: str, transit: float | None) -> str:
    return f"{regime}, {transit:.3f} s" if transit is not None else regime


if __name__ == "__main__":
    main()
