"""`peristalsis map`: recordings of a laboratory, and stored runs beside them, read, drawn, measured, written."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated

import typer

from .job import Job
from .options import Json
from .orders import MapOrder

EXAMPLES = (
    "peristalsis map rings.csv --synthetic",
    "peristalsis map rings.csv --level '60 s' --write rings.tif --write rings.mat",
    "peristalsis map rings.tif --format pdf --out out/rings_as_picture",
    "peristalsis map rings.csv --level '60 s' --track rings_pellet.csv --between '30, 80 mm' --out out/pellet",
    "peristalsis map rings.csv rings.tif --align '5 s'",
    "peristalsis map rings.csv --level '60 s' --segment '100 s' --stimuli '2 uA/cm^2:again.csv' --out out/again",
    "peristalsis map out/baseline --quantity pressure",
    "peristalsis map rings.csv out/baseline",
)
"""Examples of the help text; the tests run them in this order."""


def map_(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="A recording (.csv .tif .png .nc .mat) or the folder of a stored run."),
    ],
    synthetic: Annotated[
        bool,
        typer.Option("--synthetic", help="Make FILE first: five minutes of rings with noise and drift, and a pellet."),
    ] = False,
    quantity: Annotated[
        str | None,
        typer.Option("--quantity", metavar="Q", help="diameter, pressure, stretch or strain, if FILE does not say it."),
    ] = None,
    unit: Annotated[str | None, typer.Option("--unit", metavar="U", help="Of the values, such as mm or cmH2O.")] = None,
    oral: Annotated[
        str, typer.Option("--oral", metavar="first|last", help="Which place of FILE is the oral end.")
    ] = "first",
    positions: Annotated[
        str | None, typer.Option("--positions", metavar="X,X,...", help="Places of channels, such as '10,20,35 mm'.")
    ] = None,
    variable: Annotated[
        str | None, typer.Option("--variable", metavar="NAME", help="The map in a FILE that holds several.")
    ] = None,
    mm_per_px: Annotated[
        float | None, typer.Option("--mm-per-px", metavar="N", help="Scale of a picture along the gut.")
    ] = None,
    s_per_px: Annotated[
        float | None, typer.Option("--s-per-px", metavar="N", help="Scale of a picture in time.")
    ] = None,
    grey: Annotated[
        str | None, typer.Option("--grey", metavar="G=V,G=V", help="What greys mean: '0 = 5 mm, 255 = 20 mm'.")
    ] = None,
    time: Annotated[
        str | None, typer.Option("--time", metavar="right|down", help="Which way time runs in a picture.")
    ] = None,
    resample: Annotated[
        str | None, typer.Option("--resample", metavar="T", help="Resample to times this far apart, such as '0.1 s'.")
    ] = None,
    despike: Annotated[
        str | None,
        typer.Option("--despike", metavar="T", help="Take out spikes far from the running median of T, such as '1 s'."),
    ] = None,
    level: Annotated[
        str | None,
        typer.Option("--level", metavar="T", help="Take out the running median of T, such as '60 s': slow drift."),
    ] = None,
    threshold: Annotated[
        str | None,
        typer.Option("--threshold", metavar="D", help="Depth of a contraction, such as '2 mm'; chosen unless given."),
    ] = None,
    segment: Annotated[
        str | None,
        typer.Option("--segment", metavar="T", help="Spectrum along the gut, of segments this long, such as '100 s'."),
    ] = None,
    track: Annotated[
        str | None,
        typer.Option("--track", metavar="FILE", help="Pellets: CSV of times and positions, or a stored run."),
    ] = None,
    between: Annotated[
        str | None,
        typer.Option("--between", metavar="X,X", help="Speed of the pellets between two marks, such as '20, 80 mm'."),
    ] = None,
    align: Annotated[
        str | None,
        typer.Option("--align", metavar="T", help="Show the difference of two maps, the second moved by up to T."),
    ] = None,
    course: Annotated[
        str | None,
        typer.Option("--course", metavar="X:FILE", help="Write the pressure at X as a protocol: '50 mm:pressure.csv'."),
    ] = None,
    stimuli: Annotated[
        str | None,
        typer.Option("--stimuli", metavar="I:FILE", help="Write the contractions as stimuli: '2 uA/cm^2:again.csv'."),
    ] = None,
    write: Annotated[
        list[str] | None,
        typer.Option("--write", metavar="FILE", help="Write the map: .csv .nc .mat .tif .png. May be repeated."),
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option("--format", metavar="png|svg|pdf", help="Of the pictures, png unless given. May be repeated."),
    ] = None,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Folder of pictures and tables; out/map_NAME unless given."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")] = False,
    as_json: Json = False,
) -> Job:
    """Read a map of diameter or pressure over place and time, draw it, find its contractions.

    Two maps of one quantity stand side by side; a diameter and a pressure give the states of the wall.
    What is done to the recording (--resample, --despike, --level) is off unless asked for, and written into the answer.
    """
    given = {key: value for key, value in locals().items() if key in {one.name for one in fields(MapOrder)}}
    order = MapOrder(**{**given, "files": tuple(files), "write": tuple(write or ()), "formats": tuple(formats or ())})
    from .mapping import carry_out

    return Job(lambda screen: carry_out(order, screen))
