"""A run for other programs: curves and maps as CSV, the moving surfaces as VTK; every name carries its unit."""

from __future__ import annotations

import csv
import gzip
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ConfigurationError, could_not, shown, suggestion
from ..inputs.recording import ALL
from ..names import EVENTS, FIELDS, OUTPUTS, PROBES, SCALARS
from ..paths import located
from ..units import QuantityError, read
from . import data, surface, vtk_files

if TYPE_CHECKING:
    from ..results.result import Result

SI = ("m", "s", "V", "Pa", "N", "N/m", "J", "m/s", "S/m^2")
"""What the units ("SI",) are."""

MOST_FRAMES, MOST_FACETS = 10_000, 1024

RISKY = ("=", "+", "-", "@", "\t")
"""A text that begins with one of these would be taken for a formula by a spreadsheet."""


def export_csv(
    result: Result,
    folder: str | os.PathLike[str],
    every: float | None = None,
    fields: Sequence[str] = (),
    compress: bool = False,
    units: Sequence[str] = (),
) -> list[Path]:
    """Write curves.csv, probes.csv, events.csv and maps of fields into `folder`; returns the files.

    Curves have one row a step. Maps have one row a stored time and one column a place in the undeformed tube; the
    diameter in space is map_diameter_in_space.csv, the map that is always there. fields: which maps besides, each
    map_NAME.csv, or ("all",). every: least time between rows [s]; the last row is kept. compress: as .csv.gz. units:
    such as ("mm", "Pa"), or ("SI",), for all numbers that convert to them; the others stay in the units of `names`.
    Raises ConfigurationError for fields and units that there are not, WriteError if the folder cannot be written.
    """
    if every is not None and not every > 0.0:
        raise ConfigurationError(f"rows every {every:g} s: give a positive time")
    known = [output.name for output in FIELDS if output.name in result.arrays]
    for name in fields:
        if name not in (ALL, *known):
            raise ConfigurationError(
                f"field {shown(name)} is not stored by this run; {suggestion(name, (ALL, *known))}"
            )
    target, ending, chosen = located(folder), ".csv.gz" if compress else ".csv", Units(units)
    written = []
    try:
        target.mkdir(parents=True, exist_ok=True)
        steps, frames = (_thinned(result.arrays[name], every) for name in ("time_step", "time"))
        curves = [output for output in SCALARS if output.name in result.arrays]
        head = [_column("time", chosen.of("s"))]
        head += [_column(output.name, chosen.of(output.unit)) for output in curves]
        columns = [chosen.shown(result.arrays["time_step"], "s")]
        columns += [chosen.shown(result.arrays[output.name], output.unit) for output in curves]
        written.append(_write(target / f"curves{ending}", head, zip(*(c[steps] for c in columns), strict=True)))
        written.append(_write(target / f"probes{ending}", *_probes(result, steps, chosen)))
        written.append(_write(target / f"events{ending}", *_events(result, chosen)))
        for output in FIELDS:
            if output.name in known and (ALL in fields or output.name in fields):
                place = result.arrays["z" if "z" in output.dimensions else "z_cell"]
                head = [_column("time", chosen.of("s")), *(f"z = {chosen.place(z, 'cm')}" for z in place)]
                field = chosen.shown(data.values(result, output.name), output.unit)
                rows = np.column_stack([chosen.shown(result.arrays["time"], "s"), field])[frames]
                about = f"{output.name} [{chosen.of(output.unit)}]"
                written.append(_write(target / f"map_{output.name}{ending}", [*head], rows, about))
        moments, axis, diameter = data.diameter_map(result)
        head = [_column("time", chosen.of("s")), *(f"position = {chosen.place(place, 'mm')}" for place in axis)]
        rows = np.column_stack([chosen.shown(moments, "s"), chosen.shown(diameter, "mm")])[frames]
        about = f"inner diameter [{chosen.of('mm')}]"
        written.append(_write(target / f"map_diameter_in_space{ending}", head, rows, about))
    except OSError as error:
        raise could_not(f"write CSV files into {shown(str(target))}", error, "another folder") from None
    return written


class Units:
    """The units of a table: those that were asked for where a number converts to one of them, else its own."""

    def __init__(self, asked: Sequence[str]) -> None:
        self._factors: dict[str, tuple[str, float]] = {}
        own = sorted({"mm", *(output.unit for output in OUTPUTS.values())} - {"", "1"})
        for wanted in SI if tuple(asked) == ("SI",) else asked:
            why = ""
            found = {}
            for unit in own:
                try:
                    found[unit] = (wanted, read(f"1 {wanted}", unit))
                except QuantityError as error:
                    why = str(error)
            if not found:
                cause = why if "unknown" in why or "not a unit" in why else "no number of a run has such a unit"
                raise ConfigurationError(f"units {shown(wanted)}: {cause}; name others, such as mm, ms, Pa, N, or SI")
            self._factors = {**found, **self._factors}  # the first that fits holds

    def of(self, unit: str) -> str:
        """The unit that numbers in `unit` are shown in."""
        return self._factors.get(unit, (unit, 1.0))[0]

    def shown(self, values: Any, unit: str) -> Any:
        """Numbers in `unit`, in the unit that is shown; whatever has no other unit is left as it is."""
        return values / self._factors[unit][1] if unit in self._factors else values

    def place(self, value: float, unit: str) -> str:
        """A place for the head of a column."""
        return f"{self.shown(value, unit):.6g} {self.of(unit)}"


def _thinned(time: data.Floats, every: float | None) -> list[int]:
    """Indices of times [s] at least `every` apart, the first and the last among them."""
    if every is None or time.size < 2:
        return list(range(time.size))
    number = np.floor(time / every + 1e-9).astype(int)
    chosen = np.flatnonzero(np.diff(number, prepend=-1) > 0).tolist()
    return chosen if chosen[-1] == time.size - 1 else [*chosen, time.size - 1]


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
        raise could_not(f"write VTK files into {shown(str(target))}", error, "another folder") from None
    return [target / f"{name}.pvd" for name in series]


def _column(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _probes(result: Result, rows: Sequence[int], chosen: Units) -> tuple[list[str], Iterable[Sequence[float]]]:
    places = result.arrays["probe"]
    head = [_column("time", chosen.of("s"))]
    columns = [chosen.shown(result.arrays["time_step"][rows], "s")]
    for output in (one for one in PROBES if one.name in result.arrays):
        for k, place in enumerate(places):
            at = chosen.place(place, "cm")
            head.append(f"{output.name.removesuffix('_probe')} at {at} [{chosen.of(output.unit)}]")
            columns.append(chosen.shown(result.arrays[output.name][rows, k], output.unit))
    return head, zip(*columns, strict=True)


def _events(result: Result, chosen: Units) -> tuple[list[str], Iterable[Sequence[object]]]:
    names = [output.name for output in EVENTS if output.name in result.arrays]
    head = [_column(name.removeprefix("event_"), chosen.of(OUTPUTS[name].unit)) for name in names]
    return head, zip(*(chosen.shown(result.arrays[name], OUTPUTS[name].unit) for name in names), strict=True)


def _text(value: object) -> str:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(RISKY) else value
    return repr(float(value)) if isinstance(value, float | np.floating | int | np.integer) else str(value)


def _write(path: Path, head: Sequence[str], rows: Iterable[Iterable[object]], about: str | None = None) -> Path:
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(path, "wt", newline="", encoding="ascii", errors="replace") as file:
        writer = csv.writer(file)
        writer.writerow(head if about is None else [f"{head[0]}; cells: {about}", *head[1:]])
        for row in rows:
            writer.writerow([_text(value) for value in row])
    return path
