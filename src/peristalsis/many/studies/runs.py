"""The runs of a study: points in, rows out, each kept once for all studies that share a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...running.pool import Workers
from ..engine import rows_of
from ..kept import Store
from ..rows import Point, Row, Step
from ..sweep import Measured
from .outputs import KIND, measure


@dataclass(frozen=True)
class Runs:
    """Where runs are kept, who makes those that are missing, and who is told of each."""

    kept: Path
    workers: Workers = 1
    progress: Callable[[Step], None] | None = None

    def rows(self, points: Sequence[Point]) -> tuple[Row, ...]:
        """The row of every point, in order."""
        return rows_of(points, keeping(self.kept), self.workers, self.progress)

    def hashes(self, points: Sequence[Point]) -> tuple[str, ...]:
        """What identifies the experiment and code of every point; empty where its configuration was refused."""
        kept = keeping(self.kept)
        return tuple("" if one.configuration is None else kept.key(one.configuration) for one in points)


def keeping(folder: Path) -> Measured:
    """How runs of studies are kept in a folder."""
    return Measured(Store(folder), measure, KIND)


def kept_beside(out: Path) -> Path:
    """Where runs are kept unless said otherwise: in the folder `kept` beside that of the study, for all of them."""
    return out.parent / "kept"
