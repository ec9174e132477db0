"""What a section is, what it is handed, and what it returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from .ledger import Ledger

Effort = Literal["quick", "full"]


@dataclass(frozen=True)
class Figure:
    """One measured number beside what was aimed at; high or low is the aim, nan for a number without one."""

    what: str
    value: float | None
    unit: str = ""
    low: float = math.nan
    high: float = math.nan
    note: str = ""

    @property
    def aim(self) -> str:
        """The aim in words."""
        if not math.isnan(self.high):
            return f"≤ {self.high:g}"
        return f"≥ {self.low:g}" if not math.isnan(self.low) else "–"

    @property
    def met(self) -> bool | None:
        """Whether the aim is met; None without one, or without a number."""
        if self.value is None or (math.isnan(self.low) and math.isnan(self.high)):
            return None
        return not (self.value < self.low or self.value > self.high)


@dataclass(frozen=True)
class Table:
    """A table with its caption; cells are text or numbers."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Line:
    """A curve of a plot; style "" draws points alone."""

    label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    style: str = "-"
    marker: str = "o"


@dataclass(frozen=True)
class Plot:
    """A picture with logarithmic axes, NAME.png."""

    name: str
    title: str
    x: str
    y: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Findings:
    """What a section found: figures for the first page, the rest for its own."""

    figures: tuple[Figure, ...]
    tables: tuple[Table, ...] = ()
    notes: tuple[str, ...] = ()
    plots: tuple[Plot, ...] = ()

    def kept(self) -> dict[str, Any]:
        """As it is kept between calls."""
        return asdict(self)

    @classmethod
    def of(cls, kept: Mapping[str, Any]) -> Findings:
        """The findings that were kept; numbers that are not finite had become null."""

        def figure(one: Mapping[str, Any]) -> Figure:
            bounds = {name: math.nan if one[name] is None else one[name] for name in ("low", "high")}
            return Figure(**{**one, **bounds})

        def line(one: Mapping[str, Any]) -> Line:
            return Line(**{**one, "x": tuple(one["x"]), "y": tuple(one["y"])})

        return cls(
            tuple(figure(one) for one in kept["figures"]),
            tuple(
                Table(one["caption"], tuple(one["head"]), tuple(tuple(row) for row in one["rows"]))
                for one in kept["tables"]
            ),
            tuple(kept["notes"]),
            tuple(Plot(**{**one, "lines": tuple(line(inner) for inner in one["lines"])}) for one in kept["plots"]),
        )


@dataclass
class Bench:
    """What a section is handed: how much effort it may take, and where its measurements are kept.

    say: told which measurement begins. Measurements are plain data; one that is kept is not made again.
    """

    effort: Effort
    ledger: Ledger
    section: str = ""
    say: Callable[[str], None] = field(default=lambda text: None)

    @property
    def full(self) -> bool:
        """Whether time does not matter."""
        return self.effort == "full"

    def repeats(self, quick: int = 5, full: int = 9) -> int:
        """How often to repeat a measurement."""
        return full if self.full else quick

    def piece(self, name: str, measure: Callable[[], Any]) -> Any:
        """The kept measurement of this name (of this code, machine and effort), or a new one, kept at once."""
        found = self.ledger.find(self.effort, name)
        if found is not None:
            return found
        self.say(name)
        return self.ledger.keep(self.effort, name, measure(), self.section)


@dataclass(frozen=True)
class Section:
    """A part of the bench that runs on its own. about: what is measured, and how, for its page."""

    name: str
    title: str
    about: str
    run: Callable[[Bench], Findings]
    place: int = 50
