"""Writes the report: one page with everything in it, each table as CSV, each figure as PNG and SVG."""

from __future__ import annotations

import base64
import html
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from .._version import __version__
from ..errors import could_not, shown
from ..plots import style
from ..plots.placing import whole
from .outcome import Outcome
from .score import Scored, score_all
from .source import Picture, Source, Table
from .tables import Scores, all_tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

PAGE = "report.html"
FORMATS = ("png", "svg")
FIRST = ("claims", "counts", "explanations")
"""Tables that stand above the figures."""

COLOURS = {
    "holds in part": "#fdf0c8",
    "holds": "#d5ecd9",
    "does not hold": "#f7d6d0",
    "not testable": "#e6e6e6",
    "not run": "#f4f4f4",
}
"""Background of a cell that begins with the verdict; the longer verdict stands first."""

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1250px; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; font-size: 12.5px; margin: 0.6em 0 1.6em; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: 3px 7px; text-align: left; vertical-align: top; }
th { background: #f0f0f0; } figure { margin: 1.2em 0 2em; } img { max-width: 100%; }
figcaption { font-size: 13.5px; color: #444; } summary { cursor: pointer; font-weight: 600; }
"""


def scores_of(source: Source, outcomes: Sequence[Outcome]) -> dict[str, tuple[Scored, ...]]:
    """Title of each condition to the scores of all claims."""
    return {outcome.condition.title: score_all(source.claims, outcome.measured) for outcome in outcomes}


def write_report(
    source: Source,
    outcomes: Sequence[Outcome],
    folder: str | os.PathLike[str],
    only: str | None = None,
    note: str = "",
) -> Path:
    """Write page, tables and figures into `folder` and return the page.

    only: number of the one figure to draw, without page and tables; then the figure's file is returned. note: a line at
    the top of the page. Raises WriteError.
    """
    target = Path(folder)
    chosen = [one for one in source.pictures if only is None or one.number == only]
    if only is None:
        tables = all_tables(source, outcomes, scores_of(source, outcomes))
        return write_page(source, tables, chosen, outcomes, target / PAGE, note)
    with _writing(target):
        for one in chosen:
            if one.drawable(outcomes):
                _write_picture(one, outcomes, target)
    return target / f"{chosen[0].name}.png"


def write_page(
    source: Source,
    tables: Sequence[Table],
    pictures: Sequence[Picture],
    outcomes: Sequence[Outcome],
    page: Path,
    note: str = "",
) -> Path:
    """Write a page with tables and pictures, and beside it each table as CSV and each picture; returns the page.

    note: a line at its top. Raises WriteError.
    """
    with _writing(page.parent):
        images = {one.name: _write_picture(one, outcomes, page.parent) for one in pictures if one.drawable(outcomes)}
        for table in tables:
            _write(page.parent / f"{table.name}.csv", table.csv().encode("utf-8"))
        shown_here = [(one, images[one.name]) for one in pictures if one.name in images]
        _write(page, page_of(source, tables, shown_here, note).encode("utf-8"))
    return page


def write_table(table: Table, folder: Path) -> Path:
    """Write one table as CSV into a folder and return its path. Raises WriteError."""
    path = folder / f"{table.name}.csv"
    with _writing(folder):
        _write(path, table.csv().encode("utf-8"))
    return path


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """A folder that is there to be written into. Raises WriteError where that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise could_not(f"write the report into {shown(str(folder))}", error) from None


def _write_picture(picture: Picture, outcomes: Sequence[Outcome], folder: Path) -> bytes:
    with style.applied():
        canvas: Canvas = picture.draw(outcomes)
    for ending in FORMATS:
        style.write(canvas, folder / f"{picture.name}.{ending}", picture.title, picture.caption)
    return (folder / f"{picture.name}.png").read_bytes()


def _write(path: Path, content: bytes) -> None:
    with whole(path) as temporary:
        temporary.write_bytes(content)


def page_of(source: Source, tables: Sequence[Table], pictures: Sequence[tuple[Picture, bytes]], note: str = "") -> str:
    """The whole page as text; pictures are inside it."""
    about = source.about.replace("{version}", __version__)
    parts = [
        "<!doctype html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{html.escape(source.title)}</title>',
        f"<style>{_STYLE}</style></head><body>",
        f"<h1>{html.escape(source.heading)}</h1>",
        f"<p>{html.escape(about)}</p>",
    ]
    if note:
        parts.append(f"<p><strong>{html.escape(note)}</strong></p>")
    parts += [_table(table) for table in tables if table.name in FIRST]
    for figure, image in pictures:
        number = f"Fig. {figure.number}: " if figure.number else ""
        picture = base64.b64encode(image).decode("ascii")
        parts.append(
            f'<figure><h2>{number}{html.escape(figure.title)}</h2><img alt="{html.escape(figure.title)}" '
            f'src="data:image/png;base64,{picture}"><figcaption>{html.escape(figure.caption)}</figcaption></figure>'
        )
    parts += [_table(table) for table in tables if table.name not in FIRST]
    parts += [_definitions(source), _rules(source), "</body></html>"]
    return "\n".join(parts)


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(column)}</th>" for column in table.columns)
    rows = "\n".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in table.rows)
    note = f"<p>{html.escape(table.note)}</p>" if table.note else ""
    body = f"{note}<table><tr>{head}</tr>\n{rows}</table>"
    title = html.escape(table.title)
    return f"<details><summary>{title}</summary>{body}</details>" if table.folded else f"<h2>{title}</h2>{body}"


def _cell(text: str) -> str:
    for verdict, colour in COLOURS.items():
        if text == verdict or text.startswith(f"{verdict}:"):
            return f'<td style="background:{colour}">{html.escape(text)}</td>'
    return f"<td>{html.escape(text)}</td>"


def _definitions(source: Source) -> str:
    rows = "\n".join(
        f"<tr><td>{html.escape(one.name)}</td><td>{html.escape(one.unit)}</td><td>{html.escape(one.definition)}</td></tr>"
        for one in source.metrics.values()
    )
    return (
        "<details><summary>What is measured</summary><table><tr><th>metric</th><th>unit</th><th>definition</th></tr>"
        f"{rows}</table></details>"
    )


def _rules(source: Source) -> str:
    """Every rule as it stands in the program."""
    rows = "\n".join(
        f"<tr><td>{source.label(claim.number)}</td><td>{html.escape(part.name)}</td><td><code>{html.escape(repr(part.rule))}</code></td></tr>"
        for claim in source.claims
        for part in claim.parts
    )
    return (
        "<details><summary>Rules</summary><table><tr><th>claim</th><th>part</th><th>rule</th></tr>"
        f"{rows}</table></details>"
    )


def lines(source: Source, scores: Scores) -> list[tuple[str, ...]]:
    """Rows for a screen: number, statement, and the verdict under each condition."""
    first = next(iter(scores.values()))
    return [
        (source.label(one.claim.number), one.claim.statement, *(every[index].verdict for every in scores.values()))
        for index, one in enumerate(first)
    ]
