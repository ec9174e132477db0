"""The experiment all others are compared with."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="baseline",
    title="Normal transit",
    description=(
        "One pacemaker pulse at the oral end starts a wave in the longitudinal layer, the circular layer "
        "follows where the longitudinal active tension passes its maximum, and the stretch receptors are on."
    ),
    expected="The paper reports regular transit of the 10 cm segment in 2.4 s, which is 4.2 cm/s.",
)
