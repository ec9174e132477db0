"""Small errors put into the kernels one at a time: how many does the suite notice?

`python evidence/mutants.py [--count 215] [--workers 2] [--only FILE ...]` writes docs/evidence/mutants.md, .csv.
A mutant is killed when a test of its file's group fails; golden files take no part. The choice is made with a fixed
seed, in proportion to what there is to change in each file. `make mutants` runs it; under two hours on two cores.
Killed ones are kept in out/mutants.jsonl: what was killed in the same file under the same tests is not tried again,
unless `--afresh` is given.
"""

from __future__ import annotations

import argparse
import ast
import atexit
import csv
import functools
import hashlib
import json
import multiprocessing
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from common import FOLDER, save_text, table

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "out" / "mutants.jsonl"
SEED = 20260101
LIMIT = 180.0
"""A mutant whose tests take longer than this on the processor [s] hangs, and counts as noticed."""

UNIT, VERIFICATION = "tests/unit/test_{}.py", "tests/verification/test_{}.py"


def group(units: Sequence[str], problems: Sequence[str] = ()) -> tuple[str, ...]:
    """Test files, quick ones first."""
    return (*(UNIT.format(name) for name in units), *(VERIFICATION.format(name) for name in problems))


WALL = ("wall_problems", "contact_problems", "coupled")
GROUPS: dict[str, tuple[str, ...]] = {
    "wall/passive.py": group(["passive", "membrane"], ["wall_problems"]),
    "wall/active.py": group(["active", "membrane"], ["wall_problems"]),
    "wall/membrane.py": group(["membrane", "recorded_tension"], WALL),
    "pellet/shapes/sphere.py": group(["shapes", "contact"], ["contact_problems"]),
    "pellet/contact.py": group(["contact"], ["contact_problems"]),
    "pellet/friction.py": (*group(["friction"]), "tests/properties"),
    "wall/assembly.py": group(["membrane", "tube"], WALL),
    "numerics/block_band.py": group(["block_band", "equilibrium"]),
    "numerics/exponential.py": group(["block_band"]),
    "numerics/roots.py": group(["roots"]),
    "numerics/blend.py": group(["blend", "membrane"], ["wall_problems"]),
    "numerics/rates.py": group(["rates"], ["wall_problems"]),
    "numerics/stabilised.py": group([], ["cable_problems"]),
    "numerics/transfer.py": group(["transfer", "grid"]),
    "geometry/tube.py": group(["tube", "membrane"], ["contact_problems"]),
    "tissue/conduction.py": group(["conduction"], ["cable_problems"]),
    "tissue/sheet.py": group(["sheet"], ["cable_problems", "cell_problems"]),
    "tissue/cells/plant.py": group(["plant", "rest"], ["cell_problems"]),
    "tissue/rest.py": group(["rest"]),
    "tissue/surface.py": group(["surface_conduction"], ["bidomain_problems"]),
    "tissue/bidomain.py": group(["bidomain"], ["bidomain_problems"]),
    "numerics/cylinder.py": group(["bidomain"], ["bidomain_problems"]),
    "control/pulses.py": group(["pulses"]),
    "control/sequence.py": group(["sequence"]),
    "control/reflex.py": group(["reflex"]),
    "model/equilibrium.py": group(["equilibrium"], WALL),
    "model/residual.py": group(["equilibrium"], WALL),
    "model/linearised.py": group(["equilibrium"], WALL),
    "model/settling.py": group(["equilibrium"], WALL),
    "model/line_search.py": group(["equilibrium"], WALL),
    "model/balance.py": group(["balance"], ["coupled"]),
    "model/friction.py": group(["friction"], ["problems"]),
    "wall/surface.py": group(["surface_wall"], ["surface_problems"]),
    "wall/surface_regularisers.py": group(["surface_wall"], ["surface_problems"]),
    "pellet/surface_contact.py": group(["surface_wall"], ["surface_problems"]),
    "model/bookkeeping.py": group(["balance", "fields"], ["wall_problems", "contact_problems", "coupled"]),
    "model/exchange.py": group(["step", "regions"], ["coupled"]),
    "model/fields.py": group(["fields"], ["wall_problems", "contact_problems"]),
}

