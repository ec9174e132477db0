"""How the pellet travels over the force of muscle, its friction and its size, under the reading `tight`.

`python evidence/regimes.py [FOLDER [WORKERS]]` keeps finished runs in FOLDER (out/paper unless said otherwise) and
writes docs/paper/maps.md with two pictures. Some twenty minutes on one core, nothing if the runs are there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import ROOT, table, wrapped

from peristalsis import scenarios
from peristalsis.inputs.config import Configuration
from peristalsis.many.rows import Row
from peristalsis.many.studies.classes import ARRESTED, CAUGHT, LEFT, REGIMES, RIDES
from peristalsis.many.sweep import sweep
from peristalsis.plots import style
from peristalsis.scoring import sources

SOURCE = sources.get("paper")
assert SOURCE.space is not None
EDGE = SOURCE.space.edge
PAGES = ROOT / "docs" / "paper"
FORCES = tuple(float(f"{x:.3g}") for x in np.geomspace(0.3, 1.2, 17))
VISCOUS = tuple(float(f"{x:.3g}") for x in np.geomspace(57.5, 1200.0, 13)[:11])
RATIOS = tuple(float(f"{x:.3g}") for x in np.arange(0.98, 1.2001, 0.03))
FINER = {"grid.n_z": 1400, "grid.n_z_wall": 1300, "step.wall": "2.5 ms", "step.conduction": "0.5 ms"}
PAGE = """# Regimes over force, friction and size

Made by `python evidence/regimes.py`. The numbers of the reading `tight`, with the force of both layers
and one other number changed: what a pellet does, lines of equal transit, and the paper's experiments
as points. The reading `edge` differs in other numbers too, so its place on these maps is only near its
edge. What they say: [the regime of the paper](regimes.md).

![Regimes over force and viscous friction](regimes_viscous.png)

![Regimes over force and the size of the pellet](regimes_ratio.png)

## Again on doubled grids, with halved steps

Three points of each map on the row of the norm: beside the edge on either side, and at the full force.

"""
COLOURS = {RIDES: "#4477aa", CAUGHT: "#ccbb44", LEFT: "#ee8866", ARRESTED: "#bbbbbb"}


@dataclass(frozen=True)
class Map:
    """One map: the second axis beside the force, the norm of both readings on it, and the experiments on it."""

    name: str
    label: str
    forces: tuple[float, ...]
    values: tuple[float, ...]
    key: str
    unit: str
    experiments: Mapping[str, float]

    def configuration(self, force: float, value: float, more: Mapping[str, Any] | None = None) -> Configuration:
        """One point; the ratio is of the tube's radius."""
        base = scenarios.configuration("baseline", reading="tight")
        number = value * base.wall.radius if self.key == "pellet.radius" else value
        changes = {"longitudinal.active": force, "circular.active": force, self.key: f"{number!r} {self.unit}"}
        return base.with_changes({**changes, **(more or {})})


MAPS = (
    Map(
        "viscous",
        "viscous friction (mN·s/cm)",
        FORCES,
        VISCOUS,
        "pellet.viscous_friction",
        "mN*s/cm",
        {
            "norm": 230.0,
            "x 0.5": 115.0,
            "Fig. 3 C": 200.0,
            "Fig. 3 D": 90.0,
            "x 2": 460.0,
            "x 4": 920.0,
        },
    ),
    Map(
        "ratio",
        "radius of the pellet over that of the tube",
        FORCES[::2],
        RATIOS,
        "pellet.radius",
        "cm",
        {"norm": 0.9 / 0.795, "x 1.05": 1.05 * 0.9 / 0.795, "threshold of the paper": 1.05},
    ),
)


def records(cases: Mapping[str, Configuration], folder: Path, workers: int) -> dict[str, Row]:
    """The rows of all cases, made or kept, told on stderr."""

    def tell(step: Any) -> None:
        if not step.kept:
            print(f"{step.done}/{step.count} {step.row.point.name}", file=sys.stderr, flush=True)

    return sweep(cases, folder, SOURCE.measure, workers, tell)


def measured(of: Map, folder: Path, workers: int) -> tuple[list[list[str]], np.ndarray[Any, Any]]:
    """Regime and transit [s] (nan where there is none) at every force (columns) and value (rows)."""
    cases = {f"{of.name} {f:g} {v:g}": of.configuration(f, v) for v in of.values for f in of.forces}
    rows = records(cases, folder, workers)
    regimes = [[EDGE.regime(rows[f"{of.name} {f:g} {v:g}"].summary) for f in of.forces] for v in of.values]
    transits = [[rows[f"{of.name} {f:g} {v:g}"].summary.get("transit_s") for f in of.forces] for v in of.values]
    return regimes, np.array([[np.nan if t is None else t for t in row] for row in transits], dtype=float)


