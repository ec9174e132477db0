"""`peristalsis cell`: one cell shown, run, made from a file of another program, or written for one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConfigurationError, could_not
from ..paths import located
from .job import Job
from .options import Json
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..cells.description import Description
    from ..cells.single import Stimulus

FOREIGN = (".cellml", ".xml", ".sbml", ".mmt")

EXAMPLES = {
    "": ("peristalsis cell show du_2013", "peristalsis cell run du_2013 --duration '60 s'"),
    "show": ("peristalsis cell show corrias_buist_2007", "peristalsis cell show my_cell.py"),
    "run": (
        "peristalsis cell run du_2013 --duration '60 s'",
        "peristalsis cell run hodgkin_huxley --stimulus '10 uA/cm^2' --duration '50 ms'",
    ),
    "import": ("peristalsis cell import model.cellml --out my_cell.py",),
    "export": ("peristalsis cell export plant --out plant.mmt", "peristalsis cell export plant --out plant.cellml"),
}

Cell = Annotated[
    str, typer.Argument(metavar="NAME|FILE", help="A shipped cell, a description, or a file of another program.")
]


def _epilog(command: str) -> str:
    return "\n".join(("\b", "Examples:", *EXAMPLES[command]))


app = typer.Typer(
    name="cell",
    help="One cell: show it, run it, make it from CellML, SBML or .mmt, write it as CellML 2 or .mmt.",
    epilog=_epilog(""),
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.command("show", epilog=_epilog("show"))
def show(cell: Cell, as_json: Json = False) -> Job:
    """States, channels and constants of a cell, with units and sources."""
    return Job(lambda screen: _show(cell, screen))


@app.command("run", epilog=_epilog("run"))
def run(
    cell: Cell,
    duration: Annotated[str, typer.Option("--duration", metavar="TIME", help="How long.")] = "1 s",
    sampling: Annotated[
        str | None,
        typer.Option("--sampling", metavar="TIME", help="Interval kept; 1/1000 of the duration unless given."),
    ] = None,
    stimulus: Annotated[
        str, typer.Option("--stimulus", metavar="CURRENT", help="Current, inward positive.")
    ] = "0 uA/cm^2",
    begin: Annotated[str, typer.Option("--from", metavar="TIME", help="Beginning of the stimulus.")] = "0 ms",
    span: Annotated[
        str | None, typer.Option("--for", metavar="TIME", help="Length of the stimulus; to the end unless given.")
    ] = None,
    every: Annotated[
        str | None, typer.Option("--every", metavar="TIME", help="Period of the stimulus; once unless given.")
    ] = None,
    out: Annotated[str | None, typer.Option("--out", metavar="DIR", help="Folder; out/cell_NAME unless given.")] = None,
    as_json: Json = False,
) -> Job:
    """Run one cell by the kernels of the tissue; a CSV and a picture.

    The step is halved until the potential changes by less than 0.02 % of its range. A file of another program is
    imported first, and compared with Myokit's simulation of it.
    """
    from ..units import parse

    total = parse(duration, "ms", "--duration")
    kept = total / 1000.0 if sampling is None else parse(sampling, "ms", "--sampling")
    if not total > 0.0 or not 0.0 < kept <= total:
        raise ConfigurationError("--duration and --sampling must be above 0, and the sampling no longer than the run")
    amount = parse(stimulus, "uA/cm^2", "--stimulus")
    first, lasting = parse(begin, "ms", "--from"), total if span is None else parse(span, "ms", "--for")
    period = 0.0 if every is None else parse(every, "ms", "--every")
    if lasting < 0.0 or period < 0.0:
        raise ConfigurationError("--for and --every must not be below 0")
    folder = located(f"out/cell_{Path(cell).stem}" if out is None else out)
    return Job(lambda screen: _run(cell, total, kept, (amount, first, lasting, period), folder, screen))


@app.command("import", epilog=_epilog("import"))
def import_(
    file: Annotated[str, typer.Argument(metavar="FILE", help="CellML 1.0 to 2.0, SBML or .mmt.")],
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="FILE", help="The description; the name of the file with .py unless given."),
    ] = None,
    duration: Annotated[str, typer.Option("--duration", metavar="TIME", help="How long to compare.")] = "1 s",
    as_json: Json = False,
) -> Job:
    """Make a description of a cell from a file of another program, and compare it with Myokit's simulation."""
    from ..units import parse

    span = parse(duration, "ms", "--duration")
    if not span > 0.0:
        raise ConfigurationError(f"--duration = {duration} must be above 0")
    target = None if out is None else located(out)
    return Job(lambda screen: _import(located(file), target, span, screen))


@app.command("export", epilog=_epilog("export"))
def export(
    cell: Cell,
    out: Annotated[
        str | None, typer.Option("--out", metavar="FILE", help="Ends with .cellml or .mmt; NAME.cellml unless given.")
    ] = None,
    as_json: Json = False,
) -> Job:
    """Write a shipped cell or a description as CellML 2 (by Myokit) or as .mmt (which needs nothing)."""
    target = located(f"{Path(cell).stem}.cellml" if out is None else out)
    return Job(lambda screen: _export(cell, target, screen))


