"""One choice changed: what each mechanism does to the rise of speed with the diameter."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..source import Variant

VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {
        one.name: one
        for one in (
            Variant(
                "ungraded",
                "receptors answer with all they have from the threshold on",
                {"reflex.stretch_range": 0.001},
            ),
            Variant(
                "contact-length",
                "any length of contact brings the whole intensity",
                {"reflex.summation": "0.01 cm"},
            ),
            Variant(
                "constant-friction",
                "friction does not depend on pressing",
                {
                    "pellet.friction_coefficient": 0.0,
                    "pellet.viscous_friction_coefficient": "0 s/cm",
                    "pellet.viscous_friction": "150 mN*s/cm",
                    "pellet.dry_friction": "8 mN",
                },
            ),
            Variant(
                "falling-friction",
                "dry friction falls with speed to a third, as in mucus",
                {"pellet.fast_friction_share": 0.33, "pellet.friction_coefficient": 0.15},
            ),
            Variant(
                "all-or-none",
                "one answer of stated extent",
                {
                    "reflex.kind": "all_or_none",
                    "reflex.longitudinal_intensity": "0 uA/cm^2",
                    "reflex.inhibition_duration": "0.9 s",
                },
            ),
            Variant(
                "conducting",
                "waves of muscle instead of neurons carry the movement on",
                {
                    "circular.conduction": True,
                    "longitudinal.conduction": True,
                    "circular.conductivity_scale": 1.746e-5,
                    "longitudinal.conductivity_scale": 1.09125e-5,
                },
            ),
            Variant(
                "calcium",
                "a muscle cell whose force follows the calcium that enters (Corrias and Buist 2007), unfitted",
                {
                    "tissue.cell": "corrias_buist_2007",
                    "tissue.activation": "calcium_hill",
                    "tissue.calcium_hill.half": "0.25 uM",
                },
            ),
            Variant("late-rise", "passive tension that rises late", {"wall.law": "late_fibres"}),
            Variant("taut", "ends held at the tube's length", {"wall.slack_length": "0 cm"}),
            Variant(
                "doubled",
                "grids and steps twice as fine",
                {"grid.n_z": 800, "grid.n_z_wall": 600, "step.wall": "25 ms", "step.conduction": "5 ms"},
            ),
        )
    }
)
