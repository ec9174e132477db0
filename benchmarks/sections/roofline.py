"""How much of the processor the kernels use: counted operations over measured limits, in one run."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from benchmarks import machine_limits as limits
from peristalsis.tissue.cells.plant import PER_STEP, TABLE_LOW

from .. import kernels
from ..clock import in_turns, plain
from ..process import code
from ..section import Bench, Figure, Findings, Section, Table

COUNT = "from benchmarks.counting import main; main()"
IN_CACHE, IN_MEMORY = 2_000, 8_000_000
ROUNDS, LENGTH = 50, 20_000
FLOPS = ("add", "multiply", "divide", "root", "function")
CELLS = 1000


def run(bench: Bench) -> Findings:
    """Limits, counts and rates, and the fraction of the nearest limit."""
    counts = bench.piece("roofline, counts", lambda: json.loads(code(COUNT, {"NUMBA_DISABLE_JIT": "1"}).output))
    measured = bench.piece("roofline, rates", lambda: _measured(bench.repeats(5, 15), bench.full))
    peak, memory, cached = (measured[name] for name in ("peak", "memory", "cache"))
    rows = []
    fractions: dict[str, tuple[float, str]] = {}
    for name in ("gates", "cell", "sheet", "wall forces", "wall tangent", "wall solve"):
        n, seconds = counts[name], measured[name]
        flops = sum(n.get(kind, 0.0) for kind in FLOPS)
        divides = n.get("divide", 0.0) + n.get("root", 0.0)
        reads = 8.0 * (n.get("load", 0.0) + n.get("store", 0.0))
        floors = {
            "arithmetic": flops / peak,
            "divisions and roots": divides * measured["divide"],
            "traffic of its arrays": measured[f"{name}, bytes"] / cached,
        }
        if name in ("gates", "cell", "sheet"):
            floors["reading the tables"] = measured["tables"]
        if name == "wall solve":
            # A division is longer than an addition; the rest of the chain is additions and multiplications.
            floors["chain of dependent operations"] = (n["depth"] - 1.0) * measured["link"] + measured["division"]
        nearest = max(floors, key=lambda key: floors[key])
        fractions[name] = (floors[nearest] / seconds, nearest)
        rows.append(
            (
                name,
                flops,
                divides,
                reads,
                measured[f"{name}, bytes"],
                1e9 * seconds,
                1e-9 * flops / seconds,
                nearest,
                1e9 * floors[nearest],
                100.0 * fractions[name][0],
            )
        )
    figures = tuple(
        Figure(f"{name}, of its nearest limit", 100.0 * fractions[name][0], "%", note=fractions[name][1])
        for name in ("gates", "cell", "sheet", "wall forces", "wall solve")
    )
    machine = Table(
        "What this processor does at most, by compiled loops that do only that, measured in turns with the kernels.",
        ("limit", "measured"),
        (
            ("additions and multiplications, in registers", f"{1e-9 * peak:.3g} Gflop/s"),
            (f"triad, {24 * IN_CACHE / 1e3:.0f} kB (in cache)", f"{1e-9 * cached:.3g} GB/s"),
            (
                f"triad, {24 * IN_MEMORY / 1e6:.0f} MB (in memory)",
                f"{1e-9 * memory:.3g} GB/s" if memory else "with --full",
            ),
            ("a division among independent ones", f"{1e9 * measured['divide']:.3g} ns"),
            ("an operation that waits for the one before", f"{1e9 * measured['link']:.3g} ns"),
            ("a division that waits for the one before", f"{1e9 * measured['division']:.3g} ns"),
            ("reading and adding two rows of the table", f"{1e9 * measured['tables']:.3g} ns"),
        ),
    )
    head = (
        "kernel, a node-step",
        "flops",
        "of them divisions and roots",
        "bytes read and written",
        "bytes of its arrays",
        "measured (ns)",
        "Gflop/s",
        "nearest limit",
        "that alone (ns)",
        "reached (%)",
    )
    table = Table("Kernels, for each cell and step, or wall node and call.", head, tuple(rows))
    notes = (
        "Flops, reads and writes are counted by running the kernels' own Python source on numbers and arrays that "
        "count "
        "(`benchmarks/counting.py`). *Bytes read and written* count every access, most of which meet registers or the "
        "first cache; *bytes of its arrays* are what "
        "each call must touch at least once, compared with the triad in cache, since a run's arrays stay there. "
        "Kernels are compiled without "
        "contraction of multiplications and additions, so is the loop that gives the limit.",
        "A sum over both corners, a table's row and the solve's recurrence cannot run at the rate of independent "
        "operations: the "
        "limit that is nearest is named, and the fraction is of that one.",
    )
    return Findings(figures, (machine, table), notes)


def _measured(repeats: int, full: bool) -> dict[str, Any]:
    model = kernels.shipped_model()
    x = np.linspace(0.1, 0.9, 512)
    small = [np.ones(IN_CACHE) for _ in range(3)]
    v, out = np.linspace(-65.0, 30.0, CELLS), np.empty(CELLS)
    calls: dict[str, Any] = {
        "peak": lambda: limits.multiply_add(x, 0.5, ROUNDS),
        "cache": lambda: limits.triad(small[0], small[1], small[2], 0.5),
        "link": lambda: limits.chain(0.3, 0.5, LENGTH),
        "divide": lambda: limits.divisions(x, ROUNDS),
        "division": lambda: limits.division_chain(1.3, LENGTH),
        "tables": lambda: limits.table_reads(v, model.tables[0], TABLE_LOW, PER_STEP, out),
    }
    if full:
        large = [np.ones(IN_MEMORY) for _ in range(3)]
        calls["memory"] = lambda: limits.triad(large[0], large[1], large[2], 0.5)
    parts = [
        kernels.gates(model, CELLS, exact=False),
        kernels.sheet(model, CELLS, exact=False, conducts=False),
        kernels.sheet(model, CELLS, exact=False, conducts=True),
        *kernels.wall(model),
    ]
    calls |= {part.name: part for part in parts}
    cpu = {name: plain(timing)["cpu"] for name, timing in in_turns(calls, repeats).items()}
    link = cpu["link"] / (2 * LENGTH)
    found = {
        "peak": 2 * limits.PAIRS * x.size * ROUNDS / cpu["peak"],
        "cache": 24 * IN_CACHE / cpu["cache"],
        "memory": 24 * IN_MEMORY / cpu["memory"] if full else 0.0,
        "link": link,
        "divide": cpu["divide"] / (x.size * ROUNDS),
        "division": max(cpu["division"] / LENGTH - link, link),
        "tables": cpu["tables"] / CELLS,
    }
    cpu["wall solve"] -= cpu["wall copy"]
    for part in parts:
        found[part.name] = cpu[part.name] / part.nodes
        found[f"{part.name}, bytes"] = part.compulsory / (kernels.SUBSTEPS if part.name in ("cell", "sheet") else 1)
    return found


SECTION = Section(
    name="roofline",
    title="Kernels and the limits of the processor",
    about=(
        "Counted work of the hot kernels over what this processor can do at most, both measured in one run, in turns, "
        "on one thread."
    ),
    run=run,
    place=60,
)
