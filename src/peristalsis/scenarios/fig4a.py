"""Lumen pressure, Fig. 4 A."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig4a",
    title="Fig. 4 A: lumen pressure 0.1 kPa",
    description="The baseline in a lumen at 0.1 kPa.",
    expected="In the paper: the normal pressure, transit in 2.4 s.",
)
