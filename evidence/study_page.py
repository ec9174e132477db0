"""The page that `studies` writes: docs/evidence/studies.md, from what was measured, and pictures that commands drew."""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

from common import FOLDER, save_text, table
from study_answers import CASES, EXAMPLE, FULL, MAPS, MEMBERS
from study_workers import KILLS, POISONED, REPEATS, RUNS, WAYS

Made = Mapping[str, Any]
PICTURES = {
    "studies_sobol_tight.png": ("sobol_tight", "sensitivity.png"),
    "studies_pawn_edge.png": ("pawn_edge", "sensitivity.png"),
    "studies_cohort.png": ("cohort", "cohort.png"),
    "studies_map.png": ("map_motion", "map.png"),
}
"""Name on the page to the folder of a study and what its command drew there."""


def write(folder: Path, made: Made) -> None:
    """Write the page of what there is."""
    for name, (study, drawn) in PICTURES.items():
        if (folder / study / drawn).is_file():
            shutil.copyfile(folder / study / drawn, FOLDER / name)
    parts = [HEAD]
    for needed, part in (
        (("sobol_tight",), norm),
        (("pawn_edge",), edge),
        (("sobol_tight", "pawn_edge"), claim),
        (("checked_tight",), grids),
        (("ishigami",), known),
        (("cohort",), population),
        (("map_full", "map_motion"), maps),
        (("timed_1_0",), workers),
        (("killed",), deaths),
    ):
        if all(one in made for one in needed):
            parts.append(part(made))
    save_text("studies.md", wrapped("\n".join(parts)))


def wrapped(text: str) -> str:
    """The same with paragraphs of 100 columns; tables, headings and pictures as they are."""
    blocks = []
    for found in re.split(r"\n\s*\n", text.strip()):
        block = found.strip()
        prose = not block.startswith(("#", "|", "!"))
        blocks.append(textwrap.fill(block, 100, break_on_hyphens=False, break_long_words=False) if prose else block)
    return "\n\n".join(blocks) + "\n"


HEAD = """# Studies, carried out

Written by `python evidence/studies.py` from what the commands of [studies](../studies.md) measured. Other work ran
on the same two cores at the time: seconds on the clock depend on it, those of processor time hardly. A research model,
not medical advice.
"""


def cost(one: Mapping[str, Any]) -> str:
    """What a command took."""
    return f"{one['clock']:.0f} s on the clock, {one['processor']:.0f} s of processor time"


def bands(rows: Sequence[Mapping[str, str]], output: str) -> str:
    """The indices of one output as a table, in the order of their ranks; a line of sums for Sobol' indices."""
    mine = [row for row in rows if row["output"] == output]
    kinds = list(dict.fromkeys(row["index"] for row in mine))
    names = [row["parameter"] for row in sorted(mine, key=lambda row: int(row["rank"])) if row["index"] == kinds[0]]
    lines: list[list[object]] = []
    for name in names:
        line: list[object] = [name]
        for kind in kinds:
            row = next(one for one in mine if (one["parameter"], one["index"]) == (name, kind))
            text = f"{float(row['value']):.2g}"
            line.append(f"{text} ({float(row['low']):.2g} to {float(row['high']):.2g})" if row["low"] else text)
        lines.append(line)
    if "total" in kinds:
        sums = [sum(float(row["value"]) for row in mine if row["index"] == kind) for kind in kinds]
        lines.append(["sum", *(f"{one:.2f}" for one in sums)])
    return f"`{output}`:\n\n" + table(["parameter", *kinds], lines)


def one_sensitivity(made: Made, name: str) -> str:
    """Cost, ends of runs and indices of one sensitivity."""
    found = made.get(name)
    if found is None:
        return ""
    case = CASES[name]
    ends = ", ".join(f"{count} {status.replace('_', ' ')}" for status, count in found["statuses"].items())
    lost = ", ".join(f"{count} without `{output}`" for output, count in found["without"].items() if count)
    text = (
        f"### {case.method.capitalize()}, {case.reading}, runs of {case.duration}\n\n{sum(found['statuses'].values())} "
        f"runs: {ends}{'; ' + lost if lost else ''}. {cost(found['cost'])}.\n\n"
    )
    if found.get("refusal"):
        return text + f"Refused: {found['refusal']}\n\n"
    floor = made.get(f"nothing_{name}")
    if floor:
        words = ", ".join(f"{value:.2g} for `{output}`" for output, value in floor.items())
        text += (
            f"Shuffled numbers, that have nothing to do with the runs, get {words}: less than that says nothing.\n\n"
        )
    return text + "\n".join(bands(found["indices"], output) for output in found["without"]) + "\n"


