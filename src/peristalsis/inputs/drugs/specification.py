"""An agent at a concentration as data: what of it is stored with a configuration, whatever library it came from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...units import format_quantity

CONCENTRATION = "nM"
"""Unit of every concentration inside the package."""
NOT_ADVICE = "a research model, not medical advice"
TAGS = ("sourced", "derived", "chosen")
MOST_DOSES = 50
BOUNDS = {
    "concentration": (0.0, 1e9),
    "ic50": (1e-6, 1e9),
    "slope": (0.1, 10.0),
    "maximum": (0.0, 10.0),
}
"""Smallest and largest number, concentrations in nM."""


@dataclass(frozen=True, slots=True)
class Dose:
    """What an agent at a concentration [nM] does to one target, (110).

    channels: "cell.channel" for every cell model that has the target. ic50 [nM]: concentration of half the effect;
    range: of it, or None. slope: Hill's. maximum: factor on the conductance at high concentration, 0 for a full block.
    """

    agent: str
    concentration: float
    target: str
    channels: tuple[str, ...]
    ic50: float
    slope: float
    maximum: float
    tissue: str
    source: str
    tag: str
    range: tuple[float, float] | None = None

    @property
    def reach(self) -> float:
        """(c / IC50)^slope: the odds of a channel being bound by this agent alone."""
        return float((self.concentration / self.ic50) ** self.slope)

    def table(self) -> dict[str, Any]:
        """As it stands in a configuration file."""
        found = {
            "agent": self.agent,
            "concentration": format_quantity(self.concentration, CONCENTRATION),
            "target": self.target,
            "channels": list(self.channels),
            "ic50": format_quantity(self.ic50, CONCENTRATION),
            "slope": self.slope,
            "maximum": self.maximum,
            "tissue": self.tissue,
            "source": self.source,
            "tag": self.tag,
        }
        if self.range is not None:
            found["range"] = [format_quantity(one, CONCENTRATION) for one in self.range]
        return found

    def words(self) -> str:
        """In a line, for people."""
        return (
            f"{self.agent} {amount(self.concentration)} on {self.target} (IC50 {amount(self.ic50)}, slope "
            f"{self.slope:g}, {self.tissue}; {self.tag}: {self.source})"
        )


def amount(concentration: float) -> str:
    """A concentration [nM] in the unit in which it is a number of few digits."""
    for unit, size in (("M", 1e9), ("mM", 1e6), ("uM", 1e3), ("nM", 1.0)):
        if concentration >= size:
            return f"{concentration / size:.4g} {unit}"
    return (
        f"{concentration:.4g} nM" if concentration >= 0.1 or concentration == 0.0 else f"{1e3 * concentration:.4g} pM"
    )


def schema() -> dict[str, Any]:
    """JSON Schema of the list `drugs`: a line of text, a line and a library, or everything written out."""
    text = {"type": "string"}
    quantity = {"type": "string", "pattern": r"^\s*[0-9.]+(?:[eE][+-]?[0-9]+)?\s*[fpnuµμm]?M\s*$"}
    number = {"type": "number"}
    dose = {"type": "object", "properties": {"dose": text, "file": text}, "required": ["dose"]}
    whole = {
        "agent": text,
        "concentration": quantity,
        "target": text,
        "channels": {"type": "array", "items": text},
        "ic50": quantity,
        "range": {"type": "array", "items": quantity, "minItems": 2, "maxItems": 2},
        "slope": number,
        "maximum": number,
        "tissue": text,
        "source": text,
        "tag": {"type": "string", "enum": list(TAGS)},
    }
    table = {"type": "object", "properties": whole, "required": ["agent", "concentration", "target"]}
    listed = [text] + [one | {"additionalProperties": False} for one in (dose, table)]
    return {
        "type": "array",
        "items": {"anyOf": listed},
        "maxItems": MOST_DOSES,
        "default": [],
        "description": f"agents and their concentrations ({NOT_ADVICE})",
    }
