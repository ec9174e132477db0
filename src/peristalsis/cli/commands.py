"""The commands as typer sees them: arguments, options and help. Each returns a Job; nothing is done here."""

from __future__ import annotations

from typing import Annotated

import typer

from .app_command import app_
from .bench_command import bench
from .cell_command import app as cell_app
from .dose_command import dose_response_
from .fit_command import fit_
from .help import EXAMPLES as EXAMPLES
from .help import WITHOUT_WORDS as WITHOUT_WORDS
from .help import epilog
from .inputs import Input
from .job import Job
from .map_command import map_
from .options import Config, Drugs, Folder, Json, Library, MaybeName, Name, Overwrite, Reading, Settings
from .paper_command import paper
from .passes_command import passes_
from .study_command import COMMANDS as STUDIES

app = typer.Typer(
    name="peristalsis",
    help="Electromechanical model of colonic propulsion: waves in two muscle layers, a soft wall, a pellet.",
    epilog=epilog(""),
    add_completion=False,
    rich_markup_mode=None,  # brackets in the texts are meant
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
    plugin: Annotated[
        list[str] | None,
        typer.Option(
            "--plugin", metavar="FILE", help="Your own part, such as a cell, output, scenario or figure; repeat."
        ),
    ] = None,
) -> Job | None:
    """Electromechanical model of colonic propulsion: waves in two muscle layers, a soft wall, a pellet."""
    if context.invoked_subcommand is not None:
        return None
    if not show_version:
        raise typer.BadParameter("no command is given")
    from .showing import version

    return Job(version)


@app.command("run", epilog=epilog("run"))
def run_(
    name: MaybeName = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    drug: Drugs = None,
    drugs: Library = None,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Folder of the result; out/NAME unless given."),
    ] = None,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on from what an earlier run to this folder left, if anything."),
    ] = False,
    integrator: Annotated[
        str | None,
        typer.Option(
            "--integrator",
            metavar="implicit|explicit",
            help="How wall and pellet are stepped; explicit is the paper's scheme, with inertia. Same as "
            "--set solver.integrator=...",
        ),
    ] = None,
    certain: Annotated[
        bool,
        typer.Option(
            "--certain",
            help="Run the doubled grid and the halved steps too, and say whether they agree; five times the cost.",
        ),
    ] = False,
    workers: Annotated[
        int, typer.Option("--workers", metavar="N", help="Processes for the two runs of --certain: 1 or 2.")
    ] = 1,
    as_json: Json = False,
    no_plots: Annotated[bool, typer.Option("--no-plots", help="Draw no pictures.")] = False,
) -> Job:
    """Run a scenario, store its result, draw its pictures.

    The folder holds result.nc (every output with its unit), summary.json, config.toml and pictures. It
    appears complete or not at all. A run that diverges or is interrupted stores its history up to that point.
    Checkpoints are written on the way: after a kill or a crash, --resume goes on from the last one; the result is
    bit-identical.
    """
    from .running import Order, run

    described = Input(name, reading, settings or (), config, integrator, drug or (), drugs)
    order = Order(described, out, overwrite, not no_plots, resume, certain, workers)
    return Job(lambda screen: run(order, screen), name)


@app.command("list", epilog=epilog("list"))
def list_(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]", help="scenarios, readings, drugs, cells, activations, laws, muscles or shapes."
        ),
    ] = None,
    as_json: Json = False,
) -> Job:
    """List scenarios and readings, or the cells, laws, shapes and other parts that can be chosen.

    Each scenario with what is expected of it, each reading of the paper with its reason; parts with their numbers.
    """
    from .listing import listed

    return Job(lambda screen: listed(what, screen))


@app.command("show", epilog=epilog("show"))
def show_(
    name: Name,
    section: Annotated[
        str | None,
        typer.Argument(metavar="[SECTION]", help="Section or parameter, such as pellet; all unless given."),
    ] = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    drug: Drugs = None,
    drugs: Library = None,
    toml: Annotated[bool, typer.Option("--toml", help="Write the configuration file instead of a table.")] = False,
    as_json: Json = False,
) -> Job:
    """Show every parameter of a scenario.

    Its value and unit, its tag, its source, and what the paper prints where that is in doubt.
    """
    from .showing import show

    described = Input(name, reading, settings or (), config, None, drug or (), drugs)
    return Job(lambda screen: show(described, section, toml, screen), name)


