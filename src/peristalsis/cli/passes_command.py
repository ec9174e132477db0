"""`peristalsis passes`: pellets one after the other through the same segment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import DivergenceError
from ..paths import located
from .inputs import Input
from .job import Job
from .options import Config, Drugs, Json, Library, MaybeName, Reading, Settings
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.passes import Pass

EXAMPLES = (
    "peristalsis passes guinea_pig",
    "peristalsis passes guinea_pig --count 5 --rest '180 s' --out out/trials",
)
"""Examples of the help text."""


def passes_(
    name: MaybeName = None,
    count: Annotated[int, typer.Option("--count", metavar="N", help="Passes.")] = 3,
    rest: Annotated[
        str, typer.Option("--rest", metavar="T", help="From the end of a pass to the beginning of the next.")
    ] = "60 s",
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    drugs: Drugs = None,
    library: Library = None,
    out: Annotated[str | None, typer.Option("--out", metavar="DIR", help="Folder of table and picture.")] = None,
    as_json: Json = False,
) -> Job:
    """Pass a pellet through the same segment again and again.

    The next one enters when the one before is out, on the tissue and the wall that it left. Writes passes.csv, a row a
    pass, and passes.png.
    """
    described = Input(
        name if name or config else "guinea_pig", reading, settings or (), config, drugs=drugs or (), library=library
    )
    return Job(lambda screen: carry_out(described, count, rest, out, screen), name)


def carry_out(described: Input, count: int, rest: str, out: str | None, screen: Screen) -> int:
    """Make the passes, write the table after each of them and the picture at the end, say what came out."""
    from ..many.passes import passes, passes_csv
    from ..plots.placing import whole_in_folder

    configuration = described.configuration()
    screen.scenario = configuration.scenario
    target = Path("out", f"{configuration.scenario}_passes") if out is None else located(out)

    table, picture = target / "passes.csv", target / "passes.png"
    over: list[Pass] = []

    def progress(one: Pass) -> None:
        transit = one.result.summary["transit_s"]
        ended = f"expelled after {transit:.4g} s" if transit is not None else one.result.status.replace("_", " ")
        over.append(one)
        with whole_in_folder(table) as temporary:
            temporary.write_text(passes_csv(over), encoding="utf-8")
        screen.if_interrupted = f"interrupted; passes that are over stand in {spelled(table)}"
        screen.line(f"pass {one.number} of {count}: {ended}")

    found = passes(configuration, count=count, rest=rest, progress=progress)
    with whole_in_folder(picture) as temporary:
        found.figure().savefig(temporary)
    rows = found.rows()
    shown: list[tuple[str, ...]] = [
        (
            str(row["pass"]),
            f"{row['begins_s']:.4g} s",
            str(row["status"]).replace("_", " "),
            "–" if row["transit_s"] is None else f"{row['transit_s']:.4g} s",
            f"{10.0 * row['middle_speed_cm_s']:.3g} mm/s",
        )
        for row in rows
    ]
    screen.table(("pass", "begins", "status", "transit", "speed in the middle"), shown)
    screen.say(f"written: {spelled(table)}\nwritten: {spelled(picture)}")
    answer: dict[str, Any] = {"passes": rows, "files": [str(table), str(picture)]}
    broken = found.passes[-1].result.error
    if broken is not None:
        return screen.fail(DivergenceError(f"pass {len(rows)}: {broken}"), answer)
    screen.answer({"status": "finished", **answer})
    return 0
