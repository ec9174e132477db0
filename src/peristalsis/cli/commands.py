"""The commands as typer sees them: arguments, options and help. Each returns a Job; nothing is done here."""

from __future__ import annotations

from typing import Annotated, Optional

import typer

from .dispatch import Job
from .inputs import Input

EXIT_CODES = (
    "Exit codes: 0 finished, whatever the pellet did; 1 a check ran and failed; 2 bad input; 3 the run diverged; "
    "4 a result could not be written; 130 interrupted."
)

EXAMPLES = {
    "": ("peristalsis list", "peristalsis run baseline", "peristalsis compare out/baseline out/reflex-only"),
    "run": (
        "peristalsis run baseline",
        "peristalsis run baseline --reading stretched --out out/stretched",
        "peristalsis run baseline --set 'pellet.viscous_friction=120 mN*s/cm' --set reflex.enabled=false --out out/thin",
        "peristalsis run --config my.toml --out out/mine --json",
    ),
    "list": ("peristalsis list", "peristalsis list --json"),
    "show": (
        "peristalsis show baseline",
        "peristalsis show baseline pellet --reading printed",
        "peristalsis show segmentation --set 'rings.period=4 s' --toml",
    ),
    "schema": ("peristalsis schema",),
    "validate": ("peristalsis validate my.toml",),
    "cite": ("peristalsis cite baseline", "peristalsis cite out/baseline"),
    "plot": ("peristalsis plot out/baseline", "peristalsis plot out/baseline overview --format pdf --format svg"),
    "film": ("peristalsis film out/baseline", "peristalsis film out/baseline --out baseline.gif"),
    "export": ("peristalsis export out/baseline", "peristalsis export out/baseline --out tables"),
    "compare": (
        "peristalsis compare out/baseline out/thin",
        "peristalsis compare out/baseline out/thin out/reflex-only --out out/compared",
    ),
    "version": ("peristalsis version",),
}
"""Examples of the help texts, by command; the tests run them."""


def _epilog(command: str) -> str:
    """Examples, one a line; a blank line is a line break to typer."""
    lines = ["Examples:", *EXAMPLES[command]]
    if command in ("", "run"):
        lines.append(EXIT_CODES)
    return "\n\n".join(lines)


app = typer.Typer(
    name="peristalsis",
    help="Electromechanical model of colonic propulsion: waves in two muscle layers, a soft wall, a pellet.",
    epilog=_epilog(""),
    add_completion=False,
    rich_markup_mode=None,  # brackets in the texts are meant
    pretty_exceptions_enable=False,
)

