"""Permeability of the fast Ca²⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_fast_calcium_increased",
    title="Fig. 5: fast Ca²⁺ permeability, increased",
    description=(
        "The baseline with the conductance of the fast Ca²⁺ channel, the paper's permeability, at 1.25 of "
        "the norm in both layers."
    ),
    expected="In the paper: disrupted and delayed.",
    changes={"longitudinal.fast_calcium": "5 mS/cm^2", "circular.fast_calcium": "5 mS/cm^2"},
)
