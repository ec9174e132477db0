"""Where the error of one column comes from, part by part, and what it costs: cells, elements, both steps.

Each part is the change of the baseline's transit as that one of the four is made four times finer, the others as they
are. Writes docs/evidence/parts.md. About three minutes on one core; `python evidence/parts.py --law` measures the law
of the front's speed alone, as `tissue.front_correction` holds it, and writes nothing.
"""

from __future__ import annotations

import sys
import time
from statistics import median
from typing import NamedTuple

import numpy as np
from common import ROOT, save_text, table

import peristalsis as ps
from peristalsis.inputs.build import build
from peristalsis.model.guards import advance_safely
from peristalsis.model.initial import initial_state
from peristalsis.tissue.front_correction import CELLS_PER_FOOT, MEASURED_STEPS, correction, correction_table

sys.path.insert(0, str(ROOT))
from verification.exact.front import front_speed

ROUNDS = 5
"""Runs in turns of which the median is taken for the cost."""
REFINED = 4


class Numerics(NamedTuple):
    """Cells, elements, steps of wall and conduction [ms], and whether in the finer ways of Eqs. (85)-(88)."""

    cells: int
    elements: int
    wall: float
    conduction: float
    corrected: bool = True
    reconstructed: bool = True

    def changes(self) -> dict[str, object]:
        """As changes of a configuration."""
        return {
            "grid.n_z": self.cells,
            "grid.n_z_wall": self.elements,
            "step.wall": f"{self.wall:g} ms",
            "step.conduction": f"{self.conduction:g} ms",
            "tissue.front_correction": "measured" if self.corrected else "none",
            "trigger.timing": "within" if self.reconstructed else "step",
            "grid.exchange": "reconstructed" if self.reconstructed else "averages",
        }

    def name(self) -> str:
        """Grids and steps in short."""
        return f"{self.cells}/{self.elements}, {self.wall:g}/{self.conduction:g} ms"


REFERENCE = Numerics(2000, 1600, 1.0, 0.25)
BEFORE = Numerics(1000, 800, 2.0, 0.25, corrected=False, reconstructed=False)
SETS = {
    "before": BEFORE,
    "shipped": Numerics(700, 650, 5.0, 1.0),
    "shipped but for 4 ms": Numerics(700, 650, 4.0, 1.0),
}
WITHOUT = {
    "both": SETS["shipped"],
    "no correction of the front": SETS["shipped"]._replace(corrected=False),
    "no reconstruction": SETS["shipped"]._replace(reconstructed=False),
    "neither": SETS["shipped"]._replace(corrected=False, reconstructed=False),
}
TISSUES: dict[str, dict[str, float]] = {
    "as shipped": {},
    "leak × 2": {"leak": 2.0},
    "slow_calcium × 2": {"slow_calcium": 2.0},
    "calcium_potassium × 2": {"calcium_potassium": 2.0},
    "fast_calcium × 1.5": {"fast_calcium": 1.5},
    "fast_calcium × 0.5": {"fast_calcium": 0.5},
}


def run(numerics: Numerics) -> ps.Result:
    """The baseline with these numerics."""
    print(f"running {numerics} ...", file=sys.stderr, flush=True)
    return ps.run("baseline", numerics.changes())


_known: dict[Numerics, ps.Result] = {}


def kept(numerics: Numerics) -> ps.Result:
    """A run, made once."""
    if numerics not in _known:
        _known[numerics] = run(numerics)
    return _known[numerics]


def transit(numerics: Numerics) -> float:
    """Transit of the baseline [s]."""
    return float(kept(numerics).summary["transit_s"])


def parts(n: Numerics) -> list[float]:
    """Errors of the transit by cells, elements, wall step and conduction step [%], signed."""
    waves = n._replace(conduction=n.conduction / REFINED)  # fits a whole number of times into either step of the wall
    pairs = (
        (n, n._replace(cells=REFINED * n.cells)),
        (n, n._replace(elements=REFINED * n.elements)),
        (waves, waves._replace(wall=n.wall / REFINED)),
        (n, waves),
    )
    return [100.0 * (transit(one) / transit(finer) - 1.0) for one, finer in pairs]


def off_track(n: Numerics) -> float:
    """Root mean square of the difference of the pellet's track from the reference [mm]."""
    one, other = kept(n), kept(REFERENCE)
    times = np.linspace(0.0, min(transit(n), transit(REFERENCE)), 2001)
    tracks = [np.interp(times, r.arrays["time_step"], r.arrays["pellet_position"]) for r in (one, other)]
    return float(np.sqrt(np.mean((tracks[0] - tracks[1]) ** 2))) * 10.0


