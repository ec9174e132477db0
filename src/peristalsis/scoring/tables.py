"""Tables that every report has: columns and rows of text, for the page and for CSV files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..inputs.parameters import READINGS, shipped
from ..units import format_quantity
from .outcome import Outcome
from .score import Scored
from .source import Source, Table

USES = {
    "prediction": "prediction",
    "calibrated": "calibrated: no prediction",
    "chosen": "used to choose: no prediction",
    "plausibility": "plausibility: a bound, no prediction",
}

Scores = Mapping[str, Sequence[Scored]]
"""Title of a condition to the scores of all claims under it."""


def number(value: Any, digits: int = 4) -> str:
    """A measured value in a table; a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}g}"


def _value(value: Any, unit: str) -> str:
    if isinstance(value, float):
        return f"{value:g}" if unit in ("", "1") else format_quantity(value, unit)
    return str(value)


def matrix(source: Source, scores: Scores) -> Table:
    """Claims x conditions: the verdict, and which part does not hold."""
    first = next(iter(scores.values()))
    rows = []
    for index, scored in enumerate(first):
        cells = []
        for every in scores.values():
            one = every[index]
            cells.append(_verdict(one))
        claim = scored.claim
        rows.append((source.label(claim.number), claim.statement, claim.place, USES[claim.use], *cells))
    for left in source.untestable:
        rows.append(("–", left.statement, left.place, "–", *(f"not testable: {left.reason}" for _ in scores)))
    return Table(
        "claims",
        f"Claims and {source.word}s",
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


def counts(source: Source, scores: Scores) -> Table:
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
    return Table("counts", "Verdicts counted", "", (source.word, "claims", *verdicts), tuple(rows))


def grounds(source: Source, scores: Scores) -> Table:
    """Every part of every claim under every condition: what was found."""
    words = {True: "yes", False: "no", None: "not testable"}
    parts = [
        (one.claim.number, title, part.name, "not run" if found.missing else words[found.holds], found.numbers)
        for title, every in scores.items()
        for one in every
        for part, found in zip(one.claim.parts, one.findings, strict=True)
    ]
    parts.sort(key=lambda row: row[0])
    rows = tuple((source.label(claim), *texts) for claim, *texts in parts)
    columns = ("claim", source.word, "part", "holds", "found")
    return Table("parts", "Parts of the claims", "", columns, rows, folded=True)


def velocities(source: Source, outcomes: Sequence[Outcome]) -> Table:
    """Every named run: how it ended, transit, travel, mean velocity, and the other quantities."""
    rows: list[tuple[str, ...]] = []
    for outcome in outcomes:
        for name in source.runs:
            if name not in outcome.records:
                continue
            numbers = outcome.records[name].summary
            rows.append(
                (
                    outcome.condition.title,
                    name,
                    str(numbers["status"]).replace("_", " "),
                    *(number(numbers.get(key)) for key in source.columns),
                    str(numbers.get("error") or ""),
                )
            )
    columns = (source.word, "run", "end", *source.columns.values(), "remark")
    return Table("velocities", "Transit and mean velocity", "", columns, tuple(rows), folded=True)


def thresholds(source: Source, outcomes: Sequence[Outcome]) -> Table:
    """Every search: bracket, whether the property is monotone over the scan, and its regions."""
    rows = []
    for outcome in outcomes:
        for name, found in outcome.thresholds.items():
            search = source.searches[name]
            unit = "" if search.unit == "1" else f" {search.unit}"
            numbers = outcome.measured[name]
            inflated = numbers.get("threshold_inflated")
            also = f"; {inflated:.4g} of the inflated tube" if inflated is not None else ""
            bracket = f"{number(found.low)} to {number(found.high)}{unit}{also}" if found.value else "none in the scan"
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
        "A scan, then bisection of the last change.",
        (source.word, "threshold", "bracket", "monotone", "regions", "simulated where it does not arrive"),
        tuple(rows),
    )


def sensitivities(source: Source, outcomes: Sequence[Outcome]) -> Table:
    """Total shares of the variance of the mean velocity, with bands."""
    rows = []
    titles = {(study.first.title, study.second.title) for study in source.sensitivities.values()}
    for outcome in outcomes:
        for name, study in source.sensitivities.items():
            found = outcome.measured.get(name)
            if found is None or found["status"] != "finished":
                continue
            shares = []
            for axis in (study.first, study.second):
                low, high = found[f"{axis.name}_low"], found[f"{axis.name}_high"]
                of_what = "" if len(titles) == 1 else f"{axis.title}: "
                shares.append(f"{of_what}{found[axis.name]:.3f} ({low:.3f} to {high:.3f})")
            rows.append((outcome.condition.title, study.title, *shares))
    return Table(
        "sensitivities",
        "Shares of two factors",
        "Total share of the variance of the mean velocity in a full factorial; in brackets, leaving out one level.",
        (source.word, "range", *(titles.pop() if len(titles) == 1 else ("first factor", "second factor"))),
        tuple(rows),
    )


def explanations(source: Source, scores: Scores) -> Table:
    """Why claims do not hold under a reading: the reason, what shows it, and where they would."""
    rows = []
    for entry in source.explanations:
        verdicts = {one.claim.number: one.verdict for one in scores.get(entry.reading, ())}
        if verdicts.get(entry.claim, "holds") == "holds":
            continue
        texts = (entry.reason, entry.command, entry.nearest, entry.shown)
        rows.append((source.label(entry.claim), entry.reading, *texts))
    note = "Written after the scored runs. Nearest: the nearest condition in which the failing part was seen to hold."
    columns = ("claim", source.word, "reason", "command that shows it", "nearest", "command for it")
    return Table("explanations", "Why claims fail", note, columns, tuple(rows))


def numbers(tag: str, readings: Sequence[str] = tuple(READINGS)) -> Table:
    """Every shipped number of one tag, such as chosen, those of the readings among them."""
    seen: dict[tuple[str, str], tuple[str, ...]] = {}
    for reading in readings:
        for key, about in shipped(reading).items():
            if about.tag != tag:
                continue
            where = reading if key in READINGS[reading].parameters else "every reading"
            row = (key, where, _value(about.value, about.unit), about.description, about.source, about.printed)
            seen.setdefault((key, where), row)
    columns = ("parameter", "reading", "value", "what", "source", "printed")
    return Table(tag, f"{tag.capitalize()} numbers", "", columns, tuple(seen.values()), folded=True)


def sets(source: Source) -> Table:
    """What the parameter sets of a source change in their readings."""
    rows = tuple(
        (one.name, one.reading, key, str(value)) for one in source.sets for key, value in sorted(one.changes.items())
    )
    return Table("sets", f"The {source.word}s", "", (source.word, "reading", "parameter", "value"), rows)


def all_tables(source: Source, outcomes: Sequence[Outcome], scores: Scores) -> tuple[Table, ...]:
    """Every table of the report, in its order."""
    readings = tuple(dict.fromkeys(one.reading for one in source.sets))
    found = (
        matrix(source, scores),
        counts(source, scores),
        explanations(source, scores),
        grounds(source, scores),
        velocities(source, outcomes),
        thresholds(source, outcomes),
        sensitivities(source, outcomes),
        *(make(outcomes) for make in source.tables),
        sets(source),
        numbers("calibrated", readings),
        numbers("chosen", readings),
        numbers("fitted", readings),
    )
    return tuple(_in_words_of(source, one) for one in found if one.rows)


def _in_words_of(source: Source, table: Table) -> Table:
    title, note = source.words.get(table.name, (table.title, table.note))
    return replace(table, title=title, note=note)
