"""Runs on the whole surface: against one column, with noise, from a point; what they cost, part by part.

`python evidence/whole_surface.py` writes docs/evidence/whole_surface.md. Every run has a process of its own, so that
its memory is its own. About twenty minutes on one core; times are of the processor.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np
from common import save_text, table

import peristalsis as ps
from peristalsis import scenarios
from peristalsis.inputs.preflight import remarks

Case = dict[str, Any]
WARMING = "10 ms"
GRID = {"grid.n_z": 400, "grid.n_z_wall": 200, "output.fields": ["stretch_circumferential"]}
NOISE = 1e-7
"""Put on every place of the wall at t = 0 [cm]."""


PARTS = {"sheets": ("model.sheets", "advance_layer"), "wall": ("model.step", "solve_wall")}


def measured(case: Case) -> dict[str, Any]:
    """One run, in this process: outcome, counts, seconds of the processor by part, memory."""
    from benchmarks.parts import clocked

    configuration = scenarios.configuration(case["scenario"], changes=GRID | case["changes"])
    run = ps.Simulation(configuration)
    run.advance(WARMING)  # what is loaded at first use is not timed
    if case.get("noise"):
        draw = np.random.default_rng(1)
        places = run.state.wall.position.copy()
        places[1:-1] += NOISE * draw.standard_normal(places[1:-1].shape)
        run.state = replace(run.state, wall=replace(run.state.wall, position=places))
    first = run.time
    begin = time.process_time()
    with clocked(PARTS) as spent:
        if case["seconds"] is None:
            run.run()
        else:
            run.advance(f"{case['seconds']} s")
    total = time.process_time() - begin
    result = run.result()
    gut = run.time - first
    radius = result.arrays["stretch_circumferential"]
    steps = round(gut / run.model.dt_wall)
    return {
        "transit": result.summary["transit_s"],
        "track": result.arrays["pellet_position"].tolist(),
        "uneven": float(np.ptp(radius, axis=2).max()) if radius.shape[2] > 1 else 0.0,
        "uneven_end": float(np.ptp(radius[-1], axis=1).max()) if radius.shape[2] > 1 else 0.0,
        "newton": float(result.arrays["newton_iterations"].sum()) / steps,
        "gut": gut,
        "sheets": spent["sheets"].cpu / gut,
        "wall": spent["wall"].cpu / gut,
        "rest": (total - sum(part.cpu for part in spent.values())) / gut,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "remarks": [text for text in remarks(configuration) if "around the ring" in text],
    }


def in_a_process(case: Case) -> dict[str, Any]:
    """`measured` in a fresh process."""
    print(case, file=sys.stderr, flush=True)
    command = [sys.executable, __file__, json.dumps(case)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def costs(found: dict[str, Any]) -> tuple[object, ...]:
    """Cells of a row: seconds per simulated second by part, Newton's iterations, memory."""
    return found["sheets"], found["wall"], found["rest"], found["newton"], f"{found['memory']:.0f}"


COST_HEAD = ("sheets (s/s)", "wall (s/s)", "rest (s/s)", "Newton a step", "memory (MB)")


def uniform() -> str:
    """The baseline on 1 to 64 columns, from start to end."""
    rows = []
    one: dict[str, Any] = {}
    for columns, noise in ((1, False), (8, False), (32, False), (64, False), (64, True)):
        case = {"scenario": "baseline", "changes": {"grid.n_theta": columns}, "seconds": None, "noise": noise}
        found = in_a_process(case)
        one = one or found
        apart = float(np.abs(np.subtract(found["track"], one["track"])).max())
        label = f"{columns}, with noise of {NOISE:g} cm" if noise else str(columns)
        moved = 100.0 * (found["transit"] / one["transit"] - 1.0)
        uneven = found["uneven_end"] if noise else found["uneven"]
        rows.append((label, f"{found['transit']:.9f}", f"{moved:.2g}", f"{apart:.2g}", f"{uneven:.2g}", *costs(found)))
    head = (
        "columns",
        "transit (s)",
        "from one column (%)",
        "track apart (cm)",
        "hoop stretch, range around",
        *COST_HEAD,
    )
    return table(head, rows)


def point() -> tuple[str, str]:
    """The point pacemaker: first tenths of a second at 200 x 64 under coarse and fine conduction."""
    rows = []
    said = ""
    for columns, seconds in ((64, 0.06), (512, 0.04), (704, 0.04)):
        changes = {"grid.n_z_wall": 200, "grid.n_theta": 64, "grid.n_theta_conduction": columns}
        found = in_a_process({"scenario": "point_pacemaker", "changes": changes, "seconds": seconds})
        rows.append((columns, seconds, *costs(found)))
        said += "".join(f"- {text}\n" for text in found["remarks"])
    return table(("columns of conduction", "simulated (s)", *COST_HEAD), rows), said


def main() -> None:
    """Measure one case, or all and write the page."""
    if len(sys.argv) > 1:
        print(json.dumps(measured(json.loads(sys.argv[1]))))
        return
    table_point, said = point()
    save_text(
        "whole_surface.md",
        "# Runs on the whole surface\n\nMade by `python evidence/whole_surface.py`. Seconds of one processor core per "
        "simulated second, by part.\n\n## A ring-uniform drive, from start to end\n\nThe baseline on a wall of 200 "
        "elements, 400 cells along z, as many columns of cells as of wall. The range around the ring is the largest of "
        "the whole run; with noise, that of its end.\n\n"
        + uniform()
        + "\n## A pacemaker at a point\n\nWall of 200 x 64. What the runs say of their fronts beforehand:\n\n"
        + said
        + "\n"
        + table_point,
    )


if __name__ == "__main__":
    main()
