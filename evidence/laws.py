"""Wall laws side by side: tension against stretch, and what an element costs under each.

Writes docs/evidence/laws.md and docs/images/laws.png. Takes about two minutes on one core, most of it compiling.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from common import ROOT, save_text, table
from matplotlib.figure import Figure

import peristalsis
from peristalsis.inputs.build import build
from peristalsis.numerics.binding import Binding, bind
from peristalsis.plots import style
from peristalsis.scenarios import configuration
from peristalsis.wall.constants import WallConstants

LAWS = Path(peristalsis.__file__).parent / "wall" / "laws"
NAMES = ("tong_fung", "neo_hookean", "fung", "late_fibres")
COLOURS = (style.BLACK, style.GREEN, style.BLUE, style.VERMILION)
LOOKED_AT = (1.05, 1.13, 1.25, 1.5, 2.0, 2.5, 3.0)
ELEMENTS, ROUNDS, CALLS = 4000, 31, 20
FROM, TO = 1.0, 1000.0
"""Tensions shown [mN/cm]."""


def walled(name: str) -> tuple[Binding, WallConstants]:
    """The kernels with a law and the baseline's wall of it, with the constants that its file declares."""
    binding = bind({"wall.laws.tong_fung": LAWS / f"{name}.py"})
    law, wall = binding.module("wall.passive"), build(configuration("baseline").at_start()).wall
    if law.PARAMETERS:
        wall = wall._replace(passive=law.PassiveConstants(*(one.value for one in law.PARAMETERS)))
    return binding, wall


def tension(name: str, stretches: Any, along: bool = False) -> list[float]:
    """Nominal passive tension [mN/cm] in the direction of the stretches, the other one being 1."""
    binding, wall = walled(name)
    law = binding.module("wall.passive")
    pairs = [(s, 1.0) if along else (1.0, s) for s in map(float, stretches)]
    return [
        law.passive_tension(*pair, wall.passive)[0 if along else 1] if law.admissible(*pair, wall.passive) else np.nan
        for pair in pairs
    ]


def costs() -> dict[str, float]:
    """Time for an element and corner [ns]: the least of some rounds, in turns."""
    rng = np.random.default_rng(5)
    rho, known = 0.8 * rng.uniform(0.9, 1.3, ELEMENTS + 1), np.zeros((8, ELEMENTS + 1))
    known[2:4] = 1.0
    kernels = {}
    for name in NAMES:
        binding, wall = walled(name)
        assembly = binding.module("wall.assembly")
        work = np.zeros((assembly.WALL_ROWS, ELEMENTS + 1))
        work[assembly.STRETCH] = rng.uniform(0.9, 1.3, ELEMENTS + 1)
        kernels[name] = assembly.corner_tensions, wall, work
    least = dict.fromkeys(NAMES, np.inf)
    for _ in range(ROUNDS):
        for name, (kernel, wall, work) in kernels.items():
            begin = time.perf_counter()
            for _ in range(CALLS):
                kernel(rho, known, 0.0, wall, 0, ELEMENTS, 0, work)
            least[name] = min(least[name], (time.perf_counter() - begin) / CALLS / ELEMENTS)
    return {name: 1e9 * value for name, value in least.items()}


def picture() -> None:
    """Tension against stretch, around and along."""
    stretches = np.linspace(1.001, 3.2, 400)
    with style.applied():
        figure = Figure(figsize=(style.WIDTH, 3.2), dpi=style.DPI, layout="constrained")
        for axes, along in zip(figure.subplots(1, 2, sharey=True), (False, True), strict=True):
            for name, colour in zip(NAMES, COLOURS, strict=True):
                axes.semilogy(stretches, tension(name, stretches, along), color=colour, label=name)
            axes.set_ylim(FROM, TO)
            axes.set_xlim(1.0, stretches[-1])
            axes.set_xlabel("stretch along the tube, 1 around" if along else "stretch around the tube, 1 along")
            axes.set_title("longitudinal" if along else "circumferential")
        figure.axes[0].set_ylabel("passive tension (mN/cm)")
        figure.axes[0].legend(frameon=False)
        figure.savefig(ROOT / "docs" / "images" / "laws.png")


def main() -> None:
    """Write page and picture."""
    rows = [[name, *(float(f"{value:.3g}") for value in tension(name, LOOKED_AT))] for name in NAMES]
    found = costs()
    cost = [[name, found[name], found[name] / found[NAMES[0]]] for name in NAMES]
    save_text(
        "laws.md",
        "# Wall laws side by side\n\nPassive circumferential tension [mN/cm] by stretch around the tube, at the length "
        "of reference, with\nthe constants that the files declare (`evidence/laws.py`; "
        "[the laws](../laws.md)).\n\n"
        + table(["law", *map(str, LOOKED_AT)], rows)
        + "\nTime of the tensions and their derivatives at a corner of an element, on the machine that wrote this.\n\n"
        + table(["law", "ns", "relative to the paper's"], cost),
    )
    picture()


if __name__ == "__main__":
    main()
