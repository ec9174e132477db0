"""A film that a notebook plays where it stands, with nothing left on disk."""

from __future__ import annotations

import base64
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from .film import film

if TYPE_CHECKING:
    from ..results.result import Result


@dataclass(frozen=True)
class ShownFilm:
    """The film as the bytes of a GIF; the last line of a notebook's cell plays it, and `gif` is yours to store."""

    gif: bytes = field(repr=False)
    frames: int
    rate: int

    def _repr_html_(self) -> str:
        text = base64.b64encode(self.gif).decode("ascii")
        return f'<img alt="film of the tube and the pellet" src="data:image/gif;base64,{text}"/>'


def shown_film(result: Result, frames: int, rate: int) -> ShownFilm:
    """The film of a run for a notebook. Raises ConfigurationError as `film` does."""
    with tempfile.TemporaryDirectory(prefix="peristalsis-film-") as folder:
        path = film(result, Path(folder) / "film.gif", frames, rate)
        return ShownFilm(path.read_bytes(), frames, rate)
