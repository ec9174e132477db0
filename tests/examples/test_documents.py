"""Fenced blocks of README and docs: TOML validates, commands parse, Python names what is there."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import peristalsis as ps
from peristalsis.cli.commands import app
from peristalsis.config import Configuration
from peristalsis.plan import read_plan

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
SHELL = ("sh", "bash", "console")
NOT_RUN = "# not run"
"""A block with this comment is looked at and not tried."""


def blocks(*languages: str) -> Iterator[tuple[str, str]]:
    """(name, text) of the blocks in these languages."""
    for file in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        for number, found in enumerate(FENCE.finditer(file.read_text(encoding="utf-8")), start=1):
            if found[1] in languages and NOT_RUN not in found[2]:
                yield f"{file.name} {number}", found[2]


def cases(*languages: str) -> list[object]:
    return [pytest.param(text, id=name) for name, text in blocks(*languages)]


@pytest.fixture
def beside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that examples name."""
    (tmp_path / "pressure.csv").write_text("time [s],value [kPa]\n0,0.1\n1,0.2\n", encoding="utf-8")
    angles = "z [cm] / angle [deg],0\n4.0,1.0\n5.0,0.5\n"
    (tmp_path / "biopsy.csv").write_text(angles, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("text", cases("toml"))
def test_toml_is_a_configuration_or_a_batch(text: str, beside: Path) -> None:
    """As `validate` and `batch` would read it from a file."""
    file = beside / "example.toml"
    file.write_text(text, encoding="utf-8")
    tables = tomllib.loads(text)
    if {"points", "changes"} & tables.keys() or any("." in key for key in tables.get("grid", {})):
        assert all(point.configuration is not None for point in read_plan(file).points)
    else:
        assert isinstance(ps.configuration(file=file), Configuration)


def commands() -> list[object]:
    """Lines of the shell blocks that call the program, without their comments."""
    found = []
    for name, text in blocks(*SHELL):
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line.removeprefix("$ "), comments=True)
            if words[:1] == ["peristalsis"]:
                found.append(pytest.param(words[1:], id=f"{name}: {' '.join(words[1:])[:60]}"))
    return found


@pytest.mark.parametrize("words", commands())
def test_commands_are_parsed(words: list[str]) -> None:
    """Name of the command, options and arguments are those of the program; settings and scenarios are there."""
    import typer

    group: Any = typer.main.get_command(app)
    with group.context_class(group) as context:
        name, command, rest = group.resolve_command(context, list(words))
        assert command is not None
        options = command.make_context(name, rest, parent=context).params
    if name == "run" and isinstance(options.get("name"), str):
        from peristalsis.cli.inputs import read_settings

        settings = options.get("settings") or options.get("set_") or ()
        assert ps.configuration(options["name"], changes=read_settings(settings)) is not None
    if name == "batch":
        assert read_plan(ROOT / str(options["file"])).points


@pytest.mark.parametrize("text", cases("python"))
def test_python_compiles_and_names_what_is_there(text: str) -> None:
    """Names of the package in it exist; what the tutorial computes is run by its own test."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ps":
            assert hasattr(ps, node.attr), node.attr
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("peristalsis"):
            module = __import__(str(node.module), fromlist=["*"])
            assert all(hasattr(module, alias.name) for alias in node.names)


def test_there_are_blocks_of_every_kind() -> None:
    """The rule must not go silent when a fence changes."""
    assert min(len(cases("toml")), len(commands()), len(cases("python"))) >= 3
