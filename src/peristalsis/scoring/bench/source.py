"""The bench as a source: claims, the preparation, runs, and the words of its report."""

from __future__ import annotations

import tomllib
from pathlib import Path

from ...inputs.parameters import PREPARATIONS
from ..calibration import Calibration, read_calibration
from ..claim import Explanation
from ..source import ParameterSet, Source
from .claims import CLAIMS, NOT_TESTABLE
from .figures import PICTURES
from .measure import METRICS, measure
from .runs import RUNS
from .tables import TABLES
from .variants import VARIANTS

_PREPARATION = PREPARATIONS["guinea_pig_distal_colon"]


def _explanations() -> tuple[Explanation, ...]:
    with (Path(__file__).parent / "explanations.toml").open("rb") as file:
        return tuple(Explanation(**entry) for entry in tomllib.load(file).get("explanation", ()))


def _calibration() -> Calibration:
    return read_calibration(Path(__file__).parent / "calibration.toml", _PREPARATION.parameters)


SOURCE = Source(
    name="bench",
    title="The bench, scored",
    heading="Isolated guinea-pig distal colon: what laboratories measured, scored",
    about=f"Runs by peristalsis {{version}} of the preparation {_PREPARATION.name}. Publications, read in their "
    f"abstracts: {_PREPARATION.citation}. Fitted: {_PREPARATION.fitted_on}. B1 is calibrated, B2 to B4 "
    "served to choose, B10 is a bound; the others are predictions.",
    claims=CLAIMS,
    runs=RUNS,
    sets=(ParameterSet("guinea_pig", "tight", _PREPARATION.changes()),),
    variants=VARIANTS,
    untestable=NOT_TESTABLE,
    explanations=_explanations(),
    pictures=PICTURES,
    tables=TABLES,
    columns={
        "transit_s": "transit (s)",
        "travel_cm": "travel (cm)",
        "middle_speed_mm_s": "speed (mm/s)",
        "peak_force_mN": "largest force (mN)",
        "isometric_force_mN": "isometric force (mN)",
        "contact_kPa": "contact (kPa)",
        "relaxed_first": "relaxed first",
        "dilated_first": "dilated first",
    },
    measure=measure,
    metrics=METRICS,
    coarse={"grid.n_z": 200, "grid.n_z_wall": 150, "step.wall": "100 ms", "step.conduction": "20 ms"},
    calibration=_calibration,
    word="preparation",
    prefix="B",
)
