"""`peristalsis fit`: parameters from tracks of pellets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConfigurationError, PeristalsisError, shown
from ..paths import located
from .inputs import Input
from .job import Job
from .options import Config, Drugs, Json, Library, Reading, Settings, Workers
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.fitting import Fit, Observed
    from ..many.rows import Step

EXAMPLES = (
    "peristalsis fit track.csv --free pellet.viscous_friction",
    "peristalsis fit track.csv --free pellet.viscous_friction,pellet.dry_friction --bounds "
    "'pellet.dry_friction = 0 mN .. 100 mN' --out out/two_frictions",
    "peristalsis fit video.csv --mm-per-px 0.1 --frame-rate 30 --time-offset '0.2 s' --free-offset place "
    "--free longitudinal.fast_calcium+circular.fast_calcium",
)
"""Examples of the help text."""
MOST_WORKERS = 64
OFFSETS = ("place", "time")


@dataclass(frozen=True)
class FitOrder:
    """What a command line asks for; texts as they were typed."""

    files: tuple[str, ...]
    free: tuple[str, ...]
    bounds: tuple[str, ...]
    input: Input
    scale: tuple[float | None, float | None]
    offsets: tuple[str, str]
    free_offsets: tuple[str, ...]
    noise: str | None
    profiles: bool
    out: str | None
    workers: int


def fit_(
    files: Annotated[
        list[str],
        typer.Argument(metavar="TRACK...", help="CSV of 'time [s],position [mm]'; several are fitted at once."),
    ],
    free: Annotated[
        list[str], typer.Option("--free", metavar="KEY,KEY", help="What is to be found; KEY+KEY have one value.")
    ],
    bounds: Annotated[
        list[str] | None,
        typer.Option("--bounds", metavar="'KEY = A .. B'", help="Its smallest and largest value; may be repeated."),
    ] = None,
    name: Annotated[str | None, typer.Option("--scenario", metavar="NAME", help="baseline unless given.")] = None,
    reading: Reading = None,
    settings: Settings = None,
    config: Config = None,
    drug: Drugs = None,
    drugs: Library = None,
    mm_per_px: Annotated[
        float | None, typer.Option("--mm-per-px", metavar="N", help="Scale of positions in pixels.")
    ] = None,
    frame_rate: Annotated[
        float | None, typer.Option("--frame-rate", metavar="N", help="Frames a second of times in frames.")
    ] = None,
    time_offset: Annotated[
        str, typer.Option("--time-offset", metavar="T", help="Where the model's time begins on the recording's clock.")
    ] = "0 s",
    place_offset: Annotated[
        str, typer.Option("--place-offset", metavar="X", help="Where the oral end lies on the recording's scale.")
    ] = "0 mm",
    free_offset: Annotated[
        list[str] | None,
        typer.Option("--free-offset", metavar="place|time", help="Find this offset for each track; may be repeated."),
    ] = None,
    noise: Annotated[
        str | None,
        typer.Option("--noise", metavar="X", help="Of a position, such as '0.3 mm'; from the residuals unless given."),
    ] = None,
    no_profiles: Annotated[
        bool, typer.Option("--no-profiles", help="Intervals by curvature alone; fewer runs.")
    ] = False,
    out: Annotated[
        str | None, typer.Option("--out", metavar="DIR", help="Folder of what comes out, and of kept runs.")
    ] = None,
    workers: Workers = 1,
    as_json: Json = False,
) -> Job:
    """Find the parameters with which the pellet comes nearest to tracks that were observed.

    DIR has fit.toml, a configuration ready to be run, residuals.csv, and fit.png with tracks, residuals and the profile
    of the likelihood of each parameter, which shows whether the tracks determine it. Parameters start at the values of
    the configuration. Exit code 3 if the fit is no success.
    """
    described = Input(name if name or config else "baseline", reading, settings or (), config, None, drug or (), drugs)
    names = tuple(part.strip() for one in free for part in one.split(",") if part.strip())
    order = FitOrder(
        tuple(files),
        names,
        tuple(bounds or ()),
        described,
        (mm_per_px, frame_rate),
        (time_offset, place_offset),
        tuple(free_offset or ()),
        noise,
        not no_profiles,
        out,
        workers,
    )
    return Job(lambda screen: carry_out(order, screen), name)


def carry_out(order: FitOrder, screen: Screen) -> int:
    """Fit, write, and say what came out; the exit code."""
    from ..many.fitting import fit
    from ..many.fitting.problem import Offsets
    from ..plots.placing import whole_in_folder

    if not 1 <= order.workers <= MOST_WORKERS:
        raise ConfigurationError(f"--workers {order.workers}: not a number of processes; choose 1 to {MOST_WORKERS}")
    for one in order.free_offsets:
        if one not in OFFSETS:
            raise ConfigurationError(f"--free-offset {shown(one)}: offsets are {' and '.join(OFFSETS)}; name one")
    configuration = order.input.configuration()
    screen.scenario = configuration.scenario
    target = Path("out", f"fit_{located(order.files[0]).stem}") if order.out is None else located(order.out)
    screen.if_interrupted = f"interrupted; finished runs are kept in {spelled(target)}: call again to go on"

    def progress(step: Step) -> None:
        if not step.kept:
            screen.line(f"{step.row.point.name.partition(' | ')[0]}: {step.row.status.replace('_', ' ')}")

    found = fit(
        _observed(order),
        order.free,
        scenario=configuration,
        bounds=_bounds(order.bounds),
        free_offsets=Offsets("place" in order.free_offsets, "time" in order.free_offsets),
        noise=None if order.noise is None else _length(order.noise, "--noise"),
        profiles=order.profiles,
        out=target,
        workers=order.workers,
        progress=progress,
    )
    written: list[Path] = []
    texts = {"residuals.csv": found.csv()} | ({"fit.toml": found.configuration.to_toml()} if found.success else {})
    for name, text in texts.items():
        with whole_in_folder(target / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
        written.append(target / name)
    with whole_in_folder(target / "fit.png") as temporary:
        found.figure().savefig(temporary)
    written.append(target / "fit.png")
    _say(found, screen)
    screen.say("\n".join(f"written: {spelled(file)}" for file in written))
    answer: dict[str, Any] = {**found.numbers(), "files": [str(file) for file in written]}
    if not found.success:
        return screen.fail(FailedFit(f"the fit is no success: {found.status}: {found.message}"), answer)
    screen.answer(answer)
    return 0


class FailedFit(PeristalsisError):
    """A fit whose numbers cannot be used."""

    exit_code = 3
    status = "failed"


def _observed(order: FitOrder) -> tuple[Observed, ...]:
    from ..many.fitting import observed
    from ..maps.words import seconds

    mm, rate = order.scale
    if (mm is None) != (rate is None):
        raise ConfigurationError(
            "--mm-per-px and --frame-rate go together; give both, 1 for the one that is not needed"
        )
    scale = None if mm is None or rate is None else (mm, rate)
    time, place = seconds(order.offsets[0], "--time-offset"), _length(order.offsets[1], "--place-offset")
    found = [one for file in order.files for one in observed(file, scale=scale, time_offset=time, place_offset=place)]
    return tuple(found)


def _length(text: str, key: str) -> float:
    """A length [cm]."""
    from .. import units

    return float(units.parse(text, "cm", key))


def _bounds(texts: tuple[str, ...]) -> dict[str, tuple[object, object]]:
    found: dict[str, tuple[object, object]] = {}
    for text in texts:
        key, sign, span = (part.strip() for part in text.partition("="))
        low, dots, high = (part.strip() for part in span.partition(".."))
        if not sign or not dots or key in found:
            raise ConfigurationError(
                f"--bounds {shown(text)}: write for example 'pellet.dry_friction = 0 mN .. 100 mN', once for each key"
            )
        found[key] = (low, high)
    return found


def _say(found: Fit, screen: Screen) -> None:
    def interval(ends: tuple[float | None, float | None] | None) -> str:
        if ends is None:
            return ""
        return " to ".join("no limit" if one is None else f"{one:.4g}" for one in ends)

    screen.table(
        ("parameter", "value", "95 % by curvature", "95 % by profile", "bounds"),
        (
            (
                one.free.name,
                one.free.text(one.value),
                interval(one.interval),
                interval(one.profile),
                f"{one.free.low:.4g} to {one.free.high:.4g}",
            )
            for one in found.estimates
        ),
        title=f"{found.status}: {found.message}",
    )
    numbers = found.numbers()
    if numbers["rms_residual_cm"] is not None:
        screen.say(
            f"{numbers['observations']} positions, residuals of {10.0 * numbers['rms_residual_cm']:.3g} mm (root of "
            f"the mean square), {numbers['runs']} runs"
        )
    for name, value in numbers["offsets"].items():
        screen.say(f"{name}: {value:.4g} {'cm' if name.startswith('place') else 's'}")
    for remark in found.remarks():
        screen.warn(remark)