def norm(made: Made) -> str:
    """Sobol' and Morris at the norm."""
    file = EXAMPLE.name
    text = (
        "## Which parameter matters: the norm\n\n"
        f"`peristalsis sensitivity examples/{file}`: six parameters, ranges with reasons in the file, the reading "
        "`tight`, on half the shipped grids. Bands hold 95 %: by bootstrap for Sobol' and Morris' mean size. `total` "
        "is what a parameter does with all its interactions, `first` what it does alone; were there no interactions, "
        "both would sum to 1.\n\n"
    )
    return (
        text
        + one_sensitivity(made, "sobol_tight")
        + "\n![Sobol' indices at the norm](studies_sobol_tight.png)\n\n"
        + one_sensitivity(made, "morris_tight")
    )


def edge(made: Made) -> str:
    """PAWN, Sobol' and Morris at the edge of slipping."""
    text = (
        "## Which parameter matters: the edge of slipping\n\n"
        f"`peristalsis sensitivity examples/{EXAMPLE.name} --reading edge --method pawn`: the same factors on the "
        "numbers of the reading `edge`, where pellets slip and are caught by later waves: transit has two humps, and "
        "PAWN asks for no variance. Its index is the median distance by which the distribution moves when one "
        "parameter is held.\n\n"
    )
    if "pawn_edge_first" in made:
        text += (
            "In runs that end after 3 s a pellet that the first wave left has no transit: PAWN takes it as last in the "
            "order, Sobol' and Morris would be refused.\n\n"
        )
    pictures = {"pawn_edge": "\n![PAWN at the edge](studies_pawn_edge.png)\n"}
    names = (name for name, case in CASES.items() if case.reading == "edge")
    return text + "\n".join(one_sensitivity(made, name) + pictures.get(name, "") for name in names)


def claim(made: Made) -> str:
    """Viscous against dry friction, by every method and reading."""
    rows: list[list[object]] = []
    for name, case in CASES.items():
        ranks = {"sobol": "total", "morris": "mean size", "pawn": "median distance"}[case.method]
        indices = made.get(name, {"indices": []})["indices"]
        for output in dict.fromkeys(row["output"] for row in indices):
            by_name = {row["parameter"]: row for row in indices if (row["output"], row["index"]) == (output, ranks)}
            viscous, dry = by_name["viscous_friction"], by_name["dry_friction"]
            apart = float(viscous["low"]) > float(dry["high"])
            rows.append(
                [
                    *(f"{case.reading}, {case.duration}", case.method, output),
                    *(f"{float(one['value']):.2g}, rank {one['rank']}" for one in (viscous, dry)),
                    f"{float(viscous['value']) / max(float(dry['value']), 1e-12):.2g}",
                    "yes" if apart else "bands overlap",
                ]
            )
    force = made["sobol_tight"]["spreads"]["max_axial_force_mN"]["mean"]
    agreed, disjoint = sum(float(str(row[5])) > 1.0 for row in rows), sum(row[6] == "yes" for row in rows)
    return (
        "## Viscous or dry friction\n\n"
        "The paper says that viscous friction matters, not dry friction. Both were varied by the same factors, 0.5 to "
        f"1.5, and in {agreed} of {len(rows)} cases viscous friction has the larger index, in {disjoint} with bands "
        f"that do not touch. Dry friction is then 10 to 30 mN, beside a largest force of {force:.0f} mN in the mean: "
        "where it is some hundred mN it stops pellets, as the map below has it, and over the paper's ranges (2 to 800 "
        "mN) it has a share that [the claims](../paper/claims.md#viscous-against-dry-friction) give.\n\n"
        + table(["reading", "method", "output", "viscous", "dry", "viscous over dry", "bands apart"], rows)
    )


