"""Permeability of the slow Ca²⁺ channel, Fig. 5."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="fig5_slow_calcium_increased",
    title="Fig. 5: slow Ca²⁺ permeability, increased",
    description=(
        "The baseline with the conductance of the slow Ca²⁺ channel, the paper's permeability, at 1.25 of "
        "the norm in both layers."
    ),
    expected="In the paper: disrupted and delayed.",
    changes={"longitudinal.slow_calcium": "0.005 mS/cm^2", "circular.slow_calcium": "0.005 mS/cm^2"},
)
