"""Is what runs report without a remark converged? Some cases again on doubled grids and with halved steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from peristalsis import configuration

from .execution import GRIDS, Row
from .plan import Case

WANTED = 0.02
"""Largest change of transit, or of the last place over the tube's length, among runs without a remark."""
NUMERICAL = ("grids", "steps", "solver", "surface", "protocols")
"""Groups that vary the numerics themselves, or inputs whose kinks lie on steps."""


def finer(case: Case) -> list[Case]:
    """The case on doubled grids, and with halved steps."""
    chosen = configuration(case.scenario, reading=case.reading, changes=case.all_changes())
    doubled = {name: str(2 * getattr(chosen.grid, key)) for name, key in GRIDS.items()}
    halved = {
        "step.wall": f"{0.5 * chosen.step.wall:.8g} ms",
        "step.conduction": f"{0.5 * chosen.step.conduction:.8g} ms",
    }
    return [case.varied("grids x 2", doubled), case.varied("steps x 0.5", halved)]


def chosen_cases(cases: Sequence[Case], row_of: Callable[[Case], Row | None], count: int) -> list[Case]:
    """The first `count` cases, of groups that leave the numerics alone, that finished with a pellet."""
    found: list[Case] = []
    for case in cases:
        row = row_of(case)
        suits = case.group not in NUMERICAL and row is not None and row["outcome"] == "finished" and "last_cm" in row
        if suits and len(found) < count:
            found.append(case)
    return found


def difference(row: Row, other: Row) -> float | None:
    """Relative change of the transit (none expelled: of the last place over the length); None if it failed."""
    if other["outcome"] != "finished":
        return None
    before, after = (one["summary"].get("transit_s") for one in (row, other))
    if before is not None and after is not None:
        return abs(after - before) / before
    if before is None and after is None and row["simulated_s"] == other["simulated_s"]:
        return abs(other["last_cm"] - row["last_cm"]) / row["length_cm"]
    # One was expelled and the other was not: what is left of the way of the one that was not, at least.
    return max(abs(other["last_cm"] - row["last_cm"]) / row["length_cm"], WANTED * 1.01)


def table(cases: Sequence[Case], row_of: Callable[[Case], Row | None]) -> str:
    """Markdown of what was run of the study."""
    lines = [
        "| case | group | transit (s) or last place (cm) | grids × 2 | steps × 0.5 | change | remarks |",
        "|---|---|---|---|---|---|---|",
    ]
    silent, over, remarked = [], 0, 0
    for case in cases:
        row, others = row_of(case), [row_of(other) for other in finer(case)]
        if row is None or any(other is None for other in others):
            continue
        found = [difference(row, other) for other in others if other is not None]
        worst = None if any(value is None for value in found) else max(value for value in found if value is not None)
        said = row.get("remarks", [])
        if said:
            remarked += 1
        else:
            silent.append(worst)
            over += worst is None or worst > WANTED
        change = "failed" if worst is None else f"{100.0 * worst:.3g} %"
        cells = [case.index, case.group, _number(row), *(_number(other) for other in others if other is not None)]
        lines.append("| " + " | ".join(str(cell) for cell in [*cells, change, len(said) or "none"]) + " |")
    numbers = [value for value in silent if value is not None]
    head = (
        f"{len(silent) + remarked} cases, {remarked} of them with a remark. Without one: largest change "
        f"{100.0 * max(numbers, default=0.0):.3g} %, {over} above {100.0 * WANTED:g} %."
    )
    return head + "\n\n" + "\n".join(lines)


def _number(row: Row) -> str:
    if row["outcome"] != "finished":
        return str(row["outcome"])
    transit = row["summary"].get("transit_s")
    return f"{transit:.5g} s" if transit is not None else f"{row['last_cm']:.5g} cm"
