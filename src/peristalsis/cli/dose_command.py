"""`peristalsis dose-response`: transit, speed and force of a pellet against the concentration of an agent."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConfigurationError
from ..paths import located
from .inputs import Input
from .job import Job
from .options import Config, Json, Library, Reading, Settings, Workers
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.dose_response import DoseResponse
    from ..many.rows import Step

EXAMPLES = (
    "peristalsis dose-response nifedipine --from '1 nM' --to '1 uM'",
    "peristalsis dose-response 'verapamil in cardiac cells' --from '10 nM' --to '10 uM' --points 7 "
    "--with 'nifedipine 8 nM' --drugs l_type_is_fast --out out/two_agents",
)
"""Examples of the help text."""
MOST_WORKERS = 64


@dataclass(frozen=True)
class DoseOrder:
    """What a command line asks for; texts as they were typed."""

    agent: str
    low: str
    high: str
    points: int
    beside: tuple[str, ...]
    library: str | None
    input: Input
    out: str | None
    workers: int


def dose_response_(
    agent: Annotated[
        str,
        typer.Argument(metavar="AGENT", help="Agent, see peristalsis list drugs; 'AGENT in PREPARATION' for another."),
    ],
    low: Annotated[str, typer.Option("--from", metavar="C", help="Smallest concentration, such as '1 nM'.")],
    high: Annotated[str, typer.Option("--to", metavar="C", help="Largest concentration.")],
    points: Annotated[int, typer.Option("--points", metavar="N", help="Concentrations, evenly on a log axis.")] = 9,
    beside: Annotated[
        list[str] | None,
        typer.Option("--with", metavar="'AGENT AMOUNT'", help="What acts in all runs besides; may be repeated."),
    ] = None,
    library: Library = None,
    name: Annotated[str | None, typer.Option("--scenario", metavar="NAME", help="baseline unless given.")] = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    out: Annotated[
        str | None, typer.Option("--out", metavar="DIR", help="Folder of table, picture and kept runs.")
    ] = None,
    workers: Workers = 1,
    as_json: Json = False,
) -> Job:
    """Run a control and several concentrations of an agent, and lay Hill's curve through speed and force.

    DIR/table.csv has a row for each, with its status where the pellet does not pass; DIR/dose_response.png shows them.
    Bands are 95 %, by resampled residuals; the range of the IC50 is carried through. Finished runs are kept, and a
    second call runs only what is missing. A research model, not medical advice.
    """
    described = Input(name if name or config else "baseline", reading, settings or (), config)
    order = DoseOrder(agent, low, high, points, tuple(beside or ()), library, described, out, workers)
    return Job(lambda screen: carry_out(order, screen), name)


def carry_out(order: DoseOrder, screen: Screen) -> int:
    """Run what is missing, write table and picture, say what came out."""
    from ..many.dose_response import dose_response
    from ..plots.placing import whole_in_folder

    if not 1 <= order.workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {order.workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    configuration = order.input.configuration()
    screen.scenario = configuration.scenario
    target = Path("out", f"dose_{'_'.join(order.agent.split())}") if order.out is None else located(order.out)
    screen.if_interrupted = f"interrupted; finished runs are kept in {spelled(target)}: call again to go on"

    def progress(step: Step) -> None:
        transit = step.row.summary.get("transit_s")
        ended = f"expelled at {transit:.4g} s" if transit is not None else step.row.status.replace("_", " ")
        screen.line(f"{step.done:3d}/{step.count} {step.row.point.name}: {ended}{' (kept)' if step.kept else ''}")

    found = dose_response(
        order.agent,
        order.low,
        order.high,
        scenario=configuration,
        points=order.points,
        beside=order.beside,
        library_file=order.library,
        out=target,
        workers=order.workers,
        progress=progress,
    )
    table, picture = target / "table.csv", target / "dose_response.png"
    with whole_in_folder(table) as temporary:
        temporary.write_text(found.csv(), encoding="utf-8")
    with whole_in_folder(picture) as temporary:
        found.figure().savefig(temporary)
    _say(found, screen)
    screen.say(f"written: {spelled(table)}\nwritten: {spelled(picture)}")
    answer: dict[str, Any] = {"status": "finished", **found.numbers(), "files": [str(table), str(picture)]}
    screen.answer(answer)
    return 0


def _say(found: DoseResponse, screen: Screen) -> None:
    from ..inputs.drugs import NOT_ADVICE, amount, mixed

    screen.table(
        ("concentration", "status", "transit", "mean speed", "largest force"),
        (
            (name, row.status.replace("_", " "), *(_cell(row.summary.get(key), unit) for key, unit in _COLUMNS))
            for name, row in zip(
                ("none", *map(amount, found.concentrations)), (found.control, *found.rows), strict=True
            )
        ),
        title=f"{found.agent} ({NOT_ADVICE})",
    )
    for name, curve in found.curves.items():
        if curve.half is None or curve.half_band is None or curve.slope_band is None:
            screen.say(f"{name}: no half effect: {curve.reason}")
            continue
        whole = found.whole_band(name)
        assert whole is not None
        half = found.half_concentration(name)
        screen.say(
            f"{name}: EC50 {amount(curve.half)} ({amount(curve.half_band[0])} to {amount(curve.half_band[1])}; with "
            f"the range of the IC50 {amount(whole[0])} to {amount(whole[1])}), slope {curve.slope:.3g} "
            f"({curve.slope_band[0]:.3g} to {curve.slope_band[1]:.3g}), approaching "
            f"{100.0 * (curve.bottom or 0.0):.3g} % of the control; half of the control "
            f"{'is not reached' if half is None else f'at {amount(half)}'}"
            + (f"; {curve.reason}" if curve.reason else "")
        )
    if found.uncertainty is None:
        screen.say("no source gives a range of the IC50: the true uncertainty is larger than these bands")
    for dose in found.doses:
        screen.say(dose.words())
    said = mixed(found.doses)
    if said is not None:
        screen.say(said)


_COLUMNS = (("transit_s", "s"), ("mean_velocity_cm_s", "cm/s"), ("max_axial_force_mN", "mN"))


def _cell(value: object, unit: str) -> str:
    return f"{value:.4g} {unit}" if isinstance(value, float) else ""
