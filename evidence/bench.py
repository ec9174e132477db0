"""Numbers and pictures of docs/bench.md, from the tables of commands: nothing there is typed by hand.

    peristalsis bench --out SCORED
    peristalsis bench --claim 2 --variant ungraded --variant constant-friction --variant falling-friction \\
        --variant taut --variant late-rise --variant contact-length --variant all-or-none --variant conducting \\
        --out VARIED
    peristalsis bench --calibrate --out CALIBRATED
    peristalsis bench --claim 8 --variant calcium --out CALCIUM
    python evidence/bench.py page SCORED VARIED CALIBRATED CALCIUM
    python evidence/bench.py passes
    python evidence/bench.py channels

`page` puts tables between the marks of docs/bench.md and copies the pictures. `passes` passes pellets one after the
other, with rests of several lengths, and does the same with their table and picture; `channels`
closes the ways of calcium into the cell of the variant calcium. The folder runs of one may be
copied into another: kept runs are not made again.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from paper_claims import rows_of, table

import peristalsis as ps
from peristalsis.scoring.bench.measure import measure
from peristalsis.scoring.bench.runs import ISOMETRIC
from peristalsis.scoring.bench.variants import VARIANTS

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, IMAGES = DOCS / "bench.md", DOCS / "images"
SET = "guinea_pig"
PICTURES = ("speed_diameter", "speed_load", "isometric", "force_diameter", "diameter_map")
WORTH = {"calibrated: no prediction": "calibrated", "used to choose: no prediction": "chosen"}
RESTS = ("2 s", "30 s", "60 s", "180 s", "600 s")
SHOWN = "180 s"
"""The rest of the picture: a laboratory's few minutes."""
COUNT = 4

Runs = Mapping[str, Mapping[str, str]]


def put(name: str, text: str) -> None:
    """Put a text between the marks of a name on the page."""
    before = PAGE.read_text(encoding="utf-8")
    marks = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
    after, count = marks.subn(lambda found: found[1] + text.rstrip("\n") + "\n" + found[2], before)
    if count != 1:
        raise SystemExit(f"{PAGE.name}: not one place for {name}")
    PAGE.write_text(after, encoding="utf-8")


def runs_of(folder: Path, condition: str) -> dict[str, dict[str, str]]:
    """Rows of the table of runs under a condition, by run."""
    return {row["run"]: row for row in rows_of(folder, "velocities") if row["preparation"] == condition}


def series(runs: Runs, names: Sequence[str], column: str = "speed (mm/s)") -> str:
    """One number of several runs, one after the other."""
    return ", ".join(f"{float(runs[name][column]):.3g}" for name in names)


def change(runs: Runs, run: str, of: str, column: str) -> str:
    """By how much a number of a run differs from that of another, in per cent."""
    return f"{100.0 * (float(runs[run][column]) / float(runs[of][column]) - 1.0):+.0f} %"


