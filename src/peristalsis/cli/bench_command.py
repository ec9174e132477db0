"""`peristalsis bench`: what laboratories measured of the isolated colon, run, scored and written as one page."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from ..errors import ConfigurationError
from ..paths import located
from .job import Job
from .options import Json
from .paper_command import COARSE_NOTE, MOST_WORKERS, PaperOrder, RunProgress, carry_out_order, chosen_variants
from .streams import Screen, spelled

EXAMPLES = (
    "peristalsis bench",
    "peristalsis bench --variant constant-friction --variant ungraded",
    "peristalsis bench --claim 2 --variant taut --variant late-rise --out out/taut",
    "peristalsis bench --coarse --workers 2",
    "peristalsis bench --calibrate --out out/calibration",
)


def bench(
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Processes that run at a time.")] = 2,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder of the report and of the kept runs.")] = (
        "out/bench"
    ),
    coarse: Annotated[bool, typer.Option("--coarse", help="Coarse grids, for a quick look only.")] = False,
    variant: Annotated[
        list[str] | None,
        typer.Option(
            "--variant",
            metavar="V",
            help="Score the preparation with one choice changed as well: ungraded, contact-length, "
            "constant-friction, falling-friction, all-or-none, conducting, calcium, late-rise, "
            "taut, doubled or all. Can be given more than once.",
        ),
    ] = None,
    claim: Annotated[
        list[int] | None,
        typer.Option("--claim", metavar="N", help="Only the runs that claim N needs. Can be given more than once."),
    ] = None,
    calibrate: Annotated[
        bool,
        typer.Option(
            "--calibrate",
            help="Instead of scoring: which constants the measurements fix and which they leave free (some ten "
            "minutes of a processor).",
        ),
    ] = False,
    as_json: Json = False,
) -> Job:
    """Run the assays of an isolated colon and score what was measured there.

    Writes report.html, each table as CSV and each figure as PNG and SVG. Finished runs are kept in DIR/runs: a
    second call, or one after an interruption, runs only what is missing.
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    order = PaperOrder(
        None,
        "all",
        workers,
        located(out),
        coarse,
        searches=False,
        variants=_variants(variant or []),
        source="bench",
        claims=_claims(claim or []),
    )
    if calibrate and (order.variants or order.claims):
        other = "--variant" if order.variants else "--claim"
        raise ConfigurationError(f"--calibrate and {other}: what is calibrated stands in its file; leave one out")
    return Job(lambda screen: (calibrate_order if calibrate else carry_out_order)(order, screen))


def calibrate_order(order: PaperOrder, screen: Screen) -> int:
    """Calibrate, write the page of what came out, and say which constants are fixed; the exit code."""
    from ..scoring import calibrated, sources
    from ..scoring.calibration import Search, good_points
    from ..scoring.report import write_page
    from ..scoring.runs import Bench

    begin = time.monotonic()
    screen.if_interrupted = order.if_interrupted
    source = sources.get(order.source)
    assert source.calibration is not None
    plan, claims = source.calibration(), source.claims
    bench = Bench(source, order.out / "runs", order.workers, RunProgress(screen, "calibration"))
    grids = source.coarse if order.coarse else {}
    found = Search(bench, plan, source.sets[0], grids, screen.say).carry_out()
    tables = [
        make(claims, plan, found)
        for make in (calibrated.constants, calibrated.combinations, calibrated.predicted, calibrated.points)
    ]
    note = COARSE_NOTE if order.coarse else ""
    picture = calibrated.picture(claims, plan, found)
    page = write_page(source, tables, [picture], (), order.out / "calibration.html", note)
    spent = time.monotonic() - begin
    for one in tables[:3]:
        screen.table(one.columns, one.rows)
    good = len(good_points(claims, plan, found))
    screen.answer(
        {"status": "finished", "written": str(page), "points": len(found), "hold": good, "wall_s": round(spent, 1)}
    )
    screen.say(f"{good} of {len(found)} points hold; written: {spelled(page)} ({spent:.0f} s)")
    return 0


def _variants(names: list[str]) -> tuple[str, ...]:
    from ..scoring.bench.variants import VARIANTS

    return chosen_variants(names, VARIANTS)


def _claims(numbers: list[int]) -> tuple[int, ...]:
    """The claims that are meant, each once."""
    from ..scoring.bench.claims import CLAIMS

    known = [one.number for one in CLAIMS]
    for number in numbers:
        if number not in known:
            raise ConfigurationError(f"--claim {number}: no such claim; there are {', '.join(map(str, known))}")
    return tuple(dict.fromkeys(numbers))
