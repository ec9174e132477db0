"""The pages are tried as a reader tries them: what they show runs, in the order of the page, in an empty folder.

Python blocks, and the commands in shell blocks, in indented lines and in running text, are carried out on tiny grids
and for some milliseconds; TOML blocks are read as `validate` and `batch` read them. A block below the comment
`<!-- not run: why -->` is left out, and one below `<!-- file: NAME -->` is a file that the reader makes.
"""

from __future__ import annotations

import glob
import re
import shlex
import shutil
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

import benchmarks.command
import peristalsis as ps
import verification.command
from peristalsis import names, plugins, scenarios
from peristalsis.cli.dispatch import dispatch
from peristalsis.inputs.config import Configuration
from peristalsis.many.plan import read_plan
from peristalsis.many.studies.study import read_study
from peristalsis.plots.scene import problem

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
STEP = re.compile(
    r"(?P<not_run><!-- not run: \S[^>]*-->\s+)?(?:<!-- file: (?P<file>\w+\.\w+) -->\s+)?"
    r"^```(?P<language>\w+)\n(?P<block>.*?)^```"
    r"|^    (?P<indented>(?:peristalsis|make|python) [^\n]*)$"
    r"|`(?P<inline>(?:peristalsis [a-z]+|python -m (?:verification|benchmarks)) [^`]*)`",
    re.MULTILINE | re.DOTALL,
)
SHELL = ("sh", "bash", "console")

TINY = {"grid.n_z": 50, "grid.n_z_wall": 40}
SHORT = 0.01
"""Simulated seconds of a run that a page begins; what it advances by hand it advances for as long as it says."""
FEW_COLUMNS = 8
FEW_FIGURES = ("diameter_map", "track")

LONG = {
    "cohort": "runs some hundred members; tests/unit/test_cohort.py",
    "sensitivity": "needs pellets that arrive; tests/unit/test_indices.py",
    "paper": "runs every experiment; tests/unit/test_paper_report.py",
    "bench": "runs every assay; tests/unit/test_bench.py",
    "app": "serves until it is ended; tests/app",
    "dose-response": "compares motion, and there is none within milliseconds; tests/unit/test_dose_response.py",
    "passes": "needs pellets that pass; tests/unit/test_passes.py",
    "fit": "finds nothing in runs of milliseconds; tests/unit/test_fit.py",
}
"""Commands that are parsed and not carried out here, and where they are."""
BESIDE = {"verification": verification.command.app, "benchmarks": benchmarks.command.app}
"""Programs of the repository beside the command: they take minutes, so what a page shows of them is parsed."""
RUN_BY_ITS_OWN_TEST = "tutorial.md"
"""Python of this page: tests/examples/test_tutorial.py."""


class Step(NamedTuple):
    """Something that a page shows: `kind` is python, toml, command, beside or make; `line` is where."""

    kind: str
    text: str
    line: int


def steps(page: Path) -> Iterator[Step]:
    """What a page shows, in its order."""
    text = page.read_text(encoding="utf-8")
    for found in STEP.finditer(text):
        line = text[: found.start()].count("\n") + 1
        if found["not_run"]:
            continue
        if found["file"]:
            yield Step("file", f"{found['file']}\n{found['block']}", line + 1)
            continue
        if found["language"] in ("python", "toml"):
            yield Step(found["language"], found["block"], line + 1)
        elif found["language"] in SHELL or not found["language"]:
            shown = found["block"] or found["indented"] or found["inline"]
            for said in shown.replace("\\\n", " ").splitlines():
                words = shlex.split(said.removeprefix("$ "), comments=True)
                if words[:2] == ["python", "-m"] and words[2] in BESIDE:
                    yield Step("beside", shlex.join(words[2:]), line)
                elif words:
                    yield Step(
                        {"peristalsis": "command", "make": "make"}.get(words[0], "other"), shlex.join(words[1:]), line
                    )


SHOWN = {page.name: list(steps(page)) for page in PAGES}


def tiny(configuration: Configuration, duration: float | None) -> Configuration:
    """The same on few cells, for a short time."""
    changes: dict[str, Any] = dict(TINY)
    if configuration.grid.n_theta > FEW_COLUMNS:
        changes["grid.n_theta"] = FEW_COLUMNS
    if duration is not None and configuration.run.duration > duration:
        changes["run.duration"] = f"{max(duration, 1e-3 * configuration.step.wall)} s"  # a step at the least
    return configuration.with_changes(changes)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Folders of tiny runs by scenario, as `make demo` and `peristalsis run` leave them; each is run once."""
    place, made = tmp_path_factory.mktemp("stored"), {}

    def run(scenario: str) -> Path:
        if scenario not in made:
            made[scenario] = place / scenario
            ps.run(scenario, {**TINY, "run.duration": f"{SHORT} s"}, out=made[scenario])
        return made[scenario]

    return run


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with the files that examples name; runs begun in it are small, outputs do not outlive it."""
    (tmp_path / "pressure.csv").write_text("time [s],value [kPa]\n0,0.1\n1,0.2\n", encoding="utf-8")
    (tmp_path / "biopsy.csv").write_text("z [cm] / angle [deg],0\n4.0,1.0\n5.0,0.5\n", encoding="utf-8")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    whole = scenarios.configuration
    monkeypatch.setattr(scenarios, "configuration", lambda *given, **named: tiny(whole(*given, **named), SHORT))
    monkeypatch.setattr(ps, "configuration", lambda *given, **named: tiny(whole(*given, **named), None), raising=False)
    known = set(names.OUTPUTS)
    yield tmp_path
    plugins.forget_all()
    for name in set(names.OUTPUTS) - known:
        one = names.OUTPUTS[name]
        if one in names.HOMES.get(one.dimensions, ()):  # registered; states of a cell are known from its first run on
            names.forget(name)


