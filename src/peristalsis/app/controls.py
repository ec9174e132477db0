"""What can be set on the page: sliders and switches as data, each with the parameters it stands for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..inputs.config import Configuration
from ..inputs.parameters import PARAMETERS
from ..inputs.parts import SHIPPED
from ..inputs.protocols import changeable
from ..names import CHANNELS

LAYERS = ("longitudinal", "circular")


@dataclass(frozen=True, slots=True)
class Control:
    """A number on the page.

    shown = scale * parameter, in `unit`; with `share` it is per cent of what the scenario has, in all `keys` at once.
    low, high, step: of the slider, in `unit`.
    """

    name: str
    label: str
    group: str
    keys: tuple[str, ...]
    unit: str
    low: float
    high: float
    step: float
    scale: float = 1.0
    share: bool = False
    help: str = ""

    def shown(self, configuration: Configuration) -> float:
        """What the page shows for a configuration that is the scenario's own."""
        return 100.0 if self.share else round(self.scale * value_of(configuration, self.keys[0]), 9)

    def changes(self, shown: float, own: Configuration) -> dict[str, str]:
        """The parameters, as text with a unit, that a number on the page means beside the scenario's own."""
        found = {}
        for key in self.keys:
            value = shown / 100.0 * value_of(own, key) if self.share else shown / self.scale
            unit = PARAMETERS[key].unit
            found[key] = f"{value:.10g}" if unit == "1" else f"{value:.10g} {unit}"
        return found


@dataclass(frozen=True, slots=True)
class Switch:
    """A part of the model that is on or off: the changes that either means; none means the scenario's own."""

    name: str
    label: str
    key: str
    on: Mapping[str, Any] = field(default_factory=dict)
    off: Mapping[str, Any] = field(default_factory=dict)
    help: str = ""

    def shown(self, configuration: Configuration) -> bool:
        """Whether it is on in a configuration."""
        return bool(value_of(configuration, self.key) != self.off[self.key])

    def changes(self, on: bool, own: Configuration) -> dict[str, Any]:
        """What it changes in the scenario's own configuration."""
        return {} if on == self.shown(own) else dict(self.on if on else self.off)


PELLET, TUBE, MUSCLE, CURRENTS, RUN = "Pellet", "Tube", "Muscle", "Channels", "Run"

CONTROLS = (
    Control("pellet_diameter", "Diameter of the pellet", PELLET, ("pellet.radius",), "cm", 1.0, 2.4, 0.02, scale=2.0),
    Control(
        "viscous_friction",
        "Viscous friction",
        PELLET,
        ("pellet.viscous_friction",),
        "mN·s/cm",
        20.0,
        1500.0,
        10.0,
        help="Grows with the speed of the pellet; the less, the more slippery.",
    ),
    Control(
        "dry_friction",
        "Dry friction",
        PELLET,
        ("pellet.dry_friction",),
        "mN",
        0.0,
        1000.0,
        10.0,
        help="Has to be overcome before the pellet moves at all.",
    ),
    Control("tube_diameter", "Diameter of the tube", TUBE, ("wall.radius",), "cm", 1.0, 2.4, 0.02, scale=2.0),
    Control("pressure", "Pressure in the lumen", TUBE, ("lumen.pressure",), "kPa", 0.0, 5.0, 0.05),
    *(
        Control(
            f"{layer}_force",
            f"Force of the {layer} layer",
            MUSCLE,
            (f"{layer}.active",),
            "%",
            0.0,
            200.0,
            5.0,
            scale=100.0,
            help="As a share of the force of healthy muscle.",
        )
        for layer in LAYERS
    ),
    *(
        Control(
            name,
            f"{text[0].upper()}{text[1:]}",
            CURRENTS,
            tuple(f"{layer}.{name}" for layer in LAYERS),
            "%",
            0.0,
            200.0,
            5.0,
            share=True,
            help="Conductance in both layers, as a share of the scenario's: what drugs block or open.",
        )
        for name, text in CHANNELS.items()
    ),
    Control("duration", "Length of the run", RUN, ("run.duration",), "s", 0.5, 60.0, 0.5),
)
BY_NAME = {control.name: control for control in CONTROLS}

SWITCHES = (
    Switch(
        "pacemaker",
        "Pacemaker",
        "pacemaker.kind",
        {"pacemaker.kind": "pulse"},
        {"pacemaker.kind": "none"},
        "The stimulus at the oral end.",
    ),
    Switch(
        "receptors",
        "Stretch receptors",
        "reflex.enabled",
        {"reflex.enabled": True},
        {"reflex.enabled": False},
        "The reflex: excitation behind the pellet, inhibition ahead of it.",
    ),
    *(
        Switch(
            f"{layer}_layer",
            f"{layer.capitalize()} layer pulls",
            f"{layer}.active",
            {f"{layer}.active": 1.0},
            {f"{layer}.active": 0.0},
        )
        for layer in LAYERS
    ),
)
SWITCH_BY_NAME = {switch.name: switch for switch in SWITCHES}

GRIDS: Mapping[str, Mapping[str, Any]] = {
    "shipped": {},
    "quick": {"grid.n_z": 200, "grid.n_z_wall": 240},
}
"""Grids to choose from: that of the scenario, and a coarse one for slow machines, of which the run itself warns."""


def value_of(configuration: Configuration, key: str) -> Any:
    """The value of a parameter in its own unit."""
    section, _, name = key.partition(".")
    return getattr(getattr(configuration, section), name)


def live(keys: tuple[str, ...]) -> bool:
    """Whether these parameters may change while a run is under way."""
    return all(changeable(key) for key in keys)


def applies(control: Control, configuration: Configuration) -> bool:
    """Whether a control means anything for a configuration: the channels are those of the shipped cell."""
    return control.group != CURRENTS or all(configuration.cell_of(layer) == SHIPPED["cell"] for layer in LAYERS)
