"""What makes a site of the pages: links out of `docs`, pages of the root, and whether every public name is there.

The pages are written to be read where they lie, in the repository. On the site a link to a file that is no page
becomes the path of that file, since a site has nowhere to lead it; a link to nothing is left, and breaks the build.
"""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"

ROOT_PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
"""Pages in the root of the repository, and the page of `docs` that includes each."""
SHOWN_AS_FILES = (".png", ".csv", ".json", ".gif", ".svg")
"""Files beside the pages that the site shows or hands out."""
PUBLIC = ("peristalsis", "peristalsis.maps")
"""Modules whose `__all__` must be in the reference."""

BESIDE = "\n\n```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"
"""Puts the other pages of a folder below its README, which does not name all of them for readers of the site."""

FIGURES = "<!-- figures -->"
"""Where a page wants the table of all figures."""

INCLUDE = re.compile(r"^```\{include\} (\S+)\n```$", re.MULTILINE)
FENCE = re.compile(r"^(```|~~~).*?^\1\s*$|^    [^\n]*$|`[^`\n]+`(?!\])", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def for_the_site(text: str, page: Path) -> str:
    """The text of a page (its path in the repository) as Sphinx is to read it, includes of root pages carried out."""

    def included(found: re.Match[str]) -> str:
        source = (page.parent / found[1]).resolve()
        return relinked(source.read_text(encoding="utf-8"), source, page.parent)

    if INCLUDE.search(text):
        return INCLUDE.sub(included, text)
    return relinked(text, page, page.parent)


def relinked(text: str, page: Path, folder: Path) -> str:
    """A page's text with its links as they are seen from `folder`; code is left as it is.

    Sphinx does not know Mermaid: its picture is shown as the text it is.
    """
    parts, end = [], 0
    for code in FENCE.finditer(text):
        parts += [_links(text[end : code.start()], page, folder), code[0].replace("```mermaid", "```text", 1)]
        end = code.end()
    return "".join([*parts, _links(text[end:], page, folder)])


def _links(text: str, page: Path, folder: Path) -> str:
    return LINK.sub(lambda found: _link(found, page, folder), text)


def _link(found: re.Match[str], page: Path, folder: Path) -> str:
    mark, words, target = found.groups()
    words = _links(words, page, folder)
    place, hash_mark, anchor = target.partition("#")
    if re.match(r"[a-z]+:", target) or not place:
        return f"{mark}[{words}]({target})"
    file = (page.parent / place).resolve()
    if file.is_dir() and (file / "README.md").is_file():
        file = file / "README.md"
    elif file.is_dir() and file.with_suffix(".md").is_file():
        file = file.with_suffix(".md")
    name = ROOT_PAGES.get(file.name) if file.parent == ROOT else None
    file = DOCS / name if name else file
    if not file.exists() or (DOCS in file.parents and file.suffix in (".md", *SHOWN_AS_FILES)):
        return f"{mark}[{words}]({_way(file, folder)}{hash_mark}{anchor})"
    path = file.relative_to(ROOT).as_posix() if file.is_relative_to(ROOT) else place
    return words if path in words else f"{words} (`{path}`)"


def _way(file: Path, folder: Path) -> str:
    from os.path import relpath

    return Path(relpath(file, folder)).as_posix()


def read(app: Sphinx, name: str, source: list[str]) -> None:
    """Called by Sphinx with each page before it is read."""
    page = Path(app.env.doc2path(name))
    if page.suffix == ".md":
        source[0] = for_the_site(source[0], page)
    if page.name == "README.md":
        source[0] += BESIDE
    if FIGURES in source[0]:
        source[0] = source[0].replace(FIGURES, figures())


def figures() -> str:
    """All figures of a run as a table: name, title, caption."""
    from peristalsis.plots.registry import figures as known

    rows = (f"| `{name}` | {one.title} | {one.caption} |" for name, one in known().items())
    return "\n".join(["| figure | title | what it shows |", "|---|---|---|", *rows])


def public_names() -> set[str]:
    """Full names of what users may rely on: the package's, its maps', errors and figures."""
    from peristalsis import errors

    names = {f"{module}.{name}" for module in PUBLIC for name in importlib.import_module(module).__all__}
    classes = [errors.PeristalsisError]
    for one in classes:
        classes.extend(one.__subclasses__())
    return names | {f"peristalsis.errors.{one.__name__}" for one in classes if one.__module__ == errors.__name__}


def complete(app: Sphinx, env: BuildEnvironment) -> list[str]:
    """Called by Sphinx when all pages are read: warn of public names that no page describes."""
    from sphinx.util import logging

    described = set(env.domains["py"].objects)
    for name in sorted(public_names() - described):
        logging.getLogger(__name__).warning("%s is public and has no entry in the reference", name)
    return []


def leave_out(app: Sphinx, kind: str, name: str, member: object, skip: bool, options: object) -> bool | None:
    """Leave out fields of named tuples, of which Python says their number alone; the signature names them all."""
    return True if str(inspect.getdoc(member)).startswith("Alias for field number") else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx when it starts."""
    app.connect("source-read", read)
    app.connect("env-updated", complete)
    app.connect("autodoc-skip-member", leave_out)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