@app.command("schema", epilog=epilog("schema"))
def schema_(as_json: Json = False) -> Job:
    """Print the JSON Schema of configuration files."""
    from .showing import schema

    return Job(schema)


@app.command("validate", epilog=epilog("validate"))
def validate_(
    file: Annotated[str, typer.Argument(metavar="FILE", help="TOML file of parameters.")],
    as_json: Json = False,
) -> Job:
    """Check a configuration file.

    Nothing is run. Exit code 0 if the file is valid, 2 if not.
    """
    from .showing import validate

    return Job(lambda screen: validate(file, screen))


@app.command("cite", epilog=epilog("cite"))
def cite_(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Scenario, or folder of a stored run.")],
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    drug: Drugs = None,
    drugs: Library = None,
    as_json: Json = False,
) -> Job:
    """List the sources of a run's numbers.

    And the numbers that a scenario or a user changed.
    """
    from .showing import cite

    return Job(lambda screen: cite(Input(name, reading, settings or (), config, None, drug or (), drugs), screen), name)


@app.command("plot", epilog=epilog("plot"))
def plot_(
    folder: Folder,
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAMES]...", help="Figures, such as overview; all unless given."),
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option("--format", metavar="png|svg|pdf", help="File format, png unless given. May be repeated."),
    ] = None,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Folder of the pictures; FOLDER unless given."),
    ] = None,
    as_json: Json = False,
) -> Job:
    """Draw the figures of a stored run again.

    Those of the same name are replaced.
    """
    from .stored import plot

    return Job(lambda screen: plot(folder, names or (), formats or (), out, screen))


@app.command("film", epilog=epilog("film"))
def film_(
    folder: Folder,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="FILE", help="A .gif, or .mp4 where ffmpeg is; FOLDER/film.gif unless given."),
    ] = None,
    frames: Annotated[int, typer.Option("--frames", metavar="N", help="Frames, spread evenly over the run.")] = 100,
    rate: Annotated[int, typer.Option("--rate", metavar="N", help="Frames a second.")] = 20,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Write a film of a stored run: wall and pellet."""
    from .stored import film

    return Job(lambda screen: film(folder, out, overwrite, screen, frames, rate))


@app.command("scene", epilog=epilog("scene"))
def scene_(
    folder: Folder,
    out: Annotated[
        str | None,
        typer.Option(
            "--out", metavar="FILE", help="A picture (.png) or film (.gif, .mp4); FOLDER/scene.png unless given."
        ),
    ] = None,
    time: Annotated[
        str | None,
        typer.Option(
            "--time", metavar="T", help="Time of a picture, such as '1.2 s'; of the hardest contact unless given."
        ),
    ] = None,
    colour: Annotated[
        str, typer.Option("--colour", metavar="FIELD", help="Output that colours the wall.")
    ] = "stretch_circumferential",
    rate: Annotated[int, typer.Option("--rate", metavar="N", help="Frames a second of a film.")] = 15,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Draw a stored run in space: the wall cut open, the pellet in it.

    Needs the extra `surface`; without it, or without graphics libraries, it says what is missing.
    """
    from .stored import scene

    return Job(lambda screen: scene(folder, out, time, colour, overwrite, screen, rate))


