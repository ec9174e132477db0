"""Permeability of the fast Ca²⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_fast_calcium_decreased",
    title="Fig. 5: fast Ca²⁺ permeability, decreased",
    description=(
        "The baseline with the conductance of the fast Ca²⁺ channel, the paper's permeability, at 0.75 of "
        "the norm in both layers."
    ),
    expected="In the paper: disrupted and delayed.",
    changes={"longitudinal.fast_calcium": "3 mS/cm^2", "circular.fast_calcium": "3 mS/cm^2"},
)