COUNTS = ("tests/unit/test_cost.py",)
NEWTON = ("tests/unit/test_newton.py", *COUNTS)
DETAILS = ("tests/unit/test_surface_details.py",)
PROBLEMS = ("tests/verification/test_problems.py",)
NUMBERS = ("tests/unit/test_step_numbers.py",)
SLOWER = {
    "numerics/stabilised.py": PROBLEMS,
    "tissue/sheet.py": (*COUNTS, *PROBLEMS),
    "control/sequence.py": ("tests/unit/test_step.py", *PROBLEMS),
    "wall/surface.py": DETAILS,
    "pellet/surface_contact.py": DETAILS,
    "model/equilibrium.py": NEWTON,
    "model/residual.py": NEWTON,
    "model/linearised.py": NEWTON,
    "model/settling.py": NEWTON,
    "model/line_search.py": NEWTON,
    "wall/assembly.py": COUNTS,
    "numerics/block_band.py": COUNTS,
    "model/fields.py": ("tests/unit/test_stretched_fields.py",),
    "model/balance.py": NUMBERS,
    "model/bookkeeping.py": NUMBERS,
}
"""Tests asked last, which kept verdicts do not depend on. Among them those of how many iterations a step takes: a wrong
tangent finds the same answer, later."""

SWAPPED = {"hoop": "stretch", "stretch": "hoop", "rate_l": "0.0", "longitudinal": "circumferential"}
"""Names that stand for one another in a plausible slip."""


@dataclass(frozen=True)
class Mutant:
    """One change: file, place, what kind, and the text of the changed line before and after."""

    file: str
    line: int
    kind: str
    start: int
    stop: int
    new: str
    before: str
    after: str


def candidates(file: str) -> Iterator[Mutant]:
    """Every change that the operators below can make in a file."""
    text = (ROOT / "src" / "peristalsis" / file).read_text(encoding="utf-8")
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line.encode("utf-8")))
    source = text.encode("utf-8")

    def place(line: int, column: int) -> int:
        return starts[line - 1] + column

    def made(kind: str, start: int, stop: int, new: str, line: int) -> Mutant:
        low, high = starts[line - 1], starts[line]
        changed = source[low:start] + new.encode() + source[stop:high]
        return Mutant(file, line, kind, start, stop, new, source[low:high].decode().strip(), changed.decode().strip())

    tree = ast.parse(text)
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for statement in function.body:
            for node in ast.walk(statement):
                yield from _changes(node, source, place, made)


def _changes(node, source, place, made) -> Iterator[Mutant]:  # type: ignore[no-untyped-def]
    if isinstance(node, ast.BinOp | ast.AugAssign):
        left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.target, node.value)
        if left.end_lineno != right.lineno:
            return
        start, stop = place(left.end_lineno, left.end_col_offset), place(right.lineno, right.col_offset)
        between = source[start:stop].decode()
        for old, new, kind in (("+", "-", "sign"), ("-", "+", "sign"), ("/", "*", "ratio"), ("*", "/", "ratio")):
            if between.count(old) == 1 and "**" not in between and "//" not in between:
                at = start + between.index(old)
                yield made(kind, at, at + 1, new, node.lineno)
                break
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        start = place(node.lineno, node.col_offset)
        yield made("sign", start, start + 1, "", node.lineno)
    elif isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value not in (0.0,):
        start, stop = place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)
        yield made("factor", start, stop, repr(2.0 * node.value), node.lineno)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and isinstance(node.ops[0], ast.Lt | ast.Gt):
        start = place(node.left.end_lineno, node.left.end_col_offset)
        stop = place(node.comparators[0].lineno, node.comparators[0].col_offset)
        between = source[start:stop].decode()
        new = between.replace("<", ">") if "<" in between else between.replace(">", "<")
        yield made("order", start, stop, new, node.lineno)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in SWAPPED:
        start, stop = place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)
        yield made("swap", start, stop, SWAPPED[node.id], node.lineno)