def march(n: Numerics) -> float:
    """Processor time of the solver over the baseline, without what watches a run [s]."""
    model, state, _ = initial_state(build(ps.configuration("baseline", changes=n.changes()).at_start()))
    steps = int(kept(n).summary["steps"])
    begun = time.process_time()
    for _ in range(steps):
        state, _ = advance_safely(model, state)
    return time.process_time() - begun


def costs() -> dict[str, float]:
    """Processor time of every set over that of the numerics of before: medians of runs in turns."""
    found: dict[str, list[float]] = {name: [] for name in SETS}
    for _ in range(ROUNDS + 1):
        for name, numerics in SETS.items():
            found[name].append(march(numerics))
    before = median(found["before"][1:])
    return {name: median(times[1:]) / before for name, times in found.items()}


def law() -> str:
    """The measured speeds, as `tissue.front_correction` has them."""
    limit = front_speed(0.125, 0.0625)
    assert limit is not None
    rows = []
    for dt in (0.0625, *MEASURED_STEPS[1:]):
        speeds = [front_speed(q, dt) for q in CELLS_PER_FOOT]
        rows.append(f"{dt:g} ms: " + ", ".join("blocked" if c is None else f"{c / limit:.5f}" for c in speeds))
    return f"limit {limit:.6g} cm/s\n" + "\n".join(rows)


def tissues() -> list[tuple[object, ...]]:
    """Error of the front's speed by the law in tissue that it was not measured on [%]."""
    rows: list[tuple[object, ...]] = []
    for name, scales in TISSUES.items():
        fine = front_speed(0.2, 0.25, scales=scales)
        row: list[object] = [name, fine]
        for ratio in (0.5, 0.7, 1.0):
            for factor in (1.0, correction(ratio, correction_table(0.5))):
                speed = front_speed(ratio, 0.5, factor, scales)
                row.append(None if speed is None or fine is None else 100.0 * (speed / fine - 1.0))
        rows.append(tuple(row))
    return rows


def main() -> None:
    """Run the sets and their refinements, and write the tables."""
    limit = transit(REFERENCE)
    cost = costs()
    rows = []
    for name, numerics in SETS.items():
        each = parts(numerics)
        whole = 100.0 * (transit(numerics) / limit - 1.0)
        total = sum(abs(part) for part in each)
        rows.append((name, numerics.name(), *each, total, whole, off_track(numerics), cost[name]))
    head = (
        *("numerics", "cells/elements, steps", "cells (%)", "elements (%)", "wall step (%)", "conduction step (%)"),
        *("sum of sizes (%)", "from reference (%)", "track, rms (mm)", "cost over before"),
    )
    text = "# Errors of one column, part by part\n\nMade by `python evidence/parts.py`. Each part is the change of "
    text += f"transit from a run in which that one is {REFINED} times finer (the wall step at the finer conduction "
    text += f"step, of which both are whole multiples); the reference ({REFERENCE.name()}, finer ways) takes "
    text += f"{limit:.5f} s. "
    text += "Before is `tissue.front_correction = none`, `grid.exchange = averages`, `trigger.timing = step`; the "
    text += "finer ways, which are shipped, are `measured`, `reconstructed` and `within`, Eqs. (85)–(88), (100). Cost: "
    text += f"processor time of the solver, median of {ROUNDS} runs in turns.\n\n" + table(head, rows)
    text += "\nOne of the two without the other, at the shipped grids and steps:\n\n"
    without = [(name, transit(n), 100.0 * (transit(n) / limit - 1.0)) for name, n in WITHOUT.items()]
    text += table(("with", "transit (s)", "from reference (%)"), without)
    text += "\nSpeed of a front in tissue with other conductances, whose foot the law takes to be that of the "
    text += "shipped one: error in % by the size of a cell in shipped feet, without and with the correction, steps of "
    text += "0.5 ms.\n\n"
    head = ("tissue", "speed (cm/s)", *(f"{q}, {way}" for q in (0.5, 0.7, 1.0) for way in ("without", "with")))
    text += table(head, tissues())
    save_text("parts.md", text)


if __name__ == "__main__":
    print(law()) if "--law" in sys.argv[1:] else main()
