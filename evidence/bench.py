"""What makes speed rise with the diameter, and what the bench fixes: evidence behind docs/bench.md.

    python evidence/bench.py mechanisms [VARIANT ...]
    python evidence/bench.py calibrate

`mechanisms` runs pellets of six girths under each variant of the bench. `calibrate` fits three numbers of the
guinea-pig preparation within their ranges, by bounded least squares from seeded starts, and says which combinations of
them the data fix. Both print what they find.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import least_squares

import peristalsis as ps
from peristalsis.inputs.parameters import PREPARATIONS
from peristalsis.scoring.bench.measure import measure
from peristalsis.scoring.bench.runs import ABOVE, BELOW, ISOMETRIC
from peristalsis.scoring.bench.source import SOURCE
from peristalsis.scoring.bench.variants import VARIANTS

PREPARATION = PREPARATIONS["guinea_pig_distal_colon"]
NATURAL = float(PREPARATION.parameters["pellet.radius"].value) / float(PREPARATION.parameters["wall.radius"].value)
TARGETS = (
    ("speed of the natural pellet (mm/s)", 2.0, 0.4),
    ("speed at 1.06 over that", 0.5, 0.15),
    ("speed at 1.26 over that", 1.0, 0.08),
    ("isometric force (mN)", 70.0, 20.0),
)
"""What is fitted: name, value, and how far off it may be. Speed is measured; the others are chosen within B2 and B3."""
SEED, STARTS = 17, 3


def assay(changes: Mapping[str, Any], ratio: float, held: bool = False) -> float:
    """Speed [mm/s], or isometric force [mN], of a pellet of this girth over the tube's; nan where a run broke off."""
    radius = ratio * float(PREPARATION.parameters["wall.radius"].value)
    own = {**changes, "pellet.radius": f"{radius:.6g} cm", **(ISOMETRIC if held else {})}
    simulation = ps.Simulation(ps.configuration("guinea_pig", changes=own))
    result = simulation.run()
    if result.error:
        return float("nan")
    numbers = measure(simulation, result)[0]
    return float(numbers["isometric_force_mN" if held else "middle_speed_mm_s"])


def mechanisms() -> None:
    """Print the speed at six girths under each variant."""
    ratios = sorted([*BELOW, NATURAL, *ABOVE])
    print("| variant |" + "".join(f" {ratio:.3g} |" for ratio in ratios))
    print("|---|" + "---|" * len(ratios))
    for name in sys.argv[2:] or ("shipped", *VARIANTS):
        changes = {} if name == "shipped" else VARIANTS[name].changes
        speeds = [assay(changes, ratio) for ratio in ratios]
        print(f"| {name} |" + "".join(f" {speed:.2f} |" for speed in speeds), flush=True)


def simulated(values: Sequence[float]) -> np.ndarray:
    """The targets as the model has them, on coarse grids. values: of the fitted parameters, in their units."""
    changes: dict[str, Any] = dict(SOURCE.coarse)
    for key, value in zip(PREPARATION.fitted, values, strict=True):
        unit = PREPARATION.parameters[key].unit
        changes[key] = float(value) if unit == "1" else f"{float(value)!r} {unit}"
    natural = assay(changes, NATURAL)
    narrow, wide = (assay(changes, ratio) / natural if natural > 0.0 else 0.0 for ratio in (1.06, 1.26))
    return np.array([natural, narrow, wide, assay(changes, NATURAL, held=True)])


def calibrate() -> None:
    """Fit, print every start's outcome, and the combinations of the best one from the best to the worst fixed."""
    bounds = [(PREPARATION.parameters[key].low, PREPARATION.parameters[key].high) for key in PREPARATION.fitted]
    low, high = (np.array([max(float(pair[side] or 0.0), 0.02) for pair in bounds]) for side in (0, 1))
    wanted, width = (np.array([target[place] for target in TARGETS]) for place in (1, 2))

    def residuals(shares: np.ndarray) -> np.ndarray:
        found = (simulated(low * (high / low) ** shares) - wanted) / width
        return np.nan_to_num(found, nan=10.0)  # a run that broke off is ten widths away, and never left out

    best = None
    starts = np.random.default_rng(SEED).uniform(0.2, 0.8, (STARTS, low.size))
    for start in starts:
        fit = least_squares(residuals, start, bounds=(0.0, 1.0), diff_step=0.05, max_nfev=6)
        values = low * (high / low) ** fit.x
        words = ", ".join(f"{key} = {value:.3g}" for key, value in zip(PREPARATION.fitted, values, strict=True))
        print(f"start {np.round(start, 2)}: cost {fit.cost:.3g}; {words}", flush=True)
        best = fit if best is None or fit.cost < best.cost else best
    assert best is not None
    found = best.fun * width + wanted
    for (name, value, _), ours in zip(TARGETS, found, strict=True):
        print(f"{name}: {ours:.3g}, wanted {value:g}")
    _, sizes, rows = np.linalg.svd(best.jac / np.log(high / low))
    for size, row in zip(sizes, rows, strict=True):
        words = " ".join(f"{weight:+.2f} ln({key})" for weight, key in zip(row, PREPARATION.fitted, strict=True))
        print(f"fixed to {100.0 / size:.3g} %: {words}")


if __name__ == "__main__":
    {"mechanisms": mechanisms, "calibrate": calibrate}[sys.argv[1]]()
