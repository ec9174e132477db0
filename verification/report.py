"""From outcomes to pages: a table, a page for each family, results.json and results.csv. Nothing here decides."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from peristalsis._version import __version__
from peristalsis.errors import PeristalsisError
from peristalsis.results.result import json_ready

from .problem import Outcome, Problem, Verdict
from .prose import wrapped
from .registry import TITLES

COLUMNS = ("id", "problem", "source", "expected", "observed", "order", "verdict")
VERDICTS: tuple[Verdict, ...] = ("pass", "fail", "not applicable", "elsewhere")
INDEPENDENT = "independent.md"


@dataclass(frozen=True)
class Finding:
    """A problem with its outcome and the seconds that it took."""

    problem: Problem
    outcome: Outcome
    seconds: float

    def row(self) -> tuple[str, ...]:
        """The line of the table, in the order of COLUMNS."""
        p, o = self.problem, self.outcome
        order = "–" if o.order is None else f"{o.order:.2f}"
        return p.id, p.title, p.source, o.expected, shortened(o), order, o.verdict

    def record(self) -> dict[str, Any]:
        """Everything, as it stands in results.json."""
        p, o = self.problem, self.outcome
        return {
            "id": p.id,
            "problem": p.title,
            "source": p.source,
            "tier": p.tier,
            "equations": list(p.equations),
            "expected": o.expected,
            "observed": o.observed,
            "error": o.error,
            "order": o.order,
            "accept": o.accept,
            "verdict": o.verdict,
            "note": o.note,
            "checks": [
                {"what": c.what, "observed": c.observed, "low": c.low, "high": c.high, "passed": c.passed}
                for c in o.checks
            ],
        }


def shortened(outcome: Outcome) -> str:
    """The number nearest to its bound, or how many hold; the rest is on the page of the family."""
    if not outcome.checks:
        return outcome.note if outcome.verdict == "elsewhere" else outcome.observed
    failed = [check for check in outcome.checks if not check.passed]
    if failed:
        return "; ".join(f"{c.what}: {c.observed:.3g}, accepted {c.bounds}" for c in failed)
    tight = max((c for c in outcome.checks if c.low == 0.0 < c.high), key=lambda c: c.observed / c.high, default=None)
    closest = "" if tight is None else f"; nearest: {tight.what} {tight.observed:.2g} ({tight.bounds})"
    return f"{len(outcome.checks)} of {len(outcome.checks)} checks{closest}"


def counts(findings: Iterable[Finding]) -> dict[str, int]:
    """How many problems had each verdict."""
    found = [finding.outcome.verdict for finding in findings]
    return {verdict: found.count(verdict) for verdict in VERDICTS}


def tally(findings: Sequence[Finding]) -> str:
    """The counts in words."""
    return ", ".join(f"{number} {verdict}" for verdict, number in counts(findings).items() if number)


def pages(findings: Sequence[Finding], tier: str) -> dict[str, str]:
    """File name to text of everything that is written."""
    written = {
        "README.md": _index(findings, tier),
        "results.json": _json(findings, tier),
        "results.csv": _csv(findings),
    }
    for letter, title in TITLES.items():
        family = [finding for finding in findings if finding.problem.id.startswith(letter)]
        if family:
            written[f"{_page(title)}"] = _family(title, family)
    return written


def write(findings: Sequence[Finding], folder: Path, tier: str, more: Mapping[str, str] | None = None) -> list[Path]:
    """Write all pages, and `more` of them by name, into a folder; other files there stay. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, text in {**pages(findings, tier), **(more or {})}.items():
        file = folder / name
        file.write_text(wrapped(text) if file.suffix == ".md" else text, encoding="utf-8")
        files.append(file)
    return files


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""

    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"

    return "\n".join([line(columns), "|" + "---|" * len(columns), *(line(row) for row in rows)]) + "\n"


def _page(title: str) -> str:
    return f"{title.lower().replace(' ', '_')}.md"


def _index(findings: Sequence[Finding], tier: str) -> str:
    text = [
        "# Verification",
        f"Exact problems with known answers, {tier} tier: {tally(findings)}. Made by `make verify`; do not edit.",
        "Verdicts follow from the checks of a problem, all listed on the page of its family, with what is accepted. "
        "Orders are gated from both sides on four levels or more, within ±0.1 (±0.2 in C4s and for the damping in M14; "
        "X1 and X5 state a least order). *not applicable* carries its reason. "
        "The same problems are tests: `make test` runs the quick tier, `make verify` both.",
        "[Which test shows which equation](trace.md) · [What may be concluded](credibility.md) · "
        f"[An independent implementation]({INDEPENDENT}) · [results.json](results.json) · [results.csv](results.csv)",
    ]
    for letter, title in TITLES.items():
        family = [finding for finding in findings if finding.problem.id.startswith(letter)]
        if family:
            text += [f"## [{title}]({_page(title)})", table(COLUMNS, (finding.row() for finding in family))]
    return "\n\n".join(text).rstrip() + "\n"


def _family(title: str, findings: Sequence[Finding]) -> str:
    text = [f"# {title}", "[All problems](README.md). Made by `make verify`; do not edit."]
    for finding in findings:
        p, o = finding.problem, finding.outcome
        text.append(f"## {p.id}: {p.title} · {o.verdict}")
        equations = ", ".join(f"({n})" for n in p.equations) or "–"
        text.append(f"Expected: {o.expected}\n\nSource: {p.source}. Equations: {equations}. Tier: {p.tier}.")
        if o.checks:
            rows = ((c.what, f"{c.observed:.3g}", c.bounds, "yes" if c.passed else "**no**") for c in o.checks)
            text.append(table(("check", "observed", "accepted", "holds"), rows).rstrip())
        if o.note:
            text.append(o.note)
    return "\n\n".join(text) + "\n"


def _json(findings: Sequence[Finding], tier: str) -> str:
    content = {
        "version": __version__,
        "tier": tier,
        "counts": counts(findings),
        "problems": [finding.record() for finding in findings],
    }
    return json.dumps(json_ready(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _csv(findings: Sequence[Finding]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow((*COLUMNS[:4], "check", "observed", "low", "high", "holds", "verdict"))
    for finding in findings:
        p, o = finding.problem, finding.outcome
        head = tuple(_cell(text) for text in (p.id, p.title, p.source, o.expected))
        for c in o.checks:
            writer.writerow((*head, _cell(c.what), repr(c.observed), c.low, c.high, c.passed, o.verdict))
        if not o.checks:
            writer.writerow((*head, "", "", "", "", "", o.verdict))
    return out.getvalue()


def _cell(text: str) -> str:
    """Text that no spreadsheet takes for a formula."""
    return f"'{text}" if text[:1] in "=+-@" else text


def carry_out(problems: Iterable[Problem], done: Callable[[Finding], None] | None = None) -> list[Finding]:
    """Run problems one after the other; `done` sees each finding. An exception is a failure that says so."""
    import time

    findings = []
    for problem in problems:
        begin = time.perf_counter()
        try:
            outcome = problem.run()
        except (PeristalsisError, ValueError, ArithmeticError, IndexError) as error:
            said = f"{type(error).__name__}: {error}"
            outcome = Outcome("–", f"broke off: {said}", None, None, "–", "fail", f"Broke off with {said}")
        findings.append(Finding(problem, outcome, time.perf_counter() - begin))
        if done is not None:
            done(findings[-1])
    return findings
