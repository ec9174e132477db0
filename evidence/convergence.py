"""Both grids and both steps of the baseline halved and doubled: what transit and track owe to them.

Writes docs/evidence/convergence.md. About three minutes on one core.
"""

from __future__ import annotations

import numpy as np
from common import run_all, save_text, table

from peristalsis.inputs.config import Configuration
from peristalsis.many.cable import cable_wave_speed

FINEST = {"grid.n_z": 2000, "grid.n_z_wall": 1600, "step.wall": "1 ms", "step.conduction": "0.25 ms"}
REFINED = "all four refined (2000, 1600, 1 and 0.25 ms)"
CASES = {
    "shipped": {},
    "conduction cells / 2 (350)": {"grid.n_z": 350},
    "conduction cells x 2 (1400)": {"grid.n_z": 1400},
    "wall elements / 2 (325)": {"grid.n_z_wall": 325},
    "wall elements x 2 (1300)": {"grid.n_z_wall": 1300},
    "conduction step x 2.5 (2.5 ms)": {"step.conduction": "2.5 ms"},
    "conduction step / 2 (0.5 ms)": {"step.conduction": "0.5 ms"},
    "wall step x 2 (10 ms)": {"step.wall": "10 ms"},
    "wall step / 2.5 (2 ms)": {"step.wall": "2 ms"},
    REFINED: FINEST,
}


def main() -> None:
    """Run the cases and write the table."""
    results = run_all({label: ("baseline", changes) for label, changes in CASES.items()})
    finest = results[REFINED]
    rows = []
    for label, result in results.items():
        summary = result.summary
        transit, limit = float(summary["transit_s"]), float(finest.summary["transit_s"])
        time = np.linspace(0.0, min(transit, limit), 2001)
        track, reference = (
            np.interp(time, r.arrays["time_step"], r.arrays["pellet_position"]) for r in (result, finest)
        )
        rows.append(
            (
                label,
                transit,
                100.0 * (transit / limit - 1.0),
                float(np.abs(track - reference).max()) * 10.0,
                float(summary["max_axial_force_mN"]),
                float(summary["power_residual"]),
            )
        )
    head = (
        "baseline with",
        "transit (s)",
        "from finest (%)",
        "largest difference of the track (mm)",
        "largest axial force (mN)",
        "power residual",
    )
    waves = []
    for layer in ("longitudinal", "circular"):
        for cells, step in ((700, "1 ms"), (2400, "0.125 ms")):
            changed = Configuration().with_changes({"grid.n_z": cells, "step.conduction": step})
            waves.append((layer, cells, step, cable_wave_speed(changed, layer)))
    text = "# Convergence of the baseline\n\nMade by `python evidence/convergence.py`.\n\n" + table(head, rows)
    text += "\nWave on the undeformed cable, calibrated to 4.2 cm/s:\n\n"
    text += table(("layer", "cells", "step", "speed (cm/s)"), waves)
    save_text("convergence.md", text)


if __name__ == "__main__":
    main()
