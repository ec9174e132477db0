"""A gut that was measured: a pellet in an isolated colon, moved by its own stretch."""

from peristalsis.inputs.parameters import PREPARATIONS
from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="guinea_pig",
    title="Isolated guinea-pig distal colon",
    description=(
        "The natural pellet in a segment of guinea-pig distal colon at 37 degrees Celsius. Nothing but the pellet's "
        "stretch drives the muscle: receptors excite it on the oral side and inhibit it on the anal side, the more the "
        "more they are stretched."
    ),
    expected="About 2 mm/s with some tens of mN; speed rises with the diameter and falls with a load.",
    changes=PREPARATIONS["guinea_pig_distal_colon"].changes(),
    preparation="guinea_pig_distal_colon",
)
