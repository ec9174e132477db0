"""Variants of the paper's conditions: one choice changed under every experiment, to see which verdicts it turns."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..source import Variant

VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {
        one.name: one
        for one in (
            Variant("slow-waves", "slow waves every 3 s", {"pacemaker.kind": "periodic"}, searches=True),
            Variant("doubled", "20 s", {"run.duration": "20 s"}, searches=True),
            Variant("moving-wall", "friction against the moving wall", {"pellet.friction_frame": "wall"}),
            Variant("consistent", "consistent tensions", {"wall.tension": "consistent"}),
            Variant(
                "printed-density",
                "surface density of 26.14 g/cm²",
                {"wall.inertia": True, "wall.surface_density": "26140 mg/cm^2"},
            ),
            Variant("total", "trigger by the total tension", {"trigger.rule": "total"}),
            Variant("without-reflex", "no mechanoreceptors", {"reflex.enabled": False}),
            Variant(
                "short-reflex", "reflex half as long", {"reflex.oral_length": "0.75 cm", "reflex.anal_length": "1 cm"}
            ),
        )
    }
)
