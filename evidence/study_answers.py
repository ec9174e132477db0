"""What `studies` measures of sensitivities, cohorts and maps, each by the command that a user would give."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import ROOT
from numpy.typing import NDArray
from study_commands import carried_out, rows_of

from peristalsis.many.studies.indices import METHODS

EXAMPLE = ROOT / "examples" / "sensitivity.toml"
OUTPUTS = ("transit_s", "mean_velocity_cm_s", "max_axial_force_mN")


@dataclass(frozen=True)
class Case:
    """A sensitivity: reading, method, samples, simulated seconds."""

    reading: str
    method: str
    samples: int
    duration: str = "8 s"


CASES = {
    "sobol_tight": Case("tight", "sobol", 64),
    "morris_tight": Case("tight", "morris", 16),
    "pawn_edge": Case("edge", "pawn", 128),
    "pawn_edge_first": Case("edge", "pawn", 128, "3 s"),
    "morris_edge": Case("edge", "morris", 10),
    "sobol_edge": Case("edge", "sobol", 16),
}
"""Sensitivities by name. `pawn_edge_first` ends before later waves catch what the first one left: no transit then."""
CHECKED = 10
"""Points of each reading that are run again on the shipped grids."""
GRIDS = ("grid.n_z", "grid.n_z_wall")


def sensitivity(folder: Path, name: str) -> dict[str, Any]:
    """One sensitivity by the command: its cost, how runs ended, and its indices, or why there are none."""
    case = CASES[name]
    file = folder / f"{name}.toml"
    folder.mkdir(parents=True, exist_ok=True)
    lines = {"samples = ": f"samples = {case.samples}", "run.duration = ": f'run.duration = "{case.duration}"'}
    file.write_text(replaced(EXAMPLE.read_text(encoding="utf-8"), lines), encoding="utf-8")
    words = ("sensitivity", str(file), "--reading", case.reading, "--method", case.method, "--out", str(folder / name))
    cost = carried_out(*words, log=folder / f"{name}.log")
    table = rows_of(folder / name / "table.csv")
    solver = sum(float(row["solver_wall_s"] or 0.0) for row in rows_of(folder / name / "times.csv"))
    values = {one: [float(row[one]) for row in table if row[one]] for one in OUTPUTS}
    spreads = {one: {"mean": float(np.mean(v)), "deviation": float(np.std(v))} for one, v in values.items() if v}
    return {
        "cost": cost,
        "solver": solver,
        "statuses": Counter(row["status"] for row in table),
        "without": {one: sum(not row[one] for row in table) for one in OUTPUTS},
        "spreads": spreads,
        "indices": rows_of(folder / name / "indices.csv") if cost["code"] == 0 else [],
        "refusal": "" if cost["code"] == 0 else (folder / f"{name}.log").read_text("utf-8").strip().splitlines()[-1],
    }


def of_nothing(folder: Path, name: str) -> dict[str, float]:
    """PAWN's index of a parameter that does nothing, from the same runs: what indices of small samples are at least."""
    table = rows_of(folder / name / "table.csv")
    values = {one: np.array([float(row[one] or "nan") for row in table]) for one in OUTPUTS}
    found = {}
    for output, results in values.items():
        drawn = np.random.default_rng(1).permuted(np.tile(np.linspace(0.0, 1.0, len(table)), (5, 1)), axis=1).T
        indices = METHODS["pawn"].indices([str(k) for k in range(5)], drawn, results, 1)
        found[output] = float(np.mean([one.value for one in indices]))
    return found


def checked(folder: Path, reading: str) -> list[dict[str, Any]]:
    """Ten points of a sensitivity, drawn by a seed, on its grids and on the shipped ones."""
    drawn_from = next(name for name, case in CASES.items() if case.reading == reading)
    table = rows_of(folder / drawn_from / "table.csv")
    names = [one for one in table[0] if one.endswith("[times]")]
    picks = sorted(np.random.default_rng(1).choice(len(table), CHECKED, replace=False))
    text = EXAMPLE.read_text(encoding="utf-8")
    head = [line for line in text[: text.index("[sensitivity]")].splitlines() if not line.startswith(GRIDS)]
    keys = _keys(text)
    lines = [*head, "[design]", 'kind = "list"']
    for name in names:
        short = name.removesuffix(" [times]")
        values = ", ".join(table[place][name] for place in picks)
        lines += [f"[parameters.{short}]", keys[short], "relative = true", f"values = [{values}]"]
    file = folder / f"checked_{reading}.toml"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    out = folder / f"checked_{reading}"
    words = ("sweep", str(file), "--reading", reading, "--out", str(out), "--no-plots")
    carried_out(*words, log=folder / f"checked_{reading}.log")
    words = ("sweep", str(_coarse(file, head)), "--reading", reading, "--out", f"{out}_coarse", "--no-plots")
    carried_out(*words, log=folder / f"checked_{reading}.log")
    pairs = zip(rows_of(Path(f"{out}_coarse") / "table.csv"), rows_of(out / "table.csv"), strict=True)
    return [{"coarse": one, "shipped": two} for one, two in pairs]


