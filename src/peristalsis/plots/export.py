"""Curves and maps of a run as plain CSV: every column names its unit."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import WriteError, shown
from ..names import EVENTS, FIELDS, OUTPUTS, PROBES, SCALARS
from . import data

if TYPE_CHECKING:
    from ..result import Result

RISKY = ("=", "+", "-", "@", "\t")
"""A text that begins with one of these would be taken for a formula by a spreadsheet."""


def export_csv(result: Result, folder: str | os.PathLike[str]) -> list[Path]:
    """Write curves.csv, probes.csv, events.csv and map_NAME.csv for every field into `folder`; returns the files.

    Curves have one row a step. Maps have one row a stored time and one column a place in the undeformed tube; the
    diameter in space is map_diameter_in_space.csv. Raises WriteError if the folder cannot be written.
    """
    target = Path(folder)
    written = []
    try:
        target.mkdir(parents=True, exist_ok=True)
        time = result.arrays["time_step"]
        curves = [output for output in SCALARS if output.name in result.arrays]
        head = [_column("time", "s"), *(_column(output.name, output.unit) for output in curves)]
        columns = [time, *(result.arrays[output.name] for output in curves)]
        written.append(_write(target / "curves.csv", head, zip(*columns, strict=True)))
        written.append(_write(target / "probes.csv", *_probes(result)))
        written.append(_write(target / "events.csv", *_events(result)))
        for output in FIELDS:
            if output.name in result.arrays:
                place = result.arrays["z" if "z" in output.dimensions else "z_cell"]
                head = [_column("time", "s"), *(f"z = {z:.6g} cm" for z in place)]
                rows = np.column_stack([result.arrays["time"], data.values(result, output.name)])
                written.append(
                    _write(target / f"map_{output.name}.csv", [*head], rows, f"{output.name} [{output.unit}]")
                )
        moments, axis, diameter = data.diameter_map(result)
        head = [_column("time", "s"), *(f"position = {place:.6g} mm" for place in axis)]
        rows = np.column_stack([moments, diameter])
        written.append(_write(target / "map_diameter_in_space.csv", head, rows, "inner diameter [mm]"))
    except OSError as error:
        raise WriteError(
            f"could not write CSV files into {shown(str(target))}: {error.strerror or error}; choose another folder"
        ) from None
    return written


def _column(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _probes(result: Result) -> tuple[list[str], Iterable[Sequence[float]]]:
    places = result.arrays["probe"]
    head, columns = [_column("time", "s")], [result.arrays["time_step"]]
    for output in PROBES:
        for k, place in enumerate(places):
            head.append(f"{output.name.removesuffix('_probe')} at {place:.4g} cm [{output.unit}]")
            columns.append(result.arrays[output.name][:, k])
    return head, zip(*columns, strict=True)


def _events(result: Result) -> tuple[list[str], Iterable[Sequence[object]]]:
    names = [output.name for output in EVENTS if output.name in result.arrays]
    head = [_column(name.removeprefix("event_"), OUTPUTS[name].unit) for name in names]
    return head, zip(*(result.arrays[name] for name in names), strict=True)


def _text(value: object) -> str:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(RISKY) else value
    return repr(float(value)) if isinstance(value, float | np.floating | int | np.integer) else str(value)


def _write(path: Path, head: Sequence[str], rows: Iterable[Iterable[object]], about: str | None = None) -> Path:
    with path.open("w", newline="", encoding="ascii", errors="replace") as file:
        writer = csv.writer(file)
        writer.writerow(head if about is None else [f"{head[0]}; cells: {about}", *head[1:]])
        for row in rows:
            writer.writerow([_text(value) for value in row])
    return path
