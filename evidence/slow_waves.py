"""Slow waves that arise by themselves and carry a pellet: the scenario `slow_waves`, its map and its numbers.

    python evidence/slow_waves.py

writes docs/evidence/slow_waves.md and docs/images/slow_waves.png. A minute on one core, besides compiling.
"""

from __future__ import annotations

import time
from pathlib import Path

import matplotlib
from common import wrapped

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import peristalsis as ps

DOCS = Path(__file__).resolve().parents[1] / "docs"
HEAD = "| grid and step | status | transit [s] | wave [mm/s] | muscle, peak [mV] | balance of work | processor [s] |"
RULE = "|---|---|---|---|---|---|---|"
LEVEL = -50.0
"""Potential through which the network rises when a slow wave passes [mV]."""


def rises(times: np.ndarray, potential: np.ndarray) -> np.ndarray:
    """Time at which every cell first rises through LEVEL after having been below it [s], nan where it does not."""
    found = np.full(potential.shape[1], np.nan)
    for k in range(potential.shape[1]):
        up = np.flatnonzero((potential[:-1, k] < LEVEL) & (potential[1:, k] >= LEVEL))
        if up.size:
            low, high = potential[up[0], k], potential[up[0] + 1, k]
            found[k] = np.interp(LEVEL, [low, high], times[up[0] : up[0] + 2])
    return found


def main() -> None:
    """Run the scenario, on a coarser grid and with longer steps too, draw it, write the page."""
    rows, results = [], []
    for label, changes in (
        ("as shipped", {}),
        ("steps doubled", {"step.wall": "20 ms", "step.conduction": "1 ms"}),
        ("cells and elements halved", {"grid.n_z": 100, "grid.n_z_wall": 300}),
    ):
        begun = time.process_time()
        result = ps.Simulation(ps.configuration("slow_waves", changes=changes)).run()
        spent = time.process_time() - begun
        z, times = result.arrays["z_cell"], result.arrays["time"]
        passed = rises(times, result.arrays["potential_network"][:, :, 0])
        reached = np.isfinite(passed) & (z > 1.0) & (z < 8.0)
        slope = np.polyfit(z[reached], passed[reached], 1)[0] if reached.sum() > 10 else np.nan
        muscle = result.arrays["potential_circular"]
        rows.append(
            f"| {label} | {result.summary['status']} | {result.summary['transit_s'] or float('nan'):.3f} | "
            f"{10.0 / slope:.2f} | {muscle.max():.1f} | {result.summary['power_residual']:.1e} | {spent:.0f} |"
        )
        results.append(result)
    draw(results[0])
    page = f"""# Slow waves that carry a pellet

Made by `python evidence/slow_waves.py`: the scenario `slow_waves`, in which nothing stimulates the tissue. A network
of interstitial cells drives both layers of gastric muscle ([cells](../cells.md), Eq. (77)).

![Diameter, potential of the network and of the circular layer, and the pellet's track](../images/slow_waves.png)

{chr(10).join([HEAD, RULE, *rows])}

The speed is that of the lag with which the cells begin (1 s/cm, 10 mm/s) and of the gradient of their period; the gaps
within the network hold neighbours together. Force and threshold of the muscle are chosen, not measured.
"""
    (DOCS / "evidence" / "slow_waves.md").write_text(wrapped(page), encoding="utf-8")


def draw(result: ps.Result) -> None:
    """Three maps of place against time, with the pellet's track on them."""
    times, arrays = result.arrays["time"], result.arrays
    figure, panels = plt.subplots(1, 3, figsize=(10.5, 3.6), sharey=True, constrained_layout=True)
    maps = (
        ("diameter (mm)", arrays["z"], 20.0 * arrays["radius"][:, :, 0], "viridis"),
        ("network (mV)", arrays["z_cell"], arrays["potential_network"][:, :, 0], "magma"),
        ("circular muscle (mV)", arrays["z_cell"], arrays["potential_circular"][:, :, 0], "magma"),
    )
    for axes, (label, z, values, colours) in zip(panels, maps, strict=True):
        mesh = axes.pcolormesh(10.0 * z, times, values, cmap=colours, shading="nearest", rasterized=True)
        figure.colorbar(mesh, ax=axes, label=label, location="top")
        track = arrays["pellet_position"]
        axes.plot(10.0 * track, arrays["time_step"], color="white", linewidth=1.2)
        axes.set_xlim(0.0, 10.0 * z[-1])
        axes.set_xlabel("from the oral end (mm)")
    panels[0].set_ylabel("time (s)")
    panels[0].invert_yaxis()
    figure.savefig(DOCS / "images" / "slow_waves.png", dpi=150)


if __name__ == "__main__":
    main()
