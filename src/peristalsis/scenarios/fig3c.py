"""Friction, Fig. 3 C."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3c",
    title="Fig. 3 C: viscous friction 200, dry friction 20",
    description=(
        "The baseline with the friction that the paper prints as 200 Ns/m and 20 N, read as 200 mN s/cm and 20 mN."
    ),
    expected="In the paper: faster than A.",
    changes={"pellet.viscous_friction": "200 mN*s/cm"},
)
