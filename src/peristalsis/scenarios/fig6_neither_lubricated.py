"""Neither pacemaker nor receptors, less viscous friction, with Fig. 6."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6_neither_lubricated",
    title="Fig. 6: neither pacemaker nor receptors, viscous friction 100",
    description="Pacemaker and stretch receptors are off, and viscous friction is 100 mN s/cm.",
    expected="In the paper: less viscous friction makes up for the missing stimulation.",
    changes={"pacemaker.kind": "none", "reflex.enabled": False, "pellet.viscous_friction": "100 mN*s/cm"},
)
