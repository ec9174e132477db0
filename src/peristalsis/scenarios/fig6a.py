"""Stimulation, Fig. 6 A."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6a",
    title="Fig. 6 A: with stimulation, viscous friction 230",
    description="The baseline: pacemaker and stretch receptors on.",
    expected="In the paper: transit in 2.4 s.",
)
