"""Lumen pressure, Fig. 4 C."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig4c",
    title="Fig. 4 C: lumen pressure 0.075 kPa",
    description="The baseline in a lumen at 0.075 kPa.",
    expected="In the paper: later than A.",
    changes={"lumen.pressure": "0.075 kPa"},
)
