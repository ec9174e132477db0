"""The runs that the claims need: a scenario, what is changed in it, and nothing that depends on the reading.

Factors and ratios are taken of the numbers of the reading, so that one run is the same experiment under each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from .. import scenarios, units
from ..inputs.config import FIELDS, Configuration

ETA, DRY = "pellet.viscous_friction", "pellet.dry_friction"
CHANNELS = ("slow_calcium", "fast_calcium", "calcium_potassium")
LAYERS = ("longitudinal", "circular")


@dataclass(frozen=True, slots=True)
class PaperRun:
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


def _channels(channel: str, factor: float) -> dict[str, float]:
    return {f"{layer}.{channel}": factor for layer in LAYERS}


def _forces(factor: float) -> dict[str, float]:
    return {f"{layer}.active": factor for layer in LAYERS}


PHASES = (-0.5, -0.25, 0.0, 0.1, 0.25, 0.5, 1.0)
"""Start of the circular layer after the longitudinal one [s]; the earlier of the two is at t = 0."""

LADDER = (0.25, 0.5, 2.0, 4.0)
"""Factors on the viscous friction of claim 4."""

SPECIAL = (565, 800, 1200, 1600, 2000)
"""Dry friction [mN] at which the paper sees a special pattern."""

PRESSURES = (1, 5, 10, 15)
"""Pressures [kPa] at which the pellet must not be stopped."""

CURVE = (0.25, 0.5, 0.75, 1.25, 2.0, 4.0)
"""Factors on the conductance of a channel: the whole curve of Fig. 5."""


def phase_name(delay: float) -> str:
    """Name of the run with this delay between the layers."""
    return f"phase_{delay:+g}s"


def _phase(delay: float, suffix: str = "", factors: Mapping[str, float] | None = None) -> PaperRun:
    """The two layers alone: receptors off, each layer started at the oral end."""
    changes = {"trigger.rule": "pacemaker", "trigger.delay": f"{delay:g} s", "reflex.enabled": False}
    return PaperRun(phase_name(delay) + suffix, changes=changes, factors=dict(factors or {}))


def _all() -> tuple[PaperRun, ...]:
    named = [name for name in scenarios.names() if name.startswith("fig")]
    found = [PaperRun(name, name) for name in ("baseline", "pendular", "segmentation", *named)]
    found += [PaperRun(f"eta_x{factor:g}", factors={ETA: factor}) for factor in LADDER]
    found += [PaperRun("dry_200", changes={DRY: "200 mN"})]
    found += [PaperRun(f"dry_{force}", changes={DRY: f"{force} mN"}) for force in SPECIAL if force != 800]
    found += [PaperRun(f"pressure_{p}", changes={"lumen.pressure": f"{p} kPa"}) for p in PRESSURES]
    found += [PaperRun("pellet_x1.05", factors={"pellet.radius": 1.05})]
    found += [PaperRun("pellet_x1.1", factors={"pellet.radius": 1.1})]
    found += [PaperRun(f"ratio_{ratio:g}", ratio=ratio) for ratio in (1.0, 1.02, 1.08, 1.13)]
    forced = {"reflex.threshold": 0.0}
    found += [PaperRun(f"ratio_{ratio:g}_forced", changes=forced, ratio=ratio) for ratio in (1.0, 1.02)]
    found += [_phase(delay) for delay in PHASES]
    found += [_phase(0.0, "_strong", _forces(1.5)), _phase(0.0, "_weak", _forces(0.25))]
    found += [PaperRun("osmotic", factors={ETA: 0.5})]
    found += [PaperRun("mineral_oil", factors={ETA: 0.5, DRY: 0.5})]
    found += [PaperRun("oil_and_bulk", factors={ETA: 0.5, DRY: 0.5, "pellet.radius": 1.05})]
    found += [
        PaperRun(f"{channel}_x{factor:g}", factors=_channels(channel, factor))
        for channel in CHANNELS
        for factor in CURVE
        if factor not in (0.75, 1.25)
    ]
    found += [PaperRun(name, name) for name in ("no_stimulation", "periodic")]
    return tuple(found)


RUNS: Mapping[str, PaperRun] = MappingProxyType({run.name: run for run in _all()})
