"""Stimulation, Fig. 6 D."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6d",
    title="Fig. 6 D: no stimulation, viscous friction 100",
    description=(
        "The pacemaker is off; the stretch receptors are on. Viscous friction is printed as 100 Ns/m and "
        "read as 100 mN s/cm."
    ),
    expected="In the paper: faster than B.",
    changes={"pacemaker.kind": "none", "pellet.viscous_friction": "100 mN*s/cm"},
)
