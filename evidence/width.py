"""How wide the region of the reading `edge` is: its numbers moved one at a time by 5 and 10 %, and all claims scored.

`python evidence/width.py [FOLDER [WORKERS]]` keeps finished runs in FOLDER (out/paper unless said otherwise) and writes
docs/paper/width.md. Some 2500 runs, an hour on one core; nothing if the runs are there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from common import ROOT, table, wrapped

from peristalsis import scenarios
from peristalsis.scoring import sources
from peristalsis.scoring.outcome import Condition
from peristalsis.scoring.runs import Bench, carry_out
from peristalsis.scoring.score import HOLDS, score_all
from peristalsis.units import DIMENSIONLESS, format_quantity

SOURCE = sources.get("paper")
PAGE = ROOT / "docs" / "paper" / "width.md"
FACTORS = (0.9, 0.95, 1.05, 1.1)
FAR = (0.9, 1.1)
"""For the reflex and the width of the pacemaker, which decide little."""
MOVED: Mapping[str, Mapping[str, str]] = {
    "force of both layers": {"circular.active": DIMENSIONLESS, "longitudinal.active": DIMENSIONLESS},
    "force of the circular layer": {"circular.active": DIMENSIONLESS},
    "force of the longitudinal layer": {"longitudinal.active": DIMENSIONLESS},
    "radius of the pellet": {"pellet.radius": "cm"},
    "c10 of the wall": {"wall.c10": "mN/cm"},
    "conductivity of both layers": {
        "longitudinal.conductivity_scale": DIMENSIONLESS,
        "circular.conductivity_scale": DIMENSIONLESS,
    },
    "intensity of the pacemaker": {"pacemaker.intensity": "uA/cm^2"},
    "width of the pacemaker": {"pacemaker.width": "cm"},
    "oral length of the reflex": {"reflex.oral_length": "cm"},
    "anal length of the reflex": {"reflex.anal_length": "cm"},
    "delay of the reflex": {"reflex.delay": "s"},
    "excitation of the reflex": {"reflex.excitation_intensity": "uA/cm^2"},
    "inhibition of the reflex": {"reflex.inhibition_conductance": "mS/cm^2"},
}
"""Every fitted number that acts in the reading, with its unit; the trigger's level does not (rule `pacemaker`)."""

HEAD = """# How wide the region of `edge` is

Made by `python evidence/width.py`. One number of the reading `edge` at a time is moved by 5 and
10 %, and the {count} claims that need no search for a threshold (all but 8, 10 and 23) are scored
anew on all their runs. The first figure is how many of the {count} hold; under `edge` itself
**{centre}**. In brackets, which claims are lost (-) and won (+). The time is the transit of the norm; a
dash: not run.

"""


def factors(name: str) -> tuple[float, ...]:
    """By what one number is multiplied."""
    return FAR if "reflex" in name or name.startswith("width") else FACTORS


def conditions() -> dict[tuple[str, float], Condition]:
    """Every number with every factor, and the reading itself under ("", 1)."""
    base = scenarios.configuration("baseline", reading="edge").flat()
    found = {("", 1.0): Condition("edge")}
    for name, keys in MOVED.items():
        for factor in factors(name):
            changes: dict[str, Any] = {}
            for key, unit in keys.items():
                value = float(f"{factor * float(base[key]):.6g}")
                changes[key] = value if unit == DIMENSIONLESS else format_quantity(value, unit)
            found[name, factor] = Condition("edge", changes, f"{name} x {factor:g}")
    return found


def main() -> None:
    """Measure, and write the page."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper") / "runs"
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    claims = [claim for claim in SOURCE.claims if SOURCE.runs.keys() >= set(claim.runs())]
    needed = SOURCE.runs_of([claim.number for claim in claims])
    held: dict[tuple[str, float], set[int]] = {}
    transits: dict[tuple[str, float], float | None] = {}
    for place, (key, condition) in enumerate(conditions().items()):
        print(f"{place} {condition.title}", file=sys.stderr, flush=True)
        outcome = carry_out(Bench(SOURCE, folder, workers), condition, needed, searches=False)
        held[key] = {one.claim.number for one in score_all(claims, outcome.measured) if one.verdict == HOLDS}
        transits[key] = outcome.measured["baseline"].get("transit_s")
    centre = held["", 1.0]

    def cell(name: str, factor: float) -> str:
        if (name, factor) not in held:
            return "–"
        now, transit = held[name, factor], transits[name, factor]
        moved = [f"-{number}" for number in sorted(centre - now)] + [f"+{number}" for number in sorted(now - centre)]
        arrives = f"{transit:.2f} s" if transit is not None else "stays"
        return f"**{len(now)}**, {arrives}" + (f" ({' '.join(moved)})" if moved else "")

    rows = [[name, *(cell(name, factor) for factor in FACTORS)] for name in MOVED]
    head = ("moved", *(f"{100.0 * (factor - 1.0):+.0f} %" for factor in FACTORS))
    PAGE.write_text(wrapped(HEAD.format(count=len(claims), centre=len(centre)) + table(head, rows)), encoding="utf-8")


if __name__ == "__main__":
    main()