def found(runs: Runs, parts: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """What was found for each claim."""
    speed, force = "speed (mm/s)", "isometric force (mN)"
    girths = ("diameter_1", "diameter_1.06", "diameter_1.1", "control", "diameter_1.2", "diameter_1.26")
    heavy = ("load_10", "load_20", "load_40", "load_60", "load_80", "load_100")
    order = [runs[run][column] for run in ("control", "diameter_1.1", "load_20") for column in ORDER]
    gone, control = (float(runs[run][speed]) for run in ("tetrodotoxin", "control"))
    return {
        "B1": f"{series(runs, ['control'])} mm/s",
        "B2": f"{series(runs, girths)} mm/s at R/r0 = 1, 1.06, 1.1, 1.14 (the natural pellet), 1.2, 1.26",
        "B3": f"{series(runs, heavy)} mm/s against 10, 20, 40, 60, 80, 100 mN",
        "B4": f"force {change(runs, 'held_hexamethonium', 'held', force)}, speed "
        f"{change(runs, 'hexamethonium', 'control', speed)}, with half of the reflex left (no source gives the share)",
        "B5": f"{100.0 * gone / control:.2g} %",
        "B6": f"{100.0 * float(runs['no_longitudinal_force'][speed]) / control:.0f} %",
        "B7": f"on {100.0 * min(map(float, order)):.0f} % of the middle 3 cm on each of three passes",
        "B8": "; ".join(parts["B8"]),
        "B10": f"{float(runs['control']['contact (kPa)']):.2g} kPa, {series(runs, ['control'], PEAK)} mN",
    }


ORDER = ("relaxed first", "dilated first")
PEAK = "largest force (mN)"


def words(text: str) -> str:
    """Names of metrics and runs as a reader says them."""
    for name, said in (("middle_speed_mm_s", "speed"), ("isometric_force_mN", "isometric force")):
        text = text.replace(name, said)
    return text


def scores(folder: Path, condition: str = SET) -> str:
    """Claims with their verdict under a condition, what was found, and what it is worth."""
    parts: dict[str, list[str]] = {}
    for row in rows_of(folder, "parts"):
        if row["preparation"] == condition:
            parts.setdefault(row["claim"], []).append(words(row["found"]))
    numbers = found(runs_of(folder, condition), parts)
    rows = []
    for row in rows_of(folder, "claims"):
        if row["claim"] in numbers:
            verdict = {"holds": "holds", "does not hold": "**contradicted**"}.get(
                row[condition], f"**{row[condition]}**"
            )
            worth = WORTH.get(row["use"], row["use"].split(":")[0])
            rows.append([row["claim"], row["statement"], verdict, numbers[row["claim"]], worth])
    return table(["", "claim", "verdict", "found", "worth"], rows)


def whole(folder: Path, name: str, drop: Sequence[str] = ()) -> str:
    """A table of a report as it stands, without some columns."""
    rows = rows_of(folder, name)
    head = [column for column in rows[0] if column not in drop]
    return table(head, [[row[column] for column in head] for row in rows])


def calcium(folder: Path) -> str:
    """What the claim of the blocker comes to, as shipped and with a cell whose force follows calcium."""
    girths = {row["preparation"]: row for row in rows_of(folder, "girths")}
    natural = list(next(iter(girths.values())))[4]
    rows = [
        [
            row["preparation"].removeprefix(f"{SET}, "),
            girths[row["preparation"]][natural],
            runs_of(folder, row["preparation"])["held"]["isometric force (mN)"],
            words(row["found"]),
            row["holds"],
        ]
        for row in rows_of(folder, "parts")
        if row["claim"] == "B8"
    ]
    head = ["muscle", "speed (mm/s)", "isometric force (mN)", "concentrations over the IC50", "B8 holds"]
    return table(head, rows)


def calibration(folder: Path) -> str:
    """What the calibration fixes, which combinations, and what holds of the claims held out."""
    points = [row for row in rows_of(folder, "calibration_points") if row["point"] != "shipped"]
    asked = [column for column in points[0] if column in ("claim 1", "claim 2", "claim 3")]
    good = sum(all(row[column] == "holds" for column in asked) for row in points)
    alone = sum(row["claim 1"] == "holds" for row in points if row["point"].startswith("a"))
    first = sum(row["point"].startswith("a") for row in points)
    count = f"B1 alone holds at {alone} of the {first} points of the first round"
    text = f"{count}, B1 to B3 at {good} of all {len(points)}.\n\n" + whole(folder, "calibration")
    text += "\n" + whole(folder, "combinations")
    held = rows_of(folder, "held_out")
    return text + "\n" + table(["held out", "holds at"], [[f"B{row['claim']}", row["holds at"]] for row in held])


def page(scored: Path, varied: Path, calibrated: Path, cell: Path) -> None:
    """Tables and pictures of the page."""
    put("scores", scores(scored))
    put("girths", whole(varied, "girths"))
    put("loads", whole(scored, "loads"))
    put("forces", whole(scored, "forces"))
    put("calcium", calcium(cell))
    put("calibration", calibration(calibrated))
    for name in PICTURES:
        shutil.copy(scored / f"{name}.png", IMAGES / f"bench_{name}.png")
    shutil.copy(calibrated / "calibration.png", IMAGES / "bench_calibration.png")


def passes() -> None:
    """Passes with rests of several lengths."""
    rows = []
    for rest in RESTS:
        found = ps.passes("guinea_pig", count=COUNT, rest=rest)
        transits = [one.result.summary["transit_s"] for one in found.passes]
        rows.append(
            [
                rest,
                ", ".join("–" if one is None else f"{one:.1f}" for one in transits),
                ", ".join(f"{10.0 * one.speed:.2f}" for one in found.passes),
                f"{found.passes[1].drive:.2g}",
                f"{10.0 * found.passes[1].narrowest:.2f}",
            ]
        )
        print(rows[-1], flush=True)
        if rest == SHOWN:
            found.figure().savefig(IMAGES / "bench_passes.png")
    head = ["rest", "transit (s)", "speed in the middle (mm/s)", "drive left (mV)", "narrowest radius (mm)"]
    put("passes", table(head, rows))


CELL = VARIANTS["calcium"].changes
LEFT = 1.0 / 31.0
"""What 30 times the IC50 leaves of a channel."""


def channels() -> None:
    """Speed and isometric force with either way of calcium into the cell of the variant, and both, all but closed."""
    names = {"L-type": "calcium_l", "low-voltage": "calcium_t"}
    whole_cell = ps.configuration("guinea_pig", changes=CELL)
    rows = []
    for closed in ((), ("L-type",), ("low-voltage",), ("L-type", "low-voltage")):
        changes = dict(CELL)
        for one in closed:
            key = f"tissue.corrias_buist_2007.{names[one]}"
            changes[key] = f"{LEFT * float(str(whole_cell.flat()[key]))!r} mS/cm^2"
        numbers = []
        for held, metric in (({}, "middle_speed_mm_s"), (ISOMETRIC, "isometric_force_mN")):
            simulation = ps.Simulation(ps.configuration("guinea_pig", changes={**changes, **held}))
            numbers.append(f"{float(measure(simulation, simulation.run())[0][metric]):.3g}")
        rows.append([" and ".join(closed) or "none", *numbers])
        print(rows[-1], flush=True)
    put("channels", table(["closed to 1/31", "speed (mm/s)", "isometric force (mN)"], rows))


if __name__ == "__main__":
    if sys.argv[1] == "page":
        page(*(Path(one) for one in sys.argv[2:6]))
    else:
        {"passes": passes, "channels": channels}[sys.argv[1]]()
