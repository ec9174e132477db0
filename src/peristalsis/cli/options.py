"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

Name = Annotated[str, typer.Argument(metavar="NAME", help="Scenario, see peristalsis list.", show_default=False)]
MaybeName = Annotated[
    str | None,
    typer.Argument(metavar="[NAME]", help="Scenario, see peristalsis list; FILE may name it.", show_default=False),
]
Reading = Annotated[
    str | None,
    typer.Option(
        "--reading", metavar="R", help="Reading of the paper's doubtful numbers: tight, stretched, printed or edge."
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change one parameter; numbers carry a unit. May be repeated."),
]
Config = Annotated[
    str | None,
    typer.Option("--config", metavar="FILE", help="TOML file of parameters, laid over the scenario."),
]
Json = Annotated[
    bool,
    typer.Option("--json", help="Print exactly one JSON object on stdout, even when something is wrong."),
]
Folder = Annotated[str, typer.Argument(metavar="FOLDER", help="Folder of a stored run, such as out/baseline.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
Drugs = Annotated[
    list[str] | None,
    typer.Option(
        "--drug",
        metavar="'AGENT AMOUNT'",
        help="An agent, such as 'nifedipine 30 nM', or an intervention, such as 'lubricant 0.5'; see peristalsis list "
        "drugs. May be repeated. A research model, not medical advice.",
    ),
]
Library = Annotated[
    str | None,
    typer.Option(
        "--drugs", metavar="FILE", help="Library of agents laid over the shipped one: a TOML file, or l_type_is_fast."
    ),
]
Workers = Annotated[int, typer.Option("--workers", metavar="N", help="Processes that run at a time.")]
