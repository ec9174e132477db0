"""Friction, Fig. 3 G."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3g",
    title="Fig. 3 G: viscous friction 230, dry friction 800",
    description=(
        "The baseline with the friction that the paper prints as 230 Ns/m and 800 N, read as 230 mN s/cm and 800 mN."
    ),
    expected="In the paper: later than A, or arrested.",
    changes={"pellet.dry_friction": "800 mN"},
)
