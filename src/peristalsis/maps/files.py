"""Reading and writing by the ending of a file's name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from ..errors import ConfigurationError, WriteError, shown, suggestion
from ..paths import located
from ..plots.placing import whole_in_folder
from .array_files import read_arrays, write_mat, write_netcdf
from .picture_files import read_picture, write_picture
from .recording import Map, Track
from .stated import Stated, stated
from .text_files import read_table, read_tracks

READERS: dict[str, Callable[[Path, Stated], Map]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv"), read_table),
    **dict.fromkeys((".tif", ".tiff", ".png"), read_picture),
    **dict.fromkeys((".nc", ".mat"), read_arrays),
}
FORMS = ("matrix", "long")
BLOCK = 2000
"""Rows of a table that are written at a time."""


def read(path: str | os.PathLike[str], **options: Any) -> Map:
    """The map in a file: .csv, .tif, .png, .nc or .mat. options: what the file does not say itself, see `Stated`.

    Raises ConfigurationError, one sentence, for what cannot be read.
    """
    place, said = located(path), stated(options)
    ending = place.suffix.lower()
    if ending not in READERS:
        raise ConfigurationError(
            f"{shown(str(path))}: a map ends in {', '.join(READERS)}; {suggestion(ending or 'nothing', READERS)}"
        )
    try:
        return READERS[ending](place, said)
    except MemoryError:
        raise ConfigurationError(f"{shown(str(path))} does not fit into memory; cut it, or thin it out") from None


def tracks(path: str | os.PathLike[str], scale: tuple[float, float] | None = None) -> tuple[Track, ...]:
    """The tracks of pellets in a CSV file; see `text_files.read_tracks`."""
    return read_tracks(located(path), scale)


def write(recorded: Map, path: str | os.PathLike[str], **options: Any) -> Path:
    """Write a map; the ending says how: .csv (form: matrix or long), .nc, .mat, .tif or .png (bits: 8 or 16; time).

    CSV, NetCDF and .mat lose nothing; a picture is quantised. The file appears whole or not at all. Raises
    ConfigurationError for an unknown ending, WriteError if it cannot write.
    """
    place = located(path)
    writers: dict[str, Callable[..., Path]] = {
        ".csv": write_csv,
        ".nc": write_netcdf,
        ".mat": write_mat,
        **dict.fromkeys((".tif", ".tiff", ".png"), write_picture),
    }
    writer = writers.get(place.suffix.lower())
    if writer is None:
        raise ConfigurationError(f"{shown(str(path))}: a map is written to {', '.join(writers)}; choose one of these")
    with whole_in_folder(place) as temporary:
        writer(recorded, temporary, **options)
    return place


def write_csv(recorded: Map, path: Path, form: str = "matrix") -> Path:
    """Write a map as text that is read back to the same bits: a matrix with axes, or one row a time and place."""
    if form not in FORMS:
        raise ConfigurationError(f"form = {shown(form)}: a table is {' or '.join(FORMS)}; choose one")
    unit = recorded.unit
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(f"# quantity: {recorded.quantity} [{unit}]\n# oral end: first\n")
        file.writelines(f"# history: {line}\n" for line in recorded.history)
        if form == "matrix":
            file.write(f"time [s] / place [mm],{','.join(map(_number, recorded.place.tolist()))}\n")
        else:
            file.write(f"time [s],place [mm],{recorded.quantity} [{unit}]\n")
        for begin in range(0, recorded.time.size, BLOCK):
            file.writelines(_rows(recorded, begin, form))
    return path


def _rows(recorded: Map, begin: int, form: str) -> Iterable[str]:
    places = [_number(one) for one in recorded.place.tolist()]
    times = recorded.time[begin : begin + BLOCK].tolist()
    for time, row in zip(times, recorded.values[begin : begin + BLOCK], strict=True):
        cells = [_number(one) for one in row.tolist()]
        if form == "matrix":
            yield f"{_number(time)},{','.join(cells)}\n"
        else:
            yield "".join(f"{_number(time)},{place},{cell}\n" for place, cell in zip(places, cells, strict=True))


def _number(value: float) -> str:
    """The shortest text of a number; nothing for a gap."""
    return "" if value != value else repr(value)


def write_tracks(found: Iterable[Track], path: str | os.PathLike[str]) -> Path:
    """Write tracks, one row a pellet and time: number, time [s], position [mm]. Raises WriteError if it cannot."""
    place = located(path)
    if place.suffix.lower() != ".csv":
        raise WriteError(f"{shown(str(path))}: tracks are written as .csv; rename it")
    with whole_in_folder(place) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as file:
        file.write("pellet,time [s],position [mm]\n")
        for number, track in enumerate(found, 1):
            for time, position in zip(track.time.tolist(), track.position.tolist(), strict=True):
                file.write(f"{number},{time!r},{position!r}\n")
    return place
