"""What a run costs, part by part: medians and bests of one process, cost per node and step, nothing absolute promised.

python benchmarks/run.py [--repeats 5]
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from collections.abc import Callable

import numpy as np

import peristalsis as ps
from peristalsis.build import build
from peristalsis.config import Configuration
from peristalsis.model.initial import initial_state
from peristalsis.model.step import advance
from peristalsis.numerics.block_band import DIAGONAL, PADDING, ROWS, solve_blocks_in_place
from peristalsis.tissue.cells import plant
from peristalsis.wall.assembly import KNOWN_ROWS, WALL_ROWS, set_drives, wall_forces, wall_tangent


def timed(call: Callable[[], object], calls: int, repeats: int) -> float:
    """Best mean time of one call [s]."""
    call()
    best = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        for _ in range(calls):
            call()
        best = min(best, (time.perf_counter() - begin) / calls)
    return best


def parts(repeats: int) -> list[tuple[str, float, str]]:
    """(part, nanoseconds per node and step, remark) at a state in the middle of the baseline."""
    model, state, _ = initial_state(build(Configuration()))
    for _ in range(400):
        state, _ = advance(model, state)
    wall, n = state.wall, model.grid.n_z_wall + 1
    rho, zeta = wall.position[:, 0, 0].copy(), wall.position[:, 0, 2].copy()
    known, work = np.ones((KNOWN_ROWS, n)), np.zeros((WALL_ROWS, n))
    system = np.zeros((ROWS, n + PADDING))
    set_drives(wall.drive[0, :, 0].copy(), wall.drive[1, :, 0].copy(), known)

    def forces() -> None:
        wall_forces(rho, zeta, known, 500.0, model.wall, 1, n - 2, work)

    def tangent() -> None:
        wall_tangent(rho, zeta, 10.0, 500.0, model.wall, 1, n - 2, work, system)

    def solve() -> None:
        system[:, :] = 0.0
        system[[DIAGONAL, DIAGONAL + 3]] = 1.0
        solve_blocks_in_place(system, 1, n - 2, 3)

    cells = 100_000
    potential = np.linspace(-65.0, 30.0, cells)
    gates, cubed = np.full((4, cells), 0.3), np.empty(cells)

    def kinetics(exact: bool) -> Callable[[], None]:
        return lambda: plant.relax_gates(potential, gates, model.tables[0], exact, 0.25, model.cell, cubed)

    table, exact = timed(kinetics(False), 5, repeats), timed(kinetics(True), 2, repeats)
    return [
        ("gates, tables", table / cells * 1e9, f"{cells / table / 1e6:.0f} M node-steps/s"),
        ("gates, exact exponentials", exact / cells * 1e9, f"{exact / table:.1f} x the tables"),
        ("wall forces", timed(forces, 50, repeats) / n * 1e9, "an assembly"),
        ("wall tangent", timed(tangent, 50, repeats) / n * 1e9, "a Newton iteration"),
        ("block solve, 3 columns", timed(solve, 50, repeats) / n * 1e9, "a Newton iteration"),
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    print(f"peristalsis {ps.__version__}, Python {platform.python_version()}, {platform.machine()}, one thread")
    summaries = [ps.run("baseline").summary for _ in range(repeats)]
    solver = [float(summary["solver_wall_s"]) for summary in summaries]
    simulated, steps = summaries[0]["simulated_s"], summaries[0]["steps"]
    print(
        f"baseline: solver {statistics.median(solver):.2f} s (median of {repeats}; best {min(solver):.2f}, worst "
        f"{max(solver):.2f}) for {simulated:.3f} s of gut time in {steps} steps: "
        f"{statistics.median(solver) / simulated:.2f} s per gut-second, "
        f"{statistics.median(solver) / steps * 1e3:.2f} ms a step"
    )
    print(f"compile or load kernels, first run of this process: {summaries[0]['compile_wall_s']:.2f} s")
    print(f"{'part':<28}{'ns per node':>12}  remark")
    for name, nanoseconds, remark in parts(repeats):
        print(f"{name:<28}{nanoseconds:>12.1f}  {remark}")


if __name__ == "__main__":
    main()
