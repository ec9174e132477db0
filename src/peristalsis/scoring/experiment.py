"""One experiment: a scenario, what is changed in it, and nothing that depends on the parameter set.

Factors and ratios are taken of the numbers of the parameter set, so that one experiment is the same under each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .. import scenarios, units
from ..inputs.config import FIELDS, Configuration


@dataclass(frozen=True, slots=True)
class Experiment:
    """One run: changes by value, changes by factor, and the pellet's radius as a ratio of the tube's.

    name: unique. scenario: what is changed; its own changes apply over every reading.
    """

    name: str
    scenario: str = "baseline"
    changes: Mapping[str, Any] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    ratio: float | None = None

    def configuration(self, reading: str, variant: Mapping[str, Any] | None = None) -> Configuration:
        """The configuration under a reading; a variant is laid over the reading and under the experiment.

        Raises ConfigurationError where the experiment has no meaning, such as a tube that cannot hold its pellet.
        """
        scenario = scenarios.get(self.scenario)
        base = scenarios.configuration(reading=reading, changes=dict(variant or {}))
        own = {**scenario.changes, **self.changes}
        if self.ratio is not None:
            radius = own.get("wall.radius")
            tube = base.wall.radius if radius is None else units.parse(str(radius), "cm", "wall.radius")
            own["pellet.radius"] = units.format_quantity(self.ratio * tube, "cm")
        values = base.flat()
        for key, factor in self.factors.items():
            if key in own:
                raise ValueError(f"{self.name}: {key} is changed by value and by factor; keep one")
            value = float(values[key]) * factor  # type: ignore[arg-type]
            unit = FIELDS[key].unit
            own[key] = value if unit == units.DIMENSIONLESS else units.format_quantity(value, unit)
        return base.with_changes({**own, "scenario": scenario.name})
