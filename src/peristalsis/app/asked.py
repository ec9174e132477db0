"""From what a page asks for to a checked configuration: nothing but known names and numbers within bounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from .. import scenarios
from ..errors import ConfigurationError, shown, suggestion
from ..inputs.config import Configuration
from ..inputs.drugs import changes_by
from ..inputs.parameters import READINGS
from . import agents
from .controls import BY_NAME, CONTROLS, GRIDS, SWITCH_BY_NAME, SWITCHES, applies, live

PARTS = ("scenario", "reading", "grid", "values", "switches", "drugs", "library")


@dataclass(frozen=True)
class Asked:
    """What one run is to be: a scenario and a reading by name, and what differs from them.

    values: numbers by the name of their control, in the unit of the page. switches: on or off by name. drugs: doses by
    the name of an agent (`agents.offered`). library: which channel of the model is which target.
    """

    scenario: str = scenarios.BASELINE
    reading: str | None = None
    grid: str = "shipped"
    values: Mapping[str, float] = field(default_factory=dict)
    switches: Mapping[str, bool] = field(default_factory=dict)
    drugs: Mapping[str, float] = field(default_factory=dict)
    library: str = agents.SHIPPED

    def own(self) -> Configuration:
        """The configuration of the scenario and reading as they are."""
        return _own(self.scenario, self.reading)

    def changes(self) -> dict[str, Any]:
        """What numbers, switches and drugs change, by parameter; a layer that is off stays off whatever its force.

        Interventions multiply what the numbers have set. Raises ConfigurationError where these do not go together.
        """
        own = self.own()
        found = dict(GRIDS[self.grid])
        for name, value in self.values.items():
            control = BY_NAME[name]
            if value != control.shown(own):
                found |= control.changes(value, own)
        for name, on in self.switches.items():
            switch = SWITCH_BY_NAME[name]
            if not (on and switch.key in found):
                found |= switch.changes(on, own)
        doses, interventions = agents.split(self.drugs, self.library)
        if interventions:
            found |= changes_by(interventions, self._with(found))
        if doses:
            found["drugs"] = [*(dose.table() for dose in own.drugs), *doses]
        return found

    def configuration(self) -> Configuration:
        """The configuration of the run. Raises ConfigurationError where its parameters do not go together."""
        return self._with(self.changes())

    def _with(self, changes: Mapping[str, Any]) -> Configuration:
        return scenarios.configuration(self.scenario, reading=self.reading, changes=changes)

    def python(self) -> str:
        """The same run as five lines of Python."""
        changes = ", ".join(f'"{key}": {value!r}' for key, value in self.changes().items())
        reading = "" if self.reading is None else f", reading={self.reading!r}"
        return (
            "import peristalsis as ps\n"
            f"changes = {{{changes}}}\n"
            f"result = ps.run({self.scenario!r}, changes{reading})\n"
            "result.plot.overview().savefig('overview.png')\n"
            "print(result)\n"
        )


def offered() -> dict[str, str]:
    """The scenarios of one column, by name with their title: the whole surface takes minutes and is not shown here."""
    found = {name: scenarios.get(name) for name in scenarios.names()}
    return {name: one.title for name, one in found.items() if one.changes.get("grid.n_theta", 1) == 1}


def read(content: object) -> Asked:
    """What a page sent, checked. Raises ConfigurationError for anything that is not offered."""
    parts = _mapping(content, "a run")
    _known(parts, PARTS, "part")
    scenario = _name(parts.get("scenario", scenarios.BASELINE), offered(), "scenario")
    reading = parts.get("reading")
    asked = Asked(
        scenario,
        None if reading is None else _name(reading, READINGS, "reading"),
        _name(parts.get("grid", "shipped"), GRIDS, "grid"),
        _values(parts.get("values", {})),
        _switches(parts.get("switches", {})),
        agents.read(_mapping(parts.get("drugs", {}), "the list of drugs")),
        _name(parts.get("library", agents.SHIPPED), agents.LIBRARIES, "library"),
    )
    own = asked.own()
    for name in asked.values:
        if not applies(BY_NAME[name], own):
            raise ConfigurationError(f"{name}: the cells of {scenario} have no such channel; leave it as it is")
    return asked


def read_live(content: object, asked: Asked) -> tuple[Asked, dict[str, Any]]:
    """What a page changes while a run is under way: the run as it is from now on, and the changed parameters.

    Raises ConfigurationError for what can only change between runs.
    """
    parts = _mapping(content, "a change")
    _known(parts, ("values", "switches"), "part")
    values, switches = _values(parts.get("values", {})), _switches(parts.get("switches", {}))
    fixed = [BY_NAME[name].label for name in values if not live(BY_NAME[name].keys)]
    fixed += [SWITCH_BY_NAME[name].label for name in switches if not live((SWITCH_BY_NAME[name].key,))]
    if fixed:
        raise ConfigurationError(f"{fixed[0]} cannot change during a run; start another run with it")
    after = replace(asked, values={**asked.values, **values}, switches={**asked.switches, **switches})
    before, now = asked.changes(), after.changes()
    changed = {key: value for key, value in now.items() if key not in before or before[key] != value}
    texts = asked.own().texts() if before.keys() - now.keys() else {}  # back to what the scenario has
    return after, changed | {key: texts[key] for key in before.keys() - now.keys()}


def defaults(scenario: object, reading: object) -> dict[str, Any]:
    """What the page shows for a scenario and a reading before anything is changed."""
    asked = read({"scenario": scenarios.BASELINE if scenario is None else scenario, "reading": reading})
    own = asked.own()
    return {
        "values": {control.name: control.shown(own) for control in CONTROLS if applies(control, own)},
        "switches": {switch.name: switch.shown(own) for switch in SWITCHES},
        "reading": own.reading,
    }


@lru_cache(maxsize=64)
def _own(scenario: str, reading: str | None) -> Configuration:
    return scenarios.configuration(scenario, reading=reading)


def _mapping(content: object, what: str) -> Mapping[str, Any]:
    if not isinstance(content, dict):
        raise ConfigurationError(f"{what} is described by names and values, not by {shown(content)}")
    return content


def _known(parts: Mapping[str, Any], known: Any, what: str) -> None:
    for name in parts:
        if name not in known:
            raise ConfigurationError(f"{shown(name)}: no such {what}; {suggestion(str(name), known)}")


def _name(value: object, known: Any, what: str) -> str:
    if not isinstance(value, str) or value not in known:
        raise ConfigurationError(f"{what} = {shown(value)}: not offered here; {suggestion(str(value), known)}")
    return value


def _values(content: object) -> dict[str, float]:
    found = {}
    for name, value in _mapping(content, "the numbers").items():
        _known({name: value}, BY_NAME, "control")
        control = BY_NAME[name]
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not control.low <= value <= control.high:
            unit = f" {control.unit}"
            raise ConfigurationError(
                f"{control.label} = {shown(value)}: give a number from {control.low:g} to {control.high:g}{unit}"
            )
        found[name] = float(value)
    return found


def _switches(content: object) -> dict[str, bool]:
    found = {}
    for name, value in _mapping(content, "the switches").items():
        _known({name: value}, SWITCH_BY_NAME, "switch")
        if not isinstance(value, bool):
            raise ConfigurationError(f"{SWITCH_BY_NAME[name].label} = {shown(value)}: give true or false")
        found[name] = value
    return found
