"""Radius of the tube, Fig. 7 A."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig7a",
    title="Fig. 7 A: tube radius 0.795 cm",
    description="The baseline in a tube of radius 0.795 cm; the pellet stays that of the reading.",
    expected="In the paper: transit in 2.4 s.",
)
