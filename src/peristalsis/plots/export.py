"""A run for other programs: curves and maps as CSV, the moving surfaces as VTK; every name carries its unit."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ConfigurationError, WriteError, shown
from ..names import EVENTS, FIELDS, OUTPUTS, PROBES, SCALARS
from ..paths import located
from . import data, surface, vtk_files

if TYPE_CHECKING:
    from ..result import Result

MOST_FRAMES, MOST_FACETS = 10_000, 1024

RISKY = ("=", "+", "-", "@", "\t")
"""A text that begins with one of these would be taken for a formula by a spreadsheet."""


def export_csv(result: Result, folder: str | os.PathLike[str]) -> list[Path]:
    """Write curves.csv, probes.csv, events.csv and map_NAME.csv for every field into `folder`; returns the files.

    Curves have one row a step. Maps have one row a stored time and one column a place in the undeformed tube; the
    diameter in space is map_diameter_in_space.csv. Raises WriteError if the folder cannot be written.
    """
    target = located(folder)
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


def export_vtk(
    result: Result, folder: str | os.PathLike[str], frames: int = 100, facets: int = surface.FACETS
) -> list[Path]:
    """Write wall.pvd, and pellet.pvd where there is one, into `folder`, with a .vtp file a time; returns the lists.

    frames: stored times, spread evenly over the run. facets: columns that a wall of one column is revolved into. Files
    of an earlier export of the same names are replaced. Raises ConfigurationError for counts that make no series,
    WriteError if the folder cannot be written.
    """
    if not 1 <= frames <= MOST_FRAMES or not 3 <= facets <= MOST_FACETS:
        raise ConfigurationError(
            f"export of {frames} frames with {facets} facets: give 1 to {MOST_FRAMES} frames and "
            f"3 to {MOST_FACETS} facets"
        )
    target = located(folder)
    chosen = data.spread_frames(result, frames)
    series: dict[str, Callable[[int], surface.Surface]] = {"wall": lambda frame: surface.wall(result, frame, facets)}
    if data.has_pellet(result):
        series["pellet"] = lambda frame: surface.pellet(result, frame)
    time = data.values(result, "time")
    try:
        for name, shape in series.items():
            (target / name).mkdir(parents=True, exist_ok=True)
            for old in (target / f"{name}.pvd", *(target / name).glob(f"{name}_[0-9]*.vtp")):
                old.unlink(missing_ok=True)
            files = [f"{name}/{name}_{number:04d}.vtp" for number in range(len(chosen))]
            for frame, file in zip(chosen, files, strict=True):
                part = shape(frame)
                vtk_files.write_polygons(target / file, part.points, part.quads, part.fields)
            # The list comes last: it never names a file that is not there.
            listed = [(float(time[frame]), file) for frame, file in zip(chosen, files, strict=True)]
            vtk_files.write_series(target / f"{name}.pvd", listed)
    except OSError as error:
        raise WriteError(
            f"could not write VTK files into {shown(str(target))}: {error.strerror or error}; choose another folder"
        ) from None
    return [target / f"{name}.pvd" for name in series]


def _column(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _probes(result: Result) -> tuple[list[str], Iterable[Sequence[float]]]:
    places = result.arrays["probe"]
    head, columns = [_column("time", "s")], [result.arrays["time_step"]]
    for output in (one for one in PROBES if one.name in result.arrays):
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
