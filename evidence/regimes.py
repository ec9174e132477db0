"""How the pellet travels over the force of muscle, its friction and its size, with the numbers of two readings.

`python evidence/regimes.py [FOLDER [WORKERS]]` keeps finished runs in FOLDER (out/paper unless said otherwise) and
writes docs/paper/maps.md with four pictures. An hour on one core, nothing if the runs are there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import DOUBLED, HALVED, ROOT, made_or_kept, table, wrapped

from peristalsis import scenarios
from peristalsis.inputs.config import Configuration
from peristalsis.many.studies.classes import ARRESTED, CAUGHT, LEFT, REGIMES, RIDES
from peristalsis.plots import style
from peristalsis.scoring import sources

SOURCE = sources.get("paper")
assert SOURCE.space is not None
EDGE = SOURCE.space.edge
PAGES = ROOT / "docs" / "paper"
READINGS = ("tight", "edge")


def _even(low: float, high: float, count: int) -> tuple[float, ...]:
    """Numbers evenly spaced by their logarithm, to three digits."""
    return tuple(float(f"{x:.3g}") for x in np.geomspace(low, high, count))


FORCES = {"tight": _even(0.3, 1.2, 33), "edge": _even(0.257, 1.028, 17)}
"""Of the circular layer; the norm of either reading is one of them."""
VISCOUS = {"tight": _even(57.5, 920.0, 25), "edge": _even(57.5, 920.0, 13)}
RATIOS = tuple(round(0.96 + 0.02 * k, 2) for k in range(13))
PAGE = """# Regimes over force, friction and size

Made by `python evidence/regimes.py`: what a pellet does, lines of equal transit, and the paper's
experiments as points. The force of muscle and one other number change; all others are those of a
reading. Force is that of the circular layer; the longitudinal one has the same share of the printed
force under `tight` and 0.731 of that share under `edge`. What the maps say: [the regime of the
paper](regimes.md).

## With the numbers of `tight`

The reading `edge` differs in other numbers too, so its place here is only near its edge.

![Regimes over force and viscous friction](regimes_viscous.png)

![Regimes over force and the size of the pellet](regimes_ratio.png)

## With the numbers of `edge`

Here the reading lies where its runs put it: on the last of the force that carries the pellet.

![Regimes over force and viscous friction, with the numbers of edge](regimes_viscous_edge.png)

![Regimes over force and the size of the pellet, with the numbers of edge](regimes_ratio_edge.png)

## Again on doubled grids, with halved steps

Three points of each map, on the row that is nearest to the norm: beside the edge on either side, and at
the largest force.

"""
LEVELS = {RIDES: (2.1, 2.2, 2.3, 2.4, 2.5, 2.6, 2.7), CAUGHT: (3.0, 4.0, 6.0, 8.0)}
COLOURS = {RIDES: "#4477aa", CAUGHT: "#ccbb44", LEFT: "#ee8866", ARRESTED: "#bbbbbb"}


@dataclass(frozen=True)
class Map:
    """One map with the numbers of a reading: its second axis beside the force, the norm and the experiments on it."""

    name: str
    reading: str
    label: str
    forces: tuple[float, ...]
    values: tuple[float, ...]
    key: str
    unit: str
    experiments: Mapping[str, float]

    def configuration(self, force: float, value: float, more: Mapping[str, Any] | None = None) -> Configuration:
        """One point; the ratio is of the tube's radius."""
        base = scenarios.configuration("baseline", reading=self.reading)
        number = value * base.wall.radius if self.key == "pellet.radius" else value
        longitudinal = force * base.longitudinal.active / base.circular.active
        changes = {
            "longitudinal.active": longitudinal,
            "circular.active": force,
            self.key: f"{number!r} {self.unit}",
        }
        return base.with_changes({**changes, **(more or {})})

    @property
    def about(self) -> str:
        """What tells the map from the others."""
        return f"{self.reading}, {self.label}"

    @property
    def file(self) -> str:
        """The name of its picture."""
        return f"regimes_{self.name}.png" if self.reading == READINGS[0] else f"regimes_{self.name}_{self.reading}.png"

    def norm(self, of: Configuration) -> float:
        """The place of a parameter set on the second axis."""
        return of.pellet.viscous_friction if self.name == "viscous" else of.pellet.radius / of.wall.radius


def maps(reading: str) -> tuple[Map, Map]:
    """Both maps with the numbers of one reading."""
    norm = scenarios.configuration("baseline", reading=reading)
    ratio = norm.pellet.radius / norm.wall.radius
    viscous = {"x 0.5": 115.0, "Fig. 3 C": 200.0, "Fig. 3 D": 90.0, "x 2": 460.0, "x 4": 920.0}
    sizes = {"x 0.95": 0.95 * ratio, "x 1.05": 1.05 * ratio, "threshold of the paper": 1.05}
    force = FORCES[reading]
    return (
        Map(
            *("viscous", reading, "viscous friction (mN·s/cm)", force, VISCOUS[reading]),
            *("pellet.viscous_friction", "mN*s/cm", viscous),
        ),
        Map(
            *("ratio", reading, "radius of the pellet over that of the tube", force, RATIOS),
            *("pellet.radius", "cm", sizes),
        ),
    )


