"""What a command line asks for, as records: made by the commands, carried out by what they load only then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..errors import ConfigurationError, shown


@dataclass(frozen=True)
class StudyOrder:
    """What a command line asks of a study. workers: processes, or the address of a scheduler."""

    file: str
    out: str | None
    workers: int | str
    kept: str | None = None
    parquet: bool = False
    plots: bool = True
    reading: str | None = None


@dataclass(frozen=True)
class MapOrder:
    """What a command line asks of one or two maps; texts as they were typed."""

    files: tuple[str, ...]
    synthetic: bool = False
    quantity: str | None = None
    unit: str | None = None
    oral: str = "first"
    positions: str | None = None
    variable: str | None = None
    mm_per_px: float | None = None
    s_per_px: float | None = None
    grey: str | None = None
    time: str | None = None
    resample: str | None = None
    despike: str | None = None
    level: str | None = None
    threshold: str | None = None
    segment: str | None = None
    track: str | None = None
    between: str | None = None
    align: str | None = None
    course: str | None = None
    stimuli: str | None = None
    write: tuple[str, ...] = ()
    formats: tuple[str, ...] = ()
    out: str | None = None
    overwrite: bool = False

    def stated(self) -> dict[str, Any]:
        """What `maps.read` is told of the files."""
        from ..maps.recording import QUANTITIES
        from ..maps.words import greys

        given = {
            key: getattr(self, key)
            for key in ("quantity", "unit", "variable", "mm_per_px", "s_per_px", "time")
            if getattr(self, key) is not None
        }
        if self.positions is not None:
            given["positions"] = lengths(self.positions, "--positions")
        if self.grey is not None:
            quantity = self.quantity if self.quantity in QUANTITIES else "diameter"
            given["grey"] = greys(self.grey, self.unit or QUANTITIES[quantity].unit)
        return {**given, "oral": self.oral}


def lengths(text: str, key: str) -> list[float]:
    """Lengths [mm] from a text such as "10, 20, 35 mm": the unit of the last holds for all that have none."""
    from ..maps.words import length

    parts = [part.strip() for part in text.split(",") if part.strip()]
    unit = "".join(mark for mark in (parts or [""])[-1] if mark.isalpha())
    if not unit:
        raise ConfigurationError(f"{key} = {shown(text)}: the unit is missing; write for example '10, 20, 35 mm'")
    return [length(part if any(mark.isalpha() for mark in part) else f"{part} {unit}", key) for part in parts]
