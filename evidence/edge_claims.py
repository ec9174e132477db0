"""Writes docs/paper/edge.md from the report of the fitted reading: `python evidence/edge_claims.py FOLDER [VARIANTS]`.

The folder is that of `peristalsis paper --reading all --out FOLDER`, or with `--reading edge`; the second, if there is
one, that of `peristalsis paper --reading edge --variant all --out VARIANTS`.
"""

from __future__ import annotations

import sys
from pathlib import Path

from common import wrapped
from paper_claims import PAGE, cell, rows_of, table, variants

from peristalsis.scoring import sources

HEAD = """# Claims under the reading `edge`

Made by `python evidence/edge_claims.py` from the tables of `peristalsis paper --reading edge`. *Asked*: the search that
found the reading counted this claim, so it is no prediction. *Held out*: it was not looked at. In brackets, the parts
that fail. The other readings: [claims](claims.md); what it means: [the regime of the paper](regimes.md); how far each
number can be moved: [width](width.md).

"""


def main() -> None:
    """Write the page."""
    folder = Path(sys.argv[1])
    space = sources.get("paper").space
    assert space is not None
    rows, kept = [], {"asked": 0, "held out": 0}
    for row in rows_of(folder, "claims"):
        if row["claim"].isdigit():
            use = "asked" if int(row["claim"]) in space.objective.claims else "held out"
            kept[use] += row["edge"].split(":")[0] == "holds"
            rows.append([f"{row['claim']}. {row['statement']}", use, cell(row["edge"])])
    asked, out = len(space.objective.claims), len(space.objective.held_out)
    text = HEAD + f"**{kept['asked']} of {asked} that were asked hold, and {kept['held out']} of {out} held out.**\n\n"
    text += table(["claim", "", "edge"], rows)
    text += "\n## Thresholds\n\n"
    thresholds = [row for row in rows_of(folder, "thresholds") if row["reading"].startswith("edge")]
    text += table(list(thresholds[0]), [list(row.values()) for row in thresholds])
    if len(sys.argv) > 2:
        text += variants(Path(sys.argv[2]), "edge")
    text += "\n## Grounds\n\n"
    grounds = [row for row in rows_of(folder, "parts") if row["reading"] == "edge"]
    text += table(
        ["claim", "part", "holds", "found"], [[r["claim"], r["part"], r["holds"], r["found"]] for r in grounds]
    )
    PAGE.with_name("edge.md").write_text(wrapped(text), encoding="utf-8")


if __name__ == "__main__":
    main()
