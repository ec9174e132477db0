"""Permeability of the Ca²⁺-activated K⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_calcium_potassium_norm",
    title="Fig. 5: Ca²⁺-activated K⁺ permeability, norm",
    description=(
        "The baseline; the norm to which a changed permeability of the Ca²⁺-activated K⁺ channel is compared."
    ),
    expected="In the paper: regular transit in 2.4 s.",
)
