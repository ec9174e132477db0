"""One choice changed at a time: what it does to the runs on which the failing claims rest, and to the thresholds.

Writes docs/evidence/variants.md. `python evidence/variants.py FOLDER` keeps finished runs in FOLDER (out/paper unless
given) and takes them up again; about half an hour on two cores the first time.
"""

from __future__ import annotations

import sys
from pathlib import Path

from common import save_text, table

from peristalsis.many.rows import Row
from peristalsis.scoring.outcome import Condition
from peristalsis.scoring.paper.runs import RUNS, phase_name
from peristalsis.scoring.paper.searches import SEARCHES
from peristalsis.scoring.paper.source import SOURCE
from peristalsis.scoring.paper.variants import VARIANTS
from peristalsis.scoring.runs import Bench, carry_out

CASES = {
    "baseline": "1",
    "fig3b": "3, 5",
    "fig3c": "3",
    "dry_565": "7",
    "fig4b": "9",
    "fig4c": "9",
    "fig5_slow_calcium_decreased": "11",
    "fig5_slow_calcium_increased": "12",
    "fig5_calcium_potassium_decreased": "15",
    "fig6_receptors_alone": "18",
    "fig6d": "20",
    "fig7b": "21",
    "fig7c": "21",
    "pellet_x1.05": "22",
    "ratio_1": "23",
    "pendular": "24",
    "segmentation": "25",
    phase_name(0.0): "27",
    phase_name(0.5): "27",
    "oil_and_bulk": "30",
}
"""Runs, and the claims that rest on them."""

SEARCHED = ("doubled", "slow-waves")

WORDS = """
Doubled duration moves no threshold. Slow waves catch a pellet that was left behind: every width that was tried arrives,
and only dry friction above some 1.6 N stops it. Friction against the moving wall, the consistent tensions, the printed
density (as inertia) and the reflex shift every transit and turn no failing claim into one that holds; the trigger as
printed (total tension) fires everywhere at once, makes every transit more than twice as long, and stops the pellet in
the wider tube (claim 21).
"""
"""What was seen when this was made; the tables say whether it still is."""


def ending(record: Row) -> str:
    """How a run ended, with its travel where the pellet did not arrive."""
    numbers = record.summary
    if numbers.get("transit_s") is not None:
        return f"{numbers['transit_s']:.3f} s"
    if numbers.get("travel_cm") is not None:
        return f"{record.status.replace('_', ' ')}, {numbers['travel_cm']:.2f} cm"
    return record.status


def main() -> None:
    """Run, or take up again, and write the tables."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper") / "runs"
    conditions = {"as shipped": Condition("tight")}
    conditions |= {one.title: Condition("tight", one.changes) for one in VARIANTS.values()}
    found = {}
    for title, condition in conditions.items():
        print(f"{title} ...", file=sys.stderr, flush=True)
        found[title] = Bench(SOURCE, folder, workers=2).records([RUNS[name] for name in CASES], condition)
    rows = [[name, claim, *(ending(records[name]) for records in found.values())] for name, claim in CASES.items()]
    text = "# One choice changed\n\nMade by `python evidence/variants.py`. Reading `tight`; transit, or how the run "
    text += "ended. `peristalsis paper --variant NAME` scores all claims under a variant.\n\n"
    text += table(["run", "claims", *found], rows)
    brackets = []
    for title in ("as shipped", *(VARIANTS[name].title for name in SEARCHED)):
        print(f"{title}: thresholds ...", file=sys.stderr, flush=True)
        outcome = carry_out(Bench(SOURCE, folder, workers=2), conditions[title], runs=(), searches=True)
        for name, threshold in outcome.thresholds.items():
            search = SEARCHES[name]
            unit = "" if search.unit == "1" else f" {search.unit}"
            bracket = "none" if threshold.value is None else f"{threshold.low:.4g} to {threshold.high:.4g}{unit}"
            brackets.append((title, search.title, bracket, "yes" if threshold.monotone else "no"))
    text += WORDS
    text += "\n## Thresholds\n\n" + table(["condition", "threshold", "bracket", "monotone"], brackets)
    save_text("variants.md", text)


if __name__ == "__main__":
    main()
