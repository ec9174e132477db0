"""Lumen pressure, Fig. 4 B."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig4b",
    title="Fig. 4 B: lumen pressure 0.15 kPa",
    description="The baseline in a lumen at 0.15 kPa.",
    expected="In the paper: later than A.",
    changes={"lumen.pressure": "0.15 kPa"},
)
