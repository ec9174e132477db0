"""Run the bench: `python -m robustness`, or `make robust`; it goes on where it was stopped."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from verification.prose import wrapped

from .plan import COUNT, QUICK_COUNT, SEED, Case, cases, groups

PAGE = Path(__file__).resolve().parents[1] / "docs" / "evidence" / "robust.md"

START = "20 ms"
"""Duration of a case of which the start alone is asked."""


def main(arguments: list[str] | None = None) -> int:
    """Run what is missing, write the page; 1 if any row is bad."""
    asked = _parser().parse_args(arguments)
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    count = asked.count or (QUICK_COUNT if asked.quick else COUNT)
    wanted = tuple(asked.groups.split(",")) if asked.groups else ()
    unknown = sorted(set(wanted) - set(groups()))
    if unknown:
        print(f"--groups {','.join(unknown)}: no such group; choose from {', '.join(groups())}", file=sys.stderr)
        return 2
    plan = [case for case in cases(count, asked.seed, asked.quick, wanted) if case.index >= asked.begin]
    if asked.starts:
        plan = [case.varied("start", {"run.duration": START}) for case in plan]
    if asked.show is not None:
        return _show(asked.show, cases(max(count, asked.show + 1), asked.seed, asked.quick))
    if asked.list:
        for case in plan:
            print(case.index, case.group, case.scenario, case.reading, dict(case.changes))
        return 0
    return _run(asked, plan)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m robustness", description="Random configurations, run and judged.")
    parser.add_argument("--count", type=int, help=f"cases; {COUNT}, or {QUICK_COUNT} with --quick")
    parser.add_argument(
        "--quick", action="store_true", help="few cases on coarse grids, for every day; writes no table"
    )
    parser.add_argument("--starts", action="store_true", help=f"only the starts: {START} of every case")
    parser.add_argument("--groups", help="only these, such as wall,lumen")
    parser.add_argument("--begin", type=int, default=0, metavar="INDEX", help="leave out the cases before this one")
    parser.add_argument("--seed", type=int, default=SEED, help="another plan")
    parser.add_argument("--workers", type=int, default=1, help="processes at a time")
    parser.add_argument("--limit", type=float, default=300.0, help="processor seconds of a run")
    parser.add_argument("--minutes", type=float, help="begin no new case after this time on the clock")
    parser.add_argument("--halving", type=int, default=0, metavar="N", help="N cases again on finer grids and steps")
    parser.add_argument("--no-opinions", action="store_true", help="do not try other ways where a run was refused")
    parser.add_argument("--anew", action="store_true", help="run again what is there")
    parser.add_argument("--any-code", action="store_true", help="count rows of other versions of the package as there")
    parser.add_argument("--keep", action="store_true", help="make this the last table (robustness/last.csv)")
    parser.add_argument("--page", type=Path, help="where the page is written; docs/evidence/robust.md with --keep")
    parser.add_argument("--show", type=int, metavar="INDEX", help="print a case as a file and as a command line")
    parser.add_argument("--list", action="store_true", help="print the plan")
    return parser


def _show(index: int, plan: list[Case]) -> int:
    from peristalsis import PeristalsisError

    from .report import command, toml

    case = plan[index]
    print(f"# case {index}, group {case.group}\n# {command(case)}\n")
    try:
        print(toml(case))
    except PeristalsisError as error:
        print(f"# refused by its configuration: {error}")
    return 0


def _run(asked: argparse.Namespace, plan: list[Case]) -> int:
    from . import halving
    from .log import changes, code_digest, kept, read_last, write_last
    from .report import page
    from .rules import complaints

    code = code_digest()
    there = {} if asked.anew else kept(None if asked.any_code else code)
    begin = time.monotonic()
    _carry(asked, [case for case in plan if case.key() not in there], code, there, begin)

    def row_of(case: Case) -> dict[str, object] | None:
        return there.get(case.key())

    study = halving.chosen_cases(plan, row_of, asked.halving)
    finer = [other for case in study for other in halving.finer(case) if other.key() not in there]
    _carry(asked, finer, code, there, begin)
    # Cases of the same key keep the index of this plan.
    rows = [{**there[case.key()], "index": case.index} for case in plan if case.key() in there]
    last = read_last()
    changed = changes(rows, last) if last else None
    text = page(rows, len(plan), changed, halving.table(study, row_of) if study else "")
    target = asked.page or (PAGE if asked.keep else Path("out", "robustness", "robust.md"))
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(wrapped(text), encoding="utf-8")
    if asked.keep:
        write_last(rows)
    bad = sum(1 for row in rows if complaints(row))
    print(f"{len(rows)} of {len(plan)} cases, {bad} with complaints, {len(changed or [])} changed: {target}")
    return 1 if bad or len(rows) < len(plan) else 0


def _carry(
    asked: argparse.Namespace, missing: list[Case], code: str, there: dict[str, dict[str, object]], begin: float
) -> None:
    from .log import append
    from .pool import rows
    from .rules import complaints, kind_of

    def late() -> bool:
        return asked.minutes is not None and time.monotonic() - begin > 60.0 * asked.minutes

    found = rows(missing, asked.workers, asked.limit, not asked.no_opinions, late)
    for done, row in enumerate(found, start=1):
        append(row, code)
        there[str(row["key"])] = row
        words = "; ".join(complaints(row)) or "-"
        head = f"[{done}/{len(missing)}, {time.monotonic() - begin:.0f} s] {row['index']} {row['group']}"
        print(
            f"{head} {row['variant']} {kind_of(row)} {row.get('cpu_s', 0.0):.1f} s: {words}",
            file=sys.stderr,
            flush=True,
        )


if __name__ == "__main__":
    sys.exit(main())
