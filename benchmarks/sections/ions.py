"""The ion kernel: with tables, with exponentials, and beside the same cell in Myokit."""

from __future__ import annotations

from typing import Any

import numpy as np

from peristalsis import scenarios
from peristalsis.running.simulation import Simulation

from .. import kernels
from ..clock import in_turns, plain
from ..section import Bench, Figure, Findings, Section, Table

SHIPPED, MANY = 1000, 100_000


def run(bench: Bench) -> Findings:
    """Rates, ratio to exponentials, error of the tables; Myokit where it is installed."""
    rates = bench.piece("ions, rates", lambda: _rates(bench.repeats(5, 15)))
    duration = "2.5 s" if bench.full else "0.5 s"
    error = bench.piece("ions, error of the tables", lambda: _table_error(duration))
    rate = {name: one["nodes"] / one["cpu"] / 1e6 for name, one in rates.items()}
    gates, cell = (rate[f"{what}, exact"] for what in ("gates", "cell"))
    figures = [
        Figure("gates with tables, one thread", rate["gates"], "M node-steps/s", low=80.0, note=f"{SHIPPED} cells"),
        Figure("gates with tables over exponentials", rate["gates"] / gates, "times", low=5.0, note="in turns"),
        Figure("whole cell with tables", rate["cell"], "M node-steps/s", note="gates, currents, potential in 2 stages"),
        Figure("whole cell with tables over exponentials", rate["cell"] / cell, "times"),
        Figure("sheet with tables", rate["sheet"], "M node-steps/s", note="whole cell and conduction"),
        Figure("largest error of the tables", error["largest"], "mV", high=1e-4, note=f"both sheets, {duration}"),
    ]
    order = (
        "gates",
        "gates, exact",
        "gates, many",
        "gates, many, shuffled",
        "cell",
        "cell, exact",
        "sheet",
        "sheet, exact",
    )
    rows = tuple((_words(name), rates[name]["cells"], 1e9 / (1e6 * rate[name]), rate[name]) for name in order)
    tables = [
        Table(
            "One thread, median of processor time, all kernels in turns. *exact*: every coefficient from `math.exp`.",
            ("kernel", "cells", "ns a node-step", "M node-steps/s"),
            rows,
        ),
        Table(
            "Difference of the potential of runs with tables and with exponentials, over the whole run.",
            ("layer", "largest (mV)", "rms (mV)", "largest before the wave (mV)", "shift of activation (ms)"),
            tuple(tuple(row) for row in error["rows"]),
        ),
    ]
    notes: list[str] = []
    from ..myokit_cable import compare, missing

    absent = missing()
    if absent is not None:
        notes.append(f"Myokit was not measured: {absent}")
    else:
        beside = bench.piece("ions, Myokit", lambda: compare(bench.repeats(3, 5), full=bench.full))
        awake = beside["cable"][2][1] * 1e-3 * rate["sheet"]
        figures += [
            Figure("sheet over Myokit's 1-D simulation", awake, "times", note="equal cells and steps, no cell waits"),
            Figure("with a wave on its way", beside["ratio"], "times", note="cells that the wave has not reached wait"),
            Figure("with exponentials over Myokit", beside["ratio_exact"], "times"),
            Figure(
                "potential less Myokit's, step to zero", beside["extrapolated"], "mV", note="one cell, extrapolated"
            ),
        ]
        tables += [
            Table(
                f"A cable of {beside['cells']} cells, steps of {beside['step']:g} ms, {beside['duration']:g} ms with "
                "a wave on it, "
                f"beside Myokit {beside['version']} (`Simulation1d`, Rush–Larsen, compiled C): processor time.",
                ("program", "ns a node-step", "wave speed (cm/s)"),
                tuple(tuple(row) for row in beside["cable"]),
            ),
            Table(
                "One cell, stimulated: largest difference of the potential over 1.5 s. Myokit's method is of first "
                "order, so "
                "halving the step must halve it.",
                ("step (ms)", "difference (mV)"),
                tuple(tuple(row) for row in beside["agreement"]),
            ),
        ]
        notes.append(
            "Both solve Eqs. (20)–(22) with conduction. Myokit's scheme: second order in space, first in time, "
            "forward Euler "
            "for potential and calcium; ours: fourth order in space, second in time, so equal steps are not equal "
            "errors."
        )
    return Findings(tuple(figures), tuple(tables), tuple(notes))


def _words(name: str) -> str:
    return f"{name}" if "exact" in name else f"{name}, tables"


def _rates(repeats: int) -> dict[str, dict[str, Any]]:
    model = kernels.shipped_model()
    measured = {
        "gates": kernels.gates(model, SHIPPED, exact=False),
        "gates, exact": kernels.gates(model, SHIPPED, exact=True),
        "gates, many": kernels.gates(model, MANY, exact=False),
        "gates, many, shuffled": kernels.gates(model, MANY, exact=False, shuffled=True),
        "cell": kernels.sheet(model, SHIPPED, exact=False, conducts=False),
        "cell, exact": kernels.sheet(model, SHIPPED, exact=True, conducts=False),
        "sheet": kernels.sheet(model, SHIPPED, exact=False, conducts=True),
        "sheet, exact": kernels.sheet(model, SHIPPED, exact=True, conducts=True),
    }
    found = in_turns(measured, repeats)
    cells = {name: MANY if "many" in name else SHIPPED for name in measured}
    return {
        name: plain(timing) | {"nodes": measured[name].nodes, "cells": cells[name]} for name, timing in found.items()
    }


def _table_error(duration: str) -> dict[str, Any]:
    """Both runs step by step side by side: the largest difference of the potentials after any wall step."""
    configuration = scenarios.configuration("baseline", changes={"run.duration": duration})
    pair = [Simulation(configuration.with_changes({"solver.exact_kinetics": exact})) for exact in (False, True)]
    step = f"{configuration.step.wall:g} ms"
    layers = ("longitudinal", "circular")
    largest, early = dict.fromkeys(layers, 0.0), dict.fromkeys(layers, 0.0)
    squares, count = dict.fromkeys(layers, 0.0), 0
    for _ in range(round(configuration.run.duration / (1e-3 * configuration.step.wall))):
        states = [one.advance(step) for one in pair]
        count += 1
        for layer in layers:
            with_tables, exact = (getattr(state, layer) for state in states)
            difference = np.abs(with_tables.potential - exact.potential)
            largest[layer] = max(largest[layer], float(difference.max()))
            waiting = np.isnan(exact.first_activation)
            if waiting.any():
                early[layer] = max(early[layer], float(difference[waiting].max()))
            squares[layer] += float((difference**2).mean())
        if any(one.stopped for one in pair):
            break
    rows = []
    for layer in layers:
        first = [getattr(one.state, layer).first_activation for one in pair]
        both = np.isfinite(first[0]) & np.isfinite(first[1])
        shift = float(np.abs(first[0] - first[1])[both].max()) if both.any() else None
        rows.append([layer, largest[layer], (squares[layer] / count) ** 0.5, early[layer], shift])
    return {"largest": max(largest.values()), "rows": rows}


SECTION = Section(
    name="ions",
    title="The ion kernel",
    about=(
        "Plant's cell (20)–(22) on one thread. *gates*: the exact relaxation of h, n, x and calcium and m³, eight "
        "values interpolated from a table; "
        "*cell*: with currents and the potential; *sheet*: with conduction. The same kernels with "
        "`solver.exact_kinetics` call the "
        "system's exponential for every coefficient."
    ),
    run=run,
    place=20,
)