def _import(file: Path, target: Path | None, duration: float, screen: Screen) -> int:
    from ..cells.importing import import_cell

    found = import_cell(file, target, duration=duration)
    anatomy = found.anatomy
    for remark in anatomy.remarks:
        screen.line(f"  {remark}")
    for name in anatomy.stimuli:
        screen.line(f"  stimulus left out of the cell: {name}")
    answer: dict[str, Any] = {
        "status": "finished",
        "written": str(found.file),
        "gates": [gate.state.qname() for gate in anatomy.gates],
        "states": [other.state.qname() for other in anatomy.others],
        "channels": [channel.name for channel in anatomy.channels],
        "stimuli_left_out": anatomy.stimuli,
        "largest_difference_of_rates": found.rates,
        "largest_difference_of_potential": found.trace,
        "reference": found.solver,
    }
    screen.answer(answer)
    screen.say(
        f"{spelled(found.file)}: {len(anatomy.gates)} gates, {len(anatomy.others)} other states, "
        f"{len(anatomy.channels)} currents; potential within {found.trace:.1e} of its range of {found.solver} over "
        f"{found.duration:g} ms"
    )
    return 0


def _export(cell: str, target: Path, screen: Screen) -> int:
    from ..cells.exporting import export as write

    write(cell, target)
    screen.answer({"status": "finished", "written": str(target)})
    screen.say(f"{cell} is written to {spelled(target)}")
    return 0


def _show(name: str, screen: Screen) -> int:
    cell = _described(name, screen)
    module: Any = cell.module
    numbers = [*module.CONDUCTANCES, *getattr(module, "PARAMETERS", ())]
    rows = [
        [one.name, f"{one.value:g}", one.unit, one.description, one.source] for one in numbers if hasattr(one, "unit")
    ]
    screen.line(f"{cell.name}: {cell.title}")
    screen.line(f"gates: {', '.join(cell.states[: module.GATES]) or 'none'}")
    screen.line(f"other states: {', '.join(cell.states[module.GATES :]) or 'none'}")
    screen.line(f"channels: {', '.join(module.CHANNELS)}; range {module.LOWEST:g} to {module.HIGHEST:g} mV")
    screen.table(("name", "value", "unit", "what", "source"), rows)
    screen.answer(
        {
            "status": "finished",
            "name": cell.name,
            "title": cell.title,
            "states": list(cell.states),
            "gates": module.GATES,
            "channels": list(module.CHANNELS),
            "numbers": {one.name: {"value": one.value, "unit": one.unit} for one in numbers if hasattr(one, "unit")},
        }
    )
    return 0


def _described(name: str, screen: Screen) -> Description:
    """A shipped cell, a description, or a foreign file, which is imported beside the results first."""
    from ..cells.description import described

    if name == "plant":
        raise ConfigurationError(
            "plant has kernels of its own; see its numbers with peristalsis show baseline cell, or export it as .mmt"
        )
    if Path(name).suffix.lower() in FOREIGN:
        import tempfile

        from ..cells.importing import import_cell

        with tempfile.TemporaryDirectory() as folder:
            found = import_cell(located(name), Path(folder) / f"{Path(name).stem}.py")
            screen.line(f"imported; potential within {found.trace:.1e} of its range of {found.solver}")
            return found.cell
    return described(str(located(name)) if name.endswith(".py") else name)


def _run(
    name: str, duration: float, sampling: float, given: tuple[float, float, float, float], folder: Path, screen: Screen
) -> int:
    from ..cells.pictures import keep
    from ..cells.single import converged, pulses, quiet, upstrokes

    compared = None
    if Path(name).suffix.lower() in FOREIGN:
        from ..cells.importing import import_cell

        file = folder / f"{Path(name).stem}.py"
        imported = import_cell(located(name), file)
        cell = imported.cell
        compared = imported.anatomy
    else:
        cell = _described(name, screen)
    stimulus: Stimulus = quiet if given[0] == 0.0 else pulses(*given)
    trace = converged(cell, duration, sampling, stimulus)
    reference, difference, solver = None, None, None
    if compared is not None:
        from ..cells.importing import reference_trace

        reference, solver = reference_trace(compared, trace.times, given)
        span = max(float(reference.max() - reference.min()), 1.0)
        difference = float(abs(trace.potential - reference).max()) / span
    beats = upstrokes(trace)
    period = float((beats[-1] - beats[0]) / (beats.size - 1)) if beats.size > 1 else None
    try:
        files = keep(cell, trace, folder, reference, solver)
    except OSError as error:
        raise could_not(f"write {spelled(folder)}", error, "another place with --out") from None
    low, high = float(trace.potential.min()), float(trace.potential.max())
    screen.answer(
        {
            "status": "finished",
            "lowest_potential": low,
            "highest_potential": high,
            "upstrokes": beats.tolist(),
            "period": period,
            "step": trace.step,
            "difference": difference,
            "reference": solver,
            "written": [str(file) for file in files],
        }
    )
    said = f"{cell.name}: {low:.1f} to {high:.1f} mV in steps of {trace.step:g} ms"
    said += f", {beats.size} upstrokes" + (f" every {period:g} ms" if period is not None else "")
    if difference is not None:
        said += f"; within {difference:.1e} of the range of {solver}"
    screen.say(f"{said}; {', '.join(spelled(file) for file in files)}")
    return 0
