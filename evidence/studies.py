"""Studies carried out: docs/evidence/studies.md and its pictures, from what the commands of the package measured.

`python evidence/studies.py [FOLDER [PART ...]]` measures what FOLDER (out/evidence_studies unless given) does not have,
all of it or only these parts (or single measurements of them), and writes the page of what is there. Finished runs are
kept in FOLDER/kept, finished measurements as JSON beside them: a call that is stopped goes on where it was. Some forty
minutes of one core.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from common import ROOT
from study_answers import CASES, MAPS, checked, class_map, cohort, ishigami, of_nothing, sensitivity
from study_commands import measured
from study_page import write
from study_workers import REPEATS, WAYS, jobqueue, killed, poisoned, timed

PARTS = ("sensitivity", "cohort", "map", "deaths", "workers")


def measurements(folder: Path) -> dict[str, dict[str, Callable[[], Any]]]:
    """What each part measures, by name."""
    found: dict[str, dict[str, Callable[[], Any]]] = {part: {} for part in PARTS}
    found["sensitivity"]["ishigami"] = ishigami
    for name in CASES:
        found["sensitivity"][name] = partial(sensitivity, folder, name)
        if CASES[name].method == "pawn":
            found["sensitivity"][f"nothing_{name}"] = partial(of_nothing, folder, name)
    for reading in ("tight", "edge"):
        found["sensitivity"][f"checked_{reading}"] = partial(checked, folder, reading)
    found["cohort"]["cohort"] = partial(cohort, folder)
    for name in MAPS:
        found["map"][f"map_{name}"] = partial(class_map, folder, name)
    found["deaths"]["killed"] = partial(killed, folder / "killed")
    for number, way in enumerate(WAYS[1:]):
        found["deaths"][f"poisoned_{number}"] = partial(poisoned, folder / "poisoned", way)
    found["deaths"]["jobqueue"] = partial(jobqueue, folder / "jobqueue")
    for repeat in range(REPEATS):
        for number, way in enumerate(WAYS):
            found["workers"][f"timed_{number}_{repeat}"] = partial(timed, folder / "timed", way)
    return found


def main() -> None:
    """Measure what is missing, write the page."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "out" / "evidence_studies").absolute()
    asked = sys.argv[2:] or PARTS
    made: dict[str, Any] = {}
    for part, wanted in measurements(folder).items():
        for name, make in wanted.items():
            if part in asked or name in asked:
                made[name] = measured(folder, f"measured_{name}", make)
            elif (folder / f"measured_{name}.json").is_file():
                made[name] = measured(folder, f"measured_{name}", dict)
    write(folder, made)


if __name__ == "__main__":
    main()
