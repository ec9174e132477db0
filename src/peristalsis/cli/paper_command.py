"""`peristalsis paper`: every experiment of the paper, run or taken up again, scored and written as one page."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConfigurationError, shown, suggestion
from ..paths import located
from .job import Job
from .options import Json
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.rows import Step
    from ..scoring.outcome import Outcome
    from ..scoring.source import Source

FIGURES = ("1", "2", "3", "4", "5", "6", "7")
READINGS = ("tight", "stretched", "printed", "edge", "all")
MOST_WORKERS = 64

EXAMPLES = (
    "peristalsis paper",
    "peristalsis paper --figure 3 --reading all",
    "peristalsis paper --variant doubled --variant moving-wall",
    "peristalsis paper --coarse --workers 2",
    "peristalsis paper --search --out out/search",
    "peristalsis paper --search --held-out --out out/search",
)

COARSE_NOTE = "Coarse grids: transits are off by some ten per cent. Do not quote these verdicts."


@dataclass(frozen=True)
class PaperOrder:
    """What to run and where to put it; source: whose claims are scored; claims: only what these need, all if none.

    held_out: of a search, score the claims that were held out as well, at its scored points and in the parameter sets.
    """

    figure: str | None
    reading: str
    workers: int
    out: Path
    coarse: bool
    searches: bool = True
    variants: tuple[str, ...] = ()
    source: str = "paper"
    claims: tuple[int, ...] = ()
    held_out: bool = False

    @property
    def if_interrupted(self) -> str:
        """What is said to who stops it."""
        return f"interrupted; finished runs are kept in {spelled(self.out / 'runs')}: call again to go on"

    def sets(self, source: Source) -> tuple[str, ...]:
        """The parameter sets that are meant."""
        return tuple(one.name for one in source.sets) if self.reading == "all" else (self.reading,)


def paper(
    figure: Annotated[
        str | None, typer.Option("--figure", metavar="N", help="Run and draw only figure N of the paper, 1 to 7.")
    ] = None,
    reading: Annotated[
        str, typer.Option("--reading", metavar="R", help="Reading: tight, stretched, printed, edge or all.")
    ] = "tight",
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Processes that run at a time.")] = 2,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder of the report and of the kept runs.")] = (
        "out/paper"
    ),
    coarse: Annotated[bool, typer.Option("--coarse", help="Coarse grids, for a quick look only.")] = False,
    no_searches: Annotated[
        bool, typer.Option("--no-searches", help="Leave out thresholds and sensitivities (claims 8, 10, 23).")
    ] = False,
    variant: Annotated[
        list[str] | None,
        typer.Option(
            "--variant",
            metavar="V",
            help="Score every reading with one choice changed as well: slow-waves, doubled (durations), moving-wall, "
            "consistent, printed-density, total, without-reflex, short-reflex or all. Can be given more than once.",
        ),
    ] = None,
    search: Annotated[
        bool,
        typer.Option(
            "--search", help="Search for the numbers under which most claims hold (two hours), instead of scoring."
        ),
    ] = False,
    held_out: Annotated[
        bool,
        typer.Option(
            "--held-out",
            help="With --search: score the claims that were held out as well, once it is over, and every reading.",
        ),
    ] = False,
    as_json: Json = False,
) -> Job:
    """Run every experiment of the paper and score its claims.

    Writes report.html, each table as CSV and each figure as PNG and SVG. Finished runs are kept in DIR/runs: a
    second call, or one after an interruption, runs only what is missing.
    """
    if figure is not None and figure not in FIGURES:
        raise ConfigurationError(f"--figure {shown(figure)}: the paper has figures 1 to 7; choose one of them")
    if reading not in READINGS:
        raise ConfigurationError(f"--reading {shown(reading)}: no such reading; {suggestion(reading, READINGS)}")
    if not 1 <= workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    if held_out and not search:
        raise ConfigurationError("--held-out: belongs to a search, and none is asked for; add --search")
    beside = {"--figure": figure is not None, "--no-searches": no_searches, "--variant": bool(variant)}
    beside |= {"--coarse": coarse, "--reading all": reading == "all"}
    if search and any(beside.values()):
        unused = next(option for option, given in beside.items() if given)
        raise ConfigurationError(f"{unused}: a search has its own runs, and no use for it; leave it out")
    variants = _variants(variant or [])
    order = PaperOrder(
        figure, reading, workers, located(out), coarse, not no_searches, variants=variants, held_out=held_out
    )
    return Job(lambda screen: (search_order if search else carry_out_order)(order, screen))


def _variants(names: list[str]) -> tuple[str, ...]:
    from ..scoring.paper.variants import VARIANTS

    return chosen_variants(names, VARIANTS)


def chosen_variants(names: list[str], known: Collection[str]) -> tuple[str, ...]:
    """The variants that are meant, each once. Raises ConfigurationError for one that is not known."""
    for name in names:
        if name not in known and name != "all":
            raise ConfigurationError(f"--variant {shown(name)}: no such variant; {suggestion(name, [*known, 'all'])}")
    return tuple(known) if "all" in names else tuple(dict.fromkeys(names))


def carry_out_order(order: PaperOrder, screen: Screen) -> int:
    """Run, score, write, and say what came out; the exit code."""
    from ..scoring import sources
    from ..scoring.report import lines, scores_of, write_report
    from ..scoring.runs import Bench, carry_out

    begin = time.monotonic()
    screen.if_interrupted = order.if_interrupted
    source = sources.get(order.source)
    names = source.runs_of(order.claims) if order.claims else None
    if order.figure is not None:
        names = next(one.runs for one in source.pictures if one.number == order.figure)
    outcomes: list[Outcome] = []
    for condition, searched in source.conditions(order.sets(source), order.variants, order.coarse):
        bench = Bench(source, order.out / "runs", order.workers, RunProgress(screen, condition.title))
        outcomes.append(carry_out(bench, condition, names, order.searches and order.figure is None and searched))
    page = write_report(source, outcomes, order.out, order.figure, COARSE_NOTE if order.coarse else "")
    spent = time.monotonic() - begin
    answer: dict[str, Any] = {"status": "finished", "written": str(page), "wall_s": round(spent, 1)}
    if order.figure is None:
        scores = scores_of(source, outcomes)
        answer["verdicts"] = {
            title: {source.label(one.claim.number): one.verdict for one in every} for title, every in scores.items()
        }
        screen.table(("claim", "statement", *scores), lines(source, scores))
    screen.answer(answer)
    screen.say(f"written: {spelled(page)} ({spent:.0f} s)")
    return 0


def search_order(order: PaperOrder, screen: Screen) -> int:
    """Search the space of the source, write the table of its points, and say which are best; the exit code."""
    from ..scoring import sources, together
    from ..scoring.regime import Search, table
    from ..scoring.report import write_table
    from ..scoring.runs import Bench, carry_out

    begin = time.monotonic()
    screen.if_interrupted = order.if_interrupted
    source = sources.get(order.source)
    if source.space is None:
        raise ConfigurationError(f"--search: the source {order.source} has no space to search; give it one")
    bench = Bench(source, order.out / "runs", order.workers, RunProgress(screen, "search"))
    search = Search(bench, source.space, order.sets(source)[0], screen.say)
    candidates = search.carry_out()
    found = table(source.claims, source.space, candidates)
    path = write_table(found, order.out)
    asked = [one for one in source.claims if one.number in source.space.objective.claims]
    known = together.points(candidates)
    if order.held_out:
        asked = list(source.claims)
        sets = source.conditions([one.name for one in source.sets])
        readings = [carry_out(bench, condition) for condition, _ in sets]
        known = together.points(search.with_held_out(candidates), readings)
    tables = [make(asked, known) for make in together.TABLES]
    for one in tables:
        write_table(one, order.out)
    spent = time.monotonic() - begin
    screen.table(found.columns[:9], [row[:9] for row in found.rows[:10]])
    screen.table(tables[0].columns, tables[0].rows)
    screen.answer({"status": "finished", "written": str(path), "points": len(found.rows), "wall_s": round(spent, 1)})
    screen.say(f"written: {spelled(path)} and {', '.join(one.name for one in tables)}.csv beside it ({spent:.0f} s)")
    return 0


class RunProgress:
    """One line on stderr for every finished run."""

    def __init__(self, screen: Screen, reading: str) -> None:
        self._screen = screen
        self._reading = reading

    def __call__(self, step: Step) -> None:
        numbers = step.row.summary
        transit = numbers.get("transit_s")
        ended = f"expelled at {transit:.2f} s" if transit is not None else step.row.status.replace("_", " ")
        if numbers.get("error"):
            ended += f": {numbers['error']}"
        kept = " (kept)" if step.kept else ""
        self._screen.line(f"{self._reading} {step.done:3d}/{step.count} {step.row.point.name}: {ended}{kept}")