def grids(made: Made) -> str:
    """Ten points of each reading on the shipped grids."""
    rows: list[list[object]] = []
    for reading in ("tight", "edge"):
        pairs = made.get(f"checked_{reading}", [])
        for output in ("transit_s", "mean_velocity_cm_s", "max_axial_force_mN"):
            both = [(float(one["coarse"][output]), float(one["shipped"][output])) for one in pairs
                    if one["coarse"][output] and one["shipped"][output]]  # fmt: skip
            differ = [abs(a - b) / b for a, b in both]
            if not differ:
                continue
            mean = fmean(b for _, b in both)
            spread = (sum((b - mean) ** 2 for _, b in both) / len(both)) ** 0.5
            unlike = sum(bool(one["coarse"][output]) != bool(one["shipped"][output]) for one in pairs)
            order = _agreement([a for a, _ in both], [b for _, b in both])
            rows.append(
                [
                    *(reading, output),
                    *(f"{100.0 * one:.2g} %" for one in (max(differ), median(differ), spread / mean)),
                    *(f"{order:.3f}", f"{unlike} of {len(pairs)}"),
                ]
            )  # fmt: skip
    return (
        "## Half the shipped grids\n\n"
        "Ten points of the first sensitivity of each reading, drawn by a seed, again on the shipped grids (700 cells, "
        "650 elements). "
        "Spread: standard deviation over the ten points; order: Spearman's correlation of both.\n\n"
        + table(["reading", "output", "largest difference", "median", "spread", "order", "a number on one only"], rows)
    )


def _agreement(one: Sequence[float], two: Sequence[float]) -> float:
    from scipy.stats import spearmanr

    return float(spearmanr(one, two).statistic)


def known(made: Made) -> str:
    """Ishigami's function."""
    found = made["ishigami"]
    rows = [
        [one["parameter"], one["index"], one["exact"], one["value"], f"{one['low']:.3f} to {one['high']:.3f}"]
        for one in found["indices"]
    ]
    return (
        "## A function with known indices\n\n"
        f"Ishigami and Homma's function (a = 7, b = 0.1), {found['runs']} evaluations, 95 % bands "
        "(`tests/unit/test_indices.py` holds it to 0.03):\n\n"
        + table(["parameter", "index", "exact", "found", "band"], rows)
    )


def population(made: Made) -> str:
    """The cohort."""
    found = made["cohort"]
    rows = []
    for one in found["shifts"]:
        shift = "–" if not one["low"] else (
            f"{float(one['median shift [s]']):.3g} ({float(one['low']):.3g} to {float(one['high']):.3g})"
        )  # fmt: skip
        accepted = int(one["members"])
        out = f"{100.0 * int(one['not expelled']) / accepted:.1f} %"
        middle = f"{float(one['median transit [s]']):.3g}" if one["median transit [s]"] else "–"
        counts = (one[k] for k in ("intervention", "normal", "slow", "not expelled"))
        rows.append([*counts, out, one["gained"], one["lost"], middle, shift])
    low, fifth, quarter, half, three, most, high = found["quantiles"]
    runs = found["members"] + int(found["shifts"][0]["members"]) * (len(rows) - 1)
    why = ", ".join(f"{count} {text}" for text, count in found["why_not"].items())
    accepted = int(found["shifts"][0]["members"])
    head = ["intervention", "normal", "slow", "not expelled", "share not expelled", "gained", "lost"]
    head += ["median transit, s", "paired shift, s (95 %)"]
    return (
        f"## A cohort of {MEMBERS}\n\n"
        f"`examples/cohort.toml` with {MEMBERS} members: distributions and rules with their reasons in the file, two "
        f"interventions, on a coarse grid. {accepted} members are accepted{f' ({why} left out)' if why else ''}, "
        f"{runs} runs, {cost(found['cost'])}. Transit without an intervention: "
        f"5 % below {fifth:.3g} s, a quarter below {quarter:.3g}, half below {half:.3g}, three quarters below "
        f"{three:.3g}, 95 % below {most:.3g}, from {low:.3g} to {high:.3g}.\n\n"
        + table(head, rows)
        + "\n![Transit times of the cohort, and shifts member by member](studies_cohort.png)\n"
    )


def maps(made: Made) -> str:
    """Maps against the full grid."""
    full = {tuple(row[:2]): row[2] for row in made["map_full"]["nodes"]}
    rows: list[list[object]] = []
    for name, (nodes, coarse, classes) in MAPS.items():
        found = made.get(f"map_{name}")
        if found is None or name == "full":
            continue
        same, shared = 0, 0
        for x, y, told, _ in found["nodes"]:
            if (x, y) in full:
                shared += 1
                right = full[x, y] if classes == "motion" else _expelled(full[x, y])
                same += told == right
        share = f"{100.0 * found['run'] / len(found['nodes']):.0f} %"
        rows.append([classes, f"{nodes} x {nodes}", coarse, found["run"], share, f"{same} of {shared}"])
    counted = ", ".join(f"{count} {name}" for name, count in made["map_full"]["classes"].items())
    return (
        "## Maps of classes against the full grid\n\n"
        f"`examples/stall_map.toml`, radius and dry friction, on a coarse grid, with steps of 10 ms, for "
        f"4 s. All {len(full)} nodes of a grid of "
        f"{FULL} x {FULL} were run outright ({cost(made['map_full']['cost'])}): {counted}. The refined maps beside "
        "it:\n\n"
        + table(["classes", "nodes", "coarse", "nodes run", "share", "same class as the full grid"], rows)
        + "\n![The refined map](studies_map.png)\n"
    )


