"""Permeability of the Ca²⁺-activated K⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_calcium_potassium_decreased",
    title="Fig. 5: Ca²⁺-activated K⁺ permeability, decreased",
    description=(
        "The baseline with the conductance of the Ca²⁺-activated K⁺ channel, the paper's permeability, at "
        "0.75 of the norm in both layers."
    ),
    expected="In the paper: disrupted and delayed.",
    changes={"longitudinal.calcium_potassium": "0.0225 mS/cm^2", "circular.calcium_potassium": "0.0225 mS/cm^2"},
)
