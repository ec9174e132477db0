"""The page of the bench: counts, bad rows with the lines that reproduce them, costs, changes, halvings."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Sequence
from statistics import median
from typing import Any

from .execution import Row
from .plan import Case, groups, ranges
from .rules import CLASSES, complaints, kind_of

MOST_CHANGES = 60


def command(case: Case) -> str:
    """The command line that runs a case, into the folder out/robust-INDEX."""
    parts = ["peristalsis", "run", case.scenario, "--reading", case.reading]
    for key, value in case.all_changes().items():
        parts += ["--set", f"{key}={value}"]
    return shlex.join([*parts, "--no-plots", "--out", f"out/robust-{case.index}"])


def toml(case: Case) -> str:
    """The case as a configuration file: complete, so that it means the same under other defaults."""
    from peristalsis import configuration

    return configuration(case.scenario, reading=case.reading, changes=case.all_changes()).to_toml()


def case_of(row: Row) -> Case:
    """The case of a row, all changes in one table."""
    return Case(row["index"], row["group"], row["scenario"], row["reading"], row["changes"], {}, row.get("variant", ""))


def page(
    rows: Sequence[Row],
    planned: int,
    changed: Sequence[tuple[int, str, list[str]]] | None,
    halvings: str = "",
    title: str = "",
) -> str:
    """Markdown of everything that the rows tell."""
    rows = sorted(rows, key=lambda row: row["index"])
    bad = [row for row in rows if complaints(row)]
    counts = Counter(kind_of(row) for row in rows)
    wrong = counts["refused_wrongly"] + counts["broken_off"]
    costs = sorted(row["cpu_per_s"] for row in rows if row.get("cpu_per_s") is not None)
    lines = [
        "# Random configurations",
        "",
        "Made by `make robust`; what is sampled, run and judged is in [robustness.md](../robustness.md). "
        f"{title}{len(rows)} of {planned} cases run.",
        "",
        f"Refused wrongly or broken off: {wrong} of {len(rows)} ({100.0 * wrong / max(len(rows), 1):.2g} %); "
        f"tracebacks: {counts['traceback']}; cases with any complaint: {len(bad)}.",
    ]
    if costs:
        slowest = max((row for row in rows if row.get("cpu_per_s") is not None), key=lambda row: row["cpu_per_s"])
        lines += [
            "",
            f"Processor seconds per simulated second: median {median(costs):.3g}, 95 % below "
            f"{costs[int(0.95 * (len(costs) - 1))]:.3g}, largest {costs[-1]:.3g} (case {slowest['index']}, "
            f"{slowest['group']}).",
        ]
    lines += ["", "## Outcomes by group", "", _outcomes(rows), "", "## Complaints", "", _complaints(rows)]
    lines += ["", "## Worst of each measure", "", _worst(rows)]
    lines += ["", "## Changes since the last table", "", _changes(changed)]
    if halvings:
        lines += ["", "## Grids doubled, steps halved", "", halvings]
    lines += [
        "",
        "## Bad rows",
        "",
        "`python -m robustness --show INDEX` prints any case as a file and as a command line.",
        "",
    ]
    for row in bad:
        lines += [_bad(row), ""]
    return "\n".join(lines).rstrip() + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def _outcomes(rows: Sequence[Row]) -> str:
    table = []
    for name in groups():
        ours = [row for row in rows if row["group"] == name]
        if not ours:
            continue
        counts = Counter(kind_of(row) for row in ours)
        worried = sum(1 for row in ours if kind_of(row) == "finished" and complaints(row))
        about = ranges()["groups"][name]["what"]
        table.append([about, len(ours), *(counts[kind] or "" for kind in CLASSES), worried or ""])
    totals = Counter(kind_of(row) for row in rows)
    worried = sum(1 for row in rows if kind_of(row) == "finished" and complaints(row))
    table.append(["all", len(rows), *(totals[kind] or "" for kind in CLASSES), worried or ""])
    return _table(["group", "cases", *(kind.replace("_", " ") for kind in CLASSES), "finished, complaints"], table)


def _complaints(rows: Sequence[Row]) -> str:
    counts: Counter[str] = Counter()
    example: dict[str, int] = {}
    for row in rows:
        for kind in {_kind_of_complaint(text) for text in complaints(row)}:
            counts[kind] += 1
            example.setdefault(kind, row["index"])
    if not counts:
        return "None."
    return _table(["complaint", "cases", "first"], [[kind, n, example[kind]] for kind, n in counts.most_common()])


def _kind_of_complaint(text: str) -> str:
    """A complaint without its numbers."""
    head = text.split(" = ")[0].split(" of ")[0]
    return " ".join(word for word in head.split() if not word[:1].isdigit() and word[:1] != "-")


def _worst(rows: Sequence[Row]) -> str:
    table = []
    for name, least in WORST.items():
        found = [
            (float(value), row)
            for row in rows
            if (value := row.get(name, row.get("summary", {}).get(name))) is not None
        ]
        if found:
            value, row = (min if least else max)(found, key=lambda pair: pair[0])
            table.append([name, f"{value:.4g}", row["index"], row["group"], _changed(row)])
    return _table(["measure", "worst", "case", "group", "what was varied"], table)


WORST = {
    "power_residual": False,
    "momentum_residual": False,
    "bulge_cm": False,
    "oral_pole_cm": True,
    "min_diameter_cm": True,
    "max_diameter_cm": False,
    "max_axial_force_mN": False,
    "max_contact_pressure_kPa": False,
    "newton_a_step": False,
    "cpu_per_s": False,
}
"""Measure to whether the smallest is the worst."""

HIDDEN = ("run.duration", "output.interval", "output.fields")


def _changed(row: Row) -> str:
    changes: dict[str, Any] = {key: value for key, value in row["changes"].items() if key not in HIDDEN}
    text = ", ".join(f"{key} = {value}" for key, value in changes.items())
    return f"{row['scenario']}, {row['reading']}: {text}"


def _changes(changed: Sequence[tuple[int, str, list[str]]] | None) -> str:
    if changed is None:
        return "There is no last table."
    if not changed:
        return "None."
    lines = [f"{len(changed)} cases changed.", ""]
    lines += [f"- {index} ({group}): " + "; ".join(words) for index, group, words in changed[:MOST_CHANGES]]
    if len(changed) > MOST_CHANGES:
        lines.append(f"- and {len(changed) - MOST_CHANGES} more")
    return "\n".join(lines)


def _bad(row: Row) -> str:
    words = " ".join(str(row["words"]).split())
    lines = [f"### {row['index']}: {row['group']}, {kind_of(row)}", ""]
    lines += [f"- {text}" for text in complaints(row)]
    if words:
        lines.append(f"- said: {words[-600:]}")
    if row.get("other_ways"):
        lines.append("- other ways: " + ", ".join(f"{way}: {outcome}" for way, outcome in row["other_ways"].items()))
    lines += ["", "```sh", command(case_of(row)), "```"]
    return "\n".join(lines)
