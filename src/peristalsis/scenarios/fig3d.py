"""Friction, Fig. 3 D."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3d",
    title="Fig. 3 D: viscous friction 90, dry friction 450",
    description=(
        "The baseline with the friction that the paper prints as 90 Ns/m and 450 N, read as 90 mN s/cm and 450 mN."
    ),
    expected="In the paper: before E: less viscous friction offsets much dry friction.",
    changes={"pellet.viscous_friction": "90 mN*s/cm", "pellet.dry_friction": "450 mN"},
)
