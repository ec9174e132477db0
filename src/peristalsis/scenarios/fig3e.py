"""Friction, Fig. 3 E."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3e",
    title="Fig. 3 E: viscous friction 230, dry friction 450",
    description=(
        "The baseline with the friction that the paper prints as 230 Ns/m and 450 N, read as 230 mN s/cm and 450 mN."
    ),
    expected="In the paper: later than A, or arrested.",
    changes={"pellet.dry_friction": "450 mN"},
)
