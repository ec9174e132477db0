"""Friction, Fig. 3 A."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig3a",
    title="Fig. 3 A: viscous friction 230, dry friction 20",
    description=(
        "The baseline with the friction that the paper prints as 230 Ns/m and 20 N, read as 230 mN s/cm and 20 mN."
    ),
    expected="In the paper: the reference of Fig. 3: transit in 2.4 s.",
)
