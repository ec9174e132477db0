"""The runs that the paper's claims need, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ... import scenarios
from ..experiment import Experiment

ETA, DRY = "pellet.viscous_friction", "pellet.dry_friction"
CHANNELS = ("slow_calcium", "fast_calcium", "calcium_potassium")
LAYERS = ("longitudinal", "circular")


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


def channel_run(channel: str, factor: float) -> str:
    """Name of the run with this factor on this channel."""
    states = {0.75: "decreased", 1.0: "norm", 1.25: "increased"}
    return f"fig5_{channel}_{states[factor]}" if factor in states else f"{channel}_x{factor:g}"


def _phase(delay: float, suffix: str = "", factors: Mapping[str, float] | None = None) -> Experiment:
    """The two layers alone: receptors off, each layer started at the oral end."""
    changes = {"trigger.rule": "pacemaker", "trigger.delay": f"{delay:g} s", "reflex.enabled": False}
    return Experiment(phase_name(delay) + suffix, changes=changes, factors=dict(factors or {}))


def _all() -> tuple[Experiment, ...]:
    named = [name for name in scenarios.names() if name.startswith("fig")]
    found = [Experiment(name, name) for name in ("baseline", "pendular", "segmentation", *named)]
    found += [Experiment(f"eta_x{factor:g}", factors={ETA: factor}) for factor in LADDER]
    found += [Experiment("dry_200", changes={DRY: "200 mN"})]
    found += [Experiment(f"dry_{force}", changes={DRY: f"{force} mN"}) for force in SPECIAL if force != 800]
    found += [Experiment(f"pressure_{p}", changes={"lumen.pressure": f"{p} kPa"}) for p in PRESSURES]
    found += [Experiment("pellet_x1.05", factors={"pellet.radius": 1.05})]
    found += [Experiment("pellet_x1.1", factors={"pellet.radius": 1.1})]
    found += [Experiment(f"ratio_{ratio:g}", ratio=ratio) for ratio in (1.0, 1.02, 1.08, 1.13)]
    forced = {"reflex.threshold": 0.0}
    found += [Experiment(f"ratio_{ratio:g}_forced", changes=forced, ratio=ratio) for ratio in (1.0, 1.02)]
    found += [_phase(delay) for delay in PHASES]
    found += [_phase(0.0, "_strong", _forces(1.5)), _phase(0.0, "_weak", _forces(0.25))]
    found += [Experiment("osmotic", factors={ETA: 0.5})]
    found += [Experiment("mineral_oil", factors={ETA: 0.5, DRY: 0.5})]
    found += [Experiment("oil_and_bulk", factors={ETA: 0.5, DRY: 0.5, "pellet.radius": 1.05})]
    found += [
        Experiment(f"{channel}_x{factor:g}", factors=_channels(channel, factor))
        for channel in CHANNELS
        for factor in CURVE
        if factor not in (0.75, 1.25)
    ]
    found += [Experiment(name, name) for name in ("no_stimulation", "periodic")]
    return tuple(found)


RUNS: Mapping[str, Experiment] = MappingProxyType({run.name: run for run in _all()})
