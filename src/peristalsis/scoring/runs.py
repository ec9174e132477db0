"""Makes what the claims of a source need under one condition: runs, searches, sensitivities; all is kept on disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..inputs.config import Configuration
from ..many.rows import Row, Step
from ..many.sensitivity import shares
from ..many.sweep import sweep
from ..many.threshold import Threshold, find_threshold
from .experiment import Experiment
from .outcome import Condition, Outcome
from .rules import UNUSABLE
from .searches import Search, Sensitivity
from .source import Source

Progress = Callable[[Step], None]


@dataclass(frozen=True)
class Bench:
    """Where and how the runs of a source are made."""

    source: Source
    folder: Path
    workers: int = 1
    progress: Progress | None = None

    def records(self, runs: Iterable[Experiment], condition: Condition) -> dict[str, Row]:
        """The records of runs under one condition, by name."""
        return {run: row for (_, run), row in self.records_under((condition, run) for run in runs).items()}

    def records_under(self, runs: Iterable[tuple[Condition, Experiment]]) -> dict[tuple[str, str], Row]:
        """Records of runs under many conditions, by condition and run; all missing ones are made side by side.

        An experiment that the configuration refuses has a record that says so.
        """
        asked = {(condition.title, run.name): (condition, run) for condition, run in runs}
        several = len({title for title, _ in asked}) > 1
        names = {key: " ".join(key) if several else key[1] for key in asked}
        found: dict[tuple[str, str], Row] = {}
        accepted: dict[str, Configuration] = {}
        for key, (condition, run) in asked.items():
            try:
                accepted[names[key]] = run.configuration(condition.reading, condition.variant)
            except ConfigurationError as error:
                found[key] = Row({"status": "refused", "error": str(error)})
        rows = sweep(accepted, self.folder, self.source.measure, self.workers, self.progress)
        return found | {key: rows[name] for key, name in names.items() if name in rows}

    def search(self, search: Search, condition: Condition) -> tuple[Threshold, dict[str, Row]]:
        """Carry out one search."""
        records: dict[str, Row] = {}

        def scan(values: Sequence[float]) -> list[bool | None]:
            runs = {value: search.run(value) for value in values}
            records.update(self.records(runs.values(), condition))
            return [_answer(search, records[runs[value].name]) for value in values]

        found = find_threshold(lambda value: scan([value])[0], search.values, search.tolerance, scan)
        return found, records

    def sensitivity(self, study: Sensitivity, condition: Condition) -> tuple[dict[str, Any], dict[str, Row]]:
        """Carry out one sensitivity; its numbers as metrics."""
        runs = [[study.run(first, second) for second in study.second.values] for first in study.first.values]
        records = self.records([run for row in runs for run in row], condition)
        bad = [name for name, record in records.items() if record.status in UNUSABLE]
        if bad:
            return {"status": "failed", "error": f"no velocity at {', '.join(bad[:3])}"}, records
        table = np.array([[records[run.name].summary["mean_velocity_cm_s"] for run in row] for row in runs])
        found = shares(table)
        first, second = study.first.name, study.second.name
        numbers = {
            "status": "finished",
            first: found.first,
            f"{first}_low": found.first_band[0],
            f"{first}_high": found.first_band[1],
            second: found.second,
            f"{second}_low": found.second_band[0],
            f"{second}_high": found.second_band[1],
            "velocities": table.tolist(),
        }
        return numbers, records


def _answer(search: Search, record: Row) -> bool | None:
    return None if record.status in UNUSABLE else search.holds(record.summary)


def carry_out(
    bench: Bench,
    condition: Condition,
    runs: Iterable[str] | None = None,
    searches: bool | Collection[str] = True,
) -> Outcome:
    """Make the named runs (all unless given), and the searches and sensitivities: all, none, or those named."""
    source = bench.source
    asked = (*source.searches, *source.sensitivities) if searches is True else searches or ()
    names = list(source.runs) if runs is None else list(runs)
    records = bench.records([source.runs[name] for name in names], condition)
    measured: dict[str, Mapping[str, Any]] = {name: records[name].summary for name in names}
    thresholds: dict[str, Threshold] = {}
    for search in (one for one in source.searches.values() if one.name in asked):
        thresholds[search.name], more = bench.search(search, condition)
        records |= more
        measured[search.name] = _threshold_numbers(search, thresholds[search.name], more)
    for study in (one for one in source.sensitivities.values() if one.name in asked):
        measured[study.name], more = bench.sensitivity(study, condition)
        records |= more
    return Outcome(condition, records, thresholds, measured)


def _threshold_numbers(search: Search, found: Threshold, records: Mapping[str, Row]) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        "status": "finished",
        "threshold": found.value,
        "low": found.low,
        "high": found.high,
        "monotone": found.monotone,
        "regions": [list(region) for region in found.regions()],
    }
    if search.key == "ratio" and found.value is not None:
        inflated = [
            (record.summary["inflated_ratio"] / ratio)
            for point in found.points
            for ratio in [point.value]
            if (record := records[search.run(ratio).name]).summary.get("inflated_ratio") is not None
        ]
        factor = float(np.median(inflated)) if inflated else math.nan
        numbers["threshold_inflated"] = found.value * factor
    return numbers
