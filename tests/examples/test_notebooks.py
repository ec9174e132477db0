"""The notebooks of docs/tutorials run from top to bottom, and what the last line of a cell shows can be shown.

`make docs` carries them out in kernels of their own; here their cells run as plain Python.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from peristalsis import names, plugins, scenarios
from peristalsis.errors import PeristalsisError

FOLDER = Path(__file__).parents[2] / "docs" / "tutorials"
NOTEBOOKS = sorted(file.stem for file in FOLDER.glob("*.md") if file.stem != "index")
SLOW = ("drugs", "fit_a_track", "whole_surface", "your_own_colon")
"""Notebooks of ten runs and more, or of a long one."""
CELL = re.compile(r"^```\{code-cell\}\n(?P<tags>:tags: \[.*\]\n\n)?(?P<code>.*?)^```", re.MULTILINE | re.DOTALL)
MOST_SHOWN = 80_000
"""Characters that an object other than a film may put into a notebook."""


@pytest.fixture
def forgetful() -> Iterator[None]:
    """What a notebook registers is forgotten after it."""
    known, experiments = set(names.OUTPUTS), set(scenarios.names())
    yield
    plugins.forget_all()
    for name in set(names.OUTPUTS) - known:
        names.forget(name)
    assert set(scenarios.names()) == experiments


def shown(value: object) -> str | bytes | None:
    """What a notebook shows of a value."""
    for method in ("_repr_html_", "_repr_png_"):
        if hasattr(type(value), method):
            return getattr(value, method)()
    return repr(value)


@pytest.mark.parametrize(
    "notebook", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in NOTEBOOKS]
)
def test_notebook_runs(notebook: str, forgetful: None) -> None:
    """No cell fails but those that are marked to show an error, and these do fail, with a sentence of the package."""
    text = (FOLDER / f"{notebook}.md").read_text(encoding="utf-8")
    cells = list(CELL.finditer(text))
    assert cells
    assert len(cells) == text.count("```{code-cell}")
    namespace: dict[str, object] = {"__name__": "notebook"}
    for cell in cells:
        line = text[: cell.start("code")].count("\n")
        tree = ast.parse("\n" * line + cell["code"], f"{notebook}.md")
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        if cell["tags"] and "raises-exception" in cell["tags"]:
            assert last is not None
            with pytest.raises(PeristalsisError):
                eval(compile(ast.Expression(last.value), f"{notebook}.md", "eval"), namespace)
            continue
        exec(compile(tree, f"{notebook}.md", "exec"), namespace)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), f"{notebook}.md", "eval"), namespace)
            picture = shown(value)
            if isinstance(picture, str) and type(value).__name__ != "ShownFilm":
                assert len(picture) < MOST_SHOWN


def test_every_notebook_is_on_the_list() -> None:
    """The page of the notebooks names each of them, once."""
    listed = re.search(r"```\{toctree\}\n\n?(.*?)```", (FOLDER / "index.md").read_text(encoding="utf-8"), re.DOTALL)
    assert listed is not None
    assert sorted(listed[1].split()) == NOTEBOOKS
