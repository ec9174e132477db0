"""Lumen pressure, Fig. 4 D."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig4d",
    title="Fig. 4 D: lumen pressure 20 kPa",
    description="The baseline in a lumen at 20 kPa.",
    expected="In the paper: arrested; only pressures above 15 kPa do that.",
    changes={"lumen.pressure": "20 kPa"},
)
