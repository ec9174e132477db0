"""Every kind of mistake on the command line: one clear line, the right exit code, and nothing written."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from peristalsis.cli import main
from peristalsis.cli import running as running_module
from peristalsis.inputs.config import LARGEST_TEXT

Files = Mapping[str, str | bytes]
RUN = ("run", "baseline")
STORED = {"out/old/summary.json": "{}", "out/old/result.nc": "numbers"}


@dataclass(frozen=True)
class Mistake:
    """A command line, the files it meets, what must be said, and the exit code."""

    words: tuple[str, ...]
    said: tuple[str, ...]
    code: int = 2
    files: Files | None = None


def setting(text: str, *said: str) -> Mistake:
    """A mistake in one --set; its key, and its value up to the unit, must be said."""
    key, _, value = text.partition("=")
    return Mistake((*RUN, "--set", text), (key, value, *said))


def file(content: str | bytes, *said: str) -> Mistake:
    """A mistake in a configuration file."""
    return Mistake((*RUN, "--config", "my.toml"), said, files={"my.toml": content})


MISTAKES = {
    # names
    "unknown scenario": Mistake(("run", "basline"), ("scenario = 'basline'", "did you mean baseline?")),
    "scenario like no other": Mistake(("run", "xyzzy"), ("scenario = 'xyzzy'", "choose one of baseline")),
    "empty scenario": Mistake(("run", ""), ("scenario = ''", "choose one of")),
    "unknown reading": Mistake((*RUN, "--reading", "tihgt"), ("reading = 'tihgt'", "did you mean tight?")),
    "unknown key": Mistake((*RUN, "--set", "pellet.radis=1 cm"), ("'pellet.radis'", "did you mean pellet.radius?")),
    "key without section": Mistake((*RUN, "--set", "radius=1 cm"), ("'radius'", "radius?")),
    "key like no other": Mistake((*RUN, "--set", "xyzzy=1"), ("'xyzzy' is not a parameter", "choose one of")),
    "section for a key": setting("pellet=1", "pellet is a section", "pellet.enabled"),
    "empty key": Mistake((*RUN, "--set", "=1 cm"), ("'' is not a parameter", "choose one of")),
    # quantities
    "unknown unit": setting("pellet.radius=0.9 cmm", "unknown", "did you mean"),
    "wrong dimension": setting("pellet.radius=0.9 s", "cannot be converted to cm", "'0.9 cm'"),
    "missing unit": setting("pellet.radius=0.9", "the unit is missing", "'0.9 cm'"),
    "unit for a bare number": setting("lumen.adiabatic_exponent=1.4 cm", "bare number"),
    "not a number": setting("pellet.radius=nan cm", "finite number", "'0.9 cm'"),
    "infinite": setting("pellet.radius=inf cm", "finite number"),
    "infinite by its size": setting("pellet.radius=1e999 cm", "finite number"),
    "no value": setting("pellet.radius=", "does not begin with a finite number", "'0.9 cm'"),
    "words for a number": setting("pellet.radius=big", "finite number", "'0.9 cm'"),
    "a very long value": Mistake((*RUN, "--set", f"pellet.radius={'9' * 999} cm"), ("pellet.radius", "too many")),
    "formula for a unit": setting("pellet.radius=1 cm**9**9", "is not a unit", "'0.9 cm'"),
    "list for a number": setting("pellet.radius=[1 cm, 2 cm]", "finite number", "'0.9 cm'"),
    "negative radius": Mistake(
        (*RUN, "--set", "pellet.radius=-0.9 cm"),
        ("pellet.radius = '-0.9 cm'", "more than 0 cm and at most 20 cm"),
    ),
    "zero length": Mistake((*RUN, "--set", "wall.length=0 cm"), ("wall.length = '0.0 cm'", "more than 0 cm")),
    "fraction for a count": setting("grid.n_z=300.5", "not a whole number", "at least 8"),
    "bad choice": setting("trigger.rule=activ", "active, total, pacemaker, delay, none", "did you mean active?"),
    "bad switch": setting("reflex.enabled=maybe", "true or false"),
    "number for a switch": setting("reflex.enabled=1", "true or false"),
    # values that do not fit together
    "pellet longer than the tube": Mistake(
        (*RUN, "--set", "wall.length=1.5 cm", "--set", "pacemaker.width=1 cm", "--set", "output.probes=[]"),
        ("wall.length = 1.5 cm", "2.1 cm", "pellet.radius"),
    ),
    "tube that cannot hold the pellet": Mistake(
        (*RUN, "--set", "wall.radius=0.3 cm"), ("pellet.radius = 0.9 cm", "0.3 cm", "at most 0.66 cm")
    ),
    "too few columns": setting("grid.n_theta=2", "axisymmetric", "use 1"),
    "absurd grid": setting("grid.n_z=100000000", "at most 20000"),
    "absurdly long number of cells": Mistake((*RUN, "--set", f"grid.n_z={'9' * 400}"), ("grid.n_z", "20000")),
    "too many steps": Mistake(
        (*RUN, "--set", "run.duration=1e5 s", "--set", "step.conduction=0.0001 ms"),
        ("run.duration = 100000.0 s", "1e+12 steps", "shorten the run"),
    ),
    "steps that do not divide": Mistake(
        (*RUN, "--set", "step.wall=1 ms", "--set", "step.conduction=0.3 ms"),
        ("step.wall = 1.0 ms", "step.conduction = 0.3 ms", "0.9 ms"),
    ),
    "run shorter than a step": Mistake(
        (*RUN, "--set", "run.duration=0.01 ms"), ("run.duration", "shorter than step.wall")
    ),
    "probe beyond the tube": Mistake(
        (*RUN, "--set", "output.probes=[1 cm, 11 cm]"), ("output.probes = 11.0 cm", "wall.length = 10.0 cm")
    ),
    "pulses that overlap": Mistake(
        (*RUN, "--set", "pacemaker.kind=periodic", "--set", "pacemaker.period=0.01 s"),
        ("pacemaker.period = 0.01 s", "pacemaker.duration"),
    ),
    "rings nowhere": Mistake(
        ("run", "segmentation", "--set", "rings.positions=[]"), ("rings.positions = []", "name one")
    ),
    "region without its end": Mistake(
        (*RUN, "--set", 'regions=[{name = "a", shape = "band", z_to = "1 cm"}]'),
        ("regions: a: z_from is missing", "1 cm"),
    ),
    "region that one column cannot show": Mistake(
        (
            *RUN,
            "--set",
            'regions=[{name = "a", shape = "disc", z = "1 cm", angle = "0 deg", radius = "1 mm", leak = 0}]',
        ),
        ("regions: a", "grid.n_theta = 1", "band"),
    ),
    "region in words": setting("regions=the oral end", "not a list of tables", "[[regions]]"),
    "map that is not there": file("[[regions]]\nname='a'\nshape='map'\nquantities='active'\nfile='b.csv'", "'b.csv'"),
    "pacemaker beyond the tube": setting("pacemaker.place=9.9 cm", "use at most 9.7 cm"),
    "field that is not stored": setting("output.fields=potential", "'potential' is not a field; did you mean"),
    "more fields than memory": Mistake(
        (*RUN, "--set", "grid.n_z_wall=20000", "--set", "grid.n_z=20000", "--set", "output.interval=2 ms"),
        ("output.interval = 0.002 s", "GB", "output.fields"),
    ),
    # the same thing twice
    "key set twice": Mistake(
        (*RUN, "--set", "pellet.radius=1 cm", "--set", "pellet.radius=0.9 cm"),
        ("'pellet.radius'", "twice", "keep one"),
    ),
    "program beside the package": Mistake(("verify",), ("verify", "no command", "python -m verification")),
    "option given twice": Mistake((*RUN, "--out", "a", "--out", "b"), ("--out", "2 times", "keep one")),
    "reading given twice": Mistake(
        (*RUN, "--reading", "tight", "--set", "reading=printed"),
        ("reading = 'printed'", "--reading", "keep one"),
    ),
    "scenario set": Mistake((*RUN, "--set", "scenario=mine"), ("scenario=mine", "NAME")),
    "scenario of the file": file('scenario = "resting"', "scenario = 'baseline'", "'resting'", "only one"),
    "table twice in the file": file('[pellet]\nenabled = true\n[pellet]\nradius = "1 cm"', "my.toml", "not valid TOML"),
    "key twice in the file": file('pellet.radius = "1 cm"\n"pellet.radius" = "2 cm"', "pellet.radius", "twice"),
    # configuration files
    "no such file": Mistake((*RUN, "--config", "my.toml"), ("'my.toml'", "No such file", "check the name")),
    "folder for a file": Mistake((*RUN, "--config", "."), ("'.'", "Is a directory", "check the name")),
    "malformed file": file("[pellet\nradius=", "my.toml", "not valid TOML", "line 1"),
    "nested too deeply": file("a = " + "[" * 9000 + "]" * 9000, "my.toml", "not valid TOML"),
    "unknown table": file("[pelet]\nradius = '1 cm'", "'pelet'", "did you mean pellet?"),
    "unknown key in a table": file("[pellet]\nradis = '1 cm'", "'pellet.radis'", "did you mean pellet.radius?"),
    "value for a table": file("pellet = 3", "pellet = 3", "pellet is a section"),
    "number without unit in the file": file("pellet.radius = 0.9", "pellet.radius = 0.9", "'0.9 cm'"),
    "list in the file": file("pellet.radius = ['1 cm']", "pellet.radius", "list", "'0.9 cm'"),
    "quoted switch in the file": file("reflex.enabled = 'true'", "reflex.enabled = 'true'", "without quotes"),
    "unknown scenario in the file": Mistake(
        ("validate", "my.toml"),
        ("'basline'", "did you mean baseline?"),
        files={"my.toml": "scenario = 'basline'"},
    ),
    "file too large": file("#" * (LARGEST_TEXT + 1), "my.toml", f"larger than {LARGEST_TEXT} bytes"),
    "binary file": file(b"\x80\x81\x82\xff", "my.toml", "not UTF-8"),
    "binary file with zeros": file(b"\x00\x01\x02", "my.toml", "not valid TOML"),
    # the command line itself
    "no equals sign": Mistake((*RUN, "--set", "pellet.radius"), ("'pellet.radius'", "no '='", "key=value")),
    "unknown option": Mistake((*RUN, "--overwrit"), ("--overwrit", "--overwrite", "peristalsis run --help")),
    "unknown command": Mistake(("rnu", "baseline"), ("'rnu'", "run", "peristalsis --help")),
    "option without its value": Mistake((*RUN, "--out"), ("--out", "requires", "peristalsis run --help")),
    "one argument too many": Mistake((*RUN, "again"), ("again", "peristalsis run --help")),
    "no scenario": Mistake(("run",), ("no scenario is named", "peristalsis list", "--config")),
    "no argument": Mistake(("show",), ("NAME", "peristalsis show --help")),
    "no command": Mistake(("--",), ("ommand", "peristalsis --help")),
    # where to write
    "folder exists": Mistake((*RUN, "--out", "out/old"), ("'out/old' exists", "--overwrite"), 4, STORED),
    "default folder exists": Mistake(RUN, ("'out/baseline' exists", "--out"), 4, {"out/baseline/a": "a"}),
    "a file is there": Mistake((*RUN, "--out", "here"), ("'here'", "--out"), 4, {"here": "mine"}),
    "a file is there, overwriting": Mistake(
        (*RUN, "--out", "here", "--overwrite"), ("'here' is a file", "--out"), 4, {"here": "mine"}
    ),
    "foreign files": Mistake(
        (*RUN, "--out", "photos", "--overwrite"),
        ("'photos'", "not overwritten"),
        4,
        {"photos/cat.png": "miaow"},
    ),
    "file for a parent": Mistake((*RUN, "--out", "here/out"), ("here", "--out"), 4, {"here": "mine"}),
    "parent that takes no files": Mistake((*RUN, "--out", "/proc/peristalsis/out"), ("/proc", "--out"), 4),
    "name too long": Mistake((*RUN, "--out", "x" * 300), ("too long", "--out"), 4),
    # other commands
    "unknown section": Mistake(("show", "baseline", "pelet"), ("'pelet'", "did you mean pellet?")),
    "section of a file": Mistake(("show", "baseline", "pellet", "--toml"), ("'pellet'", "--toml")),
    "unknown scenario to show": Mistake(("show", "basline"), ("'basline'", "did you mean baseline?")),
    "unknown scenario to cite": Mistake(("cite", "basline"), ("'basline'", "did you mean baseline?")),
    "folder that is no run": Mistake(("cite", "photos"), ("config.toml", "No such file"), 2, {"photos/a": "a"}),
    "nothing to plot": Mistake(("plot", "out/none"), ("'out/none'", "result.nc is missing")),
    "broken result": Mistake(("plot", "out/old"), ("'out/old'", "not a whole result", "--quarantine"), 2, STORED),
    "unknown format": Mistake(("plot", "out/old", "--format", "pgn"), ("'pgn'", "png, svg, pdf", "did you mean png?")),
    "nothing to film": Mistake(("film", "out/none"), ("'out/none'", "result.nc is missing")),
    "unknown film": Mistake(("film", "out/old", "--out", "a.doc"), ("'a.doc'", ".gif or .mp4")),
    "nothing to export": Mistake(("export", "out/none"), ("'out/none'", "result.nc is missing")),
    "unknown export": Mistake(("export", "out/old", "--format", "vtu"), ("'vtu'", "csv, vtk", "did you mean vtk?")),
    "nothing to draw in space": Mistake(("scene", "out/none"), ("'out/none'", "result.nc is missing")),
    "unknown scene": Mistake(("scene", "out/old", "--out", "a.jpg"), ("'a.jpg'", ".png, .gif, .mp4")),
    "time of a film": Mistake(("scene", "out/old", "--out", "a.gif", "--time", "1 s"), ("'1 s'", "leave it out")),
    "time without unit": Mistake(("scene", "out/old", "--time", "1"), ("--time = '1'", "the unit is missing")),
    "nothing to compare with": Mistake(("compare", "out/none"), ("'out/none'", "second folder")),
    "compared with itself": Mistake(("compare", "out/none", "out/none"), ("'out/none'", "twice")),
    "nothing to compare": Mistake(("compare", "out/none", "out/nil"), ("'out/none'", "result.nc is missing")),
    "nothing to validate": Mistake(("validate", "my.toml"), ("'my.toml'", "No such file")),
}


@pytest.fixture(autouse=True)
def nothing_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mistake must be found before the run begins."""

    def begin(*_: object) -> None:
        raise AssertionError("the run began")

    monkeypatch.setattr(running_module, "_simulate", begin)


