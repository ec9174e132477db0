"""What `peristalsis map` does: maps read and treated, pictures and tables of them written, numbers shown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, WriteError, could_not, shown, suggestion
from ..paths import located
from .orders import MapOrder, lengths
from .streams import Screen, spelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ..maps import Contractions, Map, Rule, Track

    Drawings = dict[str, tuple[Callable[[], Canvas], str]]

FORMATS = ("png", "svg", "pdf")
MOST_FILES = 2


def carry_out(order: MapOrder, screen: Screen) -> int:
    """Read, treat, measure, draw and write what is asked for; of one map, or of two beside one another."""
    from .. import maps

    for name in order.formats:
        if name not in FORMATS:
            raise ConfigurationError(
                f"--format {shown(name)}: not one of {', '.join(FORMATS)}; {suggestion(name, FORMATS)}"
            )
    if len(order.files) > MOST_FILES:
        raise ConfigurationError(f"FILE = {shown(order.files[2])}: one or two maps are shown at a time; leave it out")
    if order.synthetic:
        _make(order, screen)
    recorded = [treated(_read(file, order), order) for file in order.files]
    if len({one.name for one in recorded}) < len(recorded):  # a map and its picture: told apart by their endings
        recorded = [replace(one, name=located(file).name) for one, file in zip(recorded, order.files, strict=True)]
    tracks = _tracks(order)
    found = [maps.contractions(one, _rule(order, one)) for one in recorded]
    target = _target(order, recorded)
    answer: dict[str, Any] = {"status": "finished", "maps": []}
    for one, own in zip(recorded, found, strict=True):
        screen.say(repr(one)[1:].replace(">", "", 1))
        _say_contractions(own, screen)
        if own.chosen_by_noise:
            unit = "" if own.unit == "1" else f" {own.unit}"
            screen.warn(
                f"{one.name}: noise or drift sets the threshold, {own.threshold:.3g}{unit}; take drift out by --level, "
                "or state --threshold"
            )
        about = {"name": one.name, "quantity": one.quantity, "unit": one.unit, "history": list(one.history)}
        answer["maps"].append({**about, "numbers": own.numbers()})
    drawings = _drawings(recorded, found, tracks, order, screen, answer)
    answer["passages"] = _say_passages(tracks, recorded[0], order, screen)
    written = _inputs(recorded[0], found[0], order) + [maps.write(recorded[0], file) for file in order.write]
    target.mkdir(parents=True, exist_ok=True)
    for one, own in zip(recorded, found, strict=True):
        table = target / ("contractions.csv" if len(found) == 1 else f"contractions_{one.name}.csv")
        table.write_text(own.csv(), encoding="utf-8")
        written.append(table)
    written += _drawn(drawings, target, order)
    screen.say("\n".join(f"written: {spelled(file)}" for file in written))
    screen.answer({**answer, "files": [str(file) for file in written]})
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


def _target(order: MapOrder, recorded: list[Map]) -> Path:
    target = located(order.out) if order.out else Path("out") / f"map_{'_'.join(one.name for one in recorded)}"
    if target.exists() and not target.is_dir():
        raise WriteError(f"{shown(str(target))} is a file; choose another folder with --out")
    return target


def _make(order: MapOrder, screen: Screen) -> None:
    from .. import maps
    from ..maps.synthetic import example

    target = located(order.files[0])
    if target.exists() and not order.overwrite:
        raise WriteError(f"{shown(str(target))} exists; choose another name, or say --overwrite")
    recorded, _, track = example()
    pellet = target.with_name(f"{target.stem}_pellet.csv")
    made = [maps.write(recorded, target), maps.write_tracks([track], pellet)]
    screen.say("\n".join(f"made: {spelled(file)}" for file in made))


def _read(file: str, order: MapOrder) -> Map:
    from .. import maps

    if located(file).is_dir():
        from ..maps.of_run import RunMaps
        from ..results.result import load

        run = RunMaps(load(file))
        if order.quantity not in (None, "diameter", "pressure", "stretch"):
            raise ConfigurationError(
                f"--quantity {order.quantity}: a run has diameter, pressure and stretch; choose one"
            )
        return run.pressure() if order.quantity == "pressure" else getattr(run, order.quantity or "diameter")
    return maps.read(file, **order.stated())


def _tracks(order: MapOrder) -> tuple[Track, ...]:
    from .. import maps

    if order.track is None:
        return ()
    if located(order.track).is_dir():
        from ..maps.of_run import RunMaps
        from ..results.result import load

        return (RunMaps(load(order.track)).pellet,)
    return maps.tracks(order.track)


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
    depth = f"depth ({found.unit})"
    heads = ("begin (s)", "from (mm)", "extent (mm)", "speed (mm/s)", depth, "lasts (s)", "interval (s)")
    screen.table(("no.", "direction", *heads), rows)


def _say_passages(tracks: tuple[Track, ...], recorded: Map, order: MapOrder, screen: Screen) -> list[dict[str, Any]]:
    """Speeds of pellets over the marked stretch."""
    from ..maps.measures import passage

    if order.between is None:
        return []
    marks = lengths(order.between, "--between")
    if len(marks) != 2 or not tracks:
        raise ConfigurationError(
            f"--between {shown(order.between)}: give two marks, such as '20, 80 mm', and the pellets with --track"
        )
    found = [passage(track, *marks) for track in tracks]
    for one in found:
        speed = one.why if one.speed is None else f"{one.speed:.4g} mm/s, from {one.begin:.4g} to {one.end:.4g} s"
        screen.say(f"{one.track} over {marks[0]:g} to {marks[1]:g} mm: {speed}")
    return [one._asdict() for one in found]


def _drawings(
    recorded: list[Map],
    found: list[Contractions],
    tracks: tuple[Track, ...],
    order: MapOrder,
    screen: Screen,
    answer: dict[str, Any],
) -> Drawings:
    """Name to how it is drawn and its caption; what is worked out for them is said."""
    from ..maps import measures
    from ..maps.drawing import analysis, manometry, map_figure
    from ..maps.words import seconds

    if len(recorded) == 2:
        return _of_two(recorded, found, tracks, order, screen, answer)
    one, own = recorded[0], found[0]
    drawings: Drawings = {}
    if one.quantity == "pressure":
        drawings["manometry"] = (lambda: manometry.draw(one, own), manometry.CAPTION)
        drawings["manometry_traces"] = (lambda: manometry.draw_traces(one), manometry.TRACES_CAPTION)
    else:
        caption = map_figure.CAPTIONS[one.quantity]
        drawings[f"{one.quantity}_map"] = (lambda: map_figure.draw(one, own, tracks), caption)
    if order.segment is not None:
        power = measures.spectrum(one, seconds(order.segment, "--segment"))
        between = "" if power.limits is None else f" (95 %: {power.limits[0]:.3g} to {power.limits[1]:.3g})"
        screen.say(f"frequency: {'none stands out' if power.peak is None else f'{power.peak:.4g} /min{between}'}")
        answer["frequency_per_min"], answer["frequency_limits"] = power.peak, power.limits
        drawings["spectrum"] = (lambda: analysis.draw_spectrum(power, one), analysis.SPECTRUM_CAPTION)
    if tracks and one.quantity == "diameter":
        window = max(2.0 * one.time_step(), 0.01 * one.duration)
        drawings["velocity"] = (
            lambda: analysis.draw_velocity(tracks[0], one, window),
            f"{analysis.VELOCITY_CAPTION} Slopes over {window:g} s.",
        )
    return drawings


def _of_two(
    recorded: list[Map],
    found: list[Contractions],
    tracks: tuple[Track, ...],
    order: MapOrder,
    screen: Screen,
    answer: dict[str, Any],
) -> Drawings:
    """A diameter and a pressure give the states of the wall; two of one quantity stand side by side."""
    from ..maps import compare, states
    from ..maps.comparing import side_by_side
    from ..maps.drawing import analysis, comparison
    from ..maps.words import seconds

    first, second = recorded
    if {first.quantity, second.quantity} == {"diameter", "pressure"}:
        diameter, pressure = (first, second) if first.quantity == "diameter" else (second, first)
        wall = states.states(diameter, pressure)
        screen.say("\n".join(f"{name}: {100.0 * share:.3g} % of the map" for name, share in wall.shares.items()))
        answer["states"] = wall.shares
        return {"states": (lambda: analysis.draw_states(wall, diameter), analysis.STATES_CAPTION)}
    if first.name == second.name:
        raise ConfigurationError(f"both maps are called {shown(first.name)}; name two, or rename one of the files")
    numbers = {one.name: own.numbers() for one, own in zip(recorded, found, strict=True)}
    screen.table(("number", first.name, second.name), side_by_side(numbers, first.unit))
    drawings: Drawings = {
        "beside": (
            lambda: comparison.draw_beside((first, second), (found[0], found[1]), (tracks, ())),
            comparison.BESIDE_CAPTION,
        )
    }
    if order.align is not None:
        pair = compare(first, second, seconds(order.align, "--align"))
        screen.say(
            f"{second.name} moved by {pair.shift:g} s: correlation {pair.correlation:.4f}, root mean square difference "
            f"{pair.rms:.4g} {first.unit}"
        )
        answer["compared"] = {"shift_s": pair.shift, "correlation": pair.correlation, "rms": pair.rms}
        drawings["difference"] = (lambda: comparison.draw_difference(pair), comparison.DIFFERENCE_CAPTION)
    return drawings


def _inputs(recorded: Map, found: Contractions, order: MapOrder) -> list[Path]:
    """Inputs of a run that are made of the map."""
    from .. import units
    from ..maps.courses import write_course, write_stimuli

    files = []
    if order.course is not None:
        place, _, file = order.course.partition(":")
        if not file:
            raise ConfigurationError(f"--course {shown(order.course)}: write a place and a file, '50 mm:pressure.csv'")
        files.append(write_course(recorded, units.parse(place, "mm", "--course"), file))
    if order.stimuli is not None:
        strength, _, file = order.stimuli.partition(":")
        if not file:
            raise ConfigurationError(f"--stimuli {shown(order.stimuli)}: write '2 uA/cm^2:stimuli.csv', for example")
        files.append(write_stimuli(found, file, units.parse(strength, "uA/cm^2", "--stimuli")))
    return files


def _drawn(drawings: Drawings, target: Path, order: MapOrder) -> list[Path]:
    from ..plots import style

    files = []
    for name, (draw, caption) in drawings.items():
        with style.applied():
            figure = draw()
        for ending in dict.fromkeys(order.formats or ("png",)):
            file = target / f"{name}.{ending}"
            try:
                style.write(figure, file, name.replace("_", " "), caption)
            except OSError as error:
                raise could_not(f"write {spelled(file)}", error, "another place with --out") from None
            files.append(file)
    return files
