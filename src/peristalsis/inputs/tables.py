"""Courses of parameters from CSV files of up to millions of rows, read fast, kept by their content.

A file has a column of times and one or more of values; its first line names each with its unit. Up to `MOST_KNOTS` rows
a course is written out in the configuration as a ramp. A longer one is kept as numbers, and the configuration names it
by the hash of its content, "table table-HASH.npy": the result stores that file beside its configuration, checkpoints
and configurations sent to other processes carry it, and what is read under a name has its hash checked.
"""

from __future__ import annotations

import csv
import hashlib
import io
import re
from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from tokenize import TokenError
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import units
from ..errors import ConfigurationError, UnknownKeyError, shown, suggestion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

MOST_KNOTS = 1000
"""Values of a course that are written out in a configuration."""
MOST_ROWS = 5_000_000
MOST_COLUMNS = 50
LARGEST_FILE = 500_000_000
"""Bytes of a CSV file."""
HEADER = "write a first line such as 'time [s],value [kPa]', or 'time [s],lumen.pressure [kPa],circular.active'"

_NAME = re.compile(r"(table|stimuli)-([0-9a-f]{64})\.npy")
_LINE = re.compile(r"(?:^|:)\s*(?:table|step)\s+(?:.*/)?((?:table|stimuli)-[0-9a-f]{64}\.npy)\s*")


class Course(NamedTuple):
    """Values in the canonical unit of a parameter at increasing times [s]; `name` of the file that holds many."""

    times: tuple[float, ...] | Floats
    values: tuple[float, ...] | Floats
    name: str = ""


_held: dict[str, Course] = {}
"""Courses of many rows that this process knows, by their names."""
_lists: dict[str, Floats] = {}
"""Lists of many stimuli that this process knows, a row for each, by their names."""


def read(path: Path, key: str, numbers: Mapping[str, str]) -> dict[str, Course]:
    """The course of a parameter in a file, or those of all its columns if key is "*".

    numbers: every numeric parameter with its canonical unit. Raises ConfigurationError naming file, cause and fix.
    """
    if is_name(path):
        return {key: _of_name(path, key)}
    name, content = shown(str(path)), _content(path, key)
    head, _, body = content.removeprefix(b"\xef\xbb\xbf").lstrip(b"\r\n").partition(b"\n")
    try:
        header = next(csv.reader([head.decode("utf-8").rstrip("\r")]), [])
    except (UnicodeDecodeError, csv.Error):
        raise ConfigurationError(f"{name} cannot be read: it is not a text file of UTF-8 CSV; check it") from None
    if not 2 <= len(header) <= MOST_COLUMNS or not body.strip():
        raise ConfigurationError(f"{name}: not a header and rows of two columns or more; {HEADER}")
    given = [_titled(cell) for cell in header]
    columns = _wanted(given, key, numbers, name)
    for column in (0, *columns.values()):
        unit = "s" if column == 0 else next(numbers[one] for one, at in columns.items() if at == column)
        if given[column][1] is None and unit != units.DIMENSIONLESS:
            raise ConfigurationError(f"{name}: the header has no units for column {column + 1}; {HEADER}")
    if body.count(b"\n") <= MOST_KNOTS:
        found = _few(body, given, columns, numbers, name)
    else:
        found = _many(body, given, columns, numbers, name)
    return found


def is_name(path: Path) -> bool:
    """Whether a file has the name of a course that is kept by its content."""
    found = _NAME.fullmatch(path.name)
    return found is not None and found.group(1) == "table"


def _titled(cell: str) -> tuple[str, str | None]:
    """What a column is called, and its unit."""
    title, _, rest = cell.partition("[")
    unit, closed, _ = rest.partition("]")
    return title.strip(), unit.strip() if closed and unit.strip() else None


def _wanted(given: list[tuple[str, str | None]], key: str, numbers: Mapping[str, str], name: str) -> dict[str, int]:
    """Which column holds which parameter."""
    titles = [title for title, _ in given]
    if key == "*":
        for title in titles[1:]:
            if title not in numbers:
                fix = suggestion(title, numbers)
                raise UnknownKeyError(f"{name}: column {shown(title)} is not a numeric parameter; {fix}")
            if titles.count(title) > 1:
                raise ConfigurationError(f"{name}: column {title} is there twice; keep one")
        return {title: column for column, title in enumerate(titles) if column > 0}
    if key in titles[1:]:
        return {key: titles.index(key, 1)}
    if len(given) == 2 and titles[1] not in numbers:
        return {key: 1}
    raise ConfigurationError(f"{name} has no column {key} but {', '.join(titles[1:6])}; name one after the parameter")


