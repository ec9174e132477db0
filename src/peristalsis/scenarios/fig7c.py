"""Radius of the tube, Fig. 7 C."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig7c",
    title="Fig. 7 C: tube radius 0.6 cm",
    description="The baseline in a tube of radius 0.6 cm; the pellet stays that of the reading.",
    expected="In the paper: faster than A.",
    changes={"wall.radius": "0.6 cm"},
)
