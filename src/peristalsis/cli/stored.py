"""Commands on stored runs: pictures, films, tables, comparisons."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ConfigurationError, WriteError, shown, suggestion
from ..paths import located
from .report import number_text
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..results.result import Result

FORMATS = ("png", "svg", "pdf")
FILMS = (".gif", ".mp4")
SCENES = (".png", *FILMS)
EXPORTS = ("csv", "vtk")

Done = TypeVar("Done")


def plot(folder: str, names: Sequence[str], formats: Sequence[str], out: str | None, screen: Screen) -> int:
    """Draw the figures of a stored run again, over the old ones."""
    for name in formats:
        if name not in FORMATS:
            raise ConfigurationError(
                f"--format {shown(name)}: not one of {', '.join(FORMATS)}; {suggestion(name, FORMATS)}"
            )
    result = _load(folder, screen)
    target = _home(folder) if out is None else located(out)
    chosen = list(dict.fromkeys(names)) or None
    plots = result.plot
    files = _written(target, lambda: plots.save(target, chosen, formats=tuple(dict.fromkeys(formats)) or ("png",)))
    for name, why in plots.skipped.items():
        screen.warn(f"{name} is left out: {why}")
    return _say_written(files or [], screen)


def film(folder: str, out: str | None, overwrite: bool, screen: Screen, frames: int = 100, rate: int = 20) -> int:
    """Write a film of a stored run."""
    target = _home(folder) / "film.gif" if out is None else located(out)
    if target.suffix.lower() not in FILMS:
        raise ConfigurationError(f"--out {shown(str(target))}: a film ends in {' or '.join(FILMS)}; rename it")
    result = _load(folder, screen)
    with _taken(target, overwrite or out is None):
        _written(target, lambda: result.plot.film(target, frames, rate))
    return _say_written([target], screen)


def scene(
    folder: str, out: str | None, time: str | None, colour: str, overwrite: bool, screen: Screen, rate: int = 15
) -> int:
    """Draw a stored run in space."""
    from ..units import parse

    target = _home(folder) / "scene.png" if out is None else located(out)
    if target.suffix.lower() not in SCENES:
        raise ConfigurationError(f"--out {shown(str(target))}: a scene ends in {', '.join(SCENES)}; rename it")
    seconds = None if time is None else parse(time, "s", "--time")
    if seconds is not None and target.suffix.lower() != ".png":
        raise ConfigurationError(f"--time {shown(time)}: a film shows all times; leave it out, or name a .png")
    result = _load(folder, screen)
    with _taken(target, overwrite or out is None):
        _written(target, lambda: result.plot.scene(target, time=seconds, colour=colour, rate=rate))
    return _say_written([target], screen)


def export(
    folder: str,
    kind: str,
    out: str | None,
    overwrite: bool,
    screen: Screen,
    every: str | None = None,
    fields: Sequence[str] = (),
    compress: bool = False,
    units: str | None = None,
) -> int:
    """Write a stored run for other programs: its numbers as CSV files, or its surfaces as VTK files."""
    if kind not in EXPORTS:
        raise ConfigurationError(
            f"--format {shown(kind)}: not one of {', '.join(EXPORTS)}; {suggestion(kind, EXPORTS)}"
        )
    if kind == "vtk" and (every is not None or fields or compress or units):
        raise ConfigurationError("--every, --field, --compress and --units are for --format csv; leave them out")
    from ..units import parse

    seconds = None if every is None else parse(every, "s", "--every")
    result = _load(folder, screen)
    target = _home(folder) / kind if out is None else located(out)
    from ..plots.export import export_csv, export_vtk

    def write() -> list[Path]:
        if kind == "vtk":
            return export_vtk(result, target)
        asked = [unit.strip() for unit in (units or "").split(",") if unit.strip()]
        return export_csv(result, target, seconds, tuple(dict.fromkeys(fields)), compress, asked)

    with _taken(target, overwrite or out is None):
        files = sorted(_written(target, write))
    return _say_written(files, screen)


def bundle(
    folder: str, out: str | None, agent: str | None, licence: str | None, overwrite: bool, screen: Screen
) -> int:
    """Write a stored run as one zip with a description of it (RO-Crate)."""
    from ..results.bundle import bundle as write

    home = _home(folder)
    target = _beside(home) if out is None else located(out)
    with _taken(target, overwrite):
        file = write(home, target, agent, licence)
    return _say_written([file], screen)


def compare(folders: Sequence[str], out: str | None, overwrite: bool, screen: Screen) -> int:
    """Numbers of stored runs side by side; with a folder, pictures of their tracks and differences."""
    from ..many import comparing

    if len(folders) < 2:
        raise ConfigurationError(
            f"RUN = {shown(folders[0])}: there is nothing to compare it with; name a second folder"
        )
    runs = {name: _load(folder, screen) for name, folder in zip(labels(folders), folders, strict=True)}
    target = None if out is None else located(out)
    if target is not None:
        _refuse_existing(target, overwrite)
    screen.scenario = None
    rows = []
    for number in comparing.NUMBERS:
        values = [comparing.value_of(result.summary, number) for result in runs.values()]
        if number.decisive and any(value is not None for value in values):
            rows.append((number, values))
    status = [result.status for result in runs.values()]
    changed = comparing.changed_keys(runs)
    for sentence in comparing.cuts(runs):
        screen.warn(sentence)
    numbers = [
        ("status", *(text.replace("_", " ") for text in status)),
        *((number.label, *(number_text(value, number.unit) for value in values)) for number, values in rows),
    ]
    screen.table(("quantity", *runs), numbers)
    if changed:
        screen.table(("they differ in", *runs), ((key, *map(str, values)) for key, values in changed.items()))
    else:
        screen.say("the runs have the same parameters")
    content: dict[str, Any] = {
        "runs": [{"name": name, "folder": folder} for name, folder in zip(runs, folders, strict=True)],
        "status": status,
        "numbers": {number.key: values for number, values in rows},
        "changed": changed,
    }
    if target is not None:
        with _taken(target, overwrite):
            content |= _write_comparison(comparing.draw, runs, target, content, screen)
    screen.answer(content)
    return 0


def labels(folders: Sequence[str]) -> list[str]:
    """Names for the runs: the last part of each folder where that tells them apart, else the whole."""
    last = [located(folder).resolve().name for folder in folders]
    names = [folder if Counter(last)[name] > 1 else name for folder, name in zip(folders, last, strict=True)]
    repeated = [name for name, count in Counter(names).items() if count > 1]
    if repeated:
        raise ConfigurationError(f"RUN = {shown(repeated[0])}: it is given twice; name different folders")
    return names


def _write_comparison(
    draw: Callable[..., tuple[list[Path], list[str]]],
    runs: dict[str, Result],
    target: Path,
    content: dict[str, Any],
    screen: Screen,
) -> dict[str, Any]:
    def write() -> tuple[list[Path], list[str]]:
        target.mkdir(parents=True, exist_ok=True)
        (target / "comparison.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        return draw(runs, target)

    files, left_out = _written(target, write)
    for reason in left_out:
        screen.warn(f"not drawn: {reason}")
    screen.say(f"pictures: {', '.join(spelled(file) for file in files) or 'none'}")
    return {"pictures": [str(file) for file in files]}


def _home(folder: str) -> Path:
    """The folder of a stored run that is named by its folder or by its file."""
    return Path(folder).parent if Path(folder).is_file() else Path(folder)


def _beside(home: Path) -> Path:
    """The zip that lies beside a folder and has its name."""
    place = located(home).resolve()
    return place.with_name(f"{place.name}.zip")


def _load(folder: str, screen: Screen) -> Result:
    from ..results.result import load

    try:
        result = load(folder)
    except OSError as error:
        raise ConfigurationError(f"{shown(folder)} cannot be read: {error.strerror or error}; check the name") from None
    screen.scenario = result.configuration.scenario
    return result


def _refuse_existing(target: Path, overwrite: bool) -> None:
    if target.exists() and not overwrite:
        raise WriteError(f"{shown(str(target))} exists; choose another name with --out, or say --overwrite")


@contextmanager
def _taken(target: Path, overwrite: bool) -> Iterator[None]:
    """The name of what is to be written, for this process alone; refused where it is taken or may not be replaced."""
    from ..storing.locks import Claim

    _refuse_existing(target, overwrite)
    claim = Claim(target)
    try:
        _refuse_existing(target, overwrite)  # again: who had the name may have written it since
        yield
    finally:
        claim.release()


def _written(target: Path, write: Callable[[], Done]) -> Done:
    try:
        return write()
    except OSError as error:
        raise WriteError(
            f"could not write {spelled(target)}: {error.strerror or error}; choose another place with --out"
        ) from None


def _say_written(files: Iterable[Path], screen: Screen) -> int:
    listed = [str(file) for file in files]
    screen.say("\n".join(f"written: {spelled(file)}" for file in listed))
    screen.answer({"scenario": screen.scenario, "status": "written", "files": listed})
    return 0
