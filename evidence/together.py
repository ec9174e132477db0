"""Writes docs/paper/together.md from the tables of a search: `python evidence/together.py FOLDER`.

The folder is that of `peristalsis paper --search --held-out --out FOLDER`.
"""

from __future__ import annotations

import sys
from pathlib import Path

from common import ROOT, table, wrapped
from paper_claims import rows_of

from peristalsis.scoring import sources

PAGE = ROOT / "docs" / "paper" / "together.md"

HEAD = """# What can be had together

Made by `python evidence/together.py` from the tables of `peristalsis paper --search --held-out`: all 30 claims at every
point of the [search](regimes.md#the-search) that was scored, and under the readings. A name such as `s009.0` is
a row of [candidates.csv](candidates.csv). Held-out claims were measured when the search was over, and chose nothing.
"""

FRONT = """
## The front

Sets of claims that hold at one point; no point has all of a row and more. Of points with the same set three are named.

"""

EXCLUSIVE = """
## Pairs that exclude one another

Each of the two holds somewhere; no point has both.

"""

NOWHERE = """
## Claims that hold nowhere

The parts at which they fail, and the point that comes nearest. The margin is the share of the bound by which the number
lies on the right side; a negative one is what is missing. *does not* where no number decides, as where nothing arrives.

"""

POINTS = 3
"""So many points of a set are named."""


def main() -> None:
    """Write the page."""
    folder = Path(sys.argv[1])
    words = {str(one.number): one.statement for one in sources.get("paper").claims}
    nearest = rows_of(folder, "nearest")
    scored = max(int(row["holds at"].split(" of ")[1]) for row in nearest)
    somewhere = {row["claim"] for row in nearest if not row["holds at"].startswith("0 of")}
    text = f"{HEAD}\n{scored} points; {len(somewhere)} of the {len(words)} claims hold at one of them at least.\n"
    text += FRONT + table(
        ["claims", "hold together", "hold elsewhere only", "points"],
        [
            [row["claims"], row["hold together"], row["hold elsewhere only"], _some(row["points"])]
            for row in rows_of(folder, "front")
        ],
    )
    pairs: dict[str, list[str]] = {}
    for row in rows_of(folder, "exclusive"):
        for first, second in ((row["claim"], row["excludes"]), (row["excludes"], row["claim"])):
            pairs.setdefault(first, []).append(second)
    text += EXCLUSIVE + table(
        ["claim", "holds at", "never together with"],
        [
            [f"{claim}. {words[claim]}", _holds(nearest, claim), ", ".join(sorted(pairs[claim], key=int))]
            for claim in sorted(pairs, key=int)
        ],
    )
    text += NOWHERE + table(
        ["claim", "part", "part holds at", "best margin", "there", "point"],
        [
            [
                f"{row['claim']}. {words[row['claim']]}",
                *(row[name] for name in ("part", "part holds at", "best margin", "there", "point")),
            ]
            for row in nearest
            if row["claim"] not in somewhere
        ],
    )
    PAGE.write_text(wrapped(text), encoding="utf-8")
    (PAGE.parent / "candidates.csv").write_bytes((folder / "candidates.csv").read_bytes())


def _some(points: str) -> str:
    names = points.split(", ")
    more = len(names) - POINTS
    return ", ".join(names[:POINTS]) + (f" and {more} more" if more > 0 else "")


def _holds(nearest: list[dict[str, str]], claim: str) -> str:
    return next(row["holds at"] for row in nearest if row["claim"] == claim)


if __name__ == "__main__":
    main()
