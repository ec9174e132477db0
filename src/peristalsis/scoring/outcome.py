"""Under what experiments are made, and what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..many.rows import Row
from ..many.threshold import Threshold


@dataclass(frozen=True)
class Condition:
    """Under what the experiments are made: a reading, and a variant laid over it and under each experiment."""

    reading: str
    variant: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""

    @property
    def title(self) -> str:
        """How the condition is called in tables."""
        return self.name or self.reading


@dataclass(frozen=True)
class Outcome:
    """Everything found under one condition."""

    condition: Condition
    records: Mapping[str, Row]
    thresholds: Mapping[str, Threshold]
    measured: Mapping[str, Mapping[str, Any]]
