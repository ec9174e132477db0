"""The table of a study: a row for every point, whatever became of it; as CSV, as Parquet, and its times apart."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError, DivergenceError, PeristalsisError, could_not, shown
from ...storing import disk
from ..rows import Row
from ..table import guarded
from .outputs import number
from .study import Study

Floats = NDArray[np.float64]

TABLE, TIMES, PARQUET = "table.csv", "times.csv", "table.parquet"
CLOCK = "solver_wall_s"
WITHOUT_RESULT = ("refused", PeristalsisError.status, DivergenceError.status)
"""How points end that have no numbers, or none to be used."""


@dataclass(frozen=True)
class Table:
    """All rows of a study in the order of its points. hashes: of the configuration of each; folder: of the files."""

    study: Study
    rows: tuple[Row, ...]
    hashes: tuple[str, ...]
    folder: Path | None = None

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def status(self) -> str:
        """`finished` if every point has numbers, `failed` if none has, `partly_failed` otherwise."""
        without = sum(row.status in WITHOUT_RESULT for row in self.rows)
        return "finished" if without == 0 else "failed" if without == len(self.rows) else "partly_failed"

    @property
    def statuses(self) -> Counter[str]:
        """How many points ended in which way."""
        return Counter(row.status for row in self.rows)

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns: the point, the variables with units, status, outputs, error, hash."""
        return ("point", *(one.label for one in self.study.variables), "status", *self.study.outputs, "error", "hash")

    def records(self) -> Iterator[tuple[Any, ...]]:
        """The cells of every row as numbers and texts, None where a run has no such number."""
        for place, (row, digest) in enumerate(zip(self.rows, self.hashes, strict=True), 1):
            values = (row.point.values.get(name) for name in self.study.names)
            numbers = () if row.status in WITHOUT_RESULT else [row.summary.get(name) for name in self.study.outputs]
            cells = numbers or [None] * len(self.study.outputs)
            yield (place, *values, row.status, *cells, row.summary.get("error"), digest)

    def output(self, name: str) -> Floats:
        """One output of all points, (n,); NaN where there is none."""
        found = [None if row.status in WITHOUT_RESULT else number(row.summary, name) for row in self.rows]
        return np.array([np.nan if one is None else one for one in found])

    def values(self, name: str) -> list[Any]:
        """What one variable was, at all points."""
        return [row.point.values.get(name) for row in self.rows]

    def csv(self) -> bytes:
        """The table for a spreadsheet: the same whatever the workers."""
        return csv_of(self.columns, self.records())

    def times(self) -> bytes:
        """Seconds in the solver of every point, as CSV; they differ from machine to machine."""
        return csv_of(("point", CLOCK), ((place, row.summary.get(CLOCK)) for place, row in enumerate(self.rows, 1)))

    def write(self, folder: Path, parquet: bool = False) -> Path:
        """Write table and times, and the Parquet table if asked; the table's path. Raises WriteError."""
        try:
            disk.DISK.make_folder(folder)
            disk.replace_file(folder / TIMES, self.times())
            disk.replace_file(folder / TABLE, self.csv())
            if parquet:
                disk.replace_file(folder / PARQUET, self.parquet())
        except OSError as error:
            raise could_not(f"write into {shown(str(folder))}", error) from None
        return folder / TABLE

    def parquet(self) -> bytes:
        """The table as Parquet. Raises ConfigurationError where the extra `studies` is missing."""
        arrow, files = parquet_library()
        columns = list(zip(*self.records(), strict=True)) or [()] * len(self.columns)
        made = arrow.table({name: _column(cells) for name, cells in zip(self.columns, columns, strict=True)})
        sink = io.BytesIO()
        files.write_table(made, sink)
        return sink.getvalue()


def parquet_library() -> tuple[Any, Any]:
    """pyarrow and its Parquet module. Raises ConfigurationError where they are missing."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise ConfigurationError(
            "Parquet needs pyarrow, which is not installed; install peristalsis with its extra `studies`, or leave "
            "--parquet out: the table is there as CSV"
        ) from None
    return pyarrow, pyarrow.parquet


def _column(cells: Sequence[Any]) -> list[Any]:
    """One type in a column: numbers if all are, else texts."""
    there = [cell for cell in cells if cell is not None]
    if all(isinstance(cell, bool) for cell in there) or all(isinstance(cell, int | float) for cell in there):
        whole = all(isinstance(cell, int) for cell in there)
        return [cell if cell is None or whole else float(cell) for cell in cells]
    return [None if cell is None else str(cell) for cell in cells]


def csv_of(columns: Sequence[str], rows: Iterator[tuple[Any, ...]]) -> bytes:
    """A table for a spreadsheet: numbers in full, texts that are no formulas, empty cells for None."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow("" if cell is None else guarded(cell) if isinstance(cell, str) else repr(cell) for cell in row)
    return text.getvalue().encode("utf-8")
