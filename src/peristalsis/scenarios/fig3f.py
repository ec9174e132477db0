"""Friction, Fig. 3 F."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3f",
    title="Fig. 3 F: viscous friction 1200, dry friction 20",
    description=(
        "The baseline with the friction that the paper prints as 1200 Ns/m and 20 N, read as 1200 mN s/cm and 20 mN."
    ),
    expected="In the paper: later than A, or arrested.",
    changes={"pellet.viscous_friction": "1200 mN*s/cm"},
)
