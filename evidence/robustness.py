"""What is promised about runs, results, bits and bad input, each with the tests that hold it: run, counted, timed.

`python evidence/robustness.py` writes docs/evidence/robustness.md. It runs the tests named below, slow ones too (about
a quarter of an hour on one core), and takes the coverage from out/coverage.json if `make coverage` has left one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

from common import save_text, table

ROOT = Path(__file__).resolve().parents[1]
COVERAGE = ROOT / "out" / "coverage.json"
KEPT = (
    "inputs/config/",
    "inputs/consistency.py",
    "storing/disk.py",
    "storing/manifest.py",
    "storing/store.py",
    "storing/packing.py",
    "storing/checkpoint.py",
    "many/plan.py",
)
"""What keeps results and what reads configurations: every branch is to be reached."""


class Promise(NamedTuple):
    """Letter and number, what is promised, how it is tried, and the tests."""

    name: str
    promised: str
    tried: str
    tests: tuple[str, ...]


UNIT, PROPERTIES = "tests/unit/test_{}.py", "tests/properties/test_{}.py"
CHECKPOINT, STORE, BATCH, GUARDS = (UNIT.format(name) for name in ("checkpoint", "store", "batch", "guards"))
HOSTILE = PROPERTIES.format("hostile_input")
CLI = UNIT.format("cli")

PROMISES = (
    Promise(
        "R1",
        "a resumed run is the uninterrupted one, bitwise",
        "stopped at random steps in three kinds of runs; at every tenth step and 40 times in one run",
        (
            f"{CHECKPOINT}::test_a_resumed_run_is_the_uninterrupted_one_to_the_bit",
            f"{CHECKPOINT}::test_exact_at_every_tenth_step_and_through_many_restarts",
        ),
    ),
    Promise(
        "R2",
        "a crash leaves the old result, the new one, or none",
        "the n-th operation on the disk fails in seven ways, for every n, alone and in runs with checkpoints; kills of "
        "the process: survival.md",
        (
            f"{STORE}::test_every_operation_may_fail",
            f"{STORE}::test_any_operation_of_a_run_may_fail_and_it_is_resumed_to_the_same_bits",
            f"{CLI}::test_a_killed_run_is_resumed_to_the_same_bits",
        ),
    ),
    Promise(
        "R3",
        "every change to a stored result is noticed",
        "1000 changed bytes, 200 lengths, exchanged and emptied files, lying manifests",
        (
            f"{STORE}::test_every_changed_byte_is_noticed",
            f"{STORE}::test_altered_files_are_refused",
            f"{STORE}::test_exchanged_numbers_of_two_runs_are_noticed",
            f"{STORE}::test_a_manifest_that_lies_about_its_content",
            f"{CHECKPOINT}::test_every_changed_byte_of_a_checkpoint_is_noticed",
        ),
    ),
    Promise(
        "R4",
        "a batch that is cut short goes on and ends with the same table",
        "interrupted and taken up again here; 20 kills of a batch of 40 runs: survival.md",
        (
            f"{BATCH}::test_an_interrupted_batch_goes_on",
            f"{BATCH}::test_what_was_cut_short_goes_on_from_its_checkpoint",
        ),
    ),
    Promise(
        "R5",
        "nothing that is not finite or cannot be is stored",
        "states spoilt in more than 60 places; runs spoilt on the way",
        (
            f"{GUARDS}::test_there_are_many_cases",
            f"{GUARDS}::test_every_spoilt_state_is_noticed",
            f"{GUARDS}::test_no_spoilt_state_is_stored",
            f"{GUARDS}::test_a_state_spoilt_from_outside_is_not_stored",
        ),
    ),
    Promise(
        "R6",
        "steps and grids that are too coarse are said beforehand",
        "both sides of every limit",
        (UNIT.format("preflight"),),
    ),
    Promise(
        "R7",
        "a bad configuration is one sentence, never a traceback",
        "10 000 files made up by hypothesis; every number of every field; no coverage-guided fuzzer",
        (
            f"{HOSTILE}::test_ten_thousand_files_are_read_or_refused_in_one_sentence",
            f"{HOSTILE}::test_every_number_of_every_field_is_taken_or_refused",
            UNIT.format("mistakes"),
        ),
    ),
    Promise(
        "R8",
        "a failing point harms no other",
        "poisoned tasks, processes that die once and always, rows of failures",
        (UNIT.format("pool"), f"{BATCH}::test_failures_are_rows"),
    ),
    Promise(
        "R9",
        "a full, read-only or failing disk costs nothing that was there",
        "full at the end, at a checkpoint, in a batch; a write that fails; a folder that cannot be written",
        (
            f"{CLI}::test_a_full_disk_leaves_the_target_as_it_was",
            f"{CLI}::test_a_full_disk_is_noticed_before_the_run",
            f"{CLI}::test_a_result_that_cannot_be_written_leaves_its_checkpoint",
            f"{CHECKPOINT}::test_a_checkpoint_that_cannot_be_written_costs_no_run",
            f"{BATCH}::test_what_cannot_be_stored_ends_a_batch",
            f"{STORE}::test_places_that_cannot_be",
        ),
    ),
    Promise(
        "R10",
        "Ctrl-C ends a run within two seconds and leaves a checkpoint",
        "50 interruptions at different moments",
        (
            f"{CLI}::test_ctrl_c_ends_soon_and_leaves_a_checkpoint",
            f"{CLI}::test_a_signal_stops_a_run_and_keeps_its_history",
        ),
    ),
    Promise(
        "D1",
        "same environment, same bits",
        "one and two workers, points in another order, runs in pieces, other output intervals",
        (
            f"{BATCH}::test_neither_workers_nor_order_change_a_bit",
            f"{UNIT.format('simulation')}::test_two_runs_give_the_same_bits",
            f"{UNIT.format('simulation')}::test_pieces_give_the_same_bits_as_one_run",
            f"{UNIT.format('simulation')}::test_output_cadence_does_not_change_the_run",
        ),
    ),
    Promise(
        "D3",
        "old results stay readable",
        "a stored fixture of every schema",
        (f"{STORE}::test_old_results_stay_readable", f"{STORE}::test_there_is_a_fixture_of_the_present_schema"),
    ),
    Promise(
        "S3",
        "no name leads out of its folder",
        "names of scenarios, readings, files and results; entries of manifests; links",
        (
            f"{HOSTILE}::test_names_are_no_paths",
            f"{STORE}::test_names_that_cannot_be",
            f"{STORE}::test_hostile_manifests_are_refused",
            f"{STORE}::test_a_link_is_neither_followed_nor_replaced",
        ),
    ),
    Promise(
        "S4",
        "no data is executed",
        "pickled objects in results and checkpoints; every source file searched",
        (
            f"{STORE}::test_pickled_objects_are_never_read",
            f"{STORE}::test_no_source_reads_code_from_data",
            f"{CHECKPOINT}::test_objects_are_never_packed_and_never_made",
        ),
    ),
    Promise(
        "S6",
        "bombs are refused within a second and 50 MiB",
        "grids, steps and batches beyond measure, deep and huge texts",
        (
            f"{HOSTILE}::test_bombs_are_refused_at_once",
            f"{HOSTILE}::test_deep_and_huge_texts_are_refused_at_once",
            f"{BATCH}::test_too_many_points_are_refused_before_they_are_made",
        ),
    ),
)


def tried(promise: Promise) -> tuple[str, str, str, str, str, str]:
    """A row: name, promise, how it is tried, tests passed of all, seconds, verdict."""
    print(promise.name, file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        command = [sys.executable, "-m", "pytest", "-q", "--tb=short", "-m", "slow or not slow", f"--junitxml={report}"]
        begin = time.monotonic()
        done = subprocess.run([*command, *promise.tests], cwd=ROOT, capture_output=True, text=True, check=False)
        seconds = time.monotonic() - begin
        suite = next(ElementTree.parse(report).iter("testsuite"))
    counts = {name: int(suite.get(name, "0")) for name in ("tests", "failures", "errors", "skipped")}
    passed = counts["tests"] - counts["failures"] - counts["errors"] - counts["skipped"]
    if done.returncode != 0:
        print(done.stdout[-3000:], file=sys.stderr)
    verdict = "holds" if done.returncode == 0 and counts["skipped"] == 0 else "**does not hold**"
    return promise.name, promise.promised, promise.tried, f"{passed} of {counts['tests']}", f"{seconds:.0f}", verdict


def covered() -> str:
    """Branch coverage, from what `make coverage` left."""
    if not COVERAGE.exists():
        return "`make coverage` was not run."
    files = json.loads(COVERAGE.read_text(encoding="utf-8"))["files"]

    def share(names: list[str]) -> str:
        sums = [files[name]["summary"] for name in names]
        reached = sum(one["covered_lines"] + one["covered_branches"] for one in sums)
        every = sum(one["num_statements"] + one["num_branches"] for one in sums)
        return f"{100.0 * reached / every:.2f} %"

    package = [name for name in files if "peristalsis/" in name]
    kept = [name for name in package if any(f"peristalsis/{one}" in name for one in KEPT)]
    rest = [name for name in package if name not in kept]
    worst = sorted(rest, key=lambda name: files[name]["summary"]["percent_covered"])[:5]
    rows = [
        ("store and configuration: " + ", ".join(KEPT), len(kept), share(kept)),
        ("the rest of the package, compiled kernels aside", len(rest), share(rest)),
        *((f"least: {name.split('peristalsis/')[-1]}", 1, share([name])) for name in worst),
    ]
    return table(("part", "files", "lines and branches reached"), rows)


def main() -> None:
    """Run everything, write the page."""
    os.environ |= {"OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    head = ("", "promised", "tried", "tests passed", "s", "verdict")
    text = (
        "# What holds when things go wrong\n\nMade by `python evidence/robustness.py`: it runs the tests of each "
        "promise and counts. Kills of whole processes are in [survival.md](survival.md); how it is done is in "
        "[reproducibility.md](../reproducibility.md).\n\n"
    )
    text += table(head, [tried(promise) for promise in PROMISES])
    text += "\n## Coverage (R11)\n\nOf the quick tests, by branches.\n\n" + covered()
    save_text("robustness.md", text)


if __name__ == "__main__":
    main()
