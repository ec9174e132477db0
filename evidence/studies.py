"""Studies carried out: docs/evidence/studies.md and its pictures, from what the commands of the package measured.

`python evidence/studies.py [FOLDER [PART ...]]` measures what FOLDER (out/evidence_studies unless given) does not have,
all of it or only these parts, and writes the page of what is there. Finished runs are kept in FOLDER/kept, finished
measurements as JSON beside them: a call that is stopped goes on where it was.
"""

from __future__ import annotations

import sys
from pathlib import Path

from common import ROOT
from study_answers import CASES, checked, ishigami, sensitivity
from study_commands import measured

PARTS = ("sensitivity",)


def main() -> None:
    """Measure what is missing, write the page."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "out" / "evidence_studies").absolute()
    parts = sys.argv[2:] or PARTS
    if "sensitivity" in parts:
        measured(folder, "ishigami", ishigami)
        for reading, method, outputs, samples in CASES:
            measured(
                folder,
                f"measured_{method}_{reading}",
                lambda r=reading, m=method, o=outputs, s=samples: sensitivity(folder, r, m, o, s),
            )
        for reading in ("tight", "edge"):
            measured(folder, f"measured_checked_{reading}", lambda r=reading: checked(folder, r))


if __name__ == "__main__":
    main()