def measured(of: Map, folder: Path, workers: int) -> tuple[list[list[str]], np.ndarray[Any, Any]]:
    """Regime and transit [s] (nan where there is none) at every force (columns) and value (rows)."""
    cases = {f"{of.file} {f:g} {v:g}": of.configuration(f, v) for v in of.values for f in of.forces}
    rows = made_or_kept(cases, folder, SOURCE.measure, workers)
    found = [[rows[f"{of.file} {f:g} {v:g}"].summary for f in of.forces] for v in of.values]
    times = [[np.nan if one.get("transit_s") is None else one["transit_s"] for one in row] for row in found]
    return [[EDGE.regime(one) for one in row] for row in found], np.array(times, dtype=float)


def checked(of: Map, regimes: Sequence[Sequence[str]], folder: Path, workers: int) -> list[tuple[Any, ...]]:
    """Three points again on doubled grids, halved steps: on the row of the norm, beside the edge and far from it."""
    norm = of.norm(scenarios.configuration("baseline", reading=of.reading))
    row = min(range(len(of.values)), key=lambda k: abs(of.values[k] - norm))
    riding = regimes[row].index(RIDES)
    places = [(of.forces[k], of.values[row], regimes[row][k]) for k in (riding - 1, riding, len(of.forces) - 1)]
    rows = made_or_kept(
        {f"finer {of.file} {f:g}": of.configuration(f, v, {**DOUBLED, **HALVED}) for f, v, _ in places},
        folder,
        SOURCE.measure,
        workers,
    )
    found = [rows[f"finer {of.file} {f:g}"].summary for f, *_ in places]
    return [(of.about, *place, EDGE.regime(one), one["transit_s"]) for place, one in zip(places, found, strict=True)]


def draw(of: Map, regimes: Sequence[Sequence[str]], transits: np.ndarray[Any, Any]) -> None:
    """The map with lines of equal transit, the experiments, and both readings."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    norms = {name: scenarios.configuration("baseline", reading=name) for name in READINGS}
    own = norms[of.reading]
    with style.applied():
        figure = Figure(figsize=(7.2, 4.8), dpi=150, layout="constrained")
        axes = figure.subplots()
        numbers = np.array([[REGIMES.index(one) if one else np.nan for one in row] for row in regimes])
        colours = ListedColormap([COLOURS[one] for one in REGIMES])
        axes.pcolormesh(of.forces, of.values, numbers, cmap=colours, vmin=-0.5, vmax=3.5, shading="nearest", alpha=0.85)
        for regime, levels in LEVELS.items():  # a line does not run across an edge, where transit jumps
            within = np.where(numbers == REGIMES.index(regime), transits, np.nan)
            lines = axes.contour(of.forces, of.values, within, levels=levels, colors="black", linewidths=0.8)
            axes.clabel(lines, fmt="%g s", fontsize=7)
        axes.set_xscale("log")
        ticks = [one for one in (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2) if of.forces[0] <= one <= of.forces[-1]]
        axes.set_xticks(ticks, labels=[f"{one:g}" for one in ticks])
        if of.name == "viscous":
            axes.set_yscale("log")
            axes.set_yticks((60, 100, 230, 460, 920), labels=("60", "100", "230", "460", "920"))
        axes.minorticks_off()
        for name, value in of.experiments.items():
            if of.values[0] <= value <= of.values[-1]:
                axes.plot(own.circular.active, value, "o", color="white", markeredgecolor="black", markersize=5)
                note = (own.circular.active, value)
                axes.annotate(name, note, xytext=(-7, -3), textcoords="offset points", fontsize=7, ha="right")
        for name, marker in (("tight", "*"), ("edge", "D")):
            place = (norms[name].circular.active, of.norm(norms[name]))
            size = 13 if marker == "*" else 8
            axes.plot(*place, marker, color="white", markeredgecolor="black", markersize=size)
            axes.annotate(name, place, xytext=(7, -11), textcoords="offset points", fontsize=8)
        axes.set_xlabel("force of the circular layer (1 = printed)")
        axes.set_ylabel(of.label)
        axes.set_title(f"Numbers of the reading {of.reading}, force and one other changed", fontsize=9, loc="left")
        there = {one for row in regimes for one in row}
        figure.legend(
            handles=[Patch(color=COLOURS[one], alpha=0.85, label=one) for one in REGIMES if one in there],
            loc="outside upper center",
            ncols=4,
        )
        figure.savefig(PAGES / of.file)


def main() -> None:
    """Measure, draw, and write what the page quotes."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper") / "runs"
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    again = []
    for of in (one for reading in READINGS for one in maps(reading)):
        regimes, transits = measured(of, folder, workers)
        draw(of, regimes, transits)
        again += checked(of, regimes, folder, workers)
    head = ("map", "force", "value", "regime", "on doubled grids", "transit there (s)")
    (PAGES / "maps.md").write_text(wrapped(PAGE + table(head, again)), encoding="utf-8")
    print(table(head, again))


if __name__ == "__main__":
    main()
