"""Files that a page offers, made from a stored result in a process of their own."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from ..errors import PeristalsisError


@dataclass(frozen=True, slots=True)
class Kind:
    """A file to download: its ending, its media type, and what it is called on the page."""

    ending: str
    media: str
    label: str


KINDS = {
    "result": Kind("zip", "application/zip", "result"),
    "figure": Kind("png", "image/png", "figure"),
    "film": Kind("gif", "image/gif", "film"),
}


def make(pipe: Connection, stored: str, what: str, target: str) -> None:
    """What the process does: write the file `target` from the result in `stored`, and send None or why not."""
    try:
        _write(Path(stored), what, Path(target))
    except PeristalsisError as error:
        pipe.send(str(error))
    except Exception as error:
        pipe.send(f"unforeseen {type(error).__name__}: {error} (please report it)")
    else:
        pipe.send(None)


def _write(stored: Path, what: str, target: Path) -> None:
    from ..results.result import load

    if what == "result":
        shutil.make_archive(str(target.with_suffix("")), "zip", stored.parent, stored.name)
        return
    import matplotlib

    matplotlib.use("Agg")
    result = load(stored)
    if what == "film":
        from ..plots.film import film

        film(result, target)
        return
    result.plot.overview().savefig(target, dpi=150)