Name = Annotated[str, typer.Argument(metavar="NAME", help="Scenario, as in 'peristalsis list'.", show_default=False)]
MaybeName = Annotated[
    Optional[str],  # noqa: UP045 - older typer reads this form only
    typer.Argument(metavar="[NAME]", help="Scenario, as in 'peristalsis list'; may stand in FILE.", show_default=False),
]
Reading = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option("--reading", metavar="R", help="How doubtful numbers of the paper are read: tight, stretched, printed."),
]
Settings = Annotated[
    Optional[list[str]],  # noqa: UP045
    typer.Option("--set", metavar="KEY=VALUE", help="Change one parameter; numbers carry a unit. May be repeated."),
]
Config = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option("--config", metavar="FILE", help="TOML file of parameters, laid over the scenario."),
]
Json = Annotated[
    bool, typer.Option("--json", help="Print exactly one JSON object on stdout, also when something is wrong.")
]
Folder = Annotated[str, typer.Argument(metavar="FOLDER", help="Folder of a stored run, such as out/baseline.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
) -> Optional[Job]:  # noqa: UP045
    """Electromechanical model of colonic propulsion: waves in two muscle layers, a soft wall, a pellet."""
    return None


@app.command("run", epilog=_epilog("run"))
def run_(
    name: MaybeName = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    out: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--out", metavar="DIR", help="Folder of the result; out/NAME unless given."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
    no_plots: Annotated[bool, typer.Option("--no-plots", help="Draw no pictures.")] = False,
) -> Job:
    """Run a scenario, store its result, draw its pictures.

    The folder holds result.nc (every output with its unit), summary.json, config.toml and pictures. It appears
    complete or not at all. A run that diverges or is interrupted stores its history up to there.
    """
    from .running import Order, run

    order = Order(Input(name, reading, settings or (), config), out, overwrite, not no_plots)
    return Job(lambda screen: run(order, screen), name)


@app.command("list", epilog=_epilog("list"))
def list_(as_json: Json = False) -> Job:
    """List the scenarios with what is expected of them, and the readings of the paper."""
    from .showing import list_scenarios

    return Job(list_scenarios)


@app.command("show", epilog=_epilog("show"))
def show_(
    name: Name,
    section: Annotated[
        Optional[str],  # noqa: UP045
        typer.Argument(metavar="[SECTION]", help="Section or parameter, such as pellet; all unless given."),
    ] = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    toml: Annotated[bool, typer.Option("--toml", help="Write the configuration file instead of a table.")] = False,
    as_json: Json = False,
) -> Job:
    """Show every parameter of a scenario: value, tag, what the paper prints where that is in doubt, and source."""
    from .showing import show

    return Job(lambda screen: show(Input(name, reading, settings or (), config), section, toml, screen), name)


@app.command("schema", epilog=_epilog("schema"))
def schema_(as_json: Json = False) -> Job:
    """Print the JSON Schema of configuration files."""
    from .showing import schema

    return Job(schema)


@app.command("validate", epilog=_epilog("validate"))
def validate_(
    file: Annotated[str, typer.Argument(metavar="FILE", help="TOML file of parameters.")], as_json: Json = False
) -> Job:
    """Check a configuration file without running it: exit code 0 if it is valid, 2 if not."""
    from .showing import validate

    return Job(lambda screen: validate(file, screen))


@app.command("cite", epilog=_epilog("cite"))
def cite_(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Scenario, or folder of a stored run.")],
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    as_json: Json = False,
) -> Job:
    """List the sources of the numbers of a run, and the numbers that were changed."""
    from .showing import cite

    return Job(lambda screen: cite(Input(name, reading, settings or (), config), screen), name)


@app.command("plot", epilog=_epilog("plot"))
def plot_(
    folder: Folder,
    names: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Argument(metavar="[NAMES]...", help="Figures, such as overview; all unless given."),
    ] = None,
    formats: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--format", metavar="png|svg|pdf", help="File format, png unless given. May be repeated."),
    ] = None,
    out: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--out", metavar="DIR", help="Folder of the pictures; FOLDER unless given."),
    ] = None,
    as_json: Json = False,
) -> Job:
    """Draw the figures of a stored run again, over the old ones."""
    from .stored import plot

    return Job(lambda screen: plot(folder, names or (), formats or (), out, screen))


@app.command("film", epilog=_epilog("film"))
def film_(
    folder: Folder,
    out: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--out", metavar="FILE", help="A .gif, or .mp4 where ffmpeg is; FOLDER/film.gif unless given."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Write a film of wall and pellet of a stored run."""
    from .stored import film

    return Job(lambda screen: film(folder, out, overwrite, screen))


@app.command("export", epilog=_epilog("export"))
def export_(
    folder: Folder,
    out: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--out", metavar="DIR", help="Folder of the tables; FOLDER/csv unless given."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Write the numbers of a stored run as CSV tables."""
    from .stored import export

    return Job(lambda screen: export(folder, out, overwrite, screen))


@app.command("compare", epilog=_epilog("compare"))
def compare_(
    runs: Annotated[list[str], typer.Argument(metavar="RUN RUN...", help="Folders of stored runs.")],
    out: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--out", metavar="DIR", help="Also write pictures: tracks, and diameter less that of the first run."),
    ] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> Job:
    """Set the numbers of stored runs side by side, and the parameters in which they differ."""
    from .stored import compare

    return Job(lambda screen: compare(runs, out, overwrite, screen))


@app.command("version", epilog=_epilog("version"))
def version_(as_json: Json = False) -> Job:
    """Show the versions of this package and of what its numbers depend on."""
    from .showing import version

    return Job(version)
