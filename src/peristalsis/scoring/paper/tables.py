"""Tables that only the paper's report has: its curves, and its misprints."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..outcome import Outcome
from ..source import Table
from ..tables import number
from .runs import CHANNELS, CURVE, PHASES, channel_run, phase_name


def curves(outcomes: Sequence[Outcome]) -> Table:
    """Transit over the factor on each conductance, and transit and mixing over the phase between the layers."""
    rows = []
    for outcome in outcomes:
        for channel in CHANNELS:
            for factor in sorted((*CURVE, 1.0)):
                record = outcome.records.get(channel_run(channel, factor))
                if record is not None:
                    rows.append(_curve_row(outcome, f"{channel} x", factor, record.summary))
        for delay in PHASES:
            record = outcome.records.get(phase_name(delay))
            if record is not None:
                rows.append(_curve_row(outcome, "circular after longitudinal (s)", delay, record.summary))
    columns = ("reading", "parameter", "value", "end", "transit (s)", "travel (cm)", "irregularity", "mixing")
    title = "Curves of Fig. 5 and of the phase between the layers"
    return Table("curves", title, "", columns, tuple(rows), folded=True)


def _curve_row(outcome: Outcome, parameter: str, value: float, numbers: Mapping[str, Any]) -> tuple[str, ...]:
    measured = (number(numbers.get(key)) for key in ("transit_s", "travel_cm", "irregularity", "mixing"))
    return (outcome.condition.title, parameter, f"{value:g}", str(numbers["status"]).replace("_", " "), *measured)


def misprints(outcomes: Sequence[Outcome]) -> Table:
    """What the paper prints wrongly, and how it is read: the same under any outcome."""
    entries = entries_of("misprints", "misprint")
    rows = tuple((one["equation"], one["printed"], one["read"], one["reason"]) for one in entries)
    return Table("misprints", "Misprints and how they are read", "", ("where", "printed", "read", "reason"), rows)


def entries_of(file: str, name: str) -> list[dict[str, Any]]:
    """The tables `name` of a file beside this one."""
    with Path(__file__).with_name(f"{file}.toml").open("rb") as stream:
        found: list[dict[str, Any]] = tomllib.load(stream).get(name, [])
    return found