def _coarse(file: Path, head: list[str]) -> Path:
    """The same points on the grids of the sensitivity, which has them among its kept runs."""
    example = EXAMPLE.read_text(encoding="utf-8").splitlines()
    grids = [line for line in example if line.startswith(GRIDS)]
    text = file.read_text(encoding="utf-8").replace("[changes]", "\n".join(["[changes]", *grids]), 1)
    coarse = file.with_name(f"{file.stem}_coarse.toml")
    coarse.write_text(text, encoding="utf-8")
    return coarse


def _keys(text: str) -> dict[str, str]:
    """The line `keys = ...` of every parameter of a study's file."""
    found, name = {}, ""
    for line in text.splitlines():
        if line.startswith("[parameters."):
            name = line.partition(".")[2].partition("]")[0]
        elif line.startswith("keys = "):
            found[name] = line
    return found


def ishigami() -> dict[str, Any]:
    """Indices of Ishigami and Homma's function (a = 7, b = 0.1) from 1024 samples, beside the exact ones."""
    a, b, names = 7.0, 0.1, ("x1", "x2", "x3")

    def function(shares: NDArray[np.float64]) -> NDArray[np.float64]:
        x = math.pi * (2.0 * shares - 1.0)
        return np.asarray(np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0]))

    one, two = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, a**2 / 8.0
    both = b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = one + two + both
    exact = {"first": (one / whole, two / whole, 0.0), "total": ((one + both) / whole, two / whole, both / whole)}
    way = METHODS["sobol"]
    points = way.points(3, 1024, 3)
    found = way.indices(names, points, function(points), 3)
    return {
        "runs": len(points),
        "indices": [
            {
                "parameter": one.variable,
                "index": one.name,
                "exact": exact[one.name][names.index(one.variable)],
                "value": one.value,
                "low": one.low,
                "high": one.high,
            }
            for one in found
        ],
    }


COHORT, MEMBERS = ROOT / "examples" / "cohort.toml", 200
MAP, FULL = ROOT / "examples" / "stall_map.toml", 17
MAPS = {
    "full": (FULL, FULL, "motion"),
    "motion": (FULL, 5, "motion"),
    "expelled": (FULL, 5, "expelled"),
    "example": (33, 9, "motion"),
}
"""Nodes, coarse nodes, classes. The first runs every node."""


def replaced(text: str, lines: dict[str, str]) -> str:
    """The text of a study's file with other lines: what one begins with to what it is now."""
    found = []
    for line in text.splitlines():
        found.append(next((new for begin, new in lines.items() if line.startswith(begin)), line))
    return "\n".join(found) + "\n"


def carried(folder: Path, name: str, command: str, text: str) -> dict[str, Any]:
    """A study's file written and carried out by a command: what it cost."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return carried_out(command, str(file), "--out", str(folder / name), log=folder / f"{name}.log")


def cohort(folder: Path) -> dict[str, Any]:
    """The example's cohort with two hundred members: its classes and shifts, and what it cost."""
    cost = carried(
        folder, "cohort", "cohort", replaced(COHORT.read_text("utf-8"), {"samples = ": f"samples = {MEMBERS}"})
    )
    members = rows_of(folder / "cohort" / "members.csv")
    transits = [float(one["transit_s"]) for one in members if one["accepted"] == "yes" and one["transit_s"]]
    return {
        "cost": cost,
        "shifts": rows_of(folder / "cohort" / "shifts.csv"),
        "members": len(members),
        "why_not": Counter(one["why not"].partition(" = ")[0] for one in members if one["accepted"] == "no"),
        "statuses": Counter(one["status"] for one in members),
        "quantiles": [float(one) for one in np.quantile(transits, (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0))],
    }


def class_map(folder: Path, name: str) -> dict[str, Any]:
    """One map by the command: class of every node, and which were run."""
    nodes, coarse, classes = MAPS[name]
    lines = {"classes = ": f'classes = "{classes}"', "nodes = ": f"nodes = {nodes}", "coarse = ": f"coarse = {coarse}"}
    lines |= {"run.duration = ": 'run.duration = "4 s"\nstep.wall = "10 ms"'}
    cost = carried(folder, f"map_{name}", "stall-map", replaced(MAP.read_text("utf-8"), lines))
    rows = rows_of(folder / f"map_{name}" / "map.csv")
    return {
        "cost": cost,
        "nodes": [list(row.values()) for row in rows],
        "classes": Counter(row["class"] for row in rows),
        "run": sum(row["known by"] == "run" for row in rows),
    }
