"""How pages become a site: links out of the pages, root pages, links that lead nowhere, the reference."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
from pathlib import Path
from types import ModuleType

import pytest

SITE = Path(__file__).parents[2] / "docs" / "site"


def module(name: str) -> ModuleType:
    """A module of docs/site, which is no package."""
    specification = importlib.util.spec_from_file_location(f"site_{name}", SITE / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    loaded = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(loaded)
    return loaded


pages, links = module("pages"), module("links")
DOCS = pages.DOCS


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("[cells](cells.md)", "[cells](cells.md)"),
        ("[cells](cells.md#a-cell)", "[cells](cells.md#a-cell)"),
        ("[home](../README.md)", "[home](index.md)"),
        ("[all](decisions/)", "[all](decisions/README.md)"),
        ("[measured](evidence/)", "[measured](evidence.md)"),
        ("[that file](../src/peristalsis/errors.py)", "that file (`src/peristalsis/errors.py`)"),
        ("[`examples`](../examples/)", "`examples`"),
        ("[nothing](nothing.md)", "[nothing](nothing.md)"),
        ("`[code](../src/peristalsis/errors.py)`", "`[code](../src/peristalsis/errors.py)`"),
        ("[far](https://example.org/a.py)", "[far](https://example.org/a.py)"),
        ("![map](images/diameter_map.png)", "![map](images/diameter_map.png)"),
    ],
)
def test_links_lead_somewhere_on_the_site(written: str, read: str) -> None:
    """Pages keep their links, files become their paths, and what is wrong stays wrong so that the build says so."""
    assert pages.for_the_site(written, DOCS / "laws.md") == read


def test_a_root_page_is_read_with_its_links_as_seen_from_the_pages() -> None:
    """The front page is the README, and no link of it leaves the pages."""
    front = pages.for_the_site((DOCS / "index.md").read_text(encoding="utf-8"), DOCS / "index.md")
    assert front.startswith("# peristalsis\n")
    assert "](docs/" not in front
    assert "[Tutorial](tutorial.md)" in front
    assert "[Contributing](contributing.md)" in front
    assert "(images/diameter_map.png)" in front


def test_a_picture_in_mermaid_is_shown_as_text() -> None:
    """Sphinx would warn of a language that it does not know."""
    assert "```mermaid" not in pages.for_the_site("```mermaid\na --> b\n```\n", DOCS / "architecture.md")


@pytest.mark.parametrize(
    ("link", "number"), [("b.html", 0), ("b.html#here", 0), ("b.html#gone", 1), ("c.html", 1), ("https://c.org", 0)]
)
def test_a_link_to_nothing_is_found(link: str, number: int, tmp_path: Path) -> None:
    """Files and places in them are looked for; what is elsewhere is not."""
    (tmp_path / "a.html").write_text(f'<a href="{link}">x</a>', encoding="utf-8")
    (tmp_path / "b.html").write_text('<p id="here">x</p>', encoding="utf-8")
    count, broken = links.broken(tmp_path)
    assert (count, len(broken)) == (0 if ":" in link else 1, number)


def test_public_names_say_what_they_are() -> None:
    """Each public function and class has a docstring of its own, and each function's arguments have types."""
    for full in sorted(pages.public_names()):
        home, _, name = full.rpartition(".")
        one = getattr(importlib.import_module(home), name)
        if not callable(one):
            continue
        assert inspect.getdoc(one), full
        assert one.__doc__ is not None, full
        if inspect.isfunction(one):
            untyped = [a for a, about in inspect.signature(one).parameters.items() if about.annotation is about.empty]
            assert not untyped, full
