"""What is found in recordings with a known answer: 20 synthetic maps, round trips, a recording of two hours.

Writes docs/evidence/maps.md and the pictures docs/images/maps_*.png. About five minutes on one core; one run of the
baseline, for the pictures and round trips, is among them.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from common import ROOT, save_text, table

import peristalsis as ps
from peristalsis import maps
from peristalsis.maps import STANDING, Contraction, Map, Ring
from peristalsis.maps.drawing import comparison, manometry, map_figure
from peristalsis.maps.synthetic import example
from peristalsis.plots import style

IMAGES = ROOT / "docs" / "images"
AMPLITUDE = 4.0
UNEVEN = np.array([0.0, 8.0, 16.0, 24.0, 32.0, 45.0, 58.0, 71.0, 90.0, 110.0, 130.0, 150.0, 175.0, 200.0])
"""Places of the channels of a catheter [mm]."""
SPEED, EXTENT, BEGIN = 0.05, 8.0, 1.0
"""What may be missed: share of the speed, extent [mm], time of the begin [s]."""


def ring(begin: float, place: float, speed: float, extent: float, **more: float) -> Ring:
    """A ring of the usual depth."""
    return Ring(begin, place, speed, extent, **{"amplitude": AMPLITUDE, **more})


def without(rows: slice, columns: slice) -> Callable[[Map], Map]:
    """A map with a part of it missing."""

    def cut(recorded: Map) -> Map:
        values = np.array(recorded.values)
        values[rows, columns] = np.nan
        return recorded.done("a part is missing", values=values)

    return cut


@dataclass(frozen=True)
class Case:
    """A synthetic map: its rings, noise as a share of the amplitude, what else it has, and what is done to it."""

    name: str
    rings: tuple[Ring, ...]
    noise: float = 0.0
    drift: float = 0.0
    dropped: float = 0.0
    duration: float = 120.0
    then: Callable[[Map], Map] | None = None
    places: np.ndarray | None = None
    quantity: str = "diameter"

    def recorded(self, seed: int) -> Map:
        """The map."""
        height = max(one.amplitude for one in self.rings)
        rest = 8.0 if self.quantity == "pressure" else 12.0
        made = maps.recording(
            self.rings,
            self.duration,
            place=self.places,
            quantity=self.quantity,
            rest=rest,
            noise=self.noise * height,
            drift=self.drift * height,
            dropped=self.dropped,
            seed=seed,
        )
        return made if self.then is None else self.then(made)


TRAIN = tuple(ring(20.0 + 40.0 * k, 5.0, 2.0, 85.0) for k in range(5))
CROSSING = (ring(15.0, 5.0, 2.0, 90.0), ring(15.0, 95.0, -2.0, 90.0))
PRESSURES = tuple(replace(ring(20.0 + 45.0 * k, 4.0, 20.0, 186.0, duration=6.0), amplitude=70.0) for k in range(3))
CASES = (
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),)),
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),), 0.1),
    Case("antegrade", (ring(20.0, 5.0, 2.0, 85.0),), 0.2),
    Case("retrograde", (ring(20.0, 95.0, -2.0, 85.0),), 0.2),
    Case("fast, 30 mm/s", (ring(20.0, 5.0, 30.0, 90.0),), 0.2),
    Case("slow, 0.5 mm/s", (ring(10.0, 30.0, 0.5, 40.0),), 0.2),
    Case("every 40 s", TRAIN, 0.2, duration=260.0),
    Case("one each way, apart", (ring(15.0, 5.0, 2.0, 85.0), ring(75.0, 95.0, -3.0, 85.0)), 0.2),
    Case("crossing", CROSSING),
    Case("crossing", CROSSING, 0.1),
    Case("crossing", CROSSING, 0.2),
    Case("fading by 70 %", (ring(20.0, 5.0, 2.0, 85.0, fade=0.7),), 0.1),
    Case("fading to nothing", (ring(20.0, 5.0, 2.0, 85.0, fade=1.0),), 0.2),
    Case("standing", (ring(30.0, 20.0, STANDING, 50.0),), 0.2),
    Case("spreading both ways", (ring(20.0, 50.0, 2.0, 45.0), ring(20.0, 50.0, -2.0, 45.0)), 0.1),
    Case("overtaking", (ring(10.0, 5.0, 1.2, 90.0), ring(35.0, 5.0, 3.0, 90.0)), 0.1),
    Case("5 % of frames lost", TRAIN[:2], 0.2, dropped=0.05),
    Case("10 mm not recorded", TRAIN[:2], 0.1, then=without(slice(None), slice(45, 55))),
    Case("4 s lost in a front", TRAIN[:1], 0.1, then=without(slice(380, 420), slice(None))),
    Case("pressure, uneven channels", PRESSURES, 0.2, drift=0.5, dropped=0.02, duration=180.0, places=UNEVEN,
         quantity="pressure", then=lambda one: maps.level(one, 60.0)),
)  # fmt: skip


def reached(one: Ring, places: np.ndarray) -> float:
    """Extent of a ring as the places of a recording can show it [mm]: from the first to the last that it reaches."""
    low, high = one.span
    inside = places[(places >= low) & (places <= high)]
    return float(inside[-1] - inside[0])


def matched(truth: Sequence[Ring], found: Sequence[Contraction]) -> list[Contraction | None]:
    """For each ring the contraction whose front lies nearest to its own, within its duration; each once."""
    left = list(found)
    pairs: list[Contraction | None] = []
    for one in truth:
        away = [float(np.median(np.abs(other.front[1] - one.arrival(other.front[0])))) for other in left]
        best = int(np.argmin(away)) if away else -1
        pairs.append(left.pop(best) if away and away[best] <= one.duration else None)
    return pairs


def verdict(one: Ring, got: Contraction | None, places: np.ndarray) -> str:
    """What is wrong with a contraction that was found, in words; "" where nothing is."""
    if got is None:
        return "missed"
    wrong = []
    if got.direction != one.direction:
        wrong.append(f"taken as {got.direction}")
    elif got.speed is not None and abs(got.speed / one.speed - 1.0) > SPEED:
        wrong.append(f"speed off by {100.0 * (got.speed / one.speed - 1.0):+.0f} %")
    missed = got.extent - reached(one, places)
    if abs(missed) > EXTENT:
        wrong.append(f"extent off by {missed:+.0f} mm")
    expected = float(one.arrival(np.array([got.place]))[0])
    if abs(got.begin - expected) > BEGIN:
        wrong.append(f"begin off by {got.begin - expected:+.1f} s")
    return ", ".join(wrong)


def score() -> tuple[list[list[object]], list[str]]:
    """A row for each map, and what went wrong in each."""
    rows, failures = [], []
    for number, case in enumerate(CASES, 1):
        recorded = case.recorded(number)
        found = maps.contractions(recorded)
        pairs = matched(case.rings, found.found)
        words = [
            text
            for text in (verdict(one, got, recorded.place) for one, got in zip(case.rings, pairs, strict=True))
            if text
        ]
        extra = len(found) - sum(got is not None for got in pairs)
        words += [f"{extra} that {'is' if extra == 1 else 'are'} none"] if extra else []
        got = [one for one in pairs if one is not None]
        intervals = [one.interval for one in got if one.interval is not None and len(case.rings) > 2]
        true_gap = f"{case.rings[1].begin - case.rings[0].begin:g}" if len(case.rings) > 2 else "–"
        rows.append(
            [
                number,
                f"{case.name}, noise {100.0 * case.noise:.0f} %",
                f"{len(case.rings)} / {len(found)}",
                " ".join("∞" if np.isinf(one.speed) else f"{one.speed:g}" for one in _firsts(case.rings)),
                " ".join("∞" if one.speed is None else f"{one.speed:.3g}" for one in _firsts(got)),
                " ".join(f"{reached(one, recorded.place):g}" for one in _firsts(case.rings)),
                " ".join(f"{one.extent:g}" for one in _firsts(got)),
                true_gap,
                f"{np.median(intervals):.2f}" if intervals else "–",
                "; ".join(words) or "yes",
            ]
        )
        if words:
            failures.append(f"{number} ({case.name}): {'; '.join(words)}")
    return rows, failures


def _firsts(several: Sequence) -> Sequence:
    return several[:3]


LIMITS = (
    ("a fifth as deep as the deepest", (TRAIN[0], replace(TRAIN[2], amplitude=0.8)), 0.02, None),
    ("the same, threshold 0.4 mm stated", (TRAIN[0], replace(TRAIN[2], amplitude=0.8)), 0.02, maps.Rule(threshold=0.4)),
    ("6 mm long, shorter than least_extent", (TRAIN[0], ring(90.0, 40.0, 2.0, 6.0)), 0.1, None),
    ("two 3 s apart, lasting 3 s", (ring(20.0, 5.0, 2.0, 85.0), ring(23.0, 5.0, 2.0, 85.0)), 0.1, None),
    ("two 5 s apart, lasting 3 s", (ring(20.0, 5.0, 2.0, 85.0), ring(25.0, 5.0, 2.0, 85.0)), 0.1, None),
    ("as fast as 85 mm in 0.7 s, lasting 3 s", (ring(20.0, 5.0, 120.0, 85.0),), 0.1, None),
)
"""Where the measure ends: what, rings, noise, rule."""
LEVELS = (0.1, 0.2, 0.3, 0.4, 0.6, 0.8)


def limits() -> list[list[object]]:
    """What is found where the measure ends."""
    rows = []
    for what, rings, noise, rule in LIMITS:
        recorded = Case(what, rings, noise, duration=160.0).recorded(50)
        found = maps.contractions(recorded, rule)
        pairs = matched(rings, found.found)
        words = [text for text in (verdict(*pair, recorded.place) for pair in zip(rings, pairs, strict=True)) if text]
        rows.append([what, len(rings), len(found), "; ".join(words) or "found"])
    return rows


def noise_levels(seeds: Sequence[int] = (101, 202, 303)) -> list[list[object]]:
    """Rings found rightly out of all, at each level of noise, over the 20 maps and several seeds."""
    rows = []
    for noise in LEVELS:
        right = total = extra = 0
        for case in CASES:
            for seed in seeds:
                recorded = replace(case, noise=noise).recorded(seed)
                found = maps.contractions(recorded)
                pairs = matched(case.rings, found.found)
                right += sum(not verdict(*pair, recorded.place) for pair in zip(case.rings, pairs, strict=True))
                total += len(pairs)
                extra += len(found) - sum(one is not None for one in pairs)
        rows.append([f"{100.0 * noise:.0f} %", f"{right} of {total}", extra])
    return rows


def other_measures() -> list[list[object]]:
    """Truth and finding of what is measured besides."""
    from peristalsis.maps import measures, states

    rows: list[list[object]] = []
    waves = tuple(ring(10.0 + 15.0 * k, 5.0, 2.0, 90.0, duration=4.0) for k in range(40))
    for noise in (0.0, 0.2, 0.5, 2.0):
        made = maps.recording(waves, 600.0, noise=noise * AMPLITUDE, seed=7)
        found = measures.spectrum(made, 150.0)
        said = "no peak" if found.peak is None else f"{found.peak:.3f}"
        if found.limits is not None:
            said += f" ({found.limits[0]:.2f} to {found.limits[1]:.2f})"
        rows.append([f"frequency, noise {100 * noise:.0f} %", "4 /min", said])
    made = maps.recording((), 600.0, noise=1.0, seed=8)
    rows.append(["frequency of noise alone", "no peak", measures.spectrum(made, 150.0).peak or "no peak"])
    tall = tuple(replace(one, amplitude=height, place=4.0, extent=186.0, speed=20.0, duration=6.0)
                 for one, height in zip(TRAIN, (120.0, 60.0, 110.0, 85.0, 130.0), strict=True))  # fmt: skip
    pressure = maps.recording(tall, 260.0, place=UNEVEN, quantity="pressure", rest=5.0, noise=3.0, seed=9)
    waves_found = maps.contractions(pressure, maps.Rule(threshold=25.0))
    rows.append(
        ["high-amplitude waves (120, 60, 110, 85, 130 mmHg)", 3, len(measures.high_amplitude(pressure, waves_found))]
    )
    random = np.random.default_rng(3)
    time = np.arange(0.0, 60.0, 0.2)
    for error in (0.0, 0.5):
        track = maps.Track(time, 5.0 + 2.0 * time + error * random.standard_normal(time.size))
        speed = measures.passage(track, 20.0, 80.0).speed
        rows.append([f"pellet over 20 to 80 mm, positions ± {error:g} mm", "2 mm/s", f"{speed:.3f} mm/s"])
    stuck = maps.Track(time, np.minimum(5.0 + 2.0 * time, 60.0))
    rows.append(["pellet that stops at 60 mm", "no speed", measures.passage(stuck, 20.0, 80.0).why])
    narrow = maps.recording(TRAIN, 260.0, noise=0.2, seed=10)
    deepest = max(one.occlusion for one in maps.contractions(narrow).found)
    rows.append(["largest occlusion (4 of 12 mm)", f"{4 / 12:.3f}", f"{deepest:.3f}"])
    moved = maps.recording([replace(one, begin=one.begin + 2.5) for one in TRAIN], 260.0, noise=0.8, seed=11)
    shift = maps.compare(narrow, moved, most=6.0).shift
    rows.append(["second map 2.5 s late, noise 20 %", "-2.5 s", f"{shift:.2f} s"])
    rising = maps.recording(TRAIN, 260.0, quantity="pressure", rest=5.0, seed=12)
    for words, other in (
        ("narrows as pressure rises", narrow_of(TRAIN, 1)),
        ("widens as pressure rises", narrow_of(TRAIN, -1)),
    ):
        shares = states.states(other, rising).shares
        active, passive = shares["contracting"], shares["passive: distended"]
        state = "contracting" if "narrows" in words else "passive: distended"
        said = f"contracting {100 * active:.1f} %, passively distended {100 * passive:.1f} % of the map"
        rows.append([f"state where the wall {words}", state, said])
    return rows


def narrow_of(rings: Sequence[Ring], sign: int) -> Map:
    """A diameter that narrows (1) or widens (-1) with rings."""
    made = maps.recording(rings, 260.0, seed=13)
    return made if sign > 0 else made.done("turned over", values=24.0 - made.values)


def round_trips(run: ps.Result) -> list[list[object]]:
    """The diameter map of a run written and read back: largest difference, and what the form promises."""
    from PIL import Image

    whole, rows = run.maps.diameter, list[list[object]]()
    span = float(np.nanmax(whole.values) - np.nanmin(whole.values))
    with tempfile.TemporaryDirectory() as folder:
        for name, options, promise in (
            ("map.csv", {}, 0.0),
            ("long.csv", {"form": "long"}, 0.0),
            ("map.nc", {}, 0.0),
            ("map.mat", {}, 0.0),
            ("map.tif", {"bits": 16}, 0.5 * span / 65534),
            ("map8.tif", {"bits": 8}, 0.5 * span / 254),
            ("map.png", {"bits": 16}, 0.5 * span / 65534),
            ("down.tif", {"time": "down"}, 0.5 * span / 65534),
        ):
            file = maps.write(whole, Path(folder, name), **options)
            back = maps.read(file)
            far = float(np.nanmax(np.abs(back.values - whole.values)))
            axes = max(np.abs(back.time - whole.time).max(), np.abs(back.place - whole.place).max())
            seen = "–"
            if name.endswith(".tif"):
                with Image.open(file) as picture:
                    tags = picture.tag_v2
                    lines = dict(one.split("=", 1) for one in tags[270].splitlines())
                    seen = f"{float(tags[282]):.6g} px/{lines['unit']}, {float(tags[283]):.6g} px/{lines['yunit']}"
            good = "yes" if far <= promise * (1.0 + 1e-9) and axes <= 1e-9 else "NO"
            rows.append([name, options.get("bits", "–"), promise, far, float(axes), seen, good])
    return rows


LONG = """
import re, sys, time
import numpy as np
from peristalsis import maps
from peristalsis.maps.drawing import manometry
from peristalsis.plots import style

