"""What makes the outcome of a run bad, fixed as functions of its row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

FASTEST_WAVE = 20.0
"""Wave speeds beyond this [cm/s] are no measurement of tissue that conducts at some 4 cm/s."""
LARGEST = 1e9
"""No number of a summary is larger in the units of the files."""
LARGEST_RESIDUAL = 1e-3
"""Work left over, of all work, from which on a run must say so."""
SLACK = 1e-6
"""Length [cm] by which a pole may pass an end without having left."""
BROKEN = ("diverged", "refused")

Row = Mapping[str, Any]


def faults(row: Row) -> list[str]:
    """Everything that is wrong with a row, in words; empty for a good one."""
    return [*_ended_badly(row), *_insane(row), *_silent_exit(row), *_silent_energy(row)]


def _ended_badly(row: Row) -> Iterator[str]:
    outcome = row["outcome"]
    if outcome in ("traceback", "crashed", "too_slow"):
        yield f"{outcome}: {row.get('sentence', '')}"
    elif "unforeseen" in str(row.get("sentence", "")):
        yield f"unforeseen: {row['sentence']}"
    elif outcome in BROKEN:
        if row.get("second_opinion"):
            yield f"{'broken off' if outcome == 'diverged' else 'refused wrongly'}: {row['second_opinion']} works"
        elif not tells(str(row.get("sentence", ""))):
            yield f"{outcome} with a sentence that names no parameter and no remedy: {row.get('sentence')}"


def tells(sentence: str) -> bool:
    """Whether an error names a parameter and says what to do."""
    sections = ("wall.", "pellet.", "lumen.", "grid.", "step.", "solver.", "longitudinal.", "circular.", "pacemaker.")
    more = ("tissue.", "cell.", "trigger.", "reflex.", "rings.", "run.", "output.")
    verbs = ("lower", "raise", "use", "refine", "lengthen", "shorten", "choose", "reduce", "strengthen", "set", "give")
    words = sentence.lower()
    return any(name in words for name in (*sections, *more)) and any(verb in words for verb in verbs)


def _insane(row: Row) -> Iterator[str]:
    for name, value in _numbers(row.get("summary") or {}):
        if not math.isfinite(value) or abs(value) > LARGEST:
            yield f"{name} = {value:g}"
        elif name.startswith("wave_speed_cm_s") and not 0.0 < abs(value) <= FASTEST_WAVE:
            yield f"{name} = {value:g} cm/s"


def _numbers(summary: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, value in summary.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{prefix}{key}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield f"{prefix}{key}", float(value)


def _says(row: Row, *words: str) -> bool:
    told = " ".join([*row.get("remarks", ()), *row.get("events", ())]).lower()
    return any(word in told for word in words)


def _silent_exit(row: Row) -> Iterator[str]:
    ends = row.get("ends")
    if not ends or str(row["outcome"]).startswith("expelled"):
        return
    if ends["oral_pole"] < -SLACK and not _says(row, "oral end", "oral_end", "orally", "oral clamp"):
        yield f"the pellet passed the oral end by {-ends['oral_pole']:.3g} cm without a word"
    if ends["anal_pole"] > ends["length"] + SLACK and not _says(row, "anal end", "anal_end", "expelled"):
        yield f"the pellet passed the anal end by {ends['anal_pole'] - ends['length']:.3g} cm without a word"


def _silent_energy(row: Row) -> Iterator[str]:
    residual = (row.get("summary") or {}).get("power_residual")
    if residual is not None and residual > LARGEST_RESIDUAL and not _says(row, "energy", "work"):
        yield f"work left over {residual:.2g} of all work without a word"


def answer(row: Row) -> tuple[str, float] | None:
    """How a run ended, as a status and a number: transit [s], or the final position [cm]; None without either."""
    summary = row.get("summary") or {}
    if summary.get("transit_s") is not None:
        return "transit", float(summary["transit_s"])
    if summary.get("final_position_cm") is not None:
        return "position", float(summary["final_position_cm"])
    return None


def change(row: Row, other: Row, length: float = 10.0) -> float | None:
    """Share by which two answers differ: of the transit, or of the tube's length; infinite if they differ in kind."""
    one, two = answer(row), answer(other)
    if one is None or two is None:
        return None
    if one[0] != two[0]:
        return math.inf
    return abs(one[1] - two[1]) / (one[1] if one[0] == "transit" else length)
