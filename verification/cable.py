"""E1-E3, E8, E9: the conduction operator and the passive cable against exact answers, Eqs. (30) and (31)."""

from __future__ import annotations

import numpy as np

from peristalsis.numerics.stabilised import stability_limit
from peristalsis.tissue.conduction import largest_eigenvalue

from .exact.cable import PassiveCable, apply_operator, discrete_symbol, hodgkin_rushton, sealed_cable
from .problem import Check, Outcome, Problem, equal, error, judged, order

LENGTH, DIFFUSIVITY = 10.0, 0.0873


def eigenmodes() -> Outcome:
    """Every cosine of the sealed cable is an eigenvector with the symbol of the infinite line."""
    n = 64
    h = LENGTH / n
    worst = 0.0
    for mode in (1, 2, 7, 31, 62):
        k = mode * np.pi / LENGTH
        cosine = np.cos(k * (np.arange(n) + 0.5) * h)
        exact = DIFFUSIVITY * discrete_symbol(k, h)
        rate = apply_operator(cosine, DIFFUSIVITY, h)
        worst = max(worst, float(np.abs(rate / exact - cosine).max()))
    k, sizes, errors = 3.0 * np.pi / LENGTH, [], []
    for n in (32, 64, 128, 256):
        h = LENGTH / n
        cosine = np.cos(k * (np.arange(n) + 0.5) * h)
        sizes.append(h)
        errors.append(float(np.abs(apply_operator(cosine, 1.0, h) / k**2 + cosine).max()))
    checks = [
        error("against the discrete symbol", worst, 1e-12),
        order("in space", sizes, errors, 4.0),
        error("against k² at 256 cells", errors[-1], 1e-7),
    ]
    for stages in (2, 3, 7):
        times, found = decay(stages)
        checks.append(order(f"in time, {stages} stages", times, found, 2.0))
    return judged(
        "rate −(g + D k²)/C, k² → [(27 sin(kh/2) − sin(3kh/2))/(12 h)]² on the grid",
        checks,
        "The scheme is of fourth order in space (the list of problems foresees second order).",
    )


def decay(stages: int) -> tuple[list[float], list[float]]:
    """Steps and errors of one decaying mode against exp of the discrete rate, at four steps."""
    sizes, errors = [], []
    for steps in (64, 128, 256, 512):
        cable = PassiveCable(10.0, 50)
        k = 5.0 * np.pi / 10.0
        mode = np.cos(k * cable.z)
        cable.potential = 40.0 * mode
        cable.advance(0.5 / steps, steps, stages=stages)
        exact = 40.0 * mode * np.exp(0.5 * (discrete_symbol(k, cable.h) - 1.0))
        sizes.append(0.5 / steps)
        errors.append(float(np.abs(cable.potential - exact).max()))
    return sizes, errors


def passive_cable() -> Outcome:
    """Steady passive cable with sealed ends and injected current."""
    sizes, errors = [], []
    for per_length in (12, 25, 50, 100):
        cable = PassiveCable(2.0, 2 * per_length)
        cable.advance(0.02, 700, injected=1.0)
        exact = sealed_cable(np.asarray(cable.z, dtype=np.float64), 2.0)
        away = cable.z > 0.5
        sizes.append(cable.h)
        errors.append(float(np.abs(cable.potential / exact - 1.0)[away].max()))
    return judged(
        "V = (I₀λ/D) cosh((L − z)/λ)/sinh(L/λ), sealed far end, current I₀ into z = 0",
        [error("relative, h = λ/100", errors[-1], 1e-4), order("in space", sizes, errors, 2.0)],
        "Order 2 is that of a point source spread over one cell. The scheme has sealed ends only, so the killed end "
        "(sinh/sinh) is not posed.",
    )


def step_response() -> Outcome:
    """Hodgkin and Rushton's response of the half-line to a flux switched on."""
    cable = PassiveCable(10.0, 500)
    dt, cell = 0.3 * cable.h**2, int(1.0 / cable.h)
    checks = []
    for end in (0.5, 1.0):
        steps = round(0.5 / dt)
        cable.advance(0.5 / steps, steps, injected=1.0)
        for place, k in ((1, cell), (3, 3 * cell)):
            exact = float(hodgkin_rushton(cable.z[k], end))
            checks.append(error(f"at {place} λ, {end:g} τ", cable.potential[k] - exact, 1e-4))
    checks.append(Check("exact value at 1 λ, 1 τ", float(hodgkin_rushton(cable.z[cell], 1.0)), 0.01))
    return judged("V = ½[e^−X erfc(X/2√T − √T) − e^X erfc(X/2√T + √T)]", checks, "h = λ/50.")