def _expelled(motion: str) -> str:
    return "expelled" if motion in ("rides the wave", "slips and is caught") else "not expelled"


def workers(made: Made) -> str:
    """Cost by workers."""
    rows: list[list[object]] = []
    tables = set()
    best: dict[int, float] = {}
    for number, way in enumerate(WAYS):
        found = [made[f"timed_{number}_{k}"] for k in range(REPEATS) if f"timed_{number}_{k}" in made]
        if not found:
            continue
        tables |= {one["table"] for one in found}
        best[number] = min(one["clock"] for one in found)
        processor = min(one["processor"] for one in found)
        clocks = ", ".join(f"{one['clock']:.0f}" for one in found)
        memory = " and ".join(f"{one:.0f}" for one in found[0]["worker_memory"]) if number else "–"
        parent = f"{max(one['parent_memory'] for one in found):.0f}"
        speed_up = f"{best[0] / best[number]:.2f}" if 0 in best else "–"
        rows.append([way, clocks, f"{best[number]:.0f}", speed_up, f"{processor:.0f}", parent, memory])
    head = ["who runs", "clock, s", "best, s", "speed-up", "processor, s", "memory of the parent, MB", "of workers, MB"]
    each = min(one["processor"] for name, one in made.items() if name.startswith("timed_")) / RUNS
    same = "the same to the bit" if len(tables) == 1 else f"**{len(tables)} different tables**"
    return (
        "## Workers\n\n"
        f"A study of {RUNS} runs (Sobol', three parameters, 80 cells, 60 elements, 10 ms, 3 s: {each:.2f} s of "
        f"processor time a run), nothing kept before; every clock is listed, of at most {REPEATS} in turn. All tables "
        f"are {same}. Processor time is that of all processes together, the least of its column; memory is the largest "
        "resident set of each process.\n\n" + table(head, rows)
    )


def deaths(made: Made) -> str:
    """What survives."""
    found = made["killed"]
    rows = [
        [k, one["victim"], one["kept"], "–" if one["victim"] == "worker" else f"{one['workers_gone']:.1f} s"]
        for k, one in enumerate(found["kills"], 1)
    ]
    reference = next((one["table"] for name, one in made.items() if name.startswith("timed_")), None)
    same = {None: "no table to compare it with", True: "the table of the study that nobody killed, to the bit",
            False: "**another table**"}[None if reference is None else reference == found["table"]]  # fmt: skip
    text = (
        "## Killed\n\n"
        f"The same study with two workers, killed {KILLS} times with SIGKILL, at numbers of kept runs, delays and "
        "victims drawn by a seed; a killed parent is followed by the same command. Workers of a dead parent end by "
        f"themselves. The outcome: {same}; {found['left']} unfinished files are left among the kept runs.\n\n"
        + table(["kill", "who", "runs kept by then", "its workers gone after"], rows)
    )
    rows = []
    for number, way in enumerate(WAYS[1:]):
        one = made.get(f"poisoned_{number}")
        if one is not None:
            others, again = f"{one['others_equal']} of {one['others']}", "yes" if one["again_equal"] else "no"
            rows.append([way, one["status"], one["error"], others, again])
    if rows:
        text += (
            f"\nA study of 20 points of which point {POISONED} kills its process each time ends with everything else, "
            "exit code 3, and a row that says so:\n\n"
            + table(["who runs", "status", "error", "other rows as without it", "whole once the cause is gone"], rows)
        )
    queue = made.get("jobqueue")
    if queue is not None and queue["version"]:
        ended = "gave the table of one worker to the bit" if queue["equal"] else "**failed**"
        text += (
            "\nThe recipe for clusters, with the class of dask-jobqueue "
            f"{queue['version']} that starts jobs on the same machine (`LocalCluster`, two jobs of one core): "
            f"{ended}. No queue of SLURM, PBS or LSF was tried.\n"
        )
    return text