def peak():
    return int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024.0

def said(what, begin):
    print(f"{what}|{time.perf_counter() - begin:.1f}|{peak():.0f}", flush=True)

said("Python with its libraries", time.perf_counter())
begin = time.perf_counter(); recorded = maps.read(sys.argv[1]); said("reading", begin)
begin = time.perf_counter()
with style.applied():
    style.write(manometry.draw(recorded), __import__("pathlib").Path(sys.argv[2], "a.png"), "", "")
    style.write(manometry.draw_traces(recorded), __import__("pathlib").Path(sys.argv[2], "b.png"), "", "")
said("both displays, as PNG", begin)
begin = time.perf_counter(); found = maps.contractions(recorded); said(f"finding {len(found)} contractions", begin)
__import__("pathlib").Path(sys.argv[2], "found.csv").write_text(found.csv())
"""


def two_hours() -> tuple[list[list[object]], str, str]:
    """Time and peak memory for a recording of two hours, 40 channels at 25 Hz; and how large its file is."""
    places = np.arange(0.0, 400.0, 10.0)
    random = np.random.default_rng(5)
    rings = [
        Ring(20.0 + 60.0 * k + float(random.uniform(-10, 10)), 35.0, float(random.uniform(8, 25)), 320.0,
             float(random.uniform(40, 110)), 7.0)
        for k in range(118)
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        made = maps.recording(rings, 7200.0, 0.04, places, "pressure", 6.0, 2.5, 2.0, 0.001, 5)
        rounded = made.done("to 0.01 mmHg", values=np.round(made.values, 2))
        file = maps.write(rounded, Path(folder, "hours.csv"))
        size = file.stat().st_size / 1e6
        del made, rounded
        done = subprocess.run(
            [sys.executable, "-c", LONG, str(file), folder], capture_output=True, text=True, check=True
        )
        listed = [line.split(",") for line in Path(folder, "found.csv").read_text().splitlines() if line[0].isdigit()]
    rows = [line.split("|") for line in done.stdout.splitlines()]
    fronts = np.array([[float(one[2]), float(one[3]), float(one[6])] for one in listed if one[1] == "antegrade"])
    late = [np.abs(fronts[:, 0] - one.arrival(fronts[:, 1])) for one in rings]
    whole = sum(bool(((away < 2.0) & (fronts[:, 2] > 0.9 * 320.0)).any()) for away in late)
    parts = sum(bool((away < 4.0).any()) for away in late) - whole
    said = (
        f"Of the {len(rings)} waves {whole} are found over nine tenths of their way, {parts} in part or in pieces:\n"
        "fast ones overtake slow ones."
    )
    return [[what, f"{seconds} s", f"{memory} MB"] for what, seconds, memory in rows], size_text(size), said


def size_text(megabytes: float) -> str:
    """A size in words."""
    return f"{megabytes:.0f} MB"


def pictures(run: ps.Result) -> None:
    """The recording of the tutorial, and it beside a run."""
    recorded, _, track = example()
    found = maps.contractions(maps.level(recorded, 60.0))
    own = run.maps.diameter
    pressure = maps.recording(PRESSURES, 180.0, place=UNEVEN, quantity="pressure", rest=8.0, noise=2.0, seed=3)
    drawn = {
        "maps_rings": lambda: map_figure.draw(recorded, found, (track,)),
        "maps_beside": lambda: comparison.draw_beside(
            (recorded, own), (found, maps.contractions(own)), ((track,), (run.maps.pellet,))
        ),
        "maps_manometry": lambda: manometry.draw(pressure),
    }
    with style.applied():
        for name, draw in drawn.items():
            style.write(draw(), IMAGES / f"{name}.png", name, "")


def main() -> None:
    """Measure, draw, write the page."""
    run = ps.load(sys.argv[1]) if len(sys.argv) > 1 else ps.run("baseline")
    rows, failures = score()
    again = [maps.contractions(case.recorded(k)).csv() for k, case in enumerate(CASES, 1)]
    same = again == [maps.contractions(case.recorded(k)).csv() for k, case in enumerate(CASES, 1)]
    hours, size, waves = two_hours()
    heads = (
        "",
        "map",
        "rings / found",
        "true mm/s",
        "found mm/s",
        "true mm",
        "found mm",
        "true s",
        "found s",
        "right?",
    )
    text = f"""# What the measures of maps find