def conservation() -> Outcome:
    """Sealed, without a leak: the charge stays; a single step spreads and hardly overshoots."""
    rng = np.random.default_rng(1)
    rate = apply_operator(rng.normal(size=500), rng.uniform(0.3, 2.0, 499), 0.02)
    cable = PassiveCable(10.0, 200)
    cable.potential = 50.0 * np.exp(-((cable.z - 2.0) ** 2))
    before, peak = float(cable.potential.sum()), float(cable.potential.max())
    cable.advance(0.3 * cable.h**2, 2000, leak=0.0)
    drift = abs(cable.potential.sum() - before) / before
    levelled = np.random.default_rng(2)
    gained = max(
        float(v @ apply_operator(v, levelled.uniform(0.3, 2.0, 79), 0.1)) for v in levelled.normal(size=(50, 80))
    )
    return judged(
        "∮V dA constant; differences never grow",
        [
            error("sum of the rates over their size", rate.sum() / np.abs(rate).sum(), 1e-13),
            error("drift over 2000 steps", drift, 1e-13 * np.sqrt(2000)),
            Check("largest V·∂V/∂t of 50 random fields", gained, high=0.0),
            Check("peak left of 50", float(cable.potential.max()), 1.0, min(45.0, peak)),
        ],
        "A fourth-order operator has no pointwise maximum principle; that the square of V falls is what holds instead.",
    )


def explicit_limit() -> Outcome:
    """The step limit of the explicit method from both sides."""
    checks = []
    for stages in (2, 4, 8):
        for factor, stable in ((0.99, True), (1.05, False)):
            cable = PassiveCable(4.0, 200)
            cable.potential = np.asarray(1e-3 * (-1.0) ** np.arange(200), dtype=np.float64)
            limit = stability_limit(stages) / (largest_eigenvalue(1.0, cable.h) + 1.0)
            verdict = cable.advance(factor * limit, 2000, stages=stages)
            if stable:
                checks.append(equal(f"{stages} stages at 0.99: verdict of the kernel", verdict, -1.0))
                checks.append(error(f"{stages} stages at 0.99: amplitude", np.abs(cable.potential).max(), 1e-3))
            else:
                checks.append(Check(f"{stages} stages at 1.05: cell reported", verdict, 0.0))
    matrix = np.array([apply_operator(unit, DIFFUSIVITY, 0.05) for unit in np.eye(60)]).T
    fastest = -np.linalg.eigvals(matrix).real.min() / largest_eigenvalue(DIFFUSIVITY, 0.05)
    checks.append(Check("fastest mode over the bound", float(fastest), 0.995, 1.0 + 1e-12))
    return judged("stable at 0.99, reported as blown up at 1.05 of dt (49/9 D/h² + g)/C = β(s)", checks)


PROBLEMS = (
    Problem("E1", "Discrete eigenmodes", "insert cos(kz) into Eqs. (30), (31)", "quick", eigenmodes, (6, 11, 30, 31)),
    Problem(
        "E2",
        "Passive cable, steady",
        "Jack, Noble & Tsien, Electric Current Flow in Excitable Cells (1975), ch. 3",
        "quick",
        passive_cable,
        (6, 11, 30, 31),
    ),
    Problem(
        "E3",
        "Step response of the half-line",
        "Hodgkin & Rushton, Proc. R. Soc. B 133 (1946)",
        "quick",
        step_response,
        (6, 11, 30, 31),
    ),
    Problem("E8", "Conservation of charge", "the sum over cells telescopes, Eq. (30)", "quick", conservation, (30,)),
    Problem(
        "E9",
        "Explicit step limit",
        "Sommeijer, Shampine & Verwer, J. Comput. Appl. Math. 88 (1998); 49/36 of the three-point symbol",
        "quick",
        explicit_limit,
        (31,),
    ),
)
