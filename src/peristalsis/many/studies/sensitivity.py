"""Which parameter matters: indices of every output of a study, by a method that fits it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError, WriteError, shown, suggestion
from ...paths import located
from ...running.pool import Workers
from ...storing import disk
from ..rows import Step
from .indices import METHODS, Index, Method
from .outputs import ALWAYS
from .runs import Runs, kept_beside
from .study import Study, located_study
from .sweep import differences, in_folder
from .table import WITHOUT_RESULT, Table, csv_of

Floats = NDArray[np.float64]

INDICES = "indices.csv"
TABLE = "sensitivity"
"""The table of a study file that is a sensitivity: method."""


@dataclass(frozen=True)
class Sensitivity:
    """Indices of every output. ranks: the index that variables are ranked by; table: the runs."""

    method: str
    table: Table
    indices: dict[str, tuple[Index, ...]]

    @property
    def ranks(self) -> str:
        """Name of the index by which variables are ranked."""
        return METHODS[self.method].ranks

    def ranked(self, output: str) -> list[Index]:
        """The ranking index of every variable, the largest first."""
        return sorted((one for one in self.indices[output] if one.name == self.ranks), key=lambda one: -one.value)

    def csv(self) -> bytes:
        """Output, variable, index, value, both ends of its band, rank."""
        rows = []
        for output, found in self.indices.items():
            order = [one.variable for one in self.ranked(output)]
            rows += [
                (
                    output,
                    one.variable,
                    one.name,
                    one.value,
                    *map(_number, (one.low, one.high)),
                    order.index(one.variable) + 1,
                )
                for one in found
            ]
        return csv_of(("output", "parameter", "index", "value", "low", "high", "rank"), iter(rows))


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None


def cost_words(study: Study, method: str) -> str:
    """What a method costs on a study, in a line to be said beforehand."""
    dimensions, samples = len(study.variables), _samples(study)
    each = {"sobol": f" x ({dimensions} parameters + 2)", "morris": f" x ({dimensions} parameters + 1)"}.get(method, "")
    return f"{method}: {samples} samples{each} = {METHODS[method].runs(dimensions, samples)} runs, less what is kept"


def method_of(study: Study, method: str | None = None) -> str:
    """The method that is asked for, by an argument or by the file; Sobol' indices unless said.

    Raises ConfigurationError for one that there is not.
    """
    given = study.more.get(TABLE, {})
    if not isinstance(given, dict) or set(given) - {"method"}:
        raise ConfigurationError(f"sensitivity = {shown(given)}: give a table with method")
    chosen = method or given.get("method", "sobol")
    if chosen not in METHODS:
        raise ConfigurationError(f"method = {shown(chosen)}: {suggestion(str(chosen), METHODS)}")
    return str(chosen)


def read_sensitivity(source: Study | str | PathLike[str], reading: str | None = None) -> Study:
    """The study of a file that may have a table [sensitivity]; its design gives samples and seed."""
    return located_study(source, (TABLE,), reading, designs=("sobol",))


def sensitivity(
    study: Study | str | PathLike[str],
    out: str | PathLike[str],
    *,
    method: str | None = None,
    workers: Workers = 1,
    kept: str | PathLike[str] | None = None,
    reading: str | None = None,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Sensitivity:
    """Indices of all outputs of a study, and OUT/indices.csv and table.csv.

    method: sobol, morris or pawn. The design of the study gives samples and seed; for Sobol' indices samples are a
    power of two. Raises ConfigurationError, after the table is written, where a method based on variance is asked of an
    output that some points do not have; other arguments and errors as of `sweep`.
    """
    read = read_sensitivity(study, reading)
    chosen = method_of(read, method)
    way = METHODS[chosen]
    if any(one.distribution is None for one in read.variables):
        raise ConfigurationError("a sensitivity is to numbers; give each parameter from and to, or a distribution")
    points = way.points(len(read.variables), _samples(read), read.design.seed)
    drawn = [variable.drawn(column) for variable, column in zip(read.variables, points.T, strict=True)]
    combinations = [dict(zip(read.names, values, strict=True)) for values in zip(*drawn, strict=True)]
    target = located(out)
    with in_folder(target):
        differences(read, target, say)
        runs = Runs(kept_beside(target) if kept is None else located(kept), workers, progress)
        made = read.points(combinations)
        table = Table(read, runs.rows(made), runs.hashes(made), target)
        table.write(target)
        found = Sensitivity(chosen, table, {name: _indices(way, table, name, points, say) for name in read.outputs})
        try:
            disk.replace_file(target / INDICES, found.csv())
        except OSError as error:
            raise WriteError(f"could not write into {shown(str(target))}: {error.strerror or error}") from None
    return found


def _indices(
    way: Method, table: Table, output: str, points: Floats, say: Callable[[str], None] | None
) -> tuple[Index, ...]:
    values, study = table.output(output), table.study
    missing = ~np.isfinite(values)
    if way.finite and missing.any():
        ways = sorted({row.status.replace("_", " ") for row, lost in zip(table.rows, missing, strict=True) if lost})
        always = next((one for one in ALWAYS if np.isfinite(table.output(one)).all()), None)
        other = f", or of the output {always}, which every point has" if always else ""
        raise ConfigurationError(
            f"{output} has no number at {missing.sum()} of {len(table)} points ({', '.join(ways)}), and this method "
            f"needs one at each; ask for --method pawn, which is always defined{other}"
        )
    usable = np.array([row.status not in WITHOUT_RESULT for row in table.rows])
    if not usable.any():
        raise ConfigurationError(f"no point has a result, the first one: {table.rows[0].summary.get('error')}")
    if not usable.all() and say is not None:
        say(f"{output}: {(~usable).sum()} of {len(table)} points have no result and are left out")
    return tuple(way.indices(study.names, points[usable], values[usable], study.design.seed))


def _samples(study: Study) -> int:
    assert study.design.samples is not None
    return study.design.samples
