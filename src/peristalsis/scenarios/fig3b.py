"""Friction, Fig. 3 B."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3b",
    title="Fig. 3 B: viscous friction 230, dry friction 2",
    description=(
        "The baseline with the friction that the paper prints as 230 Ns/m and 2 N, read as 230 mN s/cm and 2 mN."
    ),
    expected="In the paper: faster than A.",
    changes={"pellet.dry_friction": "2 mN"},
)
