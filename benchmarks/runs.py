"""Runs that sections share: a stretch of a run by the clock, and the converged track for errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis import scenarios
from peristalsis.model.model import Model
from peristalsis.model.report import StepReport
from peristalsis.model.state import State
from peristalsis.running.simulation import Simulation

from .clock import Spent, Stopwatch
from .parts import SOLVER, clocked
from .section import Bench

Floats = NDArray[np.float64]

FINE: Mapping[str, Any] = {"solver.residual_tolerance": 1e-7}
"""Beyond some 3000 wall elements rounding alone exceeds the shipped tolerance of 1e-8."""

FINEST: Mapping[str, Any] = {
    **FINE,
    "grid.n_z": 2800,
    "grid.n_z_wall": 2600,
    "step.wall": "1.25 ms",
    "step.conduction": "0.25 ms",
}
"""The converged run: all grids of the baseline, and both steps, four times finer."""

QUICK_FINEST: Mapping[str, Any] = {
    "grid.n_z": 1400,
    "grid.n_z_wall": 1300,
    "step.wall": "2.5 ms",
    "step.conduction": "0.5 ms",
}
"""Twice finer: the finest run of docs/evidence/convergence.md."""

SAMPLES = 501


@dataclass(frozen=True)
class Stretch:
    """A stretch of a run: what the solver and the whole loop took, steps, simulated seconds, iterations."""

    solver: Spent
    loop: Spent
    steps: int
    simulated: float
    newton: int
    krylov: int


class Counter:
    """An observer that adds up what the steps report."""

    def __init__(self) -> None:
        self.newton = self.krylov = 0

    def start(self, model: Model, state: State) -> None:
        """Nothing to begin."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> None:
        """Add a step."""
        self.newton += report.newton_iterations
        self.krylov += report.krylov_iterations


def stretch(scenario: str, changes: Mapping[str, Any], duration: str) -> Stretch:
    """Prepare a run (not measured) and advance it by a time."""
    counter = Counter()
    simulation = Simulation(scenarios.configuration(scenario, changes=changes), (counter,))
    with clocked(SOLVER) as spent, Stopwatch() as watch:
        simulation.advance(duration)
    steps, solver = simulation.state.step, spent["solver"]
    return Stretch(solver, watch.spent, steps, simulation.time, counter.newton, counter.krylov)


def finest(bench: Bench) -> Mapping[str, Any]:
    """The changes that make the converged run."""
    return FINEST if bench.full else QUICK_FINEST


def tracked(changes: Mapping[str, Any]) -> dict[str, Any]:
    """A whole baseline: transit [s], the pellet's track [cm] at SAMPLES times [s], what the solver took [s].

    Raises InterruptedRun or DivergenceError where the run broke off.
    """
    simulation = Simulation(scenarios.configuration("baseline", changes=changes))
    with clocked(SOLVER) as spent:
        result = simulation.run()
    if simulation.failure is not None:  # half a run must not be kept as a measurement
        raise simulation.failure
    transit = result.summary["transit_s"]
    time, place = (np.asarray(result.arrays[name], dtype=float) for name in ("time_step", "pellet_position"))
    until = float(time[-1]) if transit is None else float(transit)
    samples = np.linspace(0.0, until, SAMPLES)
    return {
        "transit": transit,
        "status": result.status,
        "until": until,
        "places": np.round(np.interp(samples, time, place), 9).tolist(),
        "cpu": spent["solver"].cpu,
        "wall": spent["solver"].wall,
        "steps": int(time.size - 1),
    }


def reference(bench: Bench) -> dict[str, Any]:
    """The converged baseline, computed once and kept."""
    found: dict[str, Any] = bench.piece("converged track", lambda: tracked(finest(bench)))
    return found


def track_error(run: Mapping[str, Any], converged: Mapping[str, Any]) -> float:
    """Root mean square over time of the difference of two tracks [cm], until the first of both is out."""
    until = min(float(run["until"]), float(converged["until"]))
    times = np.linspace(0.0, until, 2001)
    tracks = [
        np.interp(times, np.linspace(0.0, float(one["until"]), SAMPLES), np.asarray(one["places"], dtype=float))
        for one in (run, converged)
    ]
    return float(np.sqrt(np.mean((tracks[0] - tracks[1]) ** 2)))
