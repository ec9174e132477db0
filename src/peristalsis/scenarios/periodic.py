"""A train of slow waves instead of one."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="periodic",
    title="Slow waves every 3 s",
    description="The baseline with a pulse every 3 s: a pellet left behind by one wave meets the next.",
    expected="Not in the paper.  Should matter only for a pellet that the first wave does not carry out.",
    changes={"pacemaker.kind": "periodic", "pacemaker.period": "3 s"},
)
