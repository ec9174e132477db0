"""Elastic forces alone."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="no_stimulation",
    title="No pacemaker, no receptors",
    description="Pacemaker and stretch receptors are off: only pressure and the elastic wall act.",
    expected="The paper reports slow, disrupted motion by elastic forces, faster with less viscous friction.",
    changes={"pacemaker.kind": "none", "reflex.enabled": False},
)