def tree(folder: Path) -> dict[str, bytes | None]:
    """All that is in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def prepare(folder: Path, files: Files | None) -> None:
    """Put the files of a mistake in place."""
    for name, content in (files or {}).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


Ran = Callable[[Mistake, tuple[str, ...]], tuple[str, str]]


@pytest.fixture
def ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Ran:
    """Make a mistake; its stdout and stderr, once exit code and untouched files are checked."""
    monkeypatch.chdir(tmp_path)

    def make(mistake: Mistake, more: tuple[str, ...]) -> tuple[str, str]:
        prepare(tmp_path, mistake.files)
        before = tree(tmp_path)
        code = main([*more, *mistake.words] if mistake.words == ("--",) else [*mistake.words, *more])
        said = capsys.readouterr()
        assert code == mistake.code, said.err
        assert tree(tmp_path) == before
        return said.out, said.err

    return make


@pytest.mark.parametrize("mistake", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_one_clear_line_and_leaves_no_trace(mistake: Mistake, ran: Ran) -> None:
    out, err = ran(mistake, ())
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert len(err) < 600
    for words in mistake.said:
        assert words in err


@pytest.mark.parametrize(
    "mistake",
    [pytest.param(mistake, id=name) for name, mistake in MISTAKES.items() if mistake.words[-1] not in ("--out", "--")],
)
def test_with_json_a_mistake_is_one_object(mistake: Mistake, ran: Ran) -> None:
    out, err = ran(mistake, ("--json",))
    content = json.loads(out)
    assert set(content) == {"scenario", "status", "error"}
    damaged = "not a whole result" in content["error"]
    assert content["status"] == ("damaged" if damaged else {2: "invalid", 4: "write_failed"}[mistake.code])
    assert err == f"error: {content['error']}\n"


def test_there_are_many_kinds_of_mistakes() -> None:
    assert len(MISTAKES) >= 25
