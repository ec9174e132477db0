"""Radius of the tube, Fig. 7 B."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig7b",
    title="Fig. 7 B: tube radius 0.9 cm",
    description="The baseline in a tube of radius 0.9 cm; the pellet stays that of the reading.",
    expected="In the paper: slower than A, or stopped.",
    changes={"wall.radius": "0.9 cm"},
)
