"""What is wrong with a row: pure functions of it, and the class it belongs to."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from peristalsis.inputs.config import FIELDS

Row = Mapping[str, Any]

FASTEST = 20.0
"""Wave speed above which a number is no measurement [cm/s]."""
LARGEST = 1e6
"""No number of a summary is larger, whatever its unit, unless a remark names it."""
ENERGY = 1e-3
"""Share of the work, or of the largest force, that a balance may leave over without a remark."""
BULGE = 1.0
"""Distance that the wall may reach beyond its clamped rings without a word [cm]."""
POLE = 0.02
"""Distance that the pellet's pole may reach beyond a clamp without a word [cm]."""

REMEDIES = (
    "lower|raise|use|give|choose|refine|correct|shorten|lengthen|enlarge|reduce|increase|decrease|set|disable|enable|"
    "name|keep|store|try|start|move|make|strengthen|soften|stiffen|widen|narrow|change"
)
_REMEDY = re.compile(rf"[;.,:]\s+(?:[a-z ]{{0,40}}\b)?(?:{REMEDIES})\b", re.IGNORECASE)
_KEY = re.compile(
    "|".join(re.escape(key) + r"\b" for key in sorted((*FIELDS, "protocols", "regions"), key=len, reverse=True))
)

GOOD = ("finished", "refused_rightly", "ended_rightly")
CLASSES = (*GOOD, "badly_said", "refused_wrongly", "broken_off", "too_slow", "traceback")


def kind_of(row: Row) -> str:
    """One of CLASSES: what came of a case, with the second opinion taken into account."""
    outcome = row["outcome"]
    if outcome == "finished":
        return "finished"
    if outcome in ("traceback", "too_slow"):
        return str(outcome)
    if any(other == "finished" for other in row.get("other_ways", {}).values()):
        return "refused_wrongly" if outcome == "refused" else "broken_off"
    if form_of_sentence(str(row["words"])) or in_vain(row):
        return "badly_said"
    return "refused_rightly" if outcome == "refused" else "ended_rightly"


def form_of_sentence(words: str) -> list[str]:
    """What a refusal lacks: the key of a parameter, a remedy, one line without talk of bugs."""
    lacks = []
    if not _KEY.search(words):
        lacks.append("names no parameter")
    if not _REMEDY.search(words):
        lacks.append("names no remedy")
    if "report it" in words or "unforeseen" in words or "Traceback" in words or "\n" in words.strip():
        lacks.append("is no sentence for a user")
    if re.search(r"(?<![\w.])-?(?:inf|nan)\b", words):
        lacks.append("holds a number that is none")
    return lacks


TRIED = {
    "grid.n_z": "grids x 2",
    "grid.n_z_wall": "grids x 2",
    "step.wall": "steps x 0.5",
    "step.conduction": "steps x 0.5",
    "solver.residual_tolerance": "tolerance x 100",
}
"""Parameters that other ways change: a sentence that blames these alone, where those did not help, blames wrongly."""


def in_vain(row: Row) -> list[str]:
    """Whether a sentence advises what was tried and did not help."""
    named = set(_KEY.findall(str(row["words"])))
    ways = row.get("other_ways", {})
    if named and all(TRIED.get(key) in ways for key in named):
        return [f"advises {', '.join(sorted(named))}, tried in vain"]
    return []


def complaints(row: Row) -> list[str]:
    """Everything that is wrong with a row; empty for one that is in order."""
    kind = kind_of(row)
    found = [] if kind in GOOD else [kind]
    if kind == "badly_said":
        found += [*form_of_sentence(str(row["words"])), *in_vain(row)]
    if row.get("warnings"):
        found.append(f"warnings of libraries: {row['warnings'][0][:80]}")
    if "summary" not in row:
        return found
    said = told(row)
    found += [f"not finite: {name}" for name in row.get("not_finite", [])]
    for name, value in numbers(row["summary"]):
        told_of = name.startswith("max_") and _says(said, re.escape(name))
        if not math.isfinite(value) or (abs(value) > LARGEST and not told_of):
            found.append(f"insane: {name} = {value:.4g}")
        elif _SPEED.search(name) and not _possible(value, row):
            found.append(f"insane: {name} = {value:.4g} cm/s")
    residual = row["summary"].get("power_residual")
    if residual is not None and residual > ENERGY and not _says(said, r"energy|balance of work|power_residual"):
        found.append(f"energy {residual:.2g} without a remark")
    momentum = row["summary"].get("momentum_residual")
    if momentum is not None and momentum > ENERGY and not _says(said, r"momentum"):
        found.append(f"momentum {momentum:.2g} without a remark")
    if row.get("bulge_cm", 0.0) > BULGE and not _says(said, r"bulg|beyond (?:its|the) clamp"):
        found.append(f"silent bulge of {row['bulge_cm']:.3g} cm over the {row['bulge_end']} ring")
    return found + _silent_exits(row, said)


def _silent_exits(row: Row, said: str) -> list[str]:
    if row.get("oral_pole_cm") is None or row["status"] not in ("in_transit", "arrested", "diverged"):
        return []
    found = []
    if row["oral_pole_cm"] < -POLE and not _says(said, r"oral[ _](?:end|exit|clamp)|orally|clamped (?:oral )?ring"):
        where = "centre" if row["oral_centre_cm"] < 0.0 else "pole"
        found.append(f"silent exit: {where} at {row['oral_pole_cm']:.3g} cm (pole) beyond the oral clamp")
    if row["anal_pole_cm"] > row["length_cm"] + POLE and not _says(
        said, r"expelled|anal[ _](?:exit|clamp)|clamped (?:anal )?ring"
    ):
        found.append(f"silent exit: pole at {row['anal_pole_cm']:.3g} cm beyond the anal clamp")
    return found


_SPEED = re.compile(r"(?:^|\.)wave_speed_cm_s(?:[.\[]|$)")


def _possible(speed: float, row: Row) -> bool:
    """Whether a wave may have this speed [cm/s]: negative only where the run tells of a retrograde wave."""
    if 0.0 < speed <= FASTEST:
        return True
    counted = any(value > 0 for name, value in numbers(row["summary"]) if "retrograde" in name)
    return -FASTEST <= speed < 0.0 and (counted or _says(told(row), "retrograde"))


def told(row: Row) -> str:
    """Everything that a run says: remarks, kinds and words of events, texts of its summary."""
    parts = [*row.get("remarks", []), *row.get("events", {}), *row.get("event_words", []), str(row.get("status", ""))]
    return "\n".join([*parts, *texts(row.get("summary", {}))])


def _says(said: str, pattern: str) -> bool:
    return re.search(pattern, said, re.IGNORECASE) is not None


def numbers(tree: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a summary with its dotted name."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from numbers(value, f"{name}.{key}" if name else str(key))
    elif isinstance(tree, list | tuple):
        for place, value in enumerate(tree):
            yield from numbers(value, f"{name}[{place}]")
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield name, float(tree)


def texts(tree: Any) -> Iterator[str]:
    """Texts of a summary, those in lists and tables too."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            if isinstance(value, str):
                yield f"{key}: {value}"
            elif isinstance(value, Mapping | list | tuple):
                yield from texts(value)
    elif isinstance(tree, list | tuple):
        for value in tree:
            yield from [value] if isinstance(value, str) else texts(value)


def remarked(row: Row) -> bool:
    """Whether a run says anything at all of itself."""
    return bool(row.get("remarks"))


def plain(row: Row) -> str:
    """A row as a line of JSON."""
    return json.dumps(row, default=str, allow_nan=True)
