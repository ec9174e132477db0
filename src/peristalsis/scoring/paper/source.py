"""The paper as a source: claims, readings, runs, and the words of its report."""

from __future__ import annotations

from pathlib import Path

from ...inputs.parameters import READINGS
from ..claim import Explanation
from ..source import ParameterSet, Source
from ..space import read_space
from .claims import CLAIMS, NOT_TESTABLE
from .figures import FIGURES
from .runs import RUNS
from .searches import SEARCHES, SENSITIVITIES
from .tables import curves, entries_of, misprints
from .variants import VARIANTS

SOURCE = Source(
    name="paper",
    title="The paper, scored",
    heading="Computer-aided model of colonic propulsive activity: every experiment, scored",
    about="The source is Al Qatrawi & Miftahof. Runs by peristalsis {version}; frictions printed in N s/m and N are "
    "read in mN s/cm and mN. Calibrated: the wave. Chosen: what the last tables list. Everything else is prediction.",
    claims=CLAIMS,
    runs=RUNS,
    sets=tuple(ParameterSet(reading, reading) for reading in READINGS),
    searches=SEARCHES,
    sensitivities=SENSITIVITIES,
    variants=VARIANTS,
    untestable=NOT_TESTABLE,
    explanations=tuple(Explanation(**entry) for entry in entries_of("explanations", "explanation")),
    pictures=FIGURES,
    tables=(curves, misprints),
    space=read_space(Path(__file__).with_name("space.toml")),
    words={
        "thresholds": (
            "Thresholds",
            "A scan, then bisection to 2 % of the last change; one pulse at t = 0 unless the variant says otherwise.",
        ),
        "sensitivities": (
            "Viscous against dry friction",
            "Total share of the variance of the mean velocity in a 5 x 5 factorial; in brackets, leaving out one "
            "level.",
        ),
    },
)
