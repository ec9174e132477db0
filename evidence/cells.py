"""Single cells by the kernels of the tissue against Myokit's own simulation: writes docs/evidence/cells.md.

Needs the extra `cells` (Myokit) with SUNDIALS and a C compiler. Run: python evidence/cells.py
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import cell_twins
import myokit
from common import wrapped

from peristalsis.cells import single
from peristalsis.cells.description import described, start
from peristalsis.inputs.build import build
from peristalsis.numerics.stabilised import coefficients
from peristalsis.scenarios import configuration
from peristalsis.tissue.cells import plant
from peristalsis.tissue.records import Brought, SheetArrays, Steps, Tables
from peristalsis.tissue.rest import rest_state
from peristalsis.tissue.sheet import advance_sheet

PAGES = Path(__file__).resolve().parents[1] / "docs" / "evidence"
PLANT_STIMULUS = 0.2
CASES: dict[str, tuple[float, float, tuple[float, ...]]] = {
    "hodgkin_huxley": (60.0, 0.1, (0.025, 0.0125, 0.00625, 0.003125)),
    "morris_lecar": (300.0, 0.5, (0.5, 0.25, 0.125, 0.0625)),
    "plant": (4000.0, 4.0, (1.0, 0.5, 0.25, 0.125)),
    "corrias_buist_2007": (20000.0, 4.0, (1.0, 0.5, 0.25, 0.125)),
    "du_2013": (60000.0, 20.0, (1.0, 0.5, 0.25, 0.125)),
}
"""Duration, sampling and steps [ms]."""


def reference(text: str, variable: str, times: Any) -> tuple[Any, float]:
    """Potential by Myokit's CVODES at times [ms], and how far it is from the same at a tolerance ten times larger."""
    found = []
    for tolerance in (1e-9, 1e-10):
        simulation = myokit.Simulation(myokit.parse_model(text))
        simulation.set_tolerance(tolerance, tolerance)
        if "piecewise" in text:
            simulation.set_max_step_size(20.0)
        log = simulation.run(float(times[-1]) + 1e-6, log=[variable], log_times=times)
        found.append(np.array(log[variable]))
    return found[1], float(np.abs(found[0] - found[1]).max())


def plant_cell() -> tuple[Any, dict[str, float]]:
    """(a run of Plant's cell by the shipped kernels, the numbers of its twin)."""
    model = build(configuration("baseline"))
    conductances = model.longitudinal.conductances[:, :1].copy()
    rest = rest_state(conductances[:, 0], model.cell, model.tables[0])
    numbers = dict(model.cell._asdict()) | dict(zip(plant.CONDUCTANCES, conductances[:, 0].tolist(), strict=True))
    numbers |= dict(zip(("V", *plant.GATES), (rest.potential, *rest.gates), strict=True)) | {"stimulus": PLANT_STIMULUS}

    def run(duration: float, sampling: float, step: float) -> Any:
        parts = round(sampling / step)
        tables = plant.gate_table(step, model.cell), plant.gate_table(0.5 * step, model.cell)
        v, gates = np.full(1, rest.potential), np.array(rest.gates)[:, None]
        unset = np.full(1, np.nan)
        kept = [v[0]]
        for _ in range(round(duration / sampling)):
            code = advance_sheet(
                SheetArrays(v, gates, unset, unset.copy()),
                conductances,
                np.zeros(0),
                Brought(np.full(1, PLANT_STIMULUS), np.zeros(1)),
                Steps(0.0, step, parts, 1, False, 0.0),
                coefficients(4),
                Tables(*tables),
                model.cell,
            )
            assert code == -1
            kept.append(v[0])
        return np.array(kept)

    return run, numbers


def case(name: str) -> tuple[Any, Any, list[tuple[float, float, float]], float]:
    """(times, best potential, [(step, difference as a share of the range, us per step)], doubt of the reference)."""
    duration, sampling, steps = CASES[name]
    times = sampling * np.arange(round(duration / sampling) + 1)
    text = getattr(cell_twins, name.upper())
    variable = {"corrias_buist_2007": "smc.V", "du_2013": "icc.V"}.get(name, "cell.V")
    if name == "plant":
        run, numbers = plant_cell()
        text = text.format(**numbers)
    else:
        cell = described(name)
        stimulus = {"corrias_buist_2007": cell_twins.slow_wave, "du_2013": single.quiet}.get(name)
        if stimulus is None:
            amount = {"hodgkin_huxley": 10.0, "morris_lecar": 100.0}[name]
            begin = np.array([-60.0, *[0.2] * len(cell.states)])
            stimulus = single.pulses(amount, 0.0, 2.0 * duration, 0.0)
        else:
            begin = start(cell)

        def run(duration: float, sampling: float, step: float) -> Any:
            return single.run(cell, duration, sampling, step, stimulus, begin).potential

    expected, doubt = reference(text, variable, times)
    span = float(np.ptp(expected))
    rows, best = [], None
    for step in steps:
        clock = time.perf_counter()
        best = run(duration, sampling, step)
        cost = (time.perf_counter() - clock) * step / duration * 1e6
        rows.append((step, float(np.abs(best - expected).max()) / span, cost))
    return times, (best, expected), rows, doubt / span