Written by `python evidence/maps.py`. Rings of 4 mm in a tube of 12 mm (70 mmHg over 8 mmHg for the
pressures) last 3 s at half their depth (6 s); a map has 101 places 1 mm apart, or 14 channels, and
10 frames a second. Noise is a share of the depth, at each place and time anew. Right is the true
direction, a speed within 5 %, an extent within 8 mm of what the places can show, a beginning within
1 s, and nothing found that is not there. Columns: speeds, extents, intervals of the first three.

{table(heads, rows)}
Failures: {". ".join(failures) or "none"}. The extent of a
contraction that fades ends where its depth falls below the threshold, so it is short by what lies
below; a threshold that is stated moves that place.

Measured twice, the 20 maps give {"the same bits" if same else "DIFFERENT bits"}.

## How much noise

All 20 maps at each level, with three seeds:

{table(("noise", "rings found rightly", "found that are none"), noise_levels())}
The ring that fades to nothing counts as wrong in each. The bell that depths are smoothed with takes
most of the noise. Beyond 40 % of the depth the threshold, five deviations of the noise, comes near
the contractions themselves; from 80 % on nothing of it is to be trusted.

## Where it ends

{table(("rings", "true", "found", "verdict"), limits())}
## Other measures

{table(("measure", "true", "found"), other_measures())}
## Round trips

The diameter map of a run of the baseline, written and read back. Differences in mm and in s or mm;
the last but one column is what Pillow reads in the tags of the TIFF.

{table(("file", "bits", "promised", "difference", "of the axes", "scale in the tags", "kept"), round_trips(run))}
## Two hours of 40 channels

118 waves at 25 Hz, 7.2 million numbers (58 MB), a CSV of {size}, on one core of a machine that was
busy otherwise; memory is the peak of the process up to there.
{waves}

{table(("step", "time", "peak memory"), hours)}"""
    save_text("maps.md", text)
    pictures(run)


if __name__ == "__main__":
    main()
