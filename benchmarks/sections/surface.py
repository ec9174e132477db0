"""The whole surface: processor seconds for a simulated second, by part."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from peristalsis import scenarios
from peristalsis.running.simulation import Simulation

from ..clock import Stopwatch
from ..parts import STEP, clocked
from ..runs import Counter
from ..section import Bench, Figure, Findings, Section, Table

GRID = {"grid.n_z": 200, "grid.n_z_wall": 200, "grid.n_theta": 64}
CASES: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "ring-uniform": ("baseline", {**GRID, "output.interval": "20 ms"}),
    "point source": ("point_pacemaker", {**GRID, "grid.n_theta_conduction": 64}),
    "one column, for comparison": ("baseline", {**GRID, "grid.n_theta": 1, "output.interval": "20 ms"}),
}


def run(bench: Bench) -> Findings:
    """Time-boxed stretches from the start of each case."""
    box = 60.0 if bench.full else 4.0
    figures, rows = [], []
    for name, (scenario, changes) in CASES.items():
        found = bench.piece(f"surface, {name}", partial(_boxed, scenario, changes, box))
        per = {part: cpu / found["simulated"] for part, cpu in found["parts"].items()}
        total = found["cpu"] / found["simulated"]
        figures.append(
            Figure(
                f"{name}, a simulated second", total, "s of cpu", note=f"first {found['simulated']:.3g} s of the run"
            )
        )
        rows.append(
            (
                name,
                found["steps"],
                found["simulated"],
                *(per[part] for part in STEP),
                total - sum(per.values()),
                total,
                found["newton"] / found["steps"],
                found["krylov"] / found["steps"],
            )
        )
    head = (
        "case",
        "steps",
        "simulated (s)",
        *(f"{part} (s/s)" for part in STEP),
        "observers and rest (s/s)",
        "all (s/s)",
        "Newton a step",
        "Krylov a step",
    )
    caption = "200 cells and 200 elements along, 64 columns. Processor seconds for a simulated second, by part."
    return Findings(tuple(figures), (Table(caption, head, tuple(rows)),))


def _boxed(scenario: str, changes: Mapping[str, Any], box: float) -> dict[str, Any]:
    """Wall steps until `box` seconds of the processor are spent, or the run or half a second of it is over."""
    configuration = scenarios.configuration(scenario, changes=changes)
    counter = Counter()
    simulation = Simulation(configuration, (counter,))
    step = f"{configuration.step.wall!r} ms"
    simulation.advance(step)
    begun = simulation.state.step
    spent_on = 0.0
    counter.newton = counter.krylov = 0
    with clocked(STEP) as spent:
        while spent_on < box and simulation.time < 0.5 and simulation.stopped is None:
            with Stopwatch() as watch:
                simulation.advance(step)
            spent_on += watch.spent.cpu
    steps = simulation.state.step - begun
    return {
        "steps": steps,
        "simulated": steps * simulation.model.dt_wall,
        "cpu": spent_on,
        "parts": {name: one.cpu for name, one in spent.items()},
        "newton": counter.newton,
        "krylov": counter.krylov,
    }


SECTION = Section(
    name="surface",
    title="The whole surface",
    about=(
        "Stretches of runs on the whole surface from their start, as long as a budget of processor time allows: "
        "conduction, wall, what the nerves see, and the rest."
    ),
    run=run,
    place=70,
)
