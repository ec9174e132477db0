"""The page and the table of the bench."""

from __future__ import annotations

import csv
import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rules
from plan import Case

COLUMNS = ("number", "group", "outcome", "transit_s", "final_position_cm", "faults", "sentence")
CHANGED = 1e-3
"""Share by which an answer may move from one table to the next without a line."""

Rows = Sequence[Mapping[str, Any]]


def page(rows: Rows, halved: Rows, cases: Mapping[int, Case], quick: bool) -> str:
    """Everything about a table of outcomes, in Markdown."""
    bad = {row["number"]: rules.faults(row) for row in rows if rules.faults(row)}
    title = "# Random configurations" + (" (quick plan)" if quick else "")
    made = "Made by `make robust`; the ranges, each with its reason, are in `robustness/plan.toml`."
    parts = [title, made, _counts(rows, bad), _costs(rows), _bad_rows(rows, bad, cases)]
    if halved:
        parts.append(halving(rows, halved))
    return "\n\n".join(part for part in parts if part) + "\n"


def _table(head: Sequence[str], lines: Sequence[Sequence[object]]) -> str:
    def cell(value: object) -> str:
        return f"{value:.4g}" if isinstance(value, float) else str(value).replace("|", "\\|")

    body = ["| " + " | ".join(cell(value) for value in line) + " |" for line in lines]
    return "\n".join(["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *body])


def _counts(rows: Rows, bad: Mapping[int, Sequence[str]]) -> str:
    outcomes = sorted({str(row["outcome"]) for row in rows})
    lines: list[list[object]] = []
    for group in [*dict.fromkeys(str(row["group"]) for row in rows), "all"]:
        own = [row for row in rows if group in ("all", row["group"])]
        counts = Counter(str(row["outcome"]) for row in own)
        remarked = sum(1 for row in own if row.get("remarks"))
        faulty = sum(1 for row in own if row["number"] in bad)
        lines.append([group, len(own), *(counts.get(name, 0) for name in outcomes), remarked, faulty])
    return _table(["group", "runs", *outcomes, "with a remark", "bad"], lines)


def _costs(rows: Rows) -> str:
    costs = []
    for row in rows:
        summary = row.get("summary") or {}
        if summary.get("simulated_s"):
            costs.append((summary["solver_wall_s"] / summary["simulated_s"], row["number"]))
    if not costs:
        return ""
    largest = sorted(costs)[-5:][::-1]
    worst = ", ".join(f"{cost:.1f} (number {number})" for cost, number in largest)
    middle = statistics.median(cost for cost, _ in costs)
    return f"Seconds in the solver for a simulated second: median {middle:.2f}, largest {worst}."


def _bad_rows(rows: Rows, bad: Mapping[int, Sequence[str]], cases: Mapping[int, Case]) -> str:
    if not bad:
        return "No run ended badly."
    kinds = Counter(
        fault.split(":")[0].split(" = ")[0].split(" by ")[0][:60] for found in bad.values() for fault in found
    )
    parts = ["## What ended badly", _table(["kind", "times"], [[kind, count] for kind, count in kinds.most_common()])]
    for row in rows:
        if row["number"] in bad:
            told = "; ".join(bad[row["number"]])
            parts.append(f"* number {row['number']}, {row['group']}: {told}\n  `{cases[row['number']].command()}`")
    return "\n\n".join(parts[:2]) + "\n\n" + "\n".join(parts[2:])


def halving(rows: Rows, halved: Rows) -> str:
    """How far answers move on doubled grids and halved steps, with and without a remark of the run."""
    base = {row["number"]: row for row in rows}
    lines: list[list[object]] = []
    largest = {True: 0.0, False: 0.0}
    for row in sorted(halved, key=lambda one: (one["number"], one["key"])):
        before = base.get(row["number"])
        if before is None:
            continue
        length = (before.get("ends") or {}).get("length", 10.0)
        moved = rules.change(before, row, length)
        remarked = bool(before.get("remarks"))
        if moved is not None:
            largest[remarked] = max(largest[remarked], moved)
        what = "doubled grid" if str(row["key"]).startswith("grid") else "halved step"
        share = "–" if moved is None else "another end" if math.isinf(moved) else f"{100.0 * moved:.2f} %"
        answers = [
            " ".join(f"{part:.5g}" if isinstance(part, float) else part for part in rules.answer(one) or ("–",))
            for one in (before, row)
        ]
        lines.append([row["number"], row["group"], what, *answers, share, "yes" if remarked else "no"])
    words = {
        remarked: "another end" if math.isinf(value) else f"{100.0 * value:.2f} %"
        for remarked, value in largest.items()
    }
    head = ["number", "group", "against", "as shipped", "finer", "change", "remark"]
    told = f"Largest change without a remark: {words[False]}; with one: {words[True]}."
    return "## Finer grids and steps\n\n" + told + "\n\n" + _table(head, lines)


def write_table(file: Path, rows: Rows) -> None:
    """The table that the next one is compared with."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            summary = row.get("summary") or {}
            numbers = [summary.get("transit_s"), summary.get("final_position_cm")]
            shown = ["" if value is None else f"{value:.6g}" for value in numbers]
            told = str(row.get("sentence", ""))[:200]
            writer.writerow([row["number"], row["group"], row["outcome"], *shown, len(rules.faults(row)), told])


def read_table(file: Path) -> dict[int, dict[str, str]]:
    """The last table by number; empty if there is none."""
    if not file.exists():
        return {}
    with file.open(encoding="utf-8", newline="") as stream:
        return {int(row["number"]): row for row in csv.DictReader(stream)}


def regression(rows: Rows, before: Mapping[int, Mapping[str, str]]) -> str:
    """Runs that end otherwise than in the last table."""
    if not before:
        return ""
    lines: list[list[object]] = []
    for row in rows:
        old = before.get(int(row["number"]))
        if old is None:
            continue
        summary = row.get("summary") or {}
        moved = False
        for name in ("transit_s", "final_position_cm"):
            new = summary.get(name)
            if (new is None) != (old[name] == ""):
                moved = True
            elif new is not None:
                moved |= abs(float(new) - float(old[name])) > CHANGED * max(abs(float(new)), 1.0)
        if old["outcome"] != row["outcome"] or moved:
            now = summary.get("transit_s") or summary.get("final_position_cm")
            was = old["transit_s"] or old["final_position_cm"]
            lines.append([row["number"], row["group"], f"{old['outcome']} {was}", f"{row['outcome']} {now}"])
    if not lines:
        return "\n## Against the last table\n\nNo outcome changed.\n"
    return "\n## Against the last table\n\n" + _table(["number", "group", "was", "is"], lines) + "\n"
