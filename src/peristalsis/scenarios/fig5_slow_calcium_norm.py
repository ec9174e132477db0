"""Permeability of the slow Ca²⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_slow_calcium_norm",
    title="Fig. 5: slow Ca²⁺ permeability, norm",
    description=("The baseline; the norm to which a changed permeability of the slow Ca²⁺ channel is compared."),
    expected="In the paper: regular transit in 2.4 s.",
)
