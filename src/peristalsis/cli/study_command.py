"""Commands of many runs: their options and help. Each returns a Job; `batching` and `studying` carry it out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import typer

from ..errors import ConfigurationError, shown
from .job import Job
from .options import Drugs, Json, Library, Workers
from .orders import StudyOrder

MOST_WORKERS = 64

EXAMPLES: dict[str, tuple[str, ...]] = {
    "batch": ("peristalsis batch friction.toml", "peristalsis batch friction.toml --workers 2 --out out/friction"),
    "sweep": (
        "peristalsis sweep examples/friction_study.toml",
        "peristalsis sweep examples/friction_study.toml --workers 2 --parquet",
        "peristalsis sweep examples/friction_study.toml --scheduler tcp://127.0.0.1:8786",
    ),
    "stall-map": ("peristalsis stall-map examples/stall_map.toml --workers 2",),
    "sensitivity": (
        "peristalsis sensitivity examples/sensitivity.toml --workers 2",
        "peristalsis sensitivity examples/sensitivity.toml --method pawn --reading edge",
    ),
    "cohort": ("peristalsis cohort examples/cohort.toml --workers 2",),
    "kept": ("peristalsis kept", "peristalsis kept out/kept --clean stale", "peristalsis kept out/kept --clean all"),
}
"""Examples of the help texts, by command."""

File = Annotated[str, typer.Argument(metavar="STUDY.toml", help="What is varied and how; see docs/studies.md.")]
Out = Annotated[
    str | None, typer.Option("--out", metavar="DIR", help="Folder of the tables; out/NAME of the file unless given.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler", metavar="tcp://HOST:PORT", help="A Dask scheduler whose workers run instead; extra cluster."
    ),
]
Kept = Annotated[
    str | None,
    typer.Option("--kept", metavar="DIR", help="Folder of kept runs; `kept` beside that of the tables unless given."),
]
Reading = Annotated[
    str | None,
    typer.Option("--reading", metavar="R", help="Reading of the paper's doubtful numbers, instead of the file's."),
]
Parquet = Annotated[bool, typer.Option("--parquet", help="Write the table as Parquet too; extra studies.")]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Draw no pictures.")]


def workers_of(workers: int, scheduler: str | None) -> int | str:
    """Who runs. Raises ConfigurationError for what is neither a number of processes nor an address."""
    if scheduler is not None:
        if "://" not in scheduler:
            raise ConfigurationError(
                f"--scheduler {shown(scheduler)}: not an address; give one such as tcp://127.0.0.1:8786"
            )
        return scheduler
    if not 1 <= workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    return workers


def batch(
    file: Annotated[str, typer.Argument(metavar="FILE", help="TOML file: scenario, changes, and a grid or points.")],
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Folder of the runs and their table; out/NAME of FILE unless given."),
    ] = None,
    drug: Drugs = None,
    drugs: Library = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    as_json: Json = False,
) -> Job:
    """Run every point of a batch file.

    Each run has a folder in DIR/runs; DIR/table.csv has a row for each. Runs that fail are rows with their reason.
    A second call, or one after an interruption or a crash, runs only what is missing.
    """
    from .batching import batch as carry_out

    chosen = workers_of(workers, scheduler)
    return Job(lambda screen: carry_out(file, out, chosen, screen, drug or (), drugs))


def sweep(
    file: File,
    out: Out = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    kept: Kept = None,
    reading: Reading = None,
    parquet: Parquet = False,
    no_plots: NoPlots = False,
    as_json: Json = False,
) -> Job:
    """Run a study: one table, a row for every point.

    Designs: grid, list, random, Latin hypercube, Sobol'. DIR/table.csv has parameters, status, outputs and hash. A
    run that stalls, diverges or is refused is a row with its reason. A second call, or one with more samples or
    outputs, runs only what is missing.
    """
    from .studying import sweep as carry_out

    order = StudyOrder(file, out, workers_of(workers, scheduler), kept, parquet, not no_plots, reading)
    return Job(lambda screen: carry_out(order, screen))


def stall_map(
    file: File,
    out: Out = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    kept: Kept = None,
    reading: Reading = None,
    no_plots: NoPlots = False,
    as_json: Json = False,
) -> Job:
    """Map where pellets stall, or any classes, over two parameters.

    Runs are made along the boundaries only. DIR/map.csv has the class of every node, DIR/boundary.csv the boundaries.
    """
    from .studying import stall_map as carry_out

    order = StudyOrder(file, out, workers_of(workers, scheduler), kept, plots=not no_plots, reading=reading)
    return Job(lambda screen: carry_out(order, screen))


def sensitivity(
    file: File,
    method: Annotated[
        str | None,
        typer.Option("--method", metavar="sobol|morris|pawn", help="That of the file unless given, else sobol."),
    ] = None,
    out: Out = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    kept: Kept = None,
    reading: Reading = None,
    no_plots: NoPlots = False,
    as_json: Json = False,
) -> Job:
    """Rank parameters by what they do to each output.

    Sobol' indices with bands, elementary effects (Morris), or PAWN, which is defined where pellets stall too. The cost
    is stated beforehand. DIR/indices.csv has every index with its band and the rank.
    """
    from .studying import sensitivity as carry_out

    order = StudyOrder(file, out, workers_of(workers, scheduler), kept, plots=not no_plots, reading=reading)
    return Job(lambda screen: carry_out(order, method, screen))


def cohort(
    file: Annotated[str, typer.Argument(metavar="COHORT.toml", help="Distributions, rules, interventions.")],
    out: Out = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    kept: Kept = None,
    reading: Reading = None,
    no_plots: NoPlots = False,
    as_json: Json = False,
) -> Job:
    """Run a cohort: a population of members, and what interventions shift in it.

    Members are drawn from distributions and kept if they pass the stated rules. DIR/shifts.csv has, for each
    intervention, who expels the pellet, and how transit shifts, member by member. A research model, not medical advice.
    """
    from .studying import cohort as carry_out

    order = StudyOrder(file, out, workers_of(workers, scheduler), kept, plots=not no_plots, reading=reading)
    return Job(lambda screen: carry_out(order, screen))


def kept(
    folder: Annotated[str, typer.Argument(metavar="[DIR]", help="Folder of kept runs.")] = "out/kept",
    clean: Annotated[
        str | None,
        typer.Option(
            "--clean", metavar="stale|damaged|all", help="Remove those of other versions, damaged ones, or all."
        ),
    ] = None,
    as_json: Json = False,
) -> Job:
    """Count the kept runs of studies, check their hashes, or remove them."""
    from .studying import kept as carry_out

    return Job(lambda screen: carry_out(folder, clean, screen))


COMMANDS: dict[str, Callable[..., Job]] = {
    "batch": batch,
    "sweep": sweep,
    "stall-map": stall_map,
    "sensitivity": sensitivity,
    "cohort": cohort,
    "kept": kept,
}
"""The commands by name."""
