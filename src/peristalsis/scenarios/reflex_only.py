"""The stretch receptors alone."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="reflex_only",
    title="Stretch receptors alone",
    description="The pacemaker is off; the pellet's own stretch excites behind it and inhibits ahead of it.",
    expected="The paper reports irregular, delayed motion.",
    changes={"pacemaker.kind": "none"},
)
