"""What may be concluded from the model: a page made of the findings, the parameters' tags and a few words."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

from peristalsis.inputs.parameters import PARAMETERS, READINGS

from .registry import TITLES
from .report import VERDICTS, Finding, counts, table, tally


def page(findings: Sequence[Finding], tier: str) -> str:
    """The credibility page, from the findings of a run of the problems."""
    with Path(__file__).with_name("credibility.toml").open("rb") as file:
        words = tomllib.load(file)
    families = [
        (title, *(str(counts(family)[verdict]) for verdict in VERDICTS))
        for letter, title in TITLES.items()
        if (family := [finding for finding in findings if finding.problem.id.startswith(letter)])
    ]
    open_ones = [
        (f.problem.id, f.problem.title, f.outcome.verdict, f.outcome.note)
        for f in findings
        if f.outcome.verdict != "pass"
    ]
    parts = [
        "# Credibility",
        "Made by `make verify` from its results and from the tags of the parameters; do not edit. The words are "
        "those of ASME V&V 40 (2018) and of the FDA guidance on computational modeling (2023).",
        f"## Question of interest\n\n{words['question']}",
        f"## Context of use\n\n{words['context']}\n\nInfluence and risk: {words['influence']}\n\nNot for: "
        f"{words['not_for']}",
        "## Evidence by category\n\n"
        + table(
            ("category", "what there is", "where"),
            ((one["category"], one["what"], one["where"]) for one in words["evidence"]),
        ).rstrip(),
        f"## Verified\n\n{tier.capitalize()} tier: {tally(findings)}.\n\n"
        + table(("family", *VERDICTS), families)
        + "\nWhat did not simply pass:\n\n"
        + table(("id", "problem", "verdict", "why"), open_ones).rstrip(),
        f"## Calibrated\n\n{_tagged('calibrated')}",
        f"## Chosen\n\n{_tagged('chosen')}\n\nBy reading: {_readings()}.",
        f"## Corrected\n\n{_tagged('corrected')}",
        "## Validated\n\nAgainst no measurement in the paper's segment. The one number that paper and model share by "
        "construction, the 4.2 cm/s of the wave, is calibrated; the claims of the paper are another model's outcomes, "
        "and how they were scored is in [claims](../paper/claims.md).",
        "## Not validated\n\n" + "\n".join(f"- {one['what']}" for one in words["unvalidated"]),
        "What the model leaves out: [limits](../limits.md).",
    ]
    return "\n\n".join(parts) + "\n"


def _tagged(tag: str) -> str:
    """The parameters with a tag, by section."""
    sections: dict[str, list[str]] = {}
    for parameter in PARAMETERS.values():
        if parameter.tag == tag:
            section, _, name = parameter.key.partition(".")
            sections.setdefault(section, []).append(name)
    total = sum(len(names) for names in sections.values())
    listed = "; ".join(f"**{section}** {', '.join(names)}" for section, names in sections.items())
    return f"{total} of {len(PARAMETERS)} parameters (`peristalsis show baseline` gives each its reason): {listed}."


def _readings() -> str:
    return "; ".join(f"`{reading.name}`: {reading.why}" for reading in READINGS.values())
