"""All rows of many runs as one table for a spreadsheet."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..inputs.config import FIELDS
from ..results.result import CLOCK
from ..units import QuantityError
from ..units import read as read_quantity
from .plan import as_text
from .rows import Row

RISKY = ("=", "+", "-", "@", "\t", "\r")
"""A text that begins with one of these would be taken for a formula by a spreadsheet."""


def table(keys: tuple[str, ...], rows: tuple[Row, ...], target: Path) -> bytes:
    """All rows as CSV: what was set, how it ended, every number of the summary; the same whatever the workers."""
    flat = [_flat({name: value for name, value in row.summary.items() if name not in CLOCK}) for row in rows]
    numbers = list(dict.fromkeys(name for one in flat for name in one if name not in ("scenario", "reading")))
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    units = {key: FIELDS[key].unit if key in FIELDS else "" for key in keys}
    writer.writerow(["name", *keys, *numbers, "remarks", "fingerprint", "folder"])
    for row, one in zip(rows, flat, strict=True):
        folder = name_of(row.folder, target)
        given = {key: as_text(row.point.values[key]) if key in row.point.values else "" for key in units}
        values = [guarded(text, units[key]) for key, text in given.items()]
        said = " | ".join(row.remarks)
        cells = [row.point.name, *(_cell(one.get(name)) for name in numbers), said, row.fingerprint, folder]
        name, *rest = map(guarded, cells)
        writer.writerow([name, *values, *rest])
    return text.getvalue().encode("utf-8")


def name_of(folder: Path | None, target: Path) -> str:
    """A folder below TARGET as the table names it; empty for none."""
    return "" if folder is None else folder.relative_to(target).as_posix()


def _flat(summary: Mapping[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in summary.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}_{inner}": one for inner, one in value.items()}
        else:
            flat[name] = value
    return flat


def _cell(value: object) -> str:
    return "" if value is None else value if isinstance(value, str) else repr(value)


def guarded(cell: str, unit: str = "") -> str:
    """A cell that no spreadsheet takes for a formula; numbers stay as they are, those with a unit in their column."""
    return f"'{cell}" if cell.startswith(RISKY) and not _is_number(cell, unit) else cell


def _is_number(cell: str, unit: str) -> bool:
    try:
        float(cell)
    except ValueError:
        try:
            return bool(unit) and math.isfinite(read_quantity(cell, unit))
        except QuantityError:
            return False
    return True
