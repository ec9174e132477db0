"""Longitudinal muscle alone."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="pendular",
    title="Pendular movements",
    description=(
        "The circular layer has no force, so the longitudinal layer contracts alone; its waves run as in the "
        "baseline.  With friction against the resting frame a longitudinal contraction can hardly drag the "
        "pellet: compare pellet.friction_frame = wall."
    ),
    expected="The paper reports normal transit without mixing.",
    changes={"circular.active": 0.0},
)
