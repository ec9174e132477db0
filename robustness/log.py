"""Rows on disk: a line as each is finished, the last table, and what changed since."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import peristalsis

from .execution import Row
from .rules import complaints, kind_of, plain

ROOT = Path(__file__).resolve().parents[1]
ROWS = ROOT / "out" / "robustness" / "rows.jsonl"
LAST = Path(__file__).with_name("last.csv")

MEASURES = (
    "transit_s",
    "last_cm",
    "speed_longitudinal",
    "speed_circular",
    "max_axial_force_mN",
    "max_normal_force_mN",
    "max_lumen_pressure_kPa",
    "min_diameter_cm",
    "max_diameter_cm",
    "bulge_cm",
    "oral_pole_cm",
    "anal_pole_cm",
    "power_residual",
    "momentum_residual",
    "simulated_s",
)
ROUNDING = ("power_residual", "momentum_residual")
"""Measures near rounding: their changes are no news while they stay small."""
COLUMNS = (
    "index",
    "group",
    "key",
    "class",
    "status",
    *MEASURES,
    "newton_a_step",
    "cpu_per_s",
    "remarks",
    "complaints",
    "words",
)
SAME = 1e-6
"""Relative change of a measure that is no change: last bits of other libraries or processors."""


def code_digest() -> str:
    """Hash of every source and parameter file of the package: rows of another code are not kept."""
    package = Path(peristalsis.__file__).parent
    digest = hashlib.sha256()
    for file in sorted(path for kind in ("*.py", "*.toml") for path in package.rglob(kind)):
        digest.update(file.relative_to(package).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def append(row: Row, code: str, file: Path = ROWS) -> None:
    """Add a row, whole or not at all as far as a reader can tell."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("ab+") as log:
        log.seek(0, 2)
        if log.tell() > 0:  # what was cut off in the middle of a line must not spoil the next
            log.seek(-1, 2)
            if log.read(1) != b"\n":
                log.write(b"\n")
        log.write((plain({**row, "code": code}) + "\n").encode())


def kept(code: str | None, file: Path = ROWS) -> dict[str, Row]:
    """Key of a case to its row, of this code (of any if None), the newest of each."""
    if not file.exists():
        return {}
    found: dict[str, Row] = {}
    for line in file.read_text(encoding="utf-8").splitlines():
        try:
            row = json.loads(line)
        except ValueError:  # cut off when the bench was stopped
            continue
        if code is None or row.get("code") == code:
            found[row["key"]] = row
    return found


def flat(row: Row) -> dict[str, Any]:
    """A row of the table."""
    summary: Mapping[str, Any] = row.get("summary", {})
    speeds = summary.get("wave_speed_cm_s") or {}
    table = {name: row.get(name, summary.get(name)) for name in MEASURES}
    table |= {f"speed_{layer}": speeds.get(layer) for layer in ("longitudinal", "circular")}
    return {
        "index": row["index"],
        "group": row["group"],
        "key": row["key"],
        "class": kind_of(row),
        "status": row.get("status", row["outcome"]),
        **{name: _short(value) for name, value in table.items()},
        "newton_a_step": _short(row.get("newton_a_step")),
        "cpu_per_s": _short(row.get("cpu_per_s")),
        "remarks": len(row.get("remarks", [])),
        "complaints": " | ".join(complaints(row)),
        "words": " ".join(str(row["words"]).split())[-300:],
    }


def _short(value: Any) -> Any:
    return float(f"{value:.9g}") if isinstance(value, float) and math.isfinite(value) else value


def write_last(rows: Iterable[Row], file: Path = LAST) -> None:
    """Keep the table that the next run is compared with."""
    with file.open("w", encoding="utf-8", newline="") as target:
        writer = csv.DictWriter(target, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(flat(row) for row in rows)


def read_last(file: Path = LAST) -> dict[str, dict[str, str]]:
    """Key of a case to its row in the last table; empty if there is none."""
    if not file.exists():
        return {}
    with file.open(encoding="utf-8", newline="") as source:
        return {row["key"]: row for row in csv.DictReader(source)}


def changes(rows: Iterable[Row], last: Mapping[str, Mapping[str, str]]) -> list[tuple[int, str, list[str]]]:
    """Index, group and what is different from the last table, for every case that is in both and not the same."""
    found = []
    for row in rows:
        old = last.get(row["key"])
        if old is None:
            continue
        new = flat(row)
        words = [f"{name}: {old[name]} → {new[name]}" for name in ("class", "status") if old[name] != str(new[name])]
        for name in MEASURES:
            if not _same(old[name], new[name], name):
                words.append(f"{name}: {old[name] or 'none'} → {'none' if new[name] is None else new[name]}")
        if words:
            found.append((int(row["index"]), str(row["group"]), words))
    return found


def _same(old: str, new: Any, name: str) -> bool:
    if old == "" or new is None:
        return old == "" and new is None
    before, after = float(old), float(new)
    if math.isnan(before) or math.isnan(after):
        return math.isnan(before) and math.isnan(after)
    least = 1e-4 if name in ROUNDING else 1e-9
    return abs(after - before) <= SAME * max(abs(before), abs(after)) + least
