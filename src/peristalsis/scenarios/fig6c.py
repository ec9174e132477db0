"""Stimulation, Fig. 6 C."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6c",
    title="Fig. 6 C: with stimulation, viscous friction 230, printed again",
    description=("The caption prints A twice, as A and as C; one of them is a misprint, and this is word for word."),
    expected="In the paper: as A.",
)
