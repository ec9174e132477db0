"""What a figure is: a name, what it shows, and the function that draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure as data. `draw(result, **options)` returns a matplotlib Figure that belongs to no window.

    `caption` says what is plotted as a journal would print it; `needs_pellet` keeps it from runs without one, and
    `fields` from runs that did not store these.
    """

    name: str
    title: str
    caption: str
    draw: Callable[..., Canvas]
    needs_pellet: bool = False
    fields: tuple[str, ...] = ()