def _content(path: Path, key: str) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise ConfigurationError(f"{shown(str(path))} is not a regular file; check the file of {key}")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        cause = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigurationError(f"{shown(str(path))} cannot be read: {cause}; check the file of {key}") from None
    if len(content) > LARGEST_FILE:
        raise ConfigurationError(f"{shown(str(path))} is larger than {LARGEST_FILE} bytes; thin it out")
    return content


def _few(
    body: bytes, given: list[tuple[str, str | None]], columns: dict[str, int], numbers: Mapping[str, str], name: str
) -> dict[str, Course]:
    """Courses of few rows: exact decimal conversion of every number."""
    try:
        text = io.StringIO(body.decode("utf-8"), newline="")
        rows = [row for row in csv.reader(text) if any(cell.strip() for cell in row)]
    except (UnicodeDecodeError, csv.Error):
        raise ConfigurationError(f"{name} cannot be read: it is not a text file of UTF-8 CSV; check it") from None
    for number, row in enumerate(rows, 1):
        if len(row) != len(given):
            raise _ragged(name, number, len(row), len(given))
    times = tuple(
        units.parse(f"{row[0].strip()} {given[0][1]}", "s", f"{name}, row {number}, time")
        for number, row in enumerate(rows, 1)
    )
    _check_rise(times, name)
    return {
        key: Course(
            times,
            tuple(
                _cell(row[at], given[at][1], numbers[key], f"{key}, row {number}") for number, row in enumerate(rows, 1)
            ),
        )
        for key, at in columns.items()
    }


def _cell(text: str, unit: str | None, wanted: str, key: str) -> float:
    if unit is not None and wanted != units.DIMENSIONLESS:
        return units.parse(f"{text.strip()} {unit}", wanted, f"protocols, {key}")
    return number(text.strip(), key)


def number(text: str, key: str) -> float:
    """A plain number of a parameter without unit."""
    try:
        return units.parse(float(text), units.DIMENSIONLESS, f"protocols, {key}")
    except ValueError:
        raise ConfigurationError(f"protocols: {shown(text)} is not a plain number for {key}; give one") from None


def _many(
    body: bytes, given: list[tuple[str, str | None]], columns: dict[str, int], numbers: Mapping[str, str], name: str
) -> dict[str, Course]:
    """Courses of many rows, read by numpy; a foreign unit costs one more rounding."""
    import numpy as np

    used = [0, *columns.values()]
    try:
        table = np.loadtxt(
            io.BytesIO(body), delimiter=",", comments=None, usecols=used, ndmin=2, max_rows=MOST_ROWS + 1
        )
    except ValueError as error:
        raise ConfigurationError(f"{name}: {str(error).split(';')[0].rstrip('.')}; give plain numbers") from None
    if len(table) > MOST_ROWS:
        raise ConfigurationError(f"{name} has more than {MOST_ROWS} rows; thin it out")
    if body.count(b",") != len(table) * (len(given) - 1):  # decimal commas, for example
        for number, line in enumerate((one for one in body.splitlines() if one.strip()), 1):
            if line.count(b",") != len(given) - 1:
                raise _ragged(name, number, line.count(b",") + 1, len(given))
    if not np.isfinite(table).all():
        row = int(np.flatnonzero(~np.isfinite(table).all(axis=1))[0])
        raise ConfigurationError(f"{name}: row {row + 1} holds a number that is not finite; give plain numbers")
    times = _converted(table[:, 0], given[0][1], "s", f"{name}, time")
    _check_rise(times, name)
    found = {}
    for place, (key, at) in enumerate(columns.items(), start=1):
        values = _converted(table[:, place], given[at][1], numbers[key], f"protocols, {key}")
        found[key] = hold(times, values)
    return found


def _converted(column: Floats, unit: str | None, wanted: str, where: str) -> Floats:
    if unit is None:
        return column.copy() + 0.0
    try:
        factor = units.factor(unit, wanted)
    except units.QuantityError as error:
        raise ConfigurationError(f"{where}: {error}") from None
    converted: Floats = column * float(factor.numerator) / float(factor.denominator) + 0.0
    return converted


def _check_rise(times: Any, name: str) -> None:
    if isinstance(times, tuple):
        wrong = [row for row, (a, b) in enumerate(pairwise(times), 2) if not a < b]
    else:
        wrong = [row + 2 for row in (~(times[1:] > times[:-1])).nonzero()[0][:1].tolist()]
    if times[0] < 0.0 or wrong:
        row = 1 if times[0] < 0.0 else wrong[0]
        raise ConfigurationError(f"{name}: the times do not increase from 0 s on at row {row}; put them in order")


def _ragged(name: str, row: int, cells: int, wanted: int) -> ConfigurationError:
    return ConfigurationError(
        f"{name}: row {row} has {cells} cells and the header {wanted}; give one a column, with decimal points"
    )


# --- by name ----------------------------------------------------------------------------------------


