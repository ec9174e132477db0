"""`python -m benchmarks`: what the program costs, measured section by section and written as pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from peristalsis.cli import main as carry_out_line
from peristalsis.cli.dispatch import Program
from peristalsis.cli.job import Job
from peristalsis.cli.streams import Screen, spelled
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.paths import located

if TYPE_CHECKING:
    from .section import Findings

OUT = "out/benchmarks"

EXAMPLES = (
    "python -m benchmarks",
    "python -m benchmarks growth precision",
    "python -m benchmarks --full --out docs/benchmarks",
)

WITHOUT_WORDS: tuple[str, ...] = ()
"""An empty command line runs everything that is quick."""


@dataclass(frozen=True)
class BenchOrder:
    """Which sections to run (all if empty), with how much effort, where measurements and pages are kept."""

    names: tuple[str, ...]
    effort: Literal["quick", "full"]
    out: Path
    anew: bool


app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command(epilog="\n".join(("\b", "Examples:", *EXAMPLES)))
def bench(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SECTION]...", help="Sections, such as growth; all unless given.", show_default=False),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few repeats, small sizes; this unless --full.")] = False,
    full: Annotated[bool, typer.Option("--full", help="All repeats and sizes, the first compilation too.")] = False,
    out: Annotated[
        str | None, typer.Option("--out", metavar="DIR", help=f"Folder of measurements and pages; {OUT} unless given.")
    ] = None,
    anew: Annotated[bool, typer.Option("--anew", help="Measure again what was measured before.")] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print exactly one JSON object on stdout, also when something is wrong.")
    ] = False,
) -> Job:
    """Measure what runs cost: solver, kernels, growth, precision, memory, processes.

    Every measurement is kept in DIR as soon as it is made: a second call, or one after an interruption, goes on from
    there, unless sources, libraries or machine have changed. Aims that are missed are said, and are no failure.
    """
    if quick and full:
        raise ConfigurationError("--quick and --full are both given; keep one")
    effort: Literal["quick", "full"] = "full" if full else "quick"
    order = BenchOrder(tuple(names or ()), effort, located(OUT if out is None else out), anew)
    return Job(lambda screen: carry_out_order(order, screen))


def carry_out_order(order: BenchOrder, screen: Screen) -> int:
    """Run the sections, show and write what came out; the exit code."""
    from peristalsis.results.result import json_ready

    from . import report
    from .ledger import Ledger
    from .registry import chosen, sections
    from .section import Bench

    todo = chosen(order.names)
    ledger = Ledger(order.out)
    if order.anew:
        ledger.forget(order.effort, [section.name for section in todo])
    screen.line(f"{len(todo)} sections, {order.effort} (the first bench on a machine also compiles, for some minutes)")
    found: dict[str, Findings] = {}
    for section in todo:
        screen.line(f"{section.name}: {section.title}")
        handed = Bench(order.effort, ledger, section.name, lambda piece: screen.line(f"  measuring {piece}"))
        found[section.name] = section.run(handed)
        ledger.keep(order.effort, f"{report.FINDINGS}{section.name}", found[section.name].kept())
    lines = [row for section in todo for row in report.rows(section, found[section.name])]
    screen.table(report.COLUMNS, lines)
    try:
        files = report.write(ledger, order.effort, sections(), order.out)
    except OSError as error:
        raise WriteError(
            f"could not write {spelled(order.out)}: {error.strerror or error}; choose another place with --out"
        ) from None
    figures: list[dict[str, Any]] = [
        {"section": name, "what": one.what, "value": one.value, "unit": one.unit, "aim": one.aim, "met": one.met}
        for name, findings in found.items()
        for one in findings.figures
    ]
    screen.answer(
        json_ready(
            {"status": "finished", "effort": order.effort, "figures": figures, "written": [str(f) for f in files]}
        )
    )
    aimed = [one for findings in found.values() for one in findings.figures if one.met is not None]
    met = sum(1 for one in aimed if one.met)
    screen.say(f"{met} of {len(aimed)} aims met; pages in {spelled(order.out)}")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out a command line (that of the process unless given) and return its exit code; never raises."""
    return carry_out_line(arguments, Program("python -m benchmarks", __name__))