def chosen(count: int, only: Sequence[str]) -> list[Mutant]:
    """The mutants of a run: of each file the first ones of an order drawn for it, in proportion to its size."""
    every = {file: sorted(set(candidates(file)), key=lambda one: (one.start, one.kind)) for file in GROUPS}
    total = sum(len(found) for found in every.values())
    picked: list[Mutant] = []
    for file, found in every.items():
        share = max(3, round(count * len(found) / total))
        random.Random(f"{SEED} {file}").shuffle(found)
        if not only or file in only:
            picked += found[:share]
    return picked


def spared() -> list[str]:
    """Files with compiled kernels that are in no group."""
    package = ROOT / "src" / "peristalsis"
    every = (file for file in sorted(package.rglob("*.py")) if "\n@compiled" in file.read_text(encoding="utf-8"))
    return [name for name in (file.relative_to(package).as_posix() for file in every) if name not in GROUPS]


def key(mutant: Mutant) -> str:
    """What a kept verdict stands for: the change, the file it is made in and the tests that judge it."""
    parts = [repr(mutant).encode(), (ROOT / "src" / "peristalsis" / mutant.file).read_bytes()]
    for tests in GROUPS[mutant.file]:
        place = ROOT / tests
        parts += [file.read_bytes() for file in ([place] if place.is_file() else sorted(place.glob("test_*.py")))]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def kept(digest: str) -> tuple[str, str, float]:
    """The kept verdict, or that there is none; one that was killed once is killed."""
    found = ("not tried", "", 0.0)
    for line in KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []:
        known = json.loads(line)
        if known["key"] == digest and found[0] != "killed":
            found = known["verdict"], known["by"], known["seconds"]
    return found


def verdict_on(mutant: Mutant, only_kept: bool) -> tuple[str, str, float]:
    """The kept verdict if it is killed, or if only those are asked for; else a new one, which is kept."""
    digest = key(mutant)
    found = kept(digest)
    if only_kept or found[0] == "killed":
        return found
    verdict, by, seconds = judged(mutant)
    KEPT.parent.mkdir(exist_ok=True)
    with KEPT.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps({"key": digest, "verdict": verdict, "by": by, "seconds": seconds}) + "\n")
    return verdict, by, seconds


TREE: Path | None = None
"""The copy of sources and tests that a process works in; its cache of kernels serves all its mutants."""


