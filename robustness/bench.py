"""Random configurations, one after another: which run, which are refused, and is what they say true?

    python robustness/bench.py                    all configurations of plan.toml, and the page
    python robustness/bench.py --quick            one in seven, on smaller grids, into another folder
    python robustness/bench.py --halving 20       these again on doubled grids and on halved steps
    python robustness/bench.py --show 17          the command that runs number 17
    python robustness/bench.py --only 17 --only 40

Every outcome is kept as it comes, so a run that was stopped goes on; what is kept is used again while the code of the
package is the same.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import plan
import report
import rules
from plan import Case
from work import LIMIT, altered, carry_out, second_opinion

from peristalsis.environment import code_version

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent


def main(words: list[str] | None = None) -> int:
    """The command; 1 if more than one run in a hundred ended badly."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one in seven, on smaller grids")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--group", action="append", help="of these groups only; may be repeated")
    parser.add_argument("--only", action="append", type=int, help="of these numbers only; may be repeated")
    parser.add_argument("--first", type=int, help="of the first so many only")
    parser.add_argument("--halving", type=int, metavar="N", help="N finished ones again on finer grids and steps")
    parser.add_argument("--show", type=int, metavar="K", help="print the command that runs number K")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds on the clock for a run (default: 300)")
    parser.add_argument("--out", type=Path, help="folder of the outcomes (default: out/robust)")
    parser.add_argument("--share", help=argparse.SUPPRESS)  # k/n: a worker's part
    given = parser.parse_args(words)
    cases = plan.read(given.quick)
    if given.show is not None:
        print(next(case.command() for case in cases if case.number == given.show))
        return 0
    chosen = [
        c for c in cases if (not given.group or c.group in given.group) and (not given.only or c.number in given.only)
    ]
    chosen = chosen[: given.first]
    out = given.out or ROOT / "out" / ("robust-quick" if given.quick else "robust")
    out.mkdir(parents=True, exist_ok=True)
    if given.share:
        _work(chosen, out, given)
        return 0
    _all_workers(out, given, words if words is not None else sys.argv[1:])
    rows = list(kept(out).values())
    numbers = {case.number for case in chosen}
    rows = sorted((row for row in rows if row["number"] in numbers), key=lambda row: row["number"])
    halved = list(kept(out, "halving").values())
    text = report.page(rows, halved, {case.number: case for case in cases}, given.quick)
    whole = not (given.quick or given.group or given.only or given.first)
    if whole:
        before = report.read_table(HERE / "last.csv")
        text += report.regression(rows, before)
        (ROOT / "docs" / "evidence" / "robust.md").write_text(text, encoding="utf-8")
        report.write_table(HERE / "last.csv", rows)
    print(text)
    bad = sum(1 for row in rows if rules.faults(row))
    return 1 if bad > 0.01 * max(len(rows), 1) else 0


def kept(out: Path, kind: str = "run") -> dict[str, dict[str, Any]]:
    """Outcomes of this code by key; the last of each. A run that was begun and has no outcome crashed its process."""
    found: dict[str, dict[str, Any]] = {}
    for file in sorted(out.glob(f"{kind}-*.jsonl")):
        for line in file.read_text("utf-8").splitlines():
            try:
                row = json.loads(line)
            except ValueError:  # cut short by a kill
                continue
            if row.get("code") == code_version():
                found[row["key"]] = row
    return {key: row for key, row in found.items() if "outcome" in row or row.get("begun", 0) >= 2}


def _work(cases: list[Case], out: Path, given: argparse.Namespace) -> None:
    """One worker's part, one line an outcome; a case whose process died twice is a row that says so."""
    part, parts = (int(word) for word in given.share.split("/"))
    kind = "halving" if given.halving else "run"
    jobs = halving_jobs(cases, out, given.halving) if given.halving else [(key_of(case), case) for case in cases]
    done = kept(out, kind)
    file = out / f"{kind}-{part}of{parts}.jsonl"
    begun = _begun(file)
    for number, (key, case) in enumerate(jobs):
        if number % parts != part or key in done:
            continue
        about = {"key": key, "code": code_version()}
        if begun.get(key, 0) >= 2:
            row = {
                "number": case.number,
                "group": case.group,
                "outcome": "crashed",
                "sentence": "its process died twice",
            }
            _append(file, about | row)
            continue
        _append(file, about | {"begun": begun.get(key, 0) + 1})
        row = carry_out(case, given.limit)
        if row["outcome"] in rules.BROKEN and not given.halving:
            row["second_opinion"] = second_opinion(case, row)
        _append(file, about | row)


def key_of(case: Case) -> str:
    """What tells a job from another."""
    return json.dumps([case.number, case.scenario, case.reading, dict(case.changes)], sort_keys=True)


def _begun(file: Path) -> dict[str, int]:
    counts: dict[str, int] = {}
    if file.exists():
        for line in file.read_text("utf-8").splitlines():
            try:
                row = json.loads(line)
            except ValueError:
                continue
            if "begun" in row and row.get("code") == code_version():
                counts[row["key"]] = max(counts.get(row["key"], 0), row["begun"])
    return counts


def _append(file: Path, row: dict[str, Any]) -> None:
    with file.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(row, default=str) + "\n")


def halving_jobs(cases: Iterable[Case], out: Path, count: int) -> list[tuple[str, Case]]:
    """Doubled grids and halved steps of `count` finished cases, spread over the groups by their order."""
    rows = {row["number"]: row for row in kept(out).values()}
    usable = [
        c for c in cases if c.group not in ("surface", "numbers") and rules.answer(rows.get(c.number, {})) is not None
    ]
    spread = usable[:: max(1, len(usable) // count)][:count]
    jobs = []
    for case in spread:
        for what, factor in (("grid", 2.0), ("step", 0.5)):
            finer = altered(case, what, factor)
            jobs.append((f"{what} {key_of(case)}", finer))
    return jobs


def _all_workers(out: Path, given: argparse.Namespace, words: list[str]) -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, str(Path(__file__).resolve()), *words]
    staff = {
        k: subprocess.Popen([*command, "--share", f"{k}/{given.workers}"], env=environment)
        for k in range(given.workers)
    }
    begin, told = time.monotonic(), 0.0
    try:
        while staff:
            time.sleep(1.0)
            for k, one in list(staff.items()):
                if one.poll() is None:
                    continue
                del staff[k]
                if one.returncode != 0:  # it died at a case, which the next one knows
                    print(f"worker {k} ended with {one.returncode}; it is started again", file=sys.stderr)
                    staff[k] = subprocess.Popen([*command, "--share", f"{k}/{given.workers}"], env=environment)
            if time.monotonic() - told > 30.0:
                told = time.monotonic()
                kind = "halving" if given.halving else "run"
                print(f"{len(kept(out, kind))} done after {told - begin:.0f} s", file=sys.stderr, flush=True)
    finally:
        for one in staff.values():
            one.terminate()


if __name__ == "__main__":
    sys.exit(main())