def hold(times: Floats, values: Floats) -> Course:
    """Keep a course of many rows in this process, under the name that its content gives it."""
    import numpy as np

    pair = np.array([times, values], dtype="<f8")
    pair.setflags(write=False)
    name = f"table-{hashlib.sha256(pair.tobytes()).hexdigest()}.npy"
    if name not in _held:
        _held[name] = Course(pair[0], pair[1], name)
    return _held[name]


def hold_list(rows: Floats) -> str:
    """Keep many stimuli in this process, a row of 8 numbers for each, under the name that their content gives them."""
    import numpy as np

    own = np.array(rows, dtype="<f8")
    own.setflags(write=False)
    name = f"stimuli-{hashlib.sha256(own.tobytes()).hexdigest()}.npy"
    _lists.setdefault(name, own)
    return name


def list_of(path: Path) -> Floats | None:
    """The stimuli that are kept, or stored, under such a name; None for a file of another name.

    Raises ConfigurationError if it is not here, or is not what its name says.
    """
    found = _NAME.fullmatch(path.name)
    if found is None or found.group(1) != "stimuli":
        return None
    if path.name not in _lists:
        if not path.exists():
            raise ConfigurationError(
                f"stimuli: the list {path.name[:20]}... is not here: it is stored beside the config.toml of its run; "
                "give the configuration as that file, or name the CSV file"
            )
        try:
            _decoded_list(path.name, _content(path, "stimuli"))
        except ValueError as error:
            raise ConfigurationError(
                f"{shown(str(path))} cannot be read: {error}; take it from its run again"
            ) from None
    return _lists[path.name]


def held(lines: Iterable[str]) -> dict[str, Floats]:
    """The courses that canonical protocols name: name of the file to times and values, (2, n)."""
    import numpy as np

    names = [found.group(1) for line in lines if (found := _LINE.search(line))]
    courses = {name: np.array(_held[name][:2]) for name in names if name in _held}
    return courses | {name: _lists[name] for name in names if name in _lists}


def hold_all(tables: Mapping[str, Floats]) -> None:
    """Keep the courses that `held` gave in another process."""
    for name, table in tables.items():
        if name.startswith("stimuli-"):
            hold_list(table)
        else:
            hold(table[0], table[1])


def files_of(lines: Iterable[str]) -> dict[str, bytes]:
    """Name to content of the files of the courses that canonical protocols name."""
    import numpy as np

    files = {}
    for name, table in held(lines).items():
        image = io.BytesIO()
        np.save(image, table, allow_pickle=False)
        files[name] = image.getvalue()
    return files


def take_in(files: Mapping[str, bytes]) -> None:
    """Keep the courses among the files of a stored run. Raises ValueError if one is not what its name says."""
    for name, content in files.items():
        found = _NAME.fullmatch(name)
        if found is not None and found.group(1) == "stimuli":
            _decoded_list(name, content)
        elif found is not None:
            _decoded(name, content)


def _array(name: str, content: bytes) -> Any:
    import numpy as np

    try:
        return np.load(io.BytesIO(content), allow_pickle=False)
    except (EOFError, OSError, MemoryError, SyntaxError, TokenError) as error:  # of a file that somebody else made
        raise ValueError(f"{name} is no table of numbers ({type(error).__name__})") from None


def _decoded_list(name: str, content: bytes) -> None:
    rows = _array(name, content)
    if rows.dtype != "<f8" or rows.ndim != 2 or rows.shape[1] != 8 or not rows.size:
        raise ValueError(f"{name} is no list of stimuli")
    if hold_list(rows) != name:
        raise ValueError(f"{name} was changed: its content has another hash")


def _decoded(name: str, content: bytes) -> Course:
    import numpy as np

    table = _array(name, content)
    if table.dtype != np.float64 or table.ndim != 2 or len(table) != 2 or not table.size:
        raise ValueError(f"{name} is no table of times and values")
    if not (np.isfinite(table).all() and (np.diff(table[0]) > 0.0).all() and table[0, 0] >= 0.0):
        raise ValueError(f"{name} has times that do not increase, or numbers that are not finite")
    found = hold(table[0], table[1])
    if found.name != name:
        raise ValueError(f"{name} was changed: its content has another hash")
    return found


def _of_name(path: Path, key: str) -> Course:
    if path.name in _held:
        return _held[path.name]
    if not path.exists():
        raise ConfigurationError(
            f"protocols: the table of {key}, {path.name[:18]}..., is not here: it is stored beside the config.toml of "
            "its run; give the configuration as that file, or name the CSV file"
        )
    try:
        return _decoded(path.name, _content(path, key))
    except ValueError as error:
        raise ConfigurationError(f"{shown(str(path))} cannot be read: {error}; take it from its run again") from None
