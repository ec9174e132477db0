"""Kill runs and batches at random moments, let two runs meet in one folder, and see whether anything was lost.

Writes docs/evidence/survival.md. Several minutes on one core. `--runs N --batches N --pairs N` for fewer.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from common import save_text, table

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.storing.checkpoint import newest
from peristalsis.storing.store import unfinished, verify

COARSE = {
    "grid.n_z": "200",
    "grid.n_z_wall": "100",
    "step.wall": "4 ms",
    "step.conduction": "0.5 ms",
    "run.duration": "3 s",
    "run.stop_when_expelled": "false",
    "run.checkpoint": "0.1 s",
    "output.interval": "50 ms",
}
BATCH = """
scenario = "baseline"
[changes]
grid.n_z = 100
grid.n_z_wall = 60
step.wall = "4 ms"
step.conduction = "0.5 ms"
run.duration = "0.3 s"
run.checkpoint = "0.1 s"
output.interval = "50 ms"
[grid]
pellet.viscous_friction = ["60 mN*s/cm", "120 mN*s/cm", "230 mN*s/cm", "460 mN*s/cm", "920 mN*s/cm"]
pellet.dry_friction = ["0 mN", "5 mN", "10 mN", "20 mN", "40 mN", "80 mN", "160 mN", "320 mN"]
"""


def begin(words: list[str]) -> int:
    """Start a command in a process of its own, forked from this one so that nothing is imported anew; its id."""
    process = os.fork()
    if process == 0:
        os.setsid()
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        os._exit(main(words))
    return process


def ended(process: int, within: float) -> int | None:
    """Exit code of a process (minus the signal that ended it), None if it goes on for longer."""
    limit = time.monotonic() + within
    while time.monotonic() < limit:
        found, status = os.waitpid(process, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    return None


def finish(words: list[str]) -> int:
    """Carry out a command to its end; its exit code."""
    return os.waitstatus_to_exitcode(os.waitpid(begin(words), 0)[1])


def killed(words: list[str], after: float, number: int = signal.SIGKILL) -> tuple[int, float]:
    """Exit code of a command that got a signal after some seconds, and how long it took to end then."""
    process = begin(words)
    code = ended(process, after)
    if code is not None:
        return code, 0.0
    os.kill(process, number)
    start = time.monotonic()
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), time.monotonic() - start


def state_of(target: Path) -> str:
    """What a killed run left."""
    if target.exists():
        verify(target)
        return "a whole result"
    checkpoints = [found for folder in unfinished(target) if (found := newest(folder)) is not None]
    if checkpoints:
        return "checkpoints"
    return "a hidden folder without checkpoint" if unfinished(target) else "nothing"


def runs(kills: int, work: Path, chance: random.Random) -> tuple[str, bool]:
    """Kill single runs, resume each, compare with the run that was let alone."""
    changes = [word for key, value in COARSE.items() for word in ("--set", f"{key}={value}")]
    base = ["run", "baseline", *changes, "--no-plots"]
    ps.run("baseline", COARSE)  # compiles and imports once, for all the processes to come
    start = time.monotonic()
    finish([*base, "--out", str(work / "whole")])
    lasted = time.monotonic() - start
    whole = ps.load(work / "whole")
    reference, steps = whole.fingerprint, whole.summary["steps"]
    left: Counter[str] = Counter()
    same, redone, slowest, interrupts = 0, [], 0.0, 0
    for number in range(kills):
        target = work / f"run-{number}"
        words = [*base, "--out", str(target)]
        # Every fifth by Ctrl-C instead: that one is to end in order, and soon.
        how = signal.SIGINT if number % 5 == 4 else signal.SIGKILL
        code, took = killed(words, chance.uniform(0.02, 1.02) * lasted, how)
        if how == signal.SIGINT and code == 130:
            interrupts, slowest = interrupts + 1, max(slowest, took)
        found = state_of(target)
        left[f"{found} ({'Ctrl-C' if how == signal.SIGINT else 'kill -9'})"] += 1
        heads = [one.head.step for folder in (target, *unfinished(target)) if (one := newest(folder)) is not None]
        if finish([*words, "--resume"]) == 0 and ps.load(target).fingerprint == reference:
            same += 1
        if heads:
            redone.append(steps - max(heads))
        shutil.rmtree(target)
        print(f"run {number + 1}/{kills}: {found}", file=sys.stderr, flush=True)
    rows = [(name, count) for name, count in sorted(left.items())]
    text = "## Single runs\n\n"
    text += f"{kills} runs of {steps} steps ({lasted:.1f} s each), ended at random moments.\n\n"
    text += table(("left behind", "runs"), rows)
    text += f"\nResumed to the bits of the uninterrupted run: **{same} of {kills}**. "
    text += f"Runs that a checkpoint saved from beginning anew: {len(redone)}. "
    text += f"Slowest end after Ctrl-C: {slowest:.2f} s ({interrupts} of them while running).\n"
    return text, same == kills


def kill_batch(words: list[str], after: float) -> bool:
    """Kill the process of a batch alone; its workers must follow it by themselves. Whether it had ended before."""
    process = begin(words)
    if ended(process, after) is not None:
        return True
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    limit = time.monotonic() + 30.0
    while time.monotonic() < limit:
        try:
            os.killpg(process, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.05)
    raise RuntimeError("a worker outlived the batch that started it")


def whole_runs(folder: Path) -> dict[str, str]:
    """Name and hash of the manifest of every finished run."""
    runs = folder / "runs"
    if not runs.exists():
        return {}
    names = sorted(path.name for path in runs.iterdir() if not path.name.startswith("."))
    return {name: verify(runs / name).about["fingerprint"] for name in names}


def batches(kills: int, work: Path, chance: random.Random) -> tuple[str, bool]:
    """Kill one batch of 40 runs again and again, until it is done; then compare with one that was let alone."""
    plan = work / "forty.toml"
    plan.write_text(BATCH, encoding="utf-8")
    start = time.monotonic()
    finish(["batch", str(plan), "--out", str(work / "alone"), "--workers", "2"])
    lasted = time.monotonic() - start
    reference = (work / "alone" / "table.csv").read_bytes()
    words = ["batch", str(plan), "--out", str(work / "cut"), "--workers", "2"]
    kept: dict[str, str] = {}
    counts, lost = [], 0
    for number in range(kills):
        kill_batch(words, chance.uniform(0.05, 0.3) * lasted)
        now = whole_runs(work / "cut")
        lost += sum(now.get(name) != fingerprint for name, fingerprint in kept.items())
        kept = now
        counts.append(len(now))
        print(f"batch {number + 1}/{kills}: {len(now)} of 40 finished", file=sys.stderr, flush=True)
        if len(now) == 40:  # done before its time: begin another, so that all kills find work
            shutil.rmtree(work / "cut")
            kept = {}
    finish(words)
    same = (work / "cut" / "table.csv").read_bytes() == reference
    leftovers = sum(path.name.startswith(".") for path in (work / "cut" / "runs").iterdir())
    text = "## A batch\n\n"
    text += (
        f"40 runs in two processes ({lasted:.0f} s when let alone); the process that started them was killed {kills} "
    )
    text += "times at random moments, its workers ended with it each time, and the same command was given again.\n\n"
    text += table(
        ("", ""),
        [
            ("finished runs after each kill", ", ".join(map(str, counts))),
            ("finished runs lost or changed", lost),
            ("table equal to that of the batch let alone, byte by byte", "yes" if same else "no"),
            ("hidden folders left at the end", leftovers),
        ],
    )
    return text, same and lost == 0


def pairs(count: int, work: Path) -> tuple[str, bool]:
    """Two runs of different length into one folder at the same moment, again and again: one is refused, none lost."""
    coarse = {key: value for key, value in COARSE.items() if key != "run.duration"}
    changes = [word for key, value in coarse.items() for word in ("--set", f"{key}={value}")]
    seen: Counter[str] = Counter()
    well = True
    for number in range(count):
        target = work / f"pair-{number}"
        words = ["run", "baseline", *changes, "--no-plots", "--out", str(target)]
        kinds = ([], ["--overwrite"])[number % 2 == 1]
        begun = [begin([*words, *kinds, "--set", f"run.duration={one} s"]) for one in ("0.3", "0.6")]
        codes = [os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) for process in begun]
        asked = {one for one, code in zip((0.3, 0.6), codes, strict=True) if code == 0}
        stands = ps.load(target).configuration.run.duration
        left = [path for path in work.iterdir() if path.name != target.name and target.name in path.name]
        # Who was told that all is well finds the result, unless all had agreed to overwrite.
        right = stands in asked and not left and (kinds != [] or (sorted(codes) == [0, 4] and asked == {stands}))
        well = well and right
        seen[f"exit codes {codes[0]} and {codes[1]}{', both overwriting' if kinds else ''}"] += 1
        shutil.rmtree(target)
        print(f"pair {number + 1}/{count}: {codes}, {stands} s stands", file=sys.stderr, flush=True)
    text = "## Two processes, one folder\n\n"
    text += f"{count} times, two runs of different length were begun at once in one folder.\n\n"
    text += table(("how they ended", "times"), sorted(seen.items()))
    answer = "yes" if well else "no"
    text += f"\nEvery result that was said to be written stands, or was overwritten as asked: **{answer}**.\n"
    return text, well


def trial() -> int:
    """Kill, resume, report; the exit code is 1 if anything was lost."""
    options = argparse.ArgumentParser()
    options.add_argument("--runs", type=int, default=50)
    options.add_argument("--batches", type=int, default=20)
    options.add_argument("--pairs", type=int, default=50)
    given = options.parse_args()
    chance = random.Random(20)
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        about_runs, runs_well = runs(given.runs, work, chance)
        about_batches, batches_well = batches(given.batches, work, chance)
        about_pairs, pairs_well = pairs(given.pairs, work)
    verdict = (
        "Nothing that was finished was lost."
        if runs_well and batches_well and pairs_well
        else "**Something was lost.**"
    )
    load = f"Load of the machine towards the end: {os.getloadavg()[2]:.0f} on {os.cpu_count()} cores."
    pages = "\n".join((about_runs, about_batches, about_pairs))
    text = f"# Survival\n\nMade by `python evidence/survival.py`. {verdict} {load}\n\n{pages}"
    save_text("survival.md", text)
    return 0 if runs_well and batches_well and pairs_well else 1


if __name__ == "__main__":
    sys.exit(trial())
