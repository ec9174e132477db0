"""`peristalsis bench`: what laboratories measured of the isolated colon, run, scored and written as one page."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import ConfigurationError, shown, suggestion
from ..paths import located
from .job import Job
from .paper_command import MOST_WORKERS, PaperOrder, carry_out_order

EXAMPLES = (
    "peristalsis bench",
    "peristalsis bench --variant constant-friction --variant ungraded",
    "peristalsis bench --coarse --workers 2",
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
            help="Score the preparation with one choice changed as well: ungraded, contact-length, constant-friction, "
            "falling-friction, all-or-none, conducting, late-rise, taut, doubled or all. Can be given more than once.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print exactly one JSON object on stdout, also when something is wrong.")
    ] = False,
) -> Job:
    """Run the assays of an isolated colon and score what was measured there.

    Writes report.html, each table as CSV and each figure as PNG and SVG. Finished runs are kept in DIR/runs: a
    second call, or one after an interruption, runs only what is missing.
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    order = PaperOrder(
        None, "all", workers, located(out), coarse, searches=False, variants=_variants(variant or []), source="bench"
    )
    return Job(lambda screen: carry_out_order(order, screen))


def _variants(names: list[str]) -> tuple[str, ...]:
    """The variants that are meant, each once."""
    from ..scoring.bench.variants import VARIANTS

    for name in names:
        if name not in VARIANTS and name != "all":
            raise ConfigurationError(
                f"--variant {shown(name)}: no such variant; {suggestion(name, [*VARIANTS, 'all'])}"
            )
    return tuple(VARIANTS) if "all" in names else tuple(dict.fromkeys(names))
