"""How often a fit's interval holds the truth, and what one track cannot tell apart: docs/evidence/fits.md, fits.png.

Twenty tracks are made by the model itself at one viscous friction and one conductance of the fast calcium channel, seen
at 20 Hz with noise of 0.3 mm, and both are fitted to each, from 185 and 3.75. Tracks and fits are of one model: what it
leaves out of a real gut is in no interval here. Finished runs are kept in out/evidence_fits.
"""

from __future__ import annotations

import sys

import numpy as np
from common import FOLDER, ROOT, save_text, table

import peristalsis as ps
from peristalsis.many.fitting import Fit, fit
from peristalsis.many.rows import Step
from peristalsis.maps.recording import Track

OUT = ROOT / "out" / "evidence_fits"
GRID = {"grid.n_z": 300, "grid.n_z_wall": 200, "run.duration": "2.6 s"}
"""Coarser than shipped, with its steps: tracks and fits share the grid, and longer steps make tracks jump."""
FRICTION, DRY = "pellet.viscous_friction", "pellet.dry_friction"
CONDUCTANCE = "longitudinal.fast_calcium+circular.fast_calcium"
TRUTH = {FRICTION: 170.0, CONDUCTANCE: 3.6}
TRACKS, NOISE, RATE = 20, 0.3, 20.0
"""Noise in mm, rate in Hz."""


def at(values: dict[str, float]) -> dict[str, object]:
    """Both parameters as changes of the configuration."""
    layers = dict.fromkeys(CONDUCTANCE.split("+"), f"{values[CONDUCTANCE]} mS/cm^2")
    return {**GRID, FRICTION: f"{values[FRICTION]} mN*s/cm", **layers}


def tracks() -> list[Track]:
    """The tracks: one truth, and noise of its own each."""
    truth = ps.run("baseline", at(TRUTH))
    last = float(truth.summary["transit_s"])
    times = np.arange(0.3, last, 1.0 / RATE)
    place = 10.0 * np.interp(times, truth.arrays["time_step"], truth.arrays["pellet_position"])
    chance = np.random.default_rng(2026)
    return [Track(times, place + chance.normal(0.0, NOISE, times.size), f"track {n + 1}") for n in range(TRACKS)]


DRY_BOUNDS = ("0 mN", "200 mN")
BEGIN = {FRICTION: 185.0, CONDUCTANCE: 3.75}


def say(step: Step) -> None:
    """Progress on stderr."""
    if not step.kept:
        print(step.row.point.name.partition(" | ")[0], step.row.status, file=sys.stderr, flush=True)


def main() -> None:
    """Fit all tracks, draw two profiles, write the page."""
    base, observed = ps.configuration("baseline", changes=at(BEGIN)), tracks()
    found = []
    for one in observed:
        found.append(fit([one], list(TRUTH), scenario=base, profiles=False, out=OUT, progress=say))
        print(one.name, found[-1].numbers()["parameters"], found[-1].remarks(), file=sys.stderr, flush=True)
    rows: list[list[object]] = []
    for one in found:
        row: list[object] = [one.problem.observed[0].name, one.status]
        for estimate in one.estimates:
            low, high = estimate.interval or (np.nan, np.nan)
            held = low <= TRUTH[estimate.free.name] <= high
            row += [f"{estimate.value:.4g}", f"{low:.4g} to {high:.4g}", "yes" if held else "no"]
        assert one.correlation is not None
        rows.append([*row, f"{one.correlation[0, 1]:.2f}", f"{10.0 * one.noise:.3f} mm", one.problem.runs])
    held = [sum(row[k] == "yes" for row in rows) for k in (4, 7)]
    held_truth = base.with_changes(at({**TRUTH, FRICTION: BEGIN[FRICTION]}))
    pair = fit([observed[0]], [FRICTION, DRY], scenario=held_truth, out=OUT, progress=say, bounds={DRY: DRY_BOUNDS})
    pair.figure().savefig(FOLDER / "fits.png")
    head = ["track", "status", "friction, mN*s/cm", "95 %", "holds 170", "fast calcium, mS/cm^2", "95 %", "holds 3.6"]
    head += ["correlation", "noise found", "new runs"]
    save_text(
        "fits.md",
        "# Fits of tracks that the model made itself\n\n"
        f"Written by `python evidence/fits.py`. {TRACKS} tracks, each with noise of {NOISE} mm at {RATE:g} Hz; truth: "
        f"viscous friction\n170 mN*s/cm and 3.6 mS/cm^2 of fast calcium in both layers; starts: 185 and 3.75.\nOn "
        f"{GRID['grid.n_z']} cells and {GRID['grid.n_z_wall']} wall elements.\n\n"
        f"The 95 % interval holds the friction in {held[0]} and the conductance in {held[1]} of {TRACKS} tracks.\n\n"
        + table(head, rows)
        + "\n## What one track cannot tell apart\n\n"
        "Viscous and dry friction, both free, on the first track, with the true conductance held:\n\n"
        + described(pair)
        + "\n![profiles of both frictions](fits.png)\n",
    )


def described(found: Fit) -> str:
    """Estimates and remarks of a fit."""

    def ends(pair: tuple[float | None, float | None] | None) -> str:
        return "–" if pair is None else " to ".join("no limit" if one is None else f"{one:.4g}" for one in pair)

    rows = [[one.free.name, one.free.text(one.value), ends(one.interval), ends(one.profile)] for one in found.estimates]
    remarks = "".join(f"- {remark}\n" for remark in found.remarks())
    return table(["parameter", "value", "95 % by curvature", "95 % by profile"], rows) + f"\n{remarks}"


if __name__ == "__main__":
    main()
