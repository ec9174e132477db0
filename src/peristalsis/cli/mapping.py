"""What `peristalsis map` does: maps read and treated, pictures and tables of them written, numbers shown."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ConfigurationError, WriteError, shown, suggestion
from ..paths import located
from .map_command import MapOrder
from .streams import Screen, spelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ..maps import Contractions, Map, Rule

FORMATS = ("png", "svg", "pdf")


def carry_out(order: MapOrder, screen: Screen) -> int:
    """Read, treat, measure, draw and write what is asked for."""
    from .. import maps

    for name in order.formats:
        if name not in FORMATS:
            raise ConfigurationError(
                f"--format {shown(name)}: not one of {', '.join(FORMATS)}; {suggestion(name, FORMATS)}"
            )
    if order.synthetic:
        _make(order, screen)
    recorded = treated(_read(order.files[0], order), order)
    found = maps.contractions(recorded, _rule(order, recorded))
    target = located(order.out) if order.out else Path("out") / f"map_{recorded.name}"
    screen.say(repr(recorded)[1:].replace(">", "", 1))
    _say_contractions(found, screen)
    written = [maps.write(recorded, file) for file in order.write]
    (target / "contractions.csv").parent.mkdir(parents=True, exist_ok=True)
    table = target / "contractions.csv"
    table.write_text(found.csv(), encoding="utf-8")
    written += [table, *_drawn(_figures(recorded, found), target, order)]
    screen.say("\n".join(f"written: {spelled(file)}" for file in written))
    screen.answer(
        {
            "status": "finished",
            "map": {"quantity": recorded.quantity, "unit": recorded.unit, "history": list(recorded.history)},
            "numbers": found.numbers(),
            "files": [str(file) for file in written],
        }
    )
    return 0


def treated(recorded: Map, order: MapOrder) -> Map:
    """The map with what was asked to be done to it, in this order: resampled, de-spiked, level."""
    from .. import maps
    from ..maps.words import seconds

    if order.resample is not None:
        recorded = maps.resampled(recorded, seconds(order.resample, "--resample"))
    if order.despike is not None:
        recorded = maps.despiked(recorded, seconds(order.despike, "--despike"))
    if order.level is not None:
        recorded = maps.level(recorded, seconds(order.level, "--level"))
    return recorded


def _make(order: MapOrder, screen: Screen) -> None:
    from .. import maps
    from ..maps.synthetic import example

    target = located(order.files[0])
    if target.exists() and not order.overwrite:
        raise WriteError(f"{shown(str(target))} exists; choose another name, or say --overwrite")
    maps.write(example()[0], target)
    screen.say(f"made: {spelled(target)}")


def _read(file: str, order: MapOrder) -> Map:
    from .. import maps

    if located(file).is_dir():
        from ..maps.of_run import RunMaps
        from ..results.result import load

        return RunMaps(load(file)).diameter
    return maps.read(file, **order.stated())


def _rule(order: MapOrder, recorded: Map) -> Rule | None:
    from .. import units
    from ..maps import Rule

    if order.threshold is None:
        return None
    return Rule(threshold=units.parse(order.threshold, recorded.unit, "--threshold"))


def _say_contractions(found: Contractions, screen: Screen) -> None:
    rows = [
        (
            str(one.number),
            one.direction,
            *(f"{value:.4g}" if value is not None else "" for value in (one.begin, one.place, one.extent, one.speed)),
            *(f"{value:.3g}" if value is not None else "" for value in (one.amplitude, one.duration, one.interval)),
        )
        for one in found
    ]
    heads = (
        "begin (s)",
        "from (mm)",
        "extent (mm)",
        "speed (mm/s)",
        f"depth ({found.unit})",
        "lasts (s)",
        "interval (s)",
    )
    screen.table(("no.", "direction", *heads), rows)


def _figures(recorded: Map, found: Contractions) -> dict[str, tuple[Canvas, str]]:
    from ..maps.drawing import map_figure
    from ..plots import style

    with style.applied():
        return {f"{recorded.quantity}_map": (map_figure.draw(recorded, found), map_figure.CAPTIONS[recorded.quantity])}


def _drawn(figures: dict[str, tuple[Canvas, str]], target: Path, order: MapOrder) -> list[Path]:
    from ..plots import style

    files = []
    for name, (figure, caption) in figures.items():
        for ending in dict.fromkeys(order.formats or ("png",)):
            file = target / f"{name}.{ending}"
            style.write(figure, file, name.replace("_", " "), caption)
            files.append(file)
    return files
