"""Random configurations against their doubled grids: whether the remarks of a run name all that is not converged.

Writes docs/evidence/converged.md. Give the numbers of the first and of the last configuration; about half a minute
each on one core.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import save_text, table

import peristalsis as ps
from peristalsis.errors import PeristalsisError
from peristalsis.running.certain import change, kept_of, neighbours
from peristalsis.running.simulation import Simulation

GROUPS = ("friction", "muscle", "wall", "pressure", "pellet", "tissue", "mixed", "friction")
READINGS = ("tight", "stretched", "printed")
RADII = {"tight": 0.9, "stretched": 1.5, "printed": 0.75}
SEED = 1000


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two, evenly on a log scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def configuration(k: int) -> tuple[str, str, dict[str, Any]]:
    """Reading, group and changes of the k-th configuration."""
    rng = np.random.default_rng(SEED + k)
    reading, group = READINGS[k % 3], GROUPS[k % 8]
    changes: dict[str, Any] = {"run.duration": "5 s", "output.interval": "20 ms"}
    if group in ("friction", "mixed"):
        changes["pellet.viscous_friction"] = f"{between(rng, 30, 1500):.5g} mN*s/cm"
        changes["pellet.dry_friction"] = f"{between(rng, 1, 800):.5g} mN"
    if group in ("muscle", "mixed"):
        changes["longitudinal.active"] = round(between(rng, 0.3, 2), 4)
        changes["circular.active"] = round(between(rng, 0.3, 2), 4)
    if group == "wall":
        changes["wall.viscosity"] = f"{between(rng, 8, 150):.5g} mN*s/cm"
        for name in ("c1", "c2"):
            changes[f"wall.{name}"] = f"{10.4 * between(rng, 0.5, 2.5):.5g} mN/cm"
        changes["wall.c4"] = round(3.79 * between(rng, 0.6, 1.6), 4)
        changes["wall.c5"] = round(12.7 * between(rng, 0.6, 1.6), 4)
        if rng.random() < 0.5:
            changes["wall.tension"] = "consistent"
    if group == "pressure":
        changes["lumen.pressure"] = f"{between(rng, 0.03, 3):.4g} kPa"
    if group in ("pellet", "mixed"):
        changes["pellet.radius"] = f"{RADII[reading] * rng.uniform(0.92, 1.1):.4g} cm"
    if group == "tissue":
        changes["tissue.kinetics_rate"] = round(0.125 * between(rng, 0.6, 1.6), 4)
        for layer in ("longitudinal", "circular"):
            changes[f"{layer}.slow_calcium"] = f"{rng.uniform(0.003, 0.009):.4g} mS/cm^2"
        changes["pacemaker.kind"] = str(rng.choice(["pulse", "periodic"]))
    return reading, group, changes


def row_of(k: int) -> tuple[Any, ...]:
    """What the k-th configuration came to, by how much the doubled grid differs, and what the run said."""
    reading, group, changes = configuration(k)
    try:
        result = ps.run("baseline", changes, reading=reading)
    except PeristalsisError as error:
        return (k, reading, group, "refused", None, None, str(error)[:60])
    outcome = result.summary["transit_s"] or result.summary["final_position_cm"]
    said = "; ".join(text[:60] for text in result.remarks)
    try:
        other = kept_of(Simulation(neighbours(result.configuration)["grid"]).run())
    except PeristalsisError as error:
        return (k, reading, group, result.status, outcome, None, f"doubled grid: {str(error)[:60]}")
    return (k, reading, group, result.status, outcome, change(kept_of(result), other), said)


def main() -> None:
    """Run the configurations and write the table."""
    first, last = (int(word) for word in sys.argv[1:3]) if len(sys.argv) > 2 else (0, 50)
    rows = [row_of(k) for k in range(first, last + 1)]
    compared = [row for row in rows if row[5] is not None]
    silent = [row[5] for row in compared if not row[6]]
    told = [row[5] for row in compared if row[6]]
    head = ("no.", "reading", "group", "status", "transit (s) or last position (cm)", "change (%)", "remarks")
    text = (
        "# What the remarks of a run are worth\n\nMade by `python evidence/converged.py`: random configurations, each "
        "on the shipped and on the doubled grids.\n\n"
        f"{len(compared)} of {len(rows)} could be compared. Largest change among the {len(silent)} runs without a "
        f"remark: {max(silent):.2f} %. Among the {len(told)} with one: {max(told):.2f} %; "
        f"{sum(value > 2.0 for value in told)} of them changed by more than 2 %.\n\n"
    )
    save_text("converged.md", text + table(head, rows))


if __name__ == "__main__":
    main()
