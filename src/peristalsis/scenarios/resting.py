"""Nothing is asked to move, so nothing may."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="resting",
    title="Tube at rest",
    description="No pellet, no pacemaker and no reflex: the inflated tube, watched for 10 s.",
    expected="Potential, wall and pressure stay where they start; any drift is an error of the method.",
    changes={
        "pellet.enabled": False,
        "pacemaker.kind": "none",
        "reflex.enabled": False,
        "run.duration": "10 s",
    },
)
