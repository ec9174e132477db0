"""Neither pacemaker nor receptors, with Fig. 6."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6_neither",
    title="Fig. 6: neither pacemaker nor receptors",
    description="Pacemaker and stretch receptors are off: only pressure and the elastic wall act.",
    expected="In the paper: slow, disrupted motion by elastic forces.",
    changes={"pacemaker.kind": "none", "reflex.enabled": False},
)
