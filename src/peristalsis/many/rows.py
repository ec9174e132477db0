"""One run among many: the point that asks for it, the key under which it is kept, and the row that it leaves."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..inputs.config import Configuration
from ..storing.environment import code_version

CODE = code_version()
"""Of the equations that this process has loaded, not of what may have changed on disk since."""


def key_of(configuration: Configuration, code: str = CODE) -> str:
    """The key under which a run is kept: one for each experiment and version of the code."""
    return hashlib.sha256(f"{configuration.digest()} {code}".encode("ascii")).hexdigest()[:16]


@dataclass(frozen=True)
class Point:
    """One run among many: its name, what sets it apart (dotted key to value), and its configuration.

    configuration: None where the values are refused; `refusal` says why then.
    """

    name: str
    values: Mapping[str, Any] = field(default_factory=dict)
    configuration: Configuration | None = None
    refusal: str | None = None


@dataclass(frozen=True)
class Row:
    """What became of one point: `summary` has its numbers, `status`, and `error` where there is one.

    arrays: what was kept beside the numbers. folder: where the whole result is, with its fingerprint and remarks;
    None if none was stored.
    """

    summary: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    point: Point = Point("run")
    folder: Path | None = None
    fingerprint: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def status(self) -> str:
        """As of a run; `refused` if the configuration was, `failed` if its process died each time."""
        return str(self.summary["status"])


@dataclass(frozen=True)
class Step:
    """One point that has its row: how many are done of how many, and whether it was there before."""

    row: Row
    done: int
    count: int
    kept: bool
