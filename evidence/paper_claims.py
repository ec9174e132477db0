"""Writes docs/paper/claims.md from the tables of a report: `python evidence/paper_claims.py out/paper [out/variants]`.

The first folder is that of `peristalsis paper --reading all`, the second that of `peristalsis paper --variant all`.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from common import wrapped

PAGE = Path(__file__).resolve().parents[1] / "docs" / "paper" / "claims.md"
READINGS = ("tight", "stretched", "printed", "edge")

HEAD = """# Claims: how they are judged, and what came out

Made by `python evidence/paper_claims.py` from the tables of `peristalsis paper --reading all` and `--variant all`.

Thirty claims of the paper stand as data in `scoring/paper/claims.py`. A claim is made of named parts; a part is a
pure rule on measured numbers. It **holds** if all parts do, **holds in part** if some do (the others are named), **does
not hold** if none does, and is **not testable** if the runs it needs cannot be made or say nothing. A transit counts as
different from 1 % on, twice what the grids leave. Never arriving is later than any time.

Claim 1 was used to calibrate the wave, 7, 10 and 23 to choose the units of friction and the reading `tight`; they count
as no predictions. The reading `edge` is fitted: which claims it was asked for and which were held out, and each of its
grounds, stand on [its own page](edge.md). When the rules were written the baseline, the switches and the trigger rules
of [evidence](../evidence/) were known; nothing else was.
"""


def rows_of(folder: Path, table: str) -> list[dict[str, str]]:
    """The rows of one table of a report."""
    with (folder / f"{table}.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def cell(text: str) -> str:
    """A verdict for the page: bold, with what fails in brackets."""
    verdict, _, parts = text.partition(": ")
    parts = parts.removeprefix("not ")
    return f"**{verdict}** ({parts})" if parts else f"**{verdict}**"


def table(columns: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [" | ".join(columns), " | ".join("---" for _ in columns), *(" | ".join(row) for row in rows)]
    return "".join(f"| {line} |\n" for line in lines)


def matrix(folder: Path) -> str:
    """Claims x readings."""
    found = rows_of(folder, "claims")
    uses = {
        "prediction": "prediction",
        "calibrated: no prediction": "calibrated",
        "used to choose: no prediction": "chosen",
    }
    rows = [
        [f"{row['claim']}. {row['statement']}", uses[row["use"]], *(cell(row[reading]) for reading in READINGS)]
        for row in found
        if row["claim"].isdigit()
    ]
    counted = [
        [row["reading"], row["claims"], *(row[v] for v in ("holds", "holds in part", "does not hold", "not testable"))]
        for row in rows_of(folder, "counts")
        if (row["reading"], row["claims"]) != ("edge", "predictions")  # it was fitted to most of them
    ]
    return (
        "\n## Matrix: 10 s, one pulse\n\nIn brackets, the parts that fail or cannot be tested.\n\n"
        + table(["claim", "use", *READINGS], rows)
        + '\n"Resembles experiments" (section 4) is not testable: the paper shows no record and names no measure of '
        "likeness.\n\n" + table(["reading", "claims", "hold", "in part", "do not hold", "not testable"], counted)
    )


def reasons(folder: Path) -> str:
    """Why claims fail, with the commands that show it."""
    text = ""
    for reading in READINGS:
        found = [row for row in rows_of(folder, "explanations") if row["reading"] == reading]
        if not found:
            continue
        text += f"\n## Why claims fail (`{reading}`)\n\n"
        for row in found:
            text += f"- **{row['claim']}.** {row['reason']} `{row['command that shows it']}`"
            if row["nearest"] != "none seen":
                text += f" Nearest: {row['nearest']}."
                if row["command for it"] != "–":
                    text += f" `{row['command for it']}`"
            text += "\n"
    return text


def thresholds(folder: Path, title: str) -> str:
    """Thresholds with their brackets."""
    rows = [
        [row["reading"], row["threshold"], row["bracket"], row["regions"], row["simulated where it does not arrive"]]
        for row in rows_of(folder, "thresholds")
    ]
    head = ["condition", "threshold", "bracket", "what was found", "simulated where it does not arrive"]
    return f"\n## {title}\n\n" + table(head, rows)


def sensitivities(folder: Path) -> str:
    """Viscous against dry friction."""
    rows = [list(row.values()) for row in rows_of(folder, "sensitivities")]
    return (
        "\n## Viscous against dry friction\n\nTotal share of the variance of the mean velocity, with the band of "
        "leaving out one level.\n\n" + table(["reading", "range", "viscous", "dry"], rows)
    )


def variants(folder: Path, reading: str = "tight") -> str:
    """Which verdicts one changed choice turns."""
    found = [row for row in rows_of(folder, "claims") if row["claim"].isdigit()]
    titles = [name for name in found[0] if name.startswith(f"{reading}, ")]
    rows = []
    for row in found:
        turned = [row[title] != row[reading] for title in titles]
        if any(turned):
            cells = [cell(row[title]) if other else "–" for title, other in zip(titles, turned, strict=True)]
            rows.append([row["claim"], cell(row[reading]), *cells])
    unturned = [row["claim"] for row in found if all(row[title] == row[reading] for title in titles)]
    counts = [
        [row["reading"].removeprefix(f"{reading}, "), row["holds"], row["holds in part"], row["does not hold"]]
        for row in rows_of(folder, "counts")
        if row["reading"].startswith(reading) and row["claims"] == "all"
    ]
    return (
        f"\n## One choice changed (`{reading}`)\n\nWhat a changed choice turns; a dash means the same verdict. "
        "Thresholds and sensitivities (claims 8, 10, 23) are searched anew under slow waves and under 20 s only.\n\n"
        + table(["claim", reading, *(title.removeprefix(f"{reading}, ") for title in titles)], rows)
        + f"\nThe same under every variant: claims {', '.join(unturned)}.\n\n"
        + table(["variant", "hold", "in part", "do not hold"], counts)
    )


def main() -> None:
    """Write the page."""
    folder = Path(sys.argv[1])
    text = HEAD + matrix(folder) + reasons(folder) + thresholds(folder, "Thresholds (one pulse, 10 s)")
    text += "\n![Mean velocity over each parameter, with the brackets](thresholds.png)\n"
    text += sensitivities(folder)
    text += (
        "\n## Further\n\nWhat one changed choice does to the runs behind the failing claims, and thresholds at doubled "
    )
    text += "duration and under slow waves: [variants](../evidence/variants.md). The paper's misprints put back, which "
    text += "test notices and what the baseline does: [misprints](../evidence/misprints.md).\n"
    if len(sys.argv) > 2:
        other = Path(sys.argv[2])
        text += variants(other) + thresholds(other, "Thresholds under slow waves and at doubled duration")
    PAGE.write_text(wrapped(text), encoding="utf-8")


if __name__ == "__main__":
    main()