def worker_tree() -> Path:
    """The copy of this process, made at first need."""
    global TREE
    if TREE is None:
        TREE = Path(tempfile.mkdtemp(prefix="mutants-"))
        atexit.register(shutil.rmtree, TREE, ignore_errors=True)
        for name in ("src", "tests", "verification", "benchmarks"):
            shutil.copytree(ROOT / name, TREE / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", TREE / "pyproject.toml")
    return TREE


def judged(mutant: Mutant) -> tuple[str, str, float]:
    """(verdict, what noticed it, seconds) of one mutant."""
    tree = worker_tree()
    file = tree / "src" / "peristalsis" / mutant.file
    source, times = file.read_bytes(), file.stat()
    file.write_bytes(source[: mutant.start] + mutant.new.encode() + source[mutant.stop :])
    try:
        return noticed(mutant, tree)
    finally:  # with its old time, by which numba knows the kernels that stand
        file.write_bytes(source)
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def noticed(mutant: Mutant, tree: Path) -> tuple[str, str, float]:
    """Verdict on a tree that has the mutant in it. The limit is one of the processor: other jobs do not count."""
    begin, used = time.monotonic(), children_seconds()
    environment = os.environ | {
        "PYTHONPATH": str(tree / "src"),
        "NUMBA_CACHE_DIR": str(tree / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "OMP_NUM_THREADS": "1",
        "MPLBACKEND": "Agg",
    }
    limited = f'ulimit -t {LIMIT:.0f}; exec "$@"'
    for tests in (*GROUPS[mutant.file], *SLOWER.get(mutant.file, ())):
        pytest = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", tests]
        done = subprocess.run(
            ["sh", "-c", limited, "sh", *pytest], cwd=tree, env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode not in (0, 5):
            lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
            by = lines[0].split(" - ")[0].split(" ", 1)[1] if lines else f"{tests}: does not come to an end"
            return "killed", by, time.monotonic() - begin
        if children_seconds() - used > LIMIT:
            return "killed", f"{tests}: hangs", time.monotonic() - begin
    return "survived", "", time.monotonic() - begin


def children_seconds() -> float:
    """Processor time of all ended child processes [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Judge the mutants and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=215)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=[], metavar="FILE")
    parser.add_argument("--afresh", action="store_true")
    parser.add_argument("--known", action="store_true", help="try none, write the page from what is kept")
    asked = parser.parse_args()
    if asked.afresh:
        KEPT.unlink(missing_ok=True)
    mutants = chosen(asked.count, asked.only)
    excused = json.loads((ROOT / "evidence" / "equivalent_mutants.json").read_text(encoding="utf-8"))
    rows = []
    with multiprocessing.get_context("spawn").Pool(asked.workers) as pool:
        verdicts = pool.imap(functools.partial(verdict_on, only_kept=asked.known), mutants)
        for number, (mutant, (verdict, by, seconds)) in enumerate(zip(mutants, verdicts, strict=True), start=1):
            reason = excused.get(f"{mutant.file}: {mutant.before} -> {mutant.after}", "")
            if verdict == "survived" and reason:
                verdict = "equivalent"
            rows.append((mutant.file, mutant.line, mutant.kind, mutant.before, mutant.after, verdict, by or reason))
            print(f"{number}/{len(mutants)} {verdict} {seconds:.0f} s {mutant.file}:{mutant.line}", file=sys.stderr)
    head = ("file", "line", "kind", "before", "after", "verdict", "noticed by, or why equivalent")
    with (FOLDER / "mutants.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows([head, *rows])
    kinds = sorted({row[2] for row in rows})
    counts = []
    for name in [*GROUPS, "all"]:
        mine = [row for row in rows if name in ("all", row[0]) and row[5] != "not tried"]
        if mine:
            killed = sum(row[5] == "killed" for row in mine)
            equivalent = sum(row[5] == "equivalent" for row in mine)
            share = f"{100.0 * killed / max(1, len(mine) - equivalent):.1f} %"
            by_kind = [sum(row[2] == kind for row in mine) for kind in kinds]
            counts.append((name, len(mine), killed, equivalent, len(mine) - killed - equivalent, share, *by_kind))
    text = "# Mutants\n\nMade by `python evidence/mutants.py`; every mutant is listed in mutants.csv.\n\n"
    text += table(("file", "mutants", "killed", "equivalent", "survived", "killed of the rest", *kinds), counts)
    text += f"\nKernel files that no mutant was made of: {', '.join(spared()) or 'none'}.\n"
    untried = sum(row[5] == "not tried" for row in rows)
    if untried:
        text += f"\nDrawn and not tried yet: {untried}.\n"
    left = [row for row in rows if row[5] == "survived"]
    if left:
        text += "\n## Survivors\n\n" + table(head[:5], [row[:5] for row in left])
    same = [row for row in rows if row[5] == "equivalent"]
    if same:
        text += "\n## Equivalent\n\n" + table(
            ("file", "line", "before", "after", "why"), [(*row[:2], *row[3:5], row[6]) for row in same]
        )
    save_text("mutants.md", text.replace("|", "|"))


if __name__ == "__main__":
    main()
