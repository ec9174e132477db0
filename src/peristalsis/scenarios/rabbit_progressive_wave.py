"""The wave that the paper's is nearest to among those that were measured."""

from peristalsis.inputs.parameters import PREPARATIONS
from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="rabbit_progressive_wave",
    title="Progressive wave, rabbit proximal colon",
    description=(
        "The paper's tube and forces with the tissue slowed so that its wave has the speed that was measured in the "
        "rabbit's proximal colon, in a tube as long as the wave lasts."
    ),
    expected="A wave of 3.2 cm/s (measured: 3.2 +- 1.2 cm/s with hard content) that lasts about 5.5 s.",
    changes=PREPARATIONS["rabbit_progressive_wave"].changes(),
    preparation="rabbit_progressive_wave",
)
