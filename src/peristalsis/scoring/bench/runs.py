"""The runs that the claims of the bench need, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ..experiment import Experiment

CONTROL, HELD = "control", "held"

BELOW, ABOVE = (1.0, 1.06, 1.1), (1.2, 1.26)
"""Girth of pellets narrower and wider than the natural one, over that of the tube; the natural one is 1.143."""

LOADS = (10, 20, 40, 60, 80, 100)
"""Weights on the pellet's string [mN]."""

BLOCKS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Concentrations of a blocker of L-type channels over its IC50."""
BLOCKER, BLOCKER_IC50 = "nifedipine", 8.1
"""The blocker, in the library's first preparation, with its IC50 [nM] and slope 1: it finds the channel of any cell."""

HEXAMETHONIUM: Mapping[str, Any] = MappingProxyType({"reflex.gain": 0.5})
"""Nicotinic block that leaves half of what the reflex's neurons bring (chosen, for want of a measured share)."""
TETRODOTOXIN: Mapping[str, Any] = MappingProxyType({"reflex.enabled": False, "pacemaker.kind": "none"})
"""No nerve conducts: no reflex."""

ISOMETRIC: Mapping[str, Any] = MappingProxyType(
    {"pellet.held": True, "pellet.start_gap": "3.1 cm", "run.duration": "40 s"}
)
"""A pellet held in the middle of the segment."""


def diameter_run(ratio: float, held: bool = False) -> str:
    """Name of the run with a pellet of this girth over the tube's."""
    return f"{'held_' if held else ''}diameter_{ratio:g}"


def load_run(weight: float) -> str:
    """Name of the run against this weight [mN]."""
    return f"load_{weight:g}"


def block_run(concentration: float, held: bool = False) -> str:
    """Name of the run with L-type channels blocked by this concentration over the IC50."""
    return f"{'held_' if held else ''}block_{concentration:g}"


def _all() -> tuple[Experiment, ...]:
    found = [Experiment(CONTROL), Experiment(HELD, changes=ISOMETRIC)]
    for ratio in (*BELOW, *ABOVE):
        found += [
            Experiment(diameter_run(ratio), ratio=ratio),
            Experiment(diameter_run(ratio, held=True), changes=ISOMETRIC, ratio=ratio),
        ]
    for weight in LOADS:
        found += [Experiment(load_run(weight), changes={"pellet.load": "weight", "pellet.load_weight": f"{weight} mN"})]
    found += [
        Experiment("hexamethonium", changes=HEXAMETHONIUM),
        Experiment("held_hexamethonium", changes={**ISOMETRIC, **HEXAMETHONIUM}),
        Experiment("tetrodotoxin", changes=TETRODOTOXIN),
        Experiment("no_longitudinal_force", changes={"longitudinal.active": 0.0}),
    ]
    for concentration in BLOCKS:
        blocked = {"drugs": [f"{BLOCKER} {concentration * BLOCKER_IC50:g} nM"]}
        found += [
            Experiment(block_run(concentration), changes=blocked),
            Experiment(block_run(concentration, held=True), changes={**ISOMETRIC, **blocked}),
        ]
    return tuple(found)


RUNS: Mapping[str, Experiment] = MappingProxyType({run.name: run for run in _all()})
