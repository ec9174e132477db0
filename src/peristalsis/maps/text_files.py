"""Maps and tracks from CSV files: a matrix with axes, a long table, channels of a catheter, tracks of pellets.

The separator is a comma, a semicolon or a tab, whichever the header has; with the latter two a decimal comma is read.
Empty cells and nan are gaps. Lines at the top that begin with # say what the file holds: "# quantity: diameter [mm]".
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import ConfigurationError, shown
from .recording import Floats, Map, Numbers, Track, factor, locked
from .stated import Stated, finished
from .words import place_in, quantity_of, titled

LARGEST_FILE = 4_000_000_000
"""Bytes of a file that are read."""
MOST_COLUMNS = 20_000
HEADERS = (
    "begin with a line such as 'time [s] / place [mm],0,1,2', 'time [s],place [mm],diameter [mm]' or "
    "'time [s],P1 @ 10 mm [mmHg]'"
)


class Table(NamedTuple):
    """A text file taken apart: remarks at its top, cells of its header, where its rows begin, what separates cells."""

    remarks: dict[str, str]
    header: list[str]
    content: bytes
    begin: int
    separator: str
    path: Path


def content_of(path: Path) -> bytes:
    """The bytes of a file. Raises ConfigurationError if it cannot be read, is empty or too large."""
    try:
        if path.exists() and not path.is_file():
            raise ConfigurationError(f"{shown(str(path))} is not a regular file; name a recording")
        if path.stat().st_size > LARGEST_FILE:
            raise ConfigurationError(f"{shown(str(path))} is larger than {LARGEST_FILE} bytes; thin it out")
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        cause = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigurationError(f"{shown(str(path))} cannot be read: {cause}; check the name") from None
    if not content.strip():
        raise ConfigurationError(f"{shown(str(path))} is empty; check the recording")
    return content


def table_of(path: Path) -> Table:
    """A CSV file taken apart. Raises ConfigurationError if it is none."""
    name, content = shown(str(path)), content_of(path)
    remarks: dict[str, str] = {}
    begin = 3 if content.startswith(b"\xef\xbb\xbf") else 0
    try:
        while True:
            end = content.find(b"\n", begin)
            end = len(content) if end < 0 else end
            line = content[begin:end].decode("utf-8").strip()
            begin = min(end + 1, len(content))
            if line and not line.startswith("#"):
                break
            if begin == len(content):
                raise ConfigurationError(f"{name} holds remarks and no numbers; {HEADERS}")
            key, _, value = (part.strip() for part in line.lstrip("#").partition(":"))
            remarks[key] = f"{remarks[key]}\n{value}" if key in remarks else value
    except UnicodeDecodeError:
        raise ConfigurationError(f"{name} is no text of UTF-8; save it as CSV in UTF-8") from None
    head = line
    if "\0" in head:
        raise ConfigurationError(f"{name} is no text file; save the recording as CSV in UTF-8")
    separator = next((one for one in ("\t", ";", ",") if one in head), ",")
    try:
        header = next(csv.reader([head], delimiter=separator), [])
    except csv.Error as error:
        raise ConfigurationError(f"{name}: its header cannot be read ({error}); {HEADERS}") from None
    header = [cell.strip() for cell in header]
    while header and not header[-1]:
        header.pop()
    if len(header) < 2:
        raise ConfigurationError(f"{name} has {len(header)} columns; {HEADERS}")
    if len(header) > MOST_COLUMNS:
        raise ConfigurationError(f"{name} has {len(header)} columns, more than {MOST_COLUMNS}; is it turned by 90 deg?")
    return Table(remarks, header, content, begin, separator, path)


def numbers(table: Table, columns: Sequence[int] | None = None) -> Floats:
    """The rows of a table as numbers, gaps as nan. Raises ConfigurationError naming row and column of what is none."""
    name, content, begin = shown(str(table.path)), table.content, table.begin
    if not content[begin : begin + 1000].strip() and not content[begin:].strip():
        raise ConfigurationError(f"{name} has a header and no rows; check the recording")
    mark = re.escape(table.separator.encode())
    empty = re.compile(rb"(?<=%b)[ ]*(?=%b|\r|\n|$)|(?<=\n)(?=%b)" % (mark, mark, mark))
    decimal_comma = table.separator != "," and content.find(b",", begin) >= 0
    if decimal_comma or empty.search(content, max(begin - 1, 0)):  # a copy is made where it has to be
        content = empty.sub(b"nan", b"\n" + content[begin:].replace(b",", b"." if decimal_comma else b","))
        begin = 1
    rows = io.BytesIO(content)
    rows.seek(begin)
    try:
        found = np.loadtxt(rows, delimiter=table.separator, comments=None, ndmin=2, usecols=columns, quotechar='"')
    except ValueError as error:
        raise ConfigurationError(f"{name}: {_cause(str(error))}; give plain numbers, gaps empty or nan") from None
    if columns is None and found.shape[1] != len(table.header):
        raise ConfigurationError(
            f"{name}: row 1 has {found.shape[1]} cells and the header {len(table.header)}; give one a column, with "
            "decimal points"
        )
    return found


def _cause(text: str) -> str:
    found = re.match(r"could not convert string '(.*)' to float64 at row (\d+), column (\d+)", text, re.DOTALL)
    if found:
        return f"row {int(found[2]) + 1}, column {found[3]} holds {shown(found[1])}"
    return text.split(";")[0].rstrip(".")


def read_table(path: Path, said: Stated) -> Map:
    """The map in a CSV file, of whichever form. Raises ConfigurationError."""
    table = table_of(path)
    titles = [titled(cell)[0].lower() for cell in table.header]
    corner = re.split(r"[/\\]", table.header[0])
    if len(corner) == 2:
        return _matrix(table, corner, said)
    if titles[0].startswith("place") and "time" not in titles:
        raise ConfigurationError(f"{shown(str(path))} has no times; {HEADERS}")
    if {"time", "place"} <= set(titles) and len(titles) >= 3:
        return _long(table, titles, said)
    if titles[0].startswith("time"):
        return _channels(table, said)
    raise ConfigurationError(f"{shown(str(path))} begins with {shown(table.header[0])}; {HEADERS}")


def _told(table: Table, cell: str = "") -> tuple[str | None, str | None]:
    """Quantity and unit that the remarks, or a title, state."""
    title, unit = titled(table.remarks.get("quantity", "") or cell)
    return quantity_of(title, unit), unit


def _history(table: Table, form: str) -> list[str]:
    kept = [line for line in table.remarks.get("history", "").splitlines() if line]
    return [*kept, f"read from {table.path.name}, {form}"]


def _axis(values: Floats, cell: str, wanted: str, stated_unit: str | None, table: Table) -> Floats:
    unit = stated_unit or titled(cell)[1]
    what = "times" if wanted == "s" else "places"
    if unit is None:
        raise ConfigurationError(f"{shown(str(table.path))}: the {what} have no unit; {HEADERS}")
    return values * factor(unit, wanted, f"{shown(str(table.path))}, unit of the {what}")


def _matrix(table: Table, corner: list[str], said: Stated) -> Map:
    name, down, across = shown(str(table.path)), corner[0].lower(), corner[1].lower()
    turned = "place" in down and "time" in across
    if not turned and not ("time" in down and "place" in across):
        raise ConfigurationError(f"{name}: the corner {shown(table.header[0])} names no time and place; {HEADERS}")
    try:
        heads = np.array([float(cell.replace(",", ".")) for cell in table.header[1:]])
    except ValueError:
        wrong = next(cell for cell in table.header[1:] if not _is_number(cell.replace(",", ".")))
        raise ConfigurationError(f"{name}: {shown(wrong)} in the header is no number; {HEADERS}") from None
    rows = numbers(table)
    values, lefts = rows[:, 1:], rows[:, 0]
    if turned:
        values, lefts, heads, corner = np.ascontiguousarray(values.T), heads, lefts, corner[::-1]
    time = _axis(lefts, corner[0], "s", said.time_unit, table)
    place = _axis(heads, corner[1], "mm", said.place_unit, table)
    oral = table.remarks.get("oral end")
    history = _history(table, "a matrix" + (" with places down" if turned else ""))
    if oral is None:
        history.append(f"oral end {said.oral}, as stated or by default")
    return finished(table.path, values, time, place, _told(table), said, history, ("time_unit", "place_unit"))


def _long(table: Table, titles: list[str], said: Stated) -> Map:
    name = shown(str(table.path))
    others = [k for k, title in enumerate(titles) if title not in ("time", "place")]
    wanted = said.variable.lower() if said.variable else None
    chosen = [k for k in others if wanted is None or titles[k] == wanted]
    if len(chosen) != 1:
        listed = ", ".join(titles[k] for k in others)
        raise ConfigurationError(f"{name} has columns {listed}; name one of them (variable, --variable)")
    columns = [titles.index("time"), titles.index("place"), chosen[0]]
    rows = numbers(table, columns)
    if not np.isfinite(rows[:, :2]).all():
        raise ConfigurationError(
            f"{name}: a time or a place is missing in row {_row(~np.isfinite(rows[:, :2]))}; add it"
        )
    times, when = np.unique(rows[:, 0], return_inverse=True)
    places, where = np.unique(rows[:, 1], return_inverse=True)
    if times.size * places.size > 50 * len(rows) + 1000:
        raise ConfigurationError(
            f"{name}: {len(rows)} rows lie scattered over {times.size} times and {places.size} places; give a grid, "
            "one row for each time and place"
        )
    cells = when * places.size + where
    if np.unique(cells).size != cells.size:
        order = np.argsort(cells, kind="stable")
        twice = int(order[1:][np.diff(cells[order]) == 0].min()) + 1
        raise ConfigurationError(f"{name}: the time and place of row {twice} are there twice; keep one")
    values = np.full((times.size, places.size), np.nan)
    values[when, where] = rows[:, 2]
    cell = table.header[chosen[0]]
    return finished(
        table.path,
        locked(values),
        _axis(times, table.header[columns[0]], "s", said.time_unit, table),
        _axis(places, table.header[columns[1]], "mm", said.place_unit, table),
        _told(table, cell),
        said,
        _history(table, f"a long table; cells without a row are gaps: {values.size - len(rows)}"),
        ("variable", "time_unit", "place_unit"),
    )


def _channels(table: Table, said: Stated) -> Map:
    """Channels of a catheter, a column each, at the places in their names, in a second row, or stated."""
    name, cells = shown(str(table.path)), table.header[1:]
    end = table.content.find(b"\n", table.begin) + 1 or len(table.content)
    first = table.content[table.begin : end].decode("utf-8", "replace")
    second = [cell.strip() for cell in first.strip().split(table.separator)]
    places: list[float | None] = [place_in(cell) for cell in cells]
    how = "the places in their names"
    if second and titled(second[0])[0].lower().startswith("place"):
        by = factor(titled(second[0])[1] or said.place_unit or "mm", "mm", f"{name}, unit of the places")
        places = [float(cell) * by if _is_number(cell) else None for cell in second[1:]]
        table, how = table._replace(begin=end), "the places in its second row"
    if said.positions is not None:
        places, how = [float(one) for one in said.positions], "the places as stated"
    if len(places) != len(cells):
        raise ConfigurationError(f"{name} has {len(cells)} channels, and {len(places)} places are given; give one each")
    missing = [cell for cell, place in zip(cells, places, strict=True) if place is None]
    if missing:
        raise ConfigurationError(
            f"{name}: the place of channel {shown(missing[0])} is not stated; write it into its name, 'P1 @ 10 mm', or "
            "give all (positions, --positions)"
        )
    told = {titled(cell)[1] for cell in cells}
    if len(told) > 1 and said.unit is None:
        units = ", ".join(sorted(str(one) for one in told))
        raise ConfigurationError(f"{name}: channels have different units ({units}); export them in one, or state it")
    place = np.array(places, dtype=np.float64)
    order = np.argsort(place, kind="stable")
    if (np.diff(place[order]) <= 0.0).any():
        at = float(place[order][:-1][np.diff(place[order]) <= 0.0][0])
        raise ConfigurationError(f"{name}: two channels are at {at:g} mm; leave one of them out")
    rows = numbers(table)
    values: Numbers = rows[:, 1:]
    history = _history(table, f"{len(cells)} channels, {how}")
    if (np.diff(order) != 1).any():
        values = values[:, order]
        history.append("channels in the order of their places")
    quantity, unit = _told(table, cells[0])
    time = _axis(rows[:, 0], table.header[0], "s", said.time_unit, table)
    used = ("positions", "time_unit", "place_unit")
    return finished(table.path, values, time, place[order], (quantity or "pressure", unit), said, history, used)


def read_tracks(path: Path, scale: tuple[float, float] | None = None) -> tuple[Track, ...]:
    """The tracks in a CSV file: a column of times and one of positions for each pellet, or a column "pellet" besides.

    Positions are from the oral end. Rows without a position are left out. scale: millimetres a pixel and frames a
    second, of columns in px and frames, and of those without a unit. Raises ConfigurationError.
    """
    table = table_of(path)
    name, titles = shown(str(path)), [titled(cell)[0].lower() for cell in table.header]
    at = next((titles.index(word) for word in ("time", "frame", "frames") if word in titles), -1)
    if at < 0:
        raise ConfigurationError(f"{name} has no column time; begin with 'time [s],position [mm]'")
    rows = numbers(table)
    time = _of_track(rows[:, at], table.header[at], "s", scale, table)
    if "pellet" in titles and "position" in titles:
        which, column = rows[:, titles.index("pellet")], titles.index("position")
        position = _of_track(rows[:, column], table.header[column], "mm", scale, table)
        groups = [(f"pellet {one:g}", time[which == one], position[which == one]) for one in np.unique(which)]
    else:
        groups = [
            (titled(cell)[0], time, _of_track(rows[:, k], cell, "mm", scale, table))
            for k, cell in enumerate(table.header)
            if k != at
        ]
    found = []
    for label, when, where in groups:
        known = np.isfinite(where)
        size = table.remarks.get(f"diameter of {label}")
        found.append(
            Track(
                when[known], where[known], label, float(size.split()[0]) if size else None, (f"read from {path.name}",)
            )
        )
    return tuple(found)


def _of_track(values: Floats, cell: str, wanted: str, scale: tuple[float, float] | None, table: Table) -> Floats:
    """A column in s or mm; in pixels and frames, as it says or for want of a unit, by the scale."""
    title, unit = titled(cell)
    in_frames = title.lower() in ("frame", "frames") or (unit or "").lower() in ("frame", "frames")
    in_pixels = (unit or "").lower() in ("px", "pixel", "pixels")
    if not (in_frames or in_pixels or (unit is None and scale is not None)):
        return _axis(values, cell, wanted, None, table)
    if scale is None:
        raise ConfigurationError(
            f"{shown(str(table.path))}: column {shown(cell)} is in pixels or frames; state millimetres a pixel and "
            "frames a second (scale, --mm-per-px and --frame-rate)"
        )
    mm_per_pixel, frame_rate = scale
    for one in scale:
        if not 0.0 < one < 1e6:
            raise ConfigurationError(f"scale = {scale}: {one:g} is none; give numbers above 0")
    return values / frame_rate if wanted == "s" else values * mm_per_pixel


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _row(wrong: Numbers) -> int:
    return int(np.flatnonzero(wrong.any(axis=1))[0]) + 1
