"""Maps of classes over two parameters, such as where pellets stall, with runs only along the boundaries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from ...errors import ConfigurationError, WriteError, shown, suggestion
from ...paths import located
from ...running.pool import Workers, engine_of
from ...storing import disk
from ..rows import Point, Row, Step
from . import classes as known_classes
from .boundary import Node, Refined, refine, spacing_of
from .runs import Runs, kept_beside
from .study import Study, located_study
from .sweep import differences, in_folder
from .table import Table, csv_of

NODES, BOUNDARY = "map.csv", "boundary.csv"
TABLE = "map"
"""The table of a study file that is a map: classes, nodes, coarse."""
FINE, COARSE = 33, 9
"""Nodes along each parameter of a map that says nothing, and of the coarse grid that it begins with."""


@dataclass(frozen=True)
class StallMap:
    """Class of every node of a grid. levels: values of both parameters; table: the runs that were made for it."""

    study: Study
    levels: tuple[tuple[float, ...], tuple[float, ...]]
    refined: Refined
    table: Table
    folder: Path

    @property
    def runs(self) -> int:
        """How many nodes were run; the full grid has `nodes`."""
        return len(self.refined.evaluated)

    @property
    def nodes(self) -> int:
        """Nodes of the full grid."""
        return len(self.levels[0]) * len(self.levels[1])

    def boundary(self) -> list[tuple[float, float, str, str]]:
        """Middles between neighbouring nodes of different class, with both classes; on the scale of each parameter."""
        scales = [variable.distribution is not None and variable.distribution.logarithmic for variable in self._two]
        found: list[tuple[float, float, str, str]] = []
        for one, two in self.refined.crossings():
            place = [
                (axis[a] * axis[b]) ** 0.5 if log else 0.5 * (axis[a] + axis[b])
                for axis, log, a, b in zip(self.levels, scales, one, two, strict=True)
            ]
            first, second = (self.refined.classes[i][j] for i, j in (one, two))
            found.append((place[0], place[1], first, second))
        return found

    @property
    def _two(self) -> tuple[Any, ...]:
        return self.study.variables

    def nodes_csv(self) -> bytes:
        """Every node: both values, the class, and whether it was run or lies inside an area of one class."""
        rows = [
            (x, y, self.refined.classes[i][j], "run" if (i, j) in self.refined.evaluated else "inside")
            for i, x in enumerate(self.levels[0])
            for j, y in enumerate(self.levels[1])
        ]
        return csv_of([*(one.label for one in self._two), "class", "known by"], iter(rows))

    def boundary_csv(self) -> bytes:
        """Points of the boundaries: both values, and the classes on either side."""
        rows = [(x, y, one, two) for x, y, one, two in self.boundary()]
        return csv_of([*(one.label for one in self._two), "class", "other class"], iter(rows))


def stall_map(
    study: Study | str | PathLike[str],
    out: str | PathLike[str],
    *,
    workers: Workers = 1,
    kept: str | PathLike[str] | None = None,
    reading: str | None = None,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> StallMap:
    """Map classes over the two parameters of a study, and write OUT/map.csv, boundary.csv and table.csv.

    The study has two parameters with ranges, and may have a table [map]: classes (a name of `classes`), nodes along
    each parameter, and coarse, those that it begins with. Other arguments and errors as of `sweep`.
    """
    read = located_study(study, (TABLE,), reading, designs=("grid",))
    name, fine, coarse = _map_of(read)
    classifier = known_classes.get(name)
    levels = tuple(tuple(map(float, variable.levels(fine))) for variable in read.variables)
    target = located(out)
    rows: dict[Node, Row] = {}
    points: dict[Node, Point] = {}
    with in_folder(target), engine_of(workers) as engine:
        differences(read, target, say)
        runs = Runs(kept_beside(target) if kept is None else located(kept), engine, progress)

        def evaluate(nodes: Sequence[Node]) -> dict[Node, str]:
            combinations = [
                {variable.name: axis[k] for variable, axis, k in zip(read.variables, levels, node, strict=True)}
                for node in nodes
            ]
            made = read.points(combinations)
            for node, point, row in zip(nodes, made, runs.rows(made), strict=True):
                points[node], rows[node] = point, row
            return {node: known_classes.class_of(rows[node], classifier) for node in nodes}

        refined = refine((fine, fine), (coarse, coarse), evaluate)
        order = sorted(rows)
        table = Table(read, tuple(rows[one] for one in order), runs.hashes([points[one] for one in order]), target)
        found = StallMap(read, (levels[0], levels[1]), refined, table, target)
        table.write(target)
        try:
            disk.replace_file(target / NODES, found.nodes_csv())
            disk.replace_file(target / BOUNDARY, found.boundary_csv())
        except OSError as error:
            raise WriteError(f"could not write into {shown(str(target))}: {error.strerror or error}") from None
    return found


def _map_of(study: Study) -> tuple[str, int, int]:
    """Classes, nodes and coarse nodes of a study. Raises ConfigurationError where they do not fit together."""
    given = study.more.get(TABLE, {})
    words = ("classes", "nodes", "coarse")
    if not isinstance(given, dict):
        raise ConfigurationError(f"map = {shown(given)}: give a table with classes, nodes and coarse")
    for word in given:
        if word not in words:
            raise ConfigurationError(f"map: {shown(word)} is not known there; {suggestion(word, words)}")
    if len(study.variables) != 2 or any(one.distribution is None for one in study.variables):
        raise ConfigurationError(
            f"a map is over two parameters, each with from and to; this study has {', '.join(study.names)}"
        )
    name, fine, coarse = given.get("classes", "expelled"), given.get("nodes", FINE), given.get("coarse", COARSE)
    if not isinstance(name, str):
        raise ConfigurationError(f"map: classes = {shown(name)}: give a name")
    try:
        spacing_of((fine, fine), (coarse, coarse))
    except (ValueError, TypeError):
        raise ConfigurationError(
            f"map: nodes = {shown(fine)} do not divide coarse = {shown(coarse)}: nodes - 1 is coarse - 1 times 2, 4, 8 "
            "or so, such as nodes = 33 and coarse = 9"
        ) from None
    return name, fine, coarse
