"""Stimulation, Fig. 6 B."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6b",
    title="Fig. 6 B: no stimulation, viscous friction 230",
    description="The pacemaker is off; the stretch receptors are on. Friction as in the baseline.",
    expected="In the paper: later than A.",
    changes={"pacemaker.kind": "none"},
)
