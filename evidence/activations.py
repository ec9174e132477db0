"""Force after a slow wave: depolarisation, calcium by Hill's curve, and cross-bridges drive the same tissue.

    python evidence/activations.py

writes docs/evidence/activations.md and docs/images/activations.png. Some minutes on one core, besides compiling.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib
from common import wrapped

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import peristalsis as ps
from peristalsis.model.muscle import drive_of_cells

DOCS = Path(__file__).resolve().parents[1] / "docs"
PLACE = 5.0
"""Where drives are compared [cm]."""
COARSE = {"grid.n_z": 100, "grid.n_z_wall": 300}
HILL = {"tissue.activation": "calcium_hill", "tissue.calcium_hill.half": "0.25 uM"}
BRIDGES = {
    "tissue.activation": "hai_murphy",
    "tissue.hai_murphy.half": "0.25 uM",
    "tissue.hai_murphy.fastest": "1 1/s",
}
PHASIC = {"tissue.hai_murphy.latch_detachment": "0.5 1/s", "tissue.hai_murphy.full": "60 mV"}
PULL = {"longitudinal.active": 1.0, "circular.active": 1.0}
CASES: Mapping[str, Mapping[str, Any]] = {
    "depolarisation beyond −55 mV, times 4": {},
    "calcium by Hill's curve": {**HILL, **PULL},
    "cross-bridges, latch as in arteries": {**BRIDGES, **PULL},
    "cross-bridges, latch let go at 0.5/s": {**BRIDGES, **PHASIC, **PULL},
}
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
HEAD = "| drive | status | transit [s] | at rest [mV] | peak [mV] | half risen [s] | peak [s] | half fallen [s] |"


class Watch:
    """Potential, calcium and drive of the circular layer at PLACE after every step."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float, float, float]] = []

    def start(self, model: Any, state: Any) -> None:
        """Nothing to prepare."""

    def see(self, model: Any, before: Any, after: Any, report: Any) -> None:
        """Keep one row."""
        k = int(np.argmin(np.abs(model.grid.cells - PLACE)))
        driven = float(np.mean(model.circular.force_factor)) * drive_of_cells(model.circular, after.circular)[k, 0]
        calcium = 1e3 * after.circular.gates[-1, k, 0]
        self.rows.append((after.step * model.dt_wall, after.circular.potential[k, 0], calcium, driven))


def half_crossings(times: np.ndarray, values: np.ndarray) -> tuple[float, float, float]:
    """Times at which values have half risen, are largest, and have half fallen [s]; nan where they do not."""
    top = int(np.argmax(values))
    half = 0.5 * (values[0] + values[top])
    fallen = np.flatnonzero(values[top:] < half)
    return (
        float(times[np.argmax(values >= half)]),
        float(times[top]),
        float(times[top + fallen[0]]) if fallen.size else float("nan"),
    )


def main() -> None:
    """Run the cases, draw them, write the page."""
    rows, traces = [], {}
    for label, changes in CASES.items():
        watch = Watch()
        configuration = ps.configuration("slow_waves", changes={**COARSE, "run.stop_when_expelled": False, **changes})
        result = ps.Simulation(configuration, observers=(watch,)).run()
        t, v, _, driven = traces[label] = np.array(watch.rows).T
        first = t < 22.0  # the first wave
        depolarised = half_crossings(t[first], v[first])[0]
        risen, peak, fallen = (one - depolarised for one in half_crossings(t[first], driven[first]))
        transit = result.summary["transit_s"]
        rows.append(
            f"| {label} | {result.summary['status']} | {'–' if transit is None else f'{transit:.3f}'} | "
            f"{driven[0]:.2f} | {driven.max():.1f} | {risen:.2f} | {peak:.2f} | "
            f"{'never' if np.isnan(fallen) else f'{fallen:.2f}'} |"
        )
        print(rows[-1], flush=True)
    draw(traces)
    page = f"""# Force after a slow wave

Made by `python evidence/activations.py`: the scenario `slow_waves` on 100 cells and 300 elements, in which a network of
interstitial cells drives gastric muscle, with four answers to what makes the muscle pull
([activation](../activation.md)). Times are those after the potential at {PLACE:g} cm has half risen.

![Potential, calcium and drive of the circular layer at 5 cm over time](../images/activations.png)

{HEAD}
|---|---|---|---|---|---|---|---|
{chr(10).join(rows)}

Half-activation at 0.25 uM, 1/s for the kinase and the drives at full activation are examples that make the three
comparable, and no measurements. What does not depend on them: calcium follows the potential by as much as its removal
takes, bridges follow calcium by seconds, and latched bridges of an artery (0.01/s) hold on from wave to wave: the
muscle never relaxes, and the pellet is arrested. Muscle that has to relax between slow waves lets go of them faster.
"""
    (DOCS / "evidence" / "activations.md").write_text(wrapped(page), encoding="utf-8")


def draw(traces: Mapping[str, np.ndarray]) -> None:
    """Potential and calcium of the first case above, drives of all below."""
    figure, panels = plt.subplots(3, 1, figsize=(7.5, 7.0), sharex=True, constrained_layout=True)
    t, v, calcium, _ = next(iter(traces.values()))
    panels[0].plot(t, v, color="black")
    panels[0].set_ylabel("potential (mV)")
    panels[1].plot(t, calcium, color="black")
    panels[1].set_ylabel("calcium (uM)")
    for (label, (t, _, _, driven)), colour in zip(traces.items(), COLOURS, strict=True):
        panels[2].plot(t, driven, color=colour, label=label)
    panels[2].set_ylabel("drive of the muscle (mV)")
    panels[2].set_xlabel("time (s)")
    panels[2].legend(loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=2, fontsize=8)
    panels[0].set_title(f"Circular layer at {PLACE:g} cm")
    figure.savefig(DOCS / "images" / "activations.png", dpi=150)


if __name__ == "__main__":
    main()
