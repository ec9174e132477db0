"""Stretch receptors alone, with Fig. 6."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig6_receptors_alone",
    title="Fig. 6: stretch receptors alone",
    description=(
        "The pacemaker is off and nothing but the pellet's own stretch starts the circular muscle; as "
        "Fig. 6 B, under the name the text gives it."
    ),
    expected="In the paper: irregular, delayed motion.",
    changes={"pacemaker.kind": "none"},
)
