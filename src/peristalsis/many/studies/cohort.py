"""Cohorts: members drawn from distributions, those that pass stated rules, and what interventions shift in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import units
from ...errors import ConfigurationError, WriteError, shown
from ...inputs.config import FIELDS, Configuration
from ...paths import located
from ...running.pool import Workers, engine_of
from ...storing import disk
from ..plan import flat_changes
from ..rows import Point, Row, Step
from .designs import DRAWN
from .outputs import checked, number
from .runs import Runs, kept_beside
from .study import Study, located_study
from .sweep import differences, in_folder
from .table import WITHOUT_RESULT, Table, csv_of

Floats = NDArray[np.float64]

TABLES = ("accept", "interventions", "cohort")
MEMBERS, SHIFTS = "members.csv", "shifts.csv"
BEFORE = "before"
"""The name of what members are without an intervention."""
TRANSIT = "transit_s"
LEVEL, RESAMPLES = 0.95, 2000
"""Confidence of bands, and resamples of their bootstrap."""


@dataclass(frozen=True)
class Rule:
    """What an output of a member must be: between two numbers, or one of some statuses."""

    output: str
    low: float = -np.inf
    high: float = np.inf
    among: tuple[str, ...] = ()

    def broken(self, row: Row) -> str | None:
        """Why a row does not pass, or None."""
        if self.among:
            return None if row.status in self.among else f"status {row.status}"
        value = number(row.summary, self.output)
        if value is None:
            return f"no {self.output}"
        return None if self.low <= value <= self.high else f"{self.output} = {value:.4g}"


@dataclass(frozen=True)
class Shift:
    """What an intervention does to the accepted members.

    expelled: members expelled with it; gained, lost: expelled only with, only without it. shift: median over the
    members expelled both ways of the transit with it less that without [s], with its band; None where there are none.
    """

    name: str
    members: int
    expelled: int
    gained: int
    lost: int
    median: float | None
    shift: float | None
    band: tuple[float, float] | None


@dataclass(frozen=True)
class Cohort:
    """All members that were drawn, why some are not accepted, and transits of the others, by intervention.

    transits: name of the intervention (`before` is none) to times [s], NaN where the pellet stays, (n_accepted,).
    """

    table: Table
    refusals: tuple[str | None, ...]
    transits: Mapping[str, Floats]
    shifts: tuple[Shift, ...]
    slow: float | None

    @property
    def accepted(self) -> int:
        """How many members pass all rules."""
        return sum(one is None for one in self.refusals)

    def classes(self, name: str = BEFORE) -> dict[str, int]:
        """How many accepted members are normal, slow (beyond the stated transit), or do not expel the pellet."""
        times = self.transits[name]
        kept = int(np.isnan(times).sum())
        slow = 0 if self.slow is None else int((times > self.slow).sum())
        return {"normal": times.size - kept - slow, "slow": slow, "not expelled": kept}

    def members_csv(self) -> bytes:
        """Every member: what it was, how it ended, whether and why it was left out."""
        columns = (*self.table.columns, "accepted", "why not")
        rows = zip(self.table.records(), self.refusals, strict=True)
        return csv_of(columns, ((*cells, "no" if why else "yes", why) for cells, why in rows))

    def shifts_csv(self) -> bytes:
        """What each intervention does, a row for each; the first is none."""
        columns = (
            *("intervention", "members", "normal", "slow", "not expelled", "gained", "lost"),
            *("median transit [s]", "median shift [s]", "low", "high"),
        )
        rows = [
            (one.name, one.members, *self.classes(one.name).values(), one.gained, one.lost, one.median, one.shift)
            + (one.band or (None, None))
            for one in self.shifts
        ]
        return csv_of(columns, iter(rows))


def cohort(
    study: Study | str | PathLike[str],
    out: str | PathLike[str],
    *,
    workers: Workers = 1,
    kept: str | PathLike[str] | None = None,
    reading: str | None = None,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Cohort:
    """Draw and run the members of a cohort, then every intervention on those that are accepted; write the tables.

    Besides what any study has, the file may have [accept] (output = {from, to}, or status = [...]),
    [interventions.NAME] (parameters with values, or with {factor = ...} of what a member has), and [cohort] with slow,
    the transit beyond which a member is slow. Raises ConfigurationError where nobody is accepted; else as `sweep`.
    """
    read = located_study(study, TABLES, reading, designs=("random", *(one for one in DRAWN if one != "random")))
    rules, slow = _rules(read.more.get("accept", {})), _slow(read.more.get("cohort", {}))
    interventions = _interventions(read.more.get("interventions", {}), read.configuration())
    for one in read.variables:
        if not one.source and say is not None:
            say(f"{one.name}: its distribution names no source")
    target = located(out)
    with in_folder(target), engine_of(workers) as engine:
        differences(read, target, say)
        runs = Runs(kept_beside(target) if kept is None else located(kept), engine, progress)
        points = read.points()
        rows = runs.rows(points)
        table = Table(read, rows, runs.hashes(points), target)
        table.write(target)
        refusals = tuple(_refusal(row, rules) for row in rows)
        chosen = [place for place, why in enumerate(refusals) if why is None]
        if not chosen:
            raise ConfigurationError(f"none of {len(rows)} members passes the rules, the first one: {refusals[0]}")
        transits = {BEFORE: _transits([rows[place] for place in chosen])}
        for name, changes in interventions.items():
            changed = [_changed(points[place], changes) for place in chosen]
            transits[name] = _transits(runs.rows(changed), say, name)
        shifts = tuple(_shift(name, transits[BEFORE], times, read.design.seed) for name, times in transits.items())
        found = Cohort(table, refusals, transits, shifts, slow)
        try:
            disk.replace_file(target / MEMBERS, found.members_csv())
            disk.replace_file(target / SHIFTS, found.shifts_csv())
        except OSError as error:
            raise WriteError(f"could not write into {shown(str(target))}: {error.strerror or error}") from None
    return found


def _refusal(row: Row, rules: Sequence[Rule]) -> str | None:
    if row.status in WITHOUT_RESULT:
        return f"{row.status}: {row.summary.get('error')}"
    return next((why for rule in rules if (why := rule.broken(row)) is not None), None)


def _transits(rows: Sequence[Row], say: Callable[[str], None] | None = None, name: str = "") -> Floats:
    without = sum(row.status in WITHOUT_RESULT for row in rows)
    if without and say is not None:
        say(f"{name}: {without} of {len(rows)} members have no result, and count as not expelled")
    found = [None if row.status in WITHOUT_RESULT else number(row.summary, TRANSIT) for row in rows]
    return np.array([np.nan if one is None else one for one in found])


def _shift(name: str, before: Floats, after: Floats, seed: int) -> Shift:
    was, now = np.isfinite(before), np.isfinite(after)
    differences_ = (after - before)[was & now]
    shift: float | None = None
    band: tuple[float, float] | None = None
    if differences_.size and name != BEFORE:
        random = np.random.default_rng(seed)
        drawn = np.median(random.choice(differences_, (RESAMPLES, differences_.size)), axis=1)
        low, high = np.quantile(drawn, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL])
        shift, band = float(np.median(differences_)), (float(low), float(high))
    median = float(np.median(after[now])) if now.any() else None
    return Shift(
        name, after.size, int(now.sum()), int((now & ~was).sum()), int((was & ~now).sum()), median, shift, band
    )


def _changed(point: Point, changes: Mapping[str, Any]) -> Point:
    """A member with an intervention."""
    assert point.configuration is not None
    flat, given = point.configuration.flat(), dict(changes)
    for key, value in changes.items():
        if isinstance(value, Mapping):
            present, unit = flat[key], FIELDS[key].unit
            assert isinstance(present, float)
            amount = present * value["factor"]
            given[key] = amount if unit == units.DIMENSIONLESS else f"{amount!r} {unit}"
    try:
        return Point(point.name, point.values, point.configuration.with_changes(given))
    except ConfigurationError as error:
        return Point(point.name, point.values, refusal=str(error))


def _rules(given: Any) -> tuple[Rule, ...]:
    if not isinstance(given, Mapping):
        raise ConfigurationError(f"accept = {shown(given)}: give a table of outputs with from and to")
    found: list[Rule] = []
    for name, limits in _flat(given).items():
        if name == "status":
            if not isinstance(limits, list) or not all(isinstance(one, str) for one in limits):
                raise ConfigurationError(f"accept: status = {shown(limits)}: give a list of statuses")
            found.append(Rule(name, among=tuple(limits)))
            continue
        (output,) = checked([name])
        if not isinstance(limits, Mapping) or not limits or set(limits) - {"from", "to"}:
            raise ConfigurationError(f"accept: {name} = {shown(limits)}: give from, to or both, in the output's unit")
        low, high = (units.parse(limits.get(word, end), "1", f"accept: {name}.{word}") if word in limits else end
                     for word, end in (("from", -np.inf), ("to", np.inf)))  # fmt: skip
        if not low < high:
            raise ConfigurationError(f"accept: {name}: from = {low:g} is not below to = {high:g}; exchange them")
        found.append(Rule(output, low, high))
    return tuple(found)


def _flat(tree: Mapping[str, Any], head: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, inner in tree.items():
        if isinstance(inner, Mapping) and not set(inner) & {"from", "to"}:
            found |= _flat(inner, f"{head}{name}.")
        else:
            found[f"{head}{name}"] = inner
    return found


def _slow(given: Any) -> float | None:
    if not isinstance(given, Mapping) or set(given) - {"slow"}:
        raise ConfigurationError(f"cohort = {shown(given)}: give a table with slow, such as slow = '3 s'")
    return units.parse(given["slow"], "s", "cohort: slow") if "slow" in given else None


def _interventions(given: Any, base: Configuration) -> dict[str, dict[str, Any]]:
    """Name to changes; a factor is a table of its own, and of a number."""
    if not isinstance(given, Mapping):
        raise ConfigurationError(f"interventions = {shown(given)}: give tables [interventions.NAME]")
    found: dict[str, dict[str, Any]] = {}
    for name, tree in given.items():
        where = f"interventions: {name}"
        if name == BEFORE:
            raise ConfigurationError(f"{where} is what members are without one; choose another name")
        changes = flat_changes(_factors_apart(tree), where)
        for key, value in changes.items():
            if isinstance(value, _Factor):
                present = base.flat().get(key)
                if isinstance(present, bool) or not isinstance(present, float):
                    raise ConfigurationError(f"{where}: {key} = {shown(present)} is no number, and has no factor")
                changes[key] = {"factor": value.value}
        if not changes:
            raise ConfigurationError(f"{where} changes nothing; give it parameters")
        base.with_changes({key: value for key, value in changes.items() if not isinstance(value, Mapping)})
        found[name] = changes
    return found


@dataclass(frozen=True)
class _Factor:
    """A factor, while tables are flattened."""

    value: float


def _factors_apart(tree: Any) -> Any:
    if not isinstance(tree, Mapping):
        return tree
    if set(tree) == {"factor"}:
        return _Factor(units.parse(tree["factor"], units.DIMENSIONLESS, "interventions: factor"))
    return {name: _factors_apart(inner) for name, inner in tree.items()}
