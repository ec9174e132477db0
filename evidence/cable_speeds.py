"""Speed of a wave on the undeformed cable for every cell that can be excited, on three grids.

    python evidence/cable_speeds.py

writes docs/evidence/cable_speeds.md. Two minutes on one core, besides compiling.
"""

from __future__ import annotations

import time
from pathlib import Path

from common import wrapped

import peristalsis as ps
from peristalsis.many.cable import cable_wave_speed

PAGE = Path(__file__).resolve().parents[1] / "docs" / "evidence" / "cable_speeds.md"
CELLS = {
    "plant": {},
    "hodgkin_huxley": {"pacemaker.intensity": "60 uA/cm^2", "step.wall": "1 ms", "step.conduction": "0.02 ms"},
    "morris_lecar": {"pacemaker.intensity": "120 uA/cm^2", "step.wall": "1 ms", "step.conduction": "0.1 ms"},
    "fitzhugh_nagumo": {"pacemaker.intensity": "60 uA/cm^2", "step.wall": "1 ms", "step.conduction": "0.1 ms"},
    "corrias_buist_2007": {"pacemaker.intensity": "60 uA/cm^2", "step.wall": "1 ms", "step.conduction": "0.1 ms"},
}
"""Cell to what a pulse needs that excites it, and steps in which it is resolved."""
GRIDS = (500, 1000, 2000)


def row(cell: str) -> str:
    """Speeds of a cell on all grids, and what a node and step cost."""
    speeds, spent, steps = [], 0.0, 1
    for n in GRIDS:
        c = ps.configuration("baseline", changes={**CELLS[cell], "tissue.cell": cell, "grid.n_z": n})
        begun = time.process_time()
        speeds.append(cable_wave_speed(c, duration=4.0))
        spent, steps = time.process_time() - begun, n * round(4.0 / (1e-3 * c.step.conduction))
    shown = [f"{10.0 * one:.2f}" if one is not None else "no wave" for one in speeds]
    step = f"{ps.configuration('baseline', changes=CELLS[cell]).step.conduction:g}"
    print(cell, shown, flush=True)
    return f"| `{cell}` | {step} | {' | '.join(shown)} | {1e9 * spent / steps:.0f} |"


def main() -> None:
    """Write the page."""
    page = f"""# Waves on the cable

Made by `python evidence/cable_speeds.py`: the longitudinal layer alone, not deformed, with the conductivity of the
paper's tissue; a pulse at the oral end, the speed between 3 and 8 cm. Conductivities were calibrated for Plant's cell
(42 mm/s); every other speed follows. Where it says "no wave" the pulse does not travel: gastric muscle is not
excitable, slow waves reach it from [interstitial cells](slow_waves.md), which run one after another at 6.5 mm/s there;
Morris and Lecar's cell with its shipped numbers carries no pulse of 120 uA/cm^2 either; why was not looked into.

| cell | step [ms] | {GRIDS[0]} cells [mm/s] | {GRIDS[1]} cells [mm/s] | {GRIDS[2]} cells [mm/s] | ns a node and step |
|---|---|---|---|---|---|
{chr(10).join(row(cell) for cell in CELLS)}
"""
    PAGE.write_text(wrapped(page), encoding="utf-8")


if __name__ == "__main__":
    main()