@app.command("export", epilog=epilog("export"))
def export_(
    folder: Folder,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Folder of the files; FOLDER/csv or FOLDER/vtk unless given."),
    ] = None,
    kind: Annotated[
        str, typer.Option("--format", metavar="csv|vtk", help="Tables, or moving surfaces for ParaView.")
    ] = "csv",
    every: Annotated[
        str | None,
        typer.Option("--every", metavar="T", help="Time between rows, such as '10 ms'; all rows unless given."),
    ] = None,
    fields: Annotated[
        list[str] | None,
        typer.Option(
            "--field", metavar="FIELD", help="A map to write, or 'all'; may be repeated. Diameter alone unless given."
        ),
    ] = None,
    compress: Annotated[bool, typer.Option("--compress", help="Write .csv.gz files.")] = False,
    units: Annotated[
        str | None,
        typer.Option("--units", metavar="U,U,...", help="Units of the tables, such as 'mm,Pa,N', or SI."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Write a stored run for other programs.

    Its numbers as CSV tables, or wall and pellet as VTK surfaces: open wall.pvd and pellet.pvd in ParaView.
    """
    from .stored import export

    return Job(lambda screen: export(folder, kind, out, overwrite, screen, every, fields or [], compress, units))


@app.command("bundle", epilog=epilog("bundle"))
def bundle_(
    folder: Folder,
    out: Annotated[
        str | None, typer.Option("--out", metavar="FILE", help="The zip; FOLDER.zip beside the folder unless given.")
    ] = None,
    agent: Annotated[str | None, typer.Option("--agent", metavar="NAME", help="Who ran it.")] = None,
    licence: Annotated[
        str | None, typer.Option("--license", metavar="URL", help="Address of the licence of the results.")
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Write a stored run as one file for an archive.

    A zip with its files and their description as an RO-Crate (profile Process Run Crate), which repositories read.
    """
    from .stored import bundle

    return Job(lambda screen: bundle(folder, out, agent, licence, overwrite, screen))


@app.command("compare", epilog=epilog("compare"))
def compare_(
    runs: Annotated[list[str], typer.Argument(metavar="RUN RUN...", help="Folders of stored runs.")],
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Also draw tracks, and diameter less that of the first run."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Compare stored runs: numbers side by side.

    And the parameters in which the runs differ.
    """
    from .stored import compare

    return Job(lambda screen: compare(runs, out, overwrite, screen))


@app.command("check", epilog=epilog("check"))
def check_(
    folders: Annotated[list[str], typer.Argument(metavar="FOLDER...", help="Folders of stored runs.")],
    quarantine: Annotated[
        bool, typer.Option("--quarantine", help="Move damaged ones aside, to FOLDER.damaged-TIME; nothing is deleted.")
    ] = False,
    as_json: Json = False,
) -> Job:
    """Check stored runs against their hashes.

    Exit code 0 if all are whole, 1 if one is damaged or cannot be verified.
    """
    from .batching import check

    return Job(lambda screen: check(folders, quarantine, screen))


@app.command("warm-up", epilog=epilog("warm-up"))
def warm_up_(
    name: MaybeName = None,
    surface: Annotated[bool, typer.Option("--surface", help="Kernels of the whole surface too; some minutes.")] = False,
    explicit: Annotated[bool, typer.Option("--explicit", help="Kernels of the explicit scheme too.")] = False,
    settings: Settings = None,
    config: Config = None,
    as_json: Json = False,
) -> Job:
    """Compile the kernels of runs to come.

    Once on a machine, for every shell, notebook and environment; a run does the same where it has not been done.
    """
    from .warming import warm_up

    described = Input(name if name or config else "baseline", None, settings or (), config)
    return Job(lambda screen: warm_up(described, surface, explicit, screen), name)


app.add_typer(cell_app)
app.command("dose-response", epilog=epilog("dose-response"))(dose_response_)
app.command("bench", epilog=epilog("bench"))(bench)
app.command("app", epilog=epilog("app"))(app_)
app.command("fit", epilog=epilog("fit"))(fit_)
app.command("map", epilog=epilog("map"))(map_)
app.command("paper", epilog=epilog("paper"))(paper)
app.command("passes", epilog=epilog("passes"))(passes_)
for command, declared in STUDIES.items():
    app.command(command, epilog=epilog(command))(declared)


@app.command("version", epilog=epilog("version"))
def version_(as_json: Json = False) -> Job:
    """Show versions: of this package, and of what it is built on."""
    from .showing import version

    return Job(version)
