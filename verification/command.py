"""`python -m verification`: exact problems with known answers, run and written as pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from peristalsis.cli import main as carry_out_line
from peristalsis.cli.dispatch import Program
from peristalsis.cli.job import Job
from peristalsis.cli.streams import Screen, spelled
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.paths import located

if TYPE_CHECKING:
    from .report import Finding

OUT = "out/verification"
FAILED = 1

EXAMPLES = (
    "python -m verification",
    "python -m verification --full --out docs/verification",
    "python -m verification M1 M4 C1",
)

WITHOUT_WORDS: tuple[str, ...] = ()
"""An empty command line runs everything that is quick."""


@dataclass(frozen=True)
class VerifyOrder:
    """Which problems to run, and where to write the pages (nowhere if None)."""

    ids: tuple[str, ...]
    full: bool
    out: Path | None


app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command(epilog="\n".join(("\b", "Examples:", *EXAMPLES)))
def verify(
    ids: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ID]...", help="Problems, such as M4; a whole tier unless given.", show_default=False),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="The quick tier; this unless --full.")] = False,
    full: Annotated[bool, typer.Option("--full", help="Every problem, the slow ones as well.")] = False,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help=f"Folder of the pages; {OUT} unless given, none for named problems."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print exactly one JSON object on stdout, even when something is wrong.")
    ] = False,
) -> Job:
    """Run exact problems with known answers and say which hold.

    Prints id, problem, source, expected, observed, order and verdict; writes a page for each family, the trace of
    equations to code and tests, what may be concluded, results.json and results.csv. The exit code is 1 if a
    problem failed.
    """
    if quick and full:
        raise ConfigurationError("--quick and --full are both given; keep one")
    if ids and (quick or full):
        raise ConfigurationError(f"--{'quick' if quick else 'full'} is given beside problem {ids[0]}; keep one of them")
    place = located(out) if out is not None else None if ids else Path(OUT)
    return Job(lambda screen: carry_out_order(VerifyOrder(tuple(ids or ()), full, place), screen))


def carry_out_order(order: VerifyOrder, screen: Screen) -> int:
    """Run the problems, show and write what came out; the exit code."""
    from . import credibility, trace
    from .registry import chosen
    from .report import COLUMNS, carry_out, counts, tally, write

    problems = chosen(order.ids, order.full)
    screen.line(f"{len(problems)} problems (the first run on a machine also compiles, for up to a minute)")
    findings = carry_out(problems, _Progress(screen, len(problems)))
    screen.table(COLUMNS, (finding.row() for finding in findings))
    answer: dict[str, Any] = {
        "status": "finished",
        "counts": counts(findings),
        "problems": [finding.record() | {"wall_s": round(finding.seconds, 2)} for finding in findings],
    }
    if order.out is not None:
        tier = "full" if order.full else "named" if order.ids else "quick"
        more = {"trace.md": trace.page(), "credibility.md": credibility.page(findings, tier)}
        try:
            files = write(findings, order.out, tier, more)
        except OSError as error:
            raise WriteError(
                f"could not write {spelled(order.out)}: {error.strerror or error}; choose another place with --out"
            ) from None
        answer["written"] = [str(file) for file in files]
    from peristalsis.results.result import json_ready

    screen.answer(json_ready(answer))
    screen.say(tally(findings) + ("" if order.out is None else f"; pages in {spelled(order.out)}"))
    return FAILED if counts(findings)["fail"] else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out a command line (that of the process unless given) and return its exit code; never raises."""
    return carry_out_line(arguments, Program("python -m verification", __name__))


class _Progress:
    """One line on stderr for every finished problem."""

    def __init__(self, screen: Screen, count: int) -> None:
        self._screen = screen
        self._count = count
        self._done = 0

    def __call__(self, finding: Finding) -> None:
        self._done += 1
        problem = finding.problem
        self._screen.line(
            f"{self._done:3d}/{self._count} {problem.id} {problem.title}: {finding.outcome.verdict} "
            f"({finding.seconds:.1f} s)"
        )
