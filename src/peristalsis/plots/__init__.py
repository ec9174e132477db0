"""Figures of a run: `result.plot.diameter_map()`, `result.plot.save("figures")`, `result.plot.film("run.gif")`.

A new figure is a new module in `plots/figures` with ``FIGURE = Figure(...)``; nothing else has to be told.
Matplotlib is imported when something is drawn, not before.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, could_not, nearest, shown, suggestion
from ..paths import located
from .registry import figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ..results.result import Result
    from .explorer import Explorer
    from .shown_film import ShownFilm

FORMATS = ("png", "svg", "pdf")


class Plots:
    """The figures of one result; each name of `names()` is also a method that returns a matplotlib Figure."""

    def __init__(self, result: Result) -> None:
        self._result = result
        self.skipped: dict[str, str] = {}
        """Figures that the last `save` left out because the run cannot show them, and why."""

    @staticmethod
    def names() -> tuple[str, ...]:
        """All figures, the overview first."""
        return tuple(figures())

    def available(self) -> tuple[str, ...]:
        """The figures this run can show: without a pellet, those that need none, and of the fields that it stored."""
        pellet, arrays = self._result.configuration.pellet.enabled, self._result.arrays
        return tuple(
            name
            for name, figure in figures().items()
            if (pellet or not figure.needs_pellet) and all(field in arrays for field in figure.fields)
        )

    def caption(self, name: str) -> str:
        """What the figure shows, in the words of a figure caption."""
        return _figure(name).caption

    def draw(self, name: str, **options: Any) -> Canvas:
        """The figure of this name. Raises ConfigurationError for unknown names and where a pellet is missing."""
        figure = _figure(name)
        if figure.needs_pellet and not self._result.configuration.pellet.enabled:
            raise ConfigurationError(
                f"plot.{name} shows the pellet, and this run has none (pellet.enabled = false); "
                f"draw one of {', '.join(self.available())}"
            )
        from . import style

        with style.applied():
            return figure.draw(self._result, **options)

    def save(
        self,
        folder: str | os.PathLike[str],
        names: Iterable[str] | None = None,
        formats: Iterable[str] = ("png",),
    ) -> list[Path]:
        """Write figures into `folder` as <name>.<format> and return the files; by default all that are available.

        formats: png, svg, pdf. Figures that nobody named and this run cannot show are left out: `skipped` says why.
        Raises ConfigurationError for unknown names or formats, WriteError if it cannot write.
        """
        endings = _several(formats)
        for ending in endings:
            if ending not in FORMATS:
                raise ConfigurationError(f"format {shown(ending)} is not offered; {suggestion(ending, FORMATS)}")
        chosen = self.names() if names is None else _several(names)
        self.skipped = {}
        for name in chosen:
            _figure(name)
        from . import style

        target = located(folder)
        written = []
        try:
            target.mkdir(parents=True, exist_ok=True)
            for name in chosen:
                try:
                    canvas = self.draw(name)
                except ConfigurationError as error:
                    if names is not None:
                        raise
                    self.skipped[name] = str(error)
                    continue
                for ending in endings:
                    path = target / f"{name}.{ending}"
                    style.write(canvas, path, _figure(name).title, _figure(name).caption)
                    written.append(path)
        except OSError as error:
            raise could_not(f"write figures into {shown(str(target))}", error, "another folder") from None
        return written

    def film(self, path: str | os.PathLike[str], frames: int = 100, rate: int = 20) -> Path:
        """Write a film of wall and pellet to `path` (.gif, or .mp4 where ffmpeg is there); see `plots.film`."""
        from .film import film

        return film(self._result, path, frames, rate)

    def show_film(self, frames: int = 40, rate: int = 10) -> ShownFilm:
        """The film as an object that a notebook plays; `frames` pictures over the run, `rate` a second."""
        from .shown_film import shown_film

        return shown_film(self._result, frames, rate)

    def explore(self, frames: int = 40) -> Explorer:
        """Tube, diameter map and numbers with a slider for the time, for a notebook; `frames` times over the run."""
        from .explorer import explorer

        return explorer(self._result, frames)

    def scene(self, path: str | os.PathLike[str], **options: Any) -> Path:
        """Write a picture (.png) or a film (.gif, .mp4) of the tube in space; see `plots.scene`. Needs pyvista."""
        from .scene import scene

        return scene(self._result, path, **options)

    def __getattr__(self, name: str) -> Callable[..., Canvas]:
        known = figures()
        if name not in known:
            near = None if name.startswith("_") else nearest(name, known)
            hint = f"; did you mean {near}?" if near else ""
            raise AttributeError(f"there is no figure {name!r}{hint}")
        drawer = functools.partial(self.draw, name)
        drawer.__doc__ = f"{known[name].title}. {known[name].caption}"
        return drawer

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *figures()})


def _figure(name: str) -> Any:
    known = figures()
    if name not in known:
        raise ConfigurationError(f"there is no figure {shown(name)}; {suggestion(str(name), known)}")
    return known[name]


def _several(items: Iterable[str]) -> tuple[str, ...]:
    """A tuple of names; a single one may be given as plain text."""
    return (items,) if isinstance(items, str) else tuple(items)