def checked(of: Map, regimes: Sequence[Sequence[str]], folder: Path, workers: int) -> list[tuple[Any, ...]]:
    """Three points again on doubled grids and halved steps: the norm, and on its row the points beside the edge."""
    row = min(range(len(of.values)), key=lambda k: abs(of.values[k] - of.experiments["norm"]))
    riding = [k for k, found in enumerate(regimes[row]) if found == RIDES]
    columns = (
        (riding[0] - 1, riding[0], len(of.forces) - 1)
        if riding and riding[0]
        else (0, len(of.forces) // 2, len(of.forces) - 1)
    )
    places = [(of.forces[k], of.values[row], regimes[row][k]) for k in columns]
    cases = {f"finer {f:g} {v:g}": of.configuration(f, v, FINER) for f, v, _ in places}
    rows = records(cases, folder, workers)
    return [
        (
            of.label,
            f,
            v,
            was,
            EDGE.regime(rows[f"finer {f:g} {v:g}"].summary),
            rows[f"finer {f:g} {v:g}"].summary["transit_s"],
        )
        for f, v, was in places
    ]


def draw(of: Map, regimes: Sequence[Sequence[str]], transits: np.ndarray[Any, Any], edge: Configuration) -> None:
    """The map with lines of equal transit, the experiments, and both readings."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    with style.applied():
        figure = Figure(figsize=(7.2, 4.6), dpi=150, layout="constrained")
        axes = figure.subplots()
        numbers = np.array([[REGIMES.index(one) if one else np.nan for one in row] for row in regimes])
        colours = ListedColormap([COLOURS[one] for one in REGIMES])
        axes.pcolormesh(of.forces, of.values, numbers, cmap=colours, vmin=-0.5, vmax=3.5, shading="nearest", alpha=0.85)
        lines = axes.contour(
            of.forces, of.values, transits, levels=(2.3, 2.4, 2.5, 3.0, 4.0, 6.0), colors="black", linewidths=0.8
        )
        axes.clabel(lines, fmt="%g s", fontsize=7)
        axes.set_xscale("log")
        axes.set_xticks((0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2), labels=("0.3", "0.4", "0.5", "0.6", "0.8", "1", "1.2"))
        axes.minorticks_off()
        if of.name == "viscous":
            axes.set_yscale("log")
            axes.set_yticks((60, 100, 230, 460, 920), labels=("60", "100", "230", "460", "920"))
            axes.minorticks_off()
        for name, value in of.experiments.items():
            if name != "norm" and of.values[0] <= value <= of.values[-1]:
                axes.plot(1.0, value, "o", color="white", markeredgecolor="black", markersize=5)
                axes.annotate(name, (1.0, value), xytext=(-7, -3), textcoords="offset points", fontsize=7, ha="right")
        axes.plot(
            1.0, of.experiments["norm"], "*", color="white", markeredgecolor="black", markersize=13, label="tight"
        )
        radius = edge.pellet.radius / edge.wall.radius
        place = edge.pellet.viscous_friction if of.name == "viscous" else radius
        axes.plot(edge.circular.active, place, "D", color="white", markeredgecolor="black", markersize=8)
        axes.annotate("edge", (edge.circular.active, place), xytext=(6, -11), textcoords="offset points", fontsize=8)
        axes.annotate("tight", (1.0, of.experiments["norm"]), xytext=(6, -11), textcoords="offset points", fontsize=8)
        axes.set_xlabel("force of muscle, both layers (1 = printed)")
        axes.set_ylabel(of.label)
        figure.legend(
            handles=[Patch(color=COLOURS[one], alpha=0.85, label=one) for one in REGIMES],
            loc="outside upper center",
            ncols=4,
        )
        figure.savefig(PAGES / f"regimes_{of.name}.png")


def main() -> None:
    """Measure, draw, and write what the page quotes."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper") / "runs"
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    edge = scenarios.configuration("baseline", reading="edge")
    again = []
    for of in MAPS:
        regimes, transits = measured(of, folder, workers)
        draw(of, regimes, transits, edge)
        again += checked(of, regimes, folder, workers)
    head = ("map", "force", "value", "regime", "on doubled grids", "transit there (s)")
    (PAGES / "maps.md").write_text(wrapped(PAGE + table(head, again)), encoding="utf-8")
    print(table(head, again))


if __name__ == "__main__":
    main()
