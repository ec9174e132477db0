"""What a command hands over to be carried out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .streams import Screen


@dataclass(frozen=True)
class Job:
    """What a command line asks for: the work, and the scenario it is about, if that is known."""

    work: Callable[[Screen], int]
    scenario: str | None = None
