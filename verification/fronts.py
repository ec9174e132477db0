"""E4-E7: travelling fronts and a nonlinear problem with a closed solution."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from peristalsis.inputs import preflight

from .exact.reaction import Nagumo, PathmanathanGray, ReactingCable, mckean_speed
from .exact.runs import configured
from .exact.wave import speed
from .problem import Check, Outcome, Problem, error, judged, order

Floats = NDArray[np.float64]


def _front_speed(front: Nagumo, per_width: float, dt: float, end: float) -> float:
    """Speed over the second half of 2*end, once the discrete front has its own shape."""
    cable = front.cable(per_width, 45.0, 18.0)
    cable.advance(dt, round(end / dt))
    before = cable.place()
    cable.advance(dt, round(end / dt))
    return (cable.place() - before) / (round(end / dt) * dt)


def nagumo() -> Outcome:
    """Speed of the cubic front, its sign, and the pinning of both the cubic front and the tissue's own wave."""
    front = Nagumo(0.25)
    sizes = [0.4, 0.28, 0.2, 0.14]
    errors = [abs(_front_speed(front, 1.0 / h, 0.0025, 8.0) / front.speed - 1.0) for h in sizes]
    still = Nagumo(0.5).cable(1.0 / 0.28, 30.0, 15.0)
    place = still.place()
    still.advance(0.05, 400)
    back = _front_speed(Nagumo(0.75), 1.0 / 0.28, 0.01, 4.0) / Nagumo(0.75).speed
    pinned = _front_speed(Nagumo(0.45), 1.0 / 4.0, 0.2, 60.0) / Nagumo(0.45).speed
    checks = [
        error("relative at h = 0.28 w", errors[1], 2.5e-3),
        error("relative at h = 0.14 w", errors[3], 6e-4),
        order("in space", sizes, errors, 4.0),
        error("motion at a = ½", still.place() - place, 1e-10),
        error("relative at a = ¾ (c < 0)", back - 1.0, 2.5e-3),
        error("speed at h = 4 w over c: pinned", pinned, 1e-4),
    ]
    warned, silent = 0, 0.0
    finest = speed("longitudinal", 1600)
    for cells in (1000, 400, 200, 100, 50):
        found = speed("longitudinal", cells)
        off = math.inf if found is None or finest is None else abs(found / finest - 1.0)
        remarks = preflight.remarks(configured({"grid.n_z": cells, "grid.n_z_wall": 800}))
        if any("grid.n_z " in text for text in remarks):
            warned += 1
        else:
            silent = max(silent, off)
    checks += [
        Check("grids of 400, 200, 100, 50 cells warned of", warned, 4.0, 4.0),
        error("tissue's wave on the grid not warned of, relative", silent, 0.01),
    ]
    return judged(
        "c = √(κD/2)(1 − 2a); c = 0 at a = ½; sign turns; pinned on coarse grids, with a warning",
        checks,
        "Fourth order, where a second-order scheme has 2.3e-3 and 5.6e-4. The warning is the preflight's, for the "
        "tissue's own wave.",
    )


def _jump(threshold: float, u: Floats) -> Floats:
    """-u + H(u - a)."""
    return np.asarray(-u + (u > threshold))


def mckean() -> Outcome:
    """The front of a reaction that jumps."""
    checks = []
    for threshold in (0.2, 0.3):
        h = 0.05
        z = np.asarray((np.arange(600) + 0.5) * h, dtype=np.float64)
        start = np.asarray(np.where(z < 8.0, 1.0, 0.0), dtype=np.float64)
        cable = ReactingCable(z, start, 1.0, partial(_jump, threshold), 1.0)
        dt = 0.001
        cable.advance(dt, 6000)
        before = cable.place()
        cable.advance(dt, 4000)
        found = (cable.place() - before) / 4.0
        checks.append(error(f"relative, a = {threshold:g}", found / mckean_speed(threshold) - 1.0, 0.01))
    return judged(
        "c = √D (1 − 2a)/√(a(1 − a))",
        checks,
        "h = 0.05 √D. The tissue's kinetics are smooth; this is the operator and the step under the worst reaction.",
    )


def stretch() -> Outcome:
    """Uniform frozen stretch: the Lagrangian speed goes with the root of D_L = D/stretch."""
    plain = speed("circular", 800, 1.0, 8.0)
    checks = []
    for ratio in (0.7, 1.4):
        found = speed("circular", 800, ratio, 8.0)
        slower = math.nan if found is None or plain is None else found / plain
        checks.append(error(f"relative, λ_l = {ratio:g}", slower * math.sqrt(ratio) - 1.0, 5e-3))
    return judged(
        "c(λ)/c(1) = √(D_L(λ)/D_L(1)) = λ^−½",
        checks,
        "Along the tube. Anisotropy c_z/c_θ and the seam belong to the full surface.",
    )


def pathmanathan_gray() -> Outcome:
    """A nonlinear cell with a closed solution, no forcing: orders in space and time."""
    exact = PathmanathanGray()

    def l2(cells: int, steps: int) -> float:
        found, wanted = exact.solve(cells, steps)
        return float(np.sqrt(np.mean((found - wanted) ** 2)))

    cells, steps = (12, 16, 24, 32), (8, 16, 32, 64)
    space, time = [l2(n, 400) for n in cells], [l2(256, n) for n in steps]
    return judged(
        "V = √(1 + t) cos(nπz/L), β = −σ(nπ/L)²",
        [
            order("in space (L2)", [1.0 / n for n in cells], space, 4.0),
            order("in time", [1.0 / n for n in steps], time, 2.0),
            error("L2 at 32 cells", space[-1], 1e-5),
        ],
        "Axisymmetric form with G = 1 + z/(2L). Operator and order of the parts are those of (30), (31); the gates are "
        "the problem's, since the sheet's kernel is bound to Plant's cell (which E10 tests).",
    )


PROBLEMS = (
    Problem(
        "E4",
        "Nagumo front",
        "Nagumo, Arimoto & Yoshizawa, Proc. IRE 50 (1962); Keener (1987) for pinning",
        "quick",
        nagumo,
        (11, 30, 31),
    ),
    Problem("E5", "McKean front", "McKean, Adv. Math. 4 (1970)", "quick", mckean, (30, 31)),
    Problem("E6", "Stretch slows the wave", "scaling z in Eq. (11)", "quick", stretch, (6, 11, 31)),
    Problem(
        "E7",
        "Pathmanathan-Gray, unforced",
        "Pathmanathan & Gray, Int. J. Numer. Meth. Biomed. Eng. 30 (2014)",
        "quick",
        pathmanathan_gray,
        (30, 31),
    ),
)
