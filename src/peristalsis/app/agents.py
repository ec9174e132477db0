"""Agents and other interventions that a page offers by name, each with a dose within bounds: the library as a list."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ..errors import ConfigurationError, shown, suggestion
from ..inputs import drugs
from .controls import CONTROLS

SHIPPED = "shipped"
"""The library of the package as it is, beside its variants."""
BELOW, ABOVE, PER_DECADE = 2, 3, 20
"""Decades that a slider reaches below and above that of the IC50, and its steps in each."""
LIBRARIES = (SHIPPED, *drugs.variants())


@dataclass(frozen=True, slots=True)
class Offered:
    """An agent, or an intervention on parameters, with the bounds of its dose.

    name: of the agent, with "in" and a preparation where it is not the first one. unit: of the dose, empty for a
    factor. first: the dose it begins with, which is the IC50. step: of the slider, in decades for an agent.
    refused: why it cannot be given, empty where it can.
    """

    name: str
    unit: str
    low: float
    high: float
    first: float
    step: float
    help: str
    refused: str = ""

    @property
    def logarithmic(self) -> bool:
        """Whether the slider goes by decades."""
        return self.unit != ""

    def line(self, dose: float) -> str:
        """As `--drug` takes it."""
        agent, _, tissue = self.name.partition(" in ")
        return " ".join([agent, f"{dose:.6g}", *filter(None, [self.unit]), *(["in", tissue] if tissue else [])])

    def plain(self) -> dict[str, Any]:
        """What the page needs of it."""
        keys = ("name", "unit", "low", "high", "first", "step", "help", "refused", "logarithmic")
        return {key: getattr(self, key) for key in keys}


@lru_cache(maxsize=1)
def offered() -> Mapping[str, Offered]:
    """All of them by name: agents as the library prefers them, other preparations after each, interventions last."""
    known = drugs.library()
    found: dict[str, Offered] = {}
    for name in known.names():
        first = known.of(name)
        found[name] = _agent(name, first, known)
        others = dict.fromkeys(one.tissue for one in known.agents if one.name == name and one not in first)
        for tissue in others:
            found[f"{name} in {tissue}"] = _agent(f"{name} in {tissue}", known.of(name, tissue), known)
    labels = {key: control.label.lower() for control in CONTROLS for key in control.keys}
    for one in known.interventions.values():
        low, high = one.range
        words = " and ".join(labels.get(key, key) for key in one.parameters)
        help = f"Multiplies {words}; a {one.tag} factor, from {low:g} to {high:g}."
        found[one.name] = Offered(one.name, "", low, high, one.factor, 0.05, help)
    return found


def _agent(name: str, entries: tuple[drugs.Agent, ...], known: drugs.Library) -> Offered:
    half, _, unit = drugs.amount(entries[0].ic50).partition(" ")
    decade = math.floor(math.log10(float(half)) + 1e-9)
    help = "; ".join(
        f"{'Opens' if one.maximum > 1.0 else 'Blocks'} {one.target}, IC50 {drugs.amount(one.ic50)} in {one.tissue}"
        for one in entries
    )
    missing = [one.target for one in entries if not known.targets[one.target].channels]
    refused = f"the model has no {missing[0]}" if len(missing) == len(entries) else ""
    low, high = (float(f"1e{decade + reach}") for reach in (-BELOW, ABOVE))
    return Offered(name, unit, low, high, float(half), 1.0 / PER_DECADE, f"{help}.", refused)


def read(content: Mapping[str, Any]) -> dict[str, float]:
    """Doses by name as a page sent them, checked. Raises ConfigurationError for what is not offered."""
    known = offered()
    found = {}
    for name, value in content.items():
        if name not in known:
            raise ConfigurationError(f"{shown(name)}: not offered as an agent; {suggestion(str(name), known)}")
        one = known[name]
        if one.refused:
            raise ConfigurationError(f"{name}: {one.refused}; leave it out, or run a library of yours by --drugs FILE")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not one.low <= value <= one.high:
            unit = f" {one.unit}" if one.unit else ""
            raise ConfigurationError(
                f"{name} = {shown(value)}: give a number from {one.low:g} to {one.high:g}{unit}, or leave it out"
            )
        found[name] = float(value)
    return found


def split(doses: Mapping[str, float], library: str) -> tuple[list[Any], list[str]]:
    """Agents as a configuration lists them, and the lines of interventions on parameters."""
    known = offered()
    lines = {name: known[name].line(dose) for name, dose in doses.items()}
    agents = [line for name, line in lines.items() if known[name].logarithmic]
    interventions = [line for name, line in lines.items() if not known[name].logarithmic]
    if library == SHIPPED:
        return list(agents), interventions
    return [{"dose": line, "file": library} for line in agents], interventions
