"""The tables of the report: columns and rows of text, for the page and for CSV files."""

from __future__ import annotations

import csv
import io
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..inputs.parameters import READINGS, shipped
from ..units import format_quantity
from .claims import NOT_TESTABLE
from .experiments import Outcome
from .runs import CHANNELS, CURVE, PHASES, RUNS, phase_name
from .score import Scored
from .searches import SEARCHES, SENSITIVITIES

USES = {
    "prediction": "prediction",
    "calibrated": "calibrated: no prediction",
    "chosen": "used to choose: no prediction",
}


@dataclass(frozen=True, slots=True)
class Table:
    """One table: name of its file, title, a line of explanation, columns, rows."""

    name: str
    title: str
    note: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def csv(self) -> str:
        """The table as CSV text."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.rows)
        return text.getvalue()


def _number(value: Any, digits: int = 4) -> str:
    return "–" if value is None else f"{value:.{digits}g}"


def _value(value: Any, unit: str) -> str:
    if isinstance(value, float):
        return f"{value:g}" if unit in ("", "1") else format_quantity(value, unit)
    return str(value)


def matrix(scores: Mapping[str, Sequence[Scored]]) -> Table:
    """Claims x conditions: the verdict, and which part does not hold. scores: title of the condition to its scores."""
    first = next(iter(scores.values()))
    rows = []
    for index, scored in enumerate(first):
        cells = []
        for every in scores.values():
            one = every[index]
            cells.append(_verdict(one))
        claim = scored.claim
        rows.append((str(claim.number), claim.statement, claim.place, USES[claim.use], *cells))
    for statement, why in NOT_TESTABLE.items():
        rows.append(("–", statement, "section 4", "–", *(f"not testable: {why}" for _ in scores)))
    return Table(
        "claims",
        "Claims and readings",
        "Rules and tolerances were fixed before the first scored run; a claim holds in part if some of its parts do.",
        ("claim", "statement", "place", "use", *scores),
        tuple(rows),
    )


def _verdict(one: Scored) -> str:
    """The verdict, with the parts that fail beside some that hold, or cannot be judged beside some that fail."""
    failing = one.failing()
    if one.verdict == "holds in part":
        return f"{one.verdict}: not {'; '.join(failing)}"
    unjudged = [name for name in failing if name.endswith(("(not testable)", "(not run)"))]
    partly = one.verdict == "does not hold" and unjudged
    return f"{one.verdict}: {'; '.join(unjudged)}" if partly else one.verdict


def counts(scores: Mapping[str, Sequence[Scored]]) -> Table:
    """How many verdicts of each kind, over all claims and over those that are predictions."""
    verdicts = ("holds", "holds in part", "does not hold", "not testable", "not run")
    rows = []
    for title, every in scores.items():
        for label, chosen in (
            ("all", every),
            ("predictions", [one for one in every if one.claim.use == "prediction"]),
        ):
            numbers = (str(sum(1 for one in chosen if one.verdict == verdict)) for verdict in verdicts)
            rows.append((title, label, *numbers))
    return Table("counts", "Verdicts counted", "", ("reading", "claims", *verdicts), tuple(rows))


def grounds(scores: Mapping[str, Sequence[Scored]]) -> Table:
    """Every part of every claim under every condition: what was found."""
    words = {True: "yes", False: "no", None: "not testable"}
    rows = [
        (
            str(one.claim.number),
            title,
            part.name,
            "not run" if found.missing else words[found.holds],
            found.numbers,
        )
        for title, every in scores.items()
        for one in every
        for part, found in zip(one.claim.parts, one.findings, strict=True)
    ]
    rows.sort(key=lambda row: int(row[0]))
    return Table("parts", "Parts of the claims", "", ("claim", "reading", "part", "holds", "found"), tuple(rows))


def velocities(outcomes: Sequence[Outcome]) -> Table:
    """Every named run: how it ended, transit, travel, mean velocity, and the other quantities."""
    rows: list[tuple[str, ...]] = []
    for outcome in outcomes:
        for name in RUNS:
            if name not in outcome.records:
                continue
            numbers = outcome.records[name].summary
            rows.append(
                (
                    outcome.condition.title,
                    name,
                    str(numbers["status"]).replace("_", " "),
                    *(
                        _number(numbers.get(key))
                        for key in (
                            "transit_s",
                            "travel_cm",
                            "mean_velocity_cm_s",
                            "irregularity",
                            "stops",
                            "reversals",
                            "libration_cm",
                            "mixing",
                            "max_axial_force_mN",
                            "pulses",
                            "simulated_s",
                        )
                    ),
                    str(numbers.get("error") or ""),
                )
            )
    columns: tuple[str, ...] = (
        "reading",
        "run",
        "end",
        "transit (s)",
        "travel (cm)",
        "mean velocity (cm/s)",
        "irregularity",
        "stops",
    )
    columns += (
        "reversals",
        "libration (cm)",
        "mixing",
        "largest axial force (mN)",
        "pulses",
        "simulated (s)",
        "remark",
    )
    return Table("velocities", "Transit and mean velocity", "", columns, tuple(rows))


def thresholds(outcomes: Sequence[Outcome]) -> Table:
    """Every search: bracket, whether the property is monotone over the scan, and its regions."""
    rows = []
    for outcome in outcomes:
        for name, found in outcome.thresholds.items():
            search = SEARCHES[name]
            unit = "" if search.unit == "1" else f" {search.unit}"
            numbers = outcome.measured[name]
            inflated = numbers.get("threshold_inflated")
            also = f"; {inflated:.4g} of the inflated tube" if inflated is not None else ""
            bracket = (
                f"{_number(found.low)} to {_number(found.high)}{unit}{also}" if found.value else "none in the scan"
            )
            if search.predicate == "sticks":
                words = {True: "sticks or stays", False: "goes through"}
            else:
                arrives = search.predicate == "arrives"
                words = {arrives: "arrives", not arrives: "does not arrive"}
            regions = "; ".join(f"{low:g} to {high:g}: {words[holds]}" for low, high, holds in found.regions())
            times = [
                float(record.summary["simulated_s"])
                for run, record in outcome.records.items()
                if run.startswith(f"{name}=") and "simulated_s" in record.summary and not record.summary["transit_s"]
            ]
            longest = f"{max(times):g} s" if times else "all arrive"
            rows.append(
                (
                    outcome.condition.title,
                    search.title,
                    bracket,
                    "yes" if found.monotone else "no",
                    regions,
                    longest,
                )
            )
    return Table(
        "thresholds",
        "Thresholds",
        "A scan, then bisection to 2 % of the last change; one pulse at t = 0 unless the variant says otherwise.",
        ("reading", "threshold", "bracket", "monotone", "regions", "simulated where it does not arrive"),
        tuple(rows),
    )


def sensitivities(outcomes: Sequence[Outcome]) -> Table:
    """Total shares of the variance of the mean velocity, with bands."""
    rows = []
    for outcome in outcomes:
        for name, study in SENSITIVITIES.items():
            found = outcome.measured.get(name)
            if found is None or found["status"] != "finished":
                continue
            shares = tuple(
                f"{found[factor]:.3f} ({found[f'{factor}_low']:.3f} to {found[f'{factor}_high']:.3f})"
                for factor in ("viscous", "dry")
            )
            rows.append((outcome.condition.title, study.title, *shares))
    return Table(
        "sensitivities",
        "Viscous against dry friction",
        "Total share of the variance of the mean velocity in a 5 x 5 factorial; in brackets, leaving out one level.",
        ("reading", "range", "viscous friction", "dry friction"),
        tuple(rows),
    )


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
    return Table("curves", "Curves of Fig. 5 and of the phase between the layers", "", columns, tuple(rows))


def _curve_row(outcome: Outcome, parameter: str, value: float, numbers: Mapping[str, Any]) -> tuple[str, ...]:
    measured = (_number(numbers.get(key)) for key in ("transit_s", "travel_cm", "irregularity", "mixing"))
    return (outcome.condition.title, parameter, f"{value:g}", str(numbers["status"]).replace("_", " "), *measured)


def channel_run(channel: str, factor: float) -> str:
    """Name of the run with this factor on this channel."""
    states = {0.75: "decreased", 1.0: "norm", 1.25: "increased"}
    return f"fig5_{channel}_{states[factor]}" if factor in states else f"{channel}_x{factor:g}"


def misprints() -> Table:
    """What the paper prints wrongly, and how it is read."""
    entries = _entries("misprints", "misprint")
    rows = tuple((one["equation"], one["printed"], one["read"], one["reason"]) for one in entries)
    return Table("misprints", "Misprints and how they are read", "", ("where", "printed", "read", "reason"), rows)


def explanations(scores: Mapping[str, Sequence[Scored]]) -> Table:
    """Why claims do not hold under a reading: the reason, what shows it, and where they would."""
    rows = []
    for entry in _entries("explanations", "explanation"):
        every = scores.get(entry["reading"])
        if every is None or every[entry["claim"] - 1].verdict == "holds":
            continue
        texts = (entry["reason"], entry["command"], entry.get("nearest", "none seen"), entry.get("shown", "–"))
        rows.append((str(entry["claim"]), entry["reading"], *texts))
    note = "Written after the scored runs. Nearest: the nearest condition in which the failing part was seen to hold."
    columns = ("claim", "reading", "reason", "command that shows it", "nearest", "command for it")
    return Table("explanations", "Why claims fail", note, columns, tuple(rows))


def _entries(file: str, name: str) -> list[dict[str, Any]]:
    with Path(__file__).with_name(f"{file}.toml").open("rb") as stream:
        found: list[dict[str, Any]] = tomllib.load(stream).get(name, [])
    return found


def numbers(tag: str) -> Table:
    """Every shipped number of one tag, calibrated or chosen, those of the readings among them."""
    seen: dict[tuple[str, str], tuple[str, ...]] = {}
    for reading in READINGS:
        for key, about in shipped(reading).items():
            if about.tag != tag:
                continue
            where = reading if key in READINGS[reading].parameters else "every reading"
            row = (key, where, _value(about.value, about.unit), about.description, about.source, about.printed)
            seen.setdefault((key, where), row)
    columns = ("parameter", "reading", "value", "what", "source", "printed")
    return Table(tag, f"{tag.capitalize()} numbers", "", columns, tuple(seen.values()))


def all_tables(outcomes: Sequence[Outcome], scores: Mapping[str, Sequence[Scored]]) -> tuple[Table, ...]:
    """Every table of the report, in its order."""
    found = (
        matrix(scores),
        counts(scores),
        explanations(scores),
        grounds(scores),
        velocities(outcomes),
        thresholds(outcomes),
        sensitivities(outcomes),
        curves(outcomes),
        misprints(),
        numbers("calibrated"),
        numbers("chosen"),
    )
    return tuple(table for table in found if table.rows)