COMPILES = ("activation.md", "explicit.md", "laws.md", "shapes.md", "whole_surface.md")
"""Pages that compile kernels of their own for a minute each: run in the slow tier, read in the quick one."""


def runnable() -> list[Any]:
    """Pages that show something; those that compile are slow."""
    return [pytest.param(page, marks=pytest.mark.slow if page in COMPILES else ()) for page in SHOWN if SHOWN[page]]


@pytest.mark.parametrize("page", COMPILES)
def test_what_a_slow_page_shows_can_be_read(page: str, folder: Path) -> None:
    """Python compiles, files are taken, commands and options are those of the program."""
    assert SHOWN[page]
    for kind, text, line in SHOWN[page]:
        if kind == "python":
            compile(text, page, "exec")
        elif kind == "command" and "--plugin" not in text:
            parsed([word for word in shlex.split(text) if not word.isupper()], f"{page}:{line}")


@pytest.mark.parametrize("page", runnable())
def test_page_runs(page: str, folder: Path, stored: Callable[[str], Path]) -> None:
    """A reader who does what the page says, from top to bottom, meets no error."""
    namespace: dict[str, object] = {"__name__": "page"}
    for kind, text, line in SHOWN[page]:
        where = f"{page}:{line}"
        if kind == "file":
            name, _, content = text.partition("\n")
            (folder / name).write_text(content, encoding="utf-8")
        elif kind == "python" and page != RUN_BY_ITS_OWN_TEST:
            exec(compile("\n" * (line - 1) + text, page, "exec"), namespace)
        elif kind == "toml":
            read(text, folder)
        elif kind == "make":
            assert re.search(rf"^{text.split()[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), where
        elif kind == "command":
            carry_out(shlex.split(text), folder, stored, where)
        elif kind == "beside":
            program, *words = shlex.split(text)
            typer.main.get_command(BESIDE[program]).make_context(program, [w for w in words if not w.isupper()])


def read(text: str, folder: Path) -> None:
    """As `validate` and `batch` read it; a first line `# NAME.toml` names the file that later lines speak of."""
    named = re.match(r"# (\w+\.toml)\n", text)
    file = folder / (named[1] if named else "example.toml")
    file.write_text(text, encoding="utf-8")
    tables = tomllib.loads(text)
    if "parameters" in tables:
        assert all(point.configuration is not None for point in read_study(file, ("map",)).points([{}]))
    elif {"points", "changes"} & tables.keys() or any("." in key for key in tables.get("grid", {})):
        assert all(point.configuration is not None for point in read_plan(file).points)
    else:
        assert dispatch(["validate", str(file)]) == 0
        assert ps.configuration(file=file) is not None


def carry_out(words: list[str], folder: Path, stored: Callable[[str], Path], where: str) -> None:
    """A command of the page; runs that it reads and that no line above made are those of `make demo` and the like."""
    if any(word.isupper() for word in words[1:]):  # a placeholder, such as ID
        words = [word for word in words if not word.isupper()]
        return parsed(words, where)
    if words[0] in LONG:
        return parsed(words, where)
    if words[0] not in ("run", "batch"):
        for name in (Path(word).name for word in words if re.fullmatch(r"out/\w+", word)):
            if not (folder / "out" / name).exists() and name in scenarios.names():
                shutil.copytree(stored(name), folder / "out" / name)
        if "out/*" in words and not (folder / "out").exists():
            shutil.copytree(stored("baseline"), folder / "out" / "baseline")
    expanded = [one for word in words for one in (sorted(glob.glob(word)) if word == "out/*" else [word])]
    if words[0] == "run" and "--no-plots" not in words:
        expanded.append("--no-plots")
    if words[0] == "plot" and len(words) == 2:
        expanded += FEW_FIGURES  # all of them: tests/unit/test_plots.py
    if "--workers" in words:
        expanded[words.index("--workers") + 1] = "1"  # fresh processes would not know what is small here
    code = dispatch(expanded)
    if words[0] == "scene" and problem() is not None:
        assert code == 2, f"{where}: the sentence that says what is missing"
    else:
        assert code == 0, f"{where}: peristalsis {shlex.join(words)}"
    return None


def parsed(words: list[str], where: str) -> None:
    """Whether name and options of a command are those of the program."""
    from peristalsis.cli.commands import app

    group: Any = typer.main.get_command(app)
    with group.context_class(group) as context:
        name, command, rest = group.resolve_command(context, list(words))
        assert command is not None, where
        command.make_context(name, rest, parent=context, resilient_parsing=False)


def test_there_are_steps_of_every_kind() -> None:
    """The rule must not go silent when a fence changes."""
    count = {kind: sum(step.kind == kind for shown in SHOWN.values() for step in shown) for kind in ("toml", "python")}
    assert min(count.values()) >= 3, count
    commands = [step.text.split()[0] for shown in SHOWN.values() for step in shown if step.kind == "command"]
    assert len(commands) >= 25
    assert {"run", "compare", "batch", "check", "export", "plot", "film", "scene", "show"} <= set(commands)
    assert len({step.text for step in SHOWN["README.md"]}) >= 12