def cost_of(name: str, nodes: int = 2000, steps: int = 200) -> float:
    """Seconds for a node and step, the least of thirty."""
    if name == "plant":
        model = build(configuration("baseline"))
        conductances, constants, kernels, advance = (
            model.longitudinal.conductances[:, :1],
            model.cell,
            plant,
            advance_sheet,
        )
        rest = rest_state(conductances[:, 0], constants, model.tables[0])
        begin = np.array([rest.potential, *rest.gates])
    else:
        cell = described(name)
        binding = single.bound(cell)
        kernels = binding.module("tissue.cells.plant")
        advance = binding.module("tissue.sheet").advance_sheet
        constants = binding.module("tissue.cells.hodgkin_huxley").SHIPPED
        conductances, begin = cell.conductances[:, None], start(cell)
    dt = 0.01
    tables = kernels.gate_table(dt, constants), kernels.gate_table(0.5 * dt, constants)
    best = np.inf
    for repeat in range(31):
        v, states = np.full(nodes, begin[0]), np.repeat(begin[1:, None], nodes, axis=1)
        channels, unset = np.repeat(conductances, nodes, axis=1), np.full(nodes, np.nan)
        clock = time.perf_counter()
        sheet, still = SheetArrays(v, states, unset, unset.copy()), Brought(np.zeros(nodes), np.zeros(nodes))
        march = Steps(0.0, dt, steps, 1, False, 0.0)
        advance(sheet, channels, np.zeros(0), still, march, coefficients(4), Tables(*tables), constants)
        if repeat > 0:  # the first one compiles
            best = min(best, (time.perf_counter() - clock) / (nodes * steps))
    return best


def period(times: Any, v: Any) -> float | None:
    """Mean period [ms] of the upstrokes through the middle of the range."""
    beats = single.upstrokes(single.Trace(times, v, np.zeros((0, v.size)), (), 0.0))
    return float((beats[-1] - beats[0]) / (beats.size - 1)) if beats.size > 1 else None


def main() -> None:
    """Compare all cells, draw them, write the page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 11.0), layout="constrained")
    axes = figure.subplots(len(CASES), 1)
    lines = [
        "# Single cells against Myokit",
        "",
        "Written by `evidence/cells.py`. Each cell runs by the kernels of the tissue (`general`, or Plant's",
        "own), and in Myokit's CVODES from equations written by hand in `evidence/cell_twins.py`.",
        "Differences are the largest of the whole trace, as shares of its range; the uncertainty of the",
        "reference (doubt) is its change at a ten times larger tolerance. The last column is the cost of a",
        "node and step in a sheet of 2000 nodes without conduction, four stages, one core, as a multiple",
        "of Plant's in the same run.",
        "",
        "| cell | range mV | period ms | step ms | difference | order | doubt | cost |",
        "|---|---|---|---|---|---|---|---|",
    ]
    costs = {name: cost_of(name) for name in CASES}
    print({name: f"{cost * 1e9:.0f} ns" for name, cost in costs.items()})
    for axis, name in zip(axes, CASES, strict=True):
        times, (best, expected), rows, doubt = case(name)
        axis.plot(times / 1000.0, expected, lw=3, alpha=0.4, label="Myokit, CVODES")
        axis.plot(times / 1000.0, best, lw=1, label=f"this package, {rows[-1][0]:g} ms")
        axis.set(ylabel="mV", title=name)
        own, their = period(times, best), period(times, expected)
        for k, (step, share, _) in enumerate(rows):
            order = "" if k == 0 else f"{np.log2(rows[k - 1][1] / share):.2f}"
            said = "—" if own is None else f"{own:.2f} (Myokit {their:.2f})"
            cost = f"{costs[name] / costs['plant']:.1f}" if k == 0 else ""
            first = f"`{name}` | {expected.min():.1f} … {expected.max():.1f} | {said}" if k == 0 else " | | "
            lines.append(
                f"| {first} | {step:g} | {share:.1e} | {order} | {f'{doubt:.0e}' if k == 0 else ''} | {cost} |"
            )
        print(name, rows, doubt, own, their)
    axes[0].legend(loc="upper right")
    axes[-1].set_xlabel("time [s]")
    figure.savefig(PAGES / "cells.png", dpi=90)
    lines += ["", "![Potentials of the five cells by both programs](cells.png)", ""]
    (PAGES / "cells.md").write_text(wrapped("\n".join(lines)), encoding="utf-8")


if __name__ == "__main__":
    main()
