"""Kill runs and batches at random moments and see what is left, what goes on, and whether anything was lost.

Writes docs/evidence/survival.md. Several minutes on one core. `--runs N --batches N` for fewer kills.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from common import save_text, table

import peristalsis as ps
from peristalsis.checkpoint import newest
from peristalsis.store import unfinished, verify

COARSE = {
    "grid.n_z": "200",
    "grid.n_z_wall": "100",
    "step.wall": "4 ms",
    "step.conduction": "0.5 ms",
    "run.duration": "6 s",
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
run.duration = "0.5 s"
run.checkpoint = "0.1 s"
output.interval = "50 ms"
[grid]
pellet.viscous_friction = ["60 mN*s/cm", "120 mN*s/cm", "230 mN*s/cm", "460 mN*s/cm", "920 mN*s/cm"]
pellet.dry_friction = ["0 mN", "5 mN", "10 mN", "20 mN", "40 mN", "80 mN", "160 mN", "320 mN"]
"""


def command(*words: str) -> list[str]:
    """A command line in this environment."""
    return [sys.executable, "-m", "peristalsis", *words]


def finish(words: list[str]) -> subprocess.CompletedProcess[str]:
    """Carry out a command to its end."""
    return subprocess.run(words, capture_output=True, text=True, check=False)


def killed(words: list[str], after: float, number: int = signal.SIGKILL) -> tuple[int, float]:
    """Exit code of a command that got a signal after some seconds, and how long it took to end then."""
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        process.send_signal(number)
    begin = time.monotonic()
    return process.wait(), time.monotonic() - begin


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
    base = ["run", "baseline", *changes, "--no-plots", "--json"]
    begin = time.monotonic()
    done = finish(command(*base, "--out", str(work / "whole")))
    lasted = time.monotonic() - begin
    reference = ps.load(work / "whole").fingerprint
    steps = json.loads(done.stdout)["steps"]
    left: Counter[str] = Counter()
    same, redone, slowest, interrupts = 0, [], 0.0, 0
    for number in range(kills):
        target = work / f"run-{number}"
        words = command(*base, "--out", str(target))
        # Every fifth by Ctrl-C instead: that one is to end in order, and soon.
        how = signal.SIGINT if number % 5 == 4 else signal.SIGKILL
        code, took = killed(words, chance.uniform(0.1, 1.05) * lasted, how)
        if how == signal.SIGINT and code == 130:
            interrupts, slowest = interrupts + 1, max(slowest, took)
        found = state_of(target)
        left[f"{found} ({'Ctrl-C' if how == signal.SIGINT else 'kill -9'})"] += 1
        heads = [one.head.step for folder in (target, *unfinished(target)) if (one := newest(folder)) is not None]
        again = finish(command(*base, "--out", str(target), "--resume"))
        if again.returncode == 0 and ps.load(target).fingerprint == reference:
            same += 1
        if heads:
            redone.append(steps - max(heads))
        shutil.rmtree(target)
        print(f"run {number + 1}/{kills}: {found}", file=sys.stderr, flush=True)
    rows = [(name, count) for name, count in sorted(left.items())]
    text = "## Single runs\n\n"
    text += f"{kills} runs of {steps} steps ({lasted:.1f} s each, with start-up), ended at random moments.\n\n"
    text += table(("left behind", "runs"), rows)
    text += f"\nResumed to the bits of the uninterrupted run: **{same} of {kills}**. "
    text += f"Runs that a checkpoint saved from beginning anew: {len(redone)}. "
    text += f"Slowest end after Ctrl-C: {slowest:.2f} s ({interrupts} of them while running).\n"
    return text, same == kills


def kill_batch(words: list[str], after: float) -> bool:
    """Kill the process of a batch alone; its workers must follow it by themselves. Whether it had ended before."""
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        process.wait(after)
        return True
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    limit = time.monotonic() + 10.0
    while time.monotonic() < limit:
        try:
            os.killpg(process.pid, 0)
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
    begin = time.monotonic()
    finish(command("batch", str(plan), "--out", str(work / "alone"), "--workers", "2"))
    lasted = time.monotonic() - begin
    reference = (work / "alone" / "table.csv").read_bytes()
    words = command("batch", str(plan), "--out", str(work / "cut"), "--workers", "2")
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


def main() -> int:
    """Kill, resume, report; the exit code is 1 if anything was lost."""
    options = argparse.ArgumentParser()
    options.add_argument("--runs", type=int, default=50)
    options.add_argument("--batches", type=int, default=20)
    given = options.parse_args()
    chance = random.Random(20)
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        about_runs, runs_well = runs(given.runs, work, chance)
        about_batches, batches_well = batches(given.batches, work, chance)
    verdict = "Nothing that was finished was lost." if runs_well and batches_well else "**Something was lost.**"
    text = f"# Survival\n\nMade by `python evidence/survival.py`. {verdict}\n\n{about_runs}\n{about_batches}"
    save_text("survival.md", text)
    return 0 if runs_well and batches_well else 1


if __name__ == "__main__":
    sys.exit(main())
