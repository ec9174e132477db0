"""B1-B5: the longitudinal layer as a bidomain against exact answers, Eqs. (6) to (11), (37) and (38)."""

from __future__ import annotations

import numpy as np

from peristalsis.tissue.bidomain import EllipticError
from peristalsis.tissue.surface import Conductivities

from .exact.gaussian import Gaussian
from .exact.surface import CIRCULAR, LONGITUDINAL, Surface, apply_surface
from .problem import Outcome, Problem, error, judged, order

OBLIQUE = ((1, 1), (3, 2), (0, 5), (7, 0), (11, 9), (20, 16))


def symbol() -> Outcome:
    """Every wave, oblique ones too, decays with the symbol of two conductors of unequal anisotropy."""
    surface = Surface(24, 32, axial_stretch=0.8, hoop_stretch=1.3)
    operator = surface.bidomain()
    rates, outside = 0.0, 0.0
    for n, m in OBLIQUE:
        wave = surface.wave(n, m, 0.4)
        decay = surface.decay(n, m)
        inner, outer = surface.symbols(n, m, discrete=True)
        rates = max(rates, float(np.abs(apply_surface(operator, wave) + decay * wave).max() / decay))
        outside = max(outside, float(np.abs(operator.extracellular(wave) + inner / (inner + outer) * wave).max()))
    sizes, errors = [], []
    for n in (16, 32, 64, 128):
        finer = Surface(n, n, conductivities=LONGITUDINAL)
        wave = finer.wave(3, 2)
        rate = apply_surface(finer.bidomain(), wave)
        sizes.append(1.0 / n)
        errors.append(float(np.abs(rate / finer.decay(3, 2, discrete=False) + wave).max()))
    checks = [
        error("rate against the discrete symbol", rates, 1e-10),
        error("φ_e against the discrete symbol", outside, 1e-10),
        order("against the continuum", sizes, errors, 4.0),
    ]
    return judged("rate −q_i q_e/(q_i + q_e), φ_e = −V q_i/(q_i + q_e)", checks)


def equal_anisotropy() -> Outcome:
    """Equal anisotropy of both media is the monodomain; nearly equal is nearly so, through the elliptic solver."""
    rng = np.random.default_rng(4)
    potential = rng.uniform(-80.0, 30.0, (24, 32))
    axial, hoop = rng.uniform(0.7, 1.4, (23, 32)), rng.uniform(0.7, 1.4, (24, 32))
    exact = Surface(24, 32, conductivities=CIRCULAR, axial_stretch=axial, hoop_stretch=hoop)
    nearly = Conductivities(20.0, 20.0, 20.0, 20.0 * (1.0 + 1e-12))
    near = Surface(24, 32, conductivities=nearly, axial_stretch=axial, hoop_stretch=hoop)
    scale = float(np.abs(apply_surface(exact.monodomain(), potential)).max())
    checks = []
    for what, surface in (("equal", exact), ("equal to 1e-12, by the solver", near)):
        found = apply_surface(surface.bidomain(), potential) - apply_surface(exact.monodomain(), potential)
        checks.append(error(what, float(np.abs(found).max()) / scale, 1e-9))
    return judged("the monodomain with g_i g_o/(g_i + g_o)", checks)


def gauge() -> Outcome:
    """φ_e has zero mean, does not see a constant in V, and refuses a current that does not balance."""
    rng = np.random.default_rng(5)
    surface = Surface(24, 32)
    operator = surface.bidomain()
    potential = rng.uniform(-80.0, 30.0, (24, 32))
    found = operator.extracellular(potential)
    shifted = operator.extracellular(potential + 40.0)
    try:
        operator.extracellular(potential, np.ones_like(potential))
        refused = 0.0
    except EllipticError:
        refused = 1.0
    top = float(np.abs(found).max())
    checks = [
        error("mean of φ_e", abs(float(found.mean())) / top, 1e-12),
        error("change under a constant", float(np.abs(shifted - found).max()) / top, 1e-12),
        error("unbalanced current let through", 1.0 - refused, 0.0),
    ]
    return judged("∮φ_e = 0, constants unseen, ∫I = 0 or refused", checks)


def kernel() -> Outcome:
    """The corrected (7) and (8) on a Gaussian, the paper's misprints beside it, and the elliptic solver against it."""
    cells = [0.2, 0.1, 0.05, 0.025]
    errors = [Gaussian(cell, width=16.0).error() for cell in cells]
    case = Gaussian(0.1)
    n_z, n_theta = case.potential.shape
    tube = Surface(
        n_z, n_theta, length=20.0, radius=20.0 / (2.0 * np.pi), diffusivity=1e3 * LONGITUDINAL.effective_axial
    )
    top = float(np.abs(case.current).max())
    solved = apply_surface(tube.bidomain(), case.potential)
    checks = [
        error("kernel at 0.2 of the Gaussian", errors[0], 1e-3),
        error("kernel at 0.1", errors[1], 2.5e-4),
        order("kernel", cells, errors, 2.0),
        error("solver against the exact current", float(np.abs(solved - case.current).max()) / top, 5e-5),
        error("solver against the kernel", float(np.abs(solved - case.by_kernel()).max()) / top, 2.5e-4),
    ]
    sizes = {"no_pi": 0.364, "inverted_root": 0.269, "outer_share": 3.345}
    for variant, size in sizes.items():
        found = case.error(variant)  # type: ignore[arg-type]
        checks.append(
            error(f"misprint {variant.replace('_', ' ')}: {found:.3f}, off its size", abs(found - size), 0.01 * size)
        )
    wrong = [Gaussian(0.1, unit=unit).error("unsquared", closed=False) for unit in (1.0, 10.0)]
    checks.append(
        error(
            f"unsquared denominator: {wrong[0]:.3f} and {wrong[1]:.3f} by unit; 10 x tolerance over it",
            2.5e-3 / min(wrong),
            1.0,
        )
    )
    middle = []
    for cell in (0.1, 0.05):
        one = Gaussian(cell)
        peak = np.unravel_index(np.abs(one.current).argmax(), one.current.shape)
        middle.append(float(one.by_kernel("midpoint", closed=False)[peak] / one.current[peak]) - 1.0)
    checks.append(
        error(
            f"midpoint kernel: {middle[0]:+.3f}, {middle[1]:+.3f}, off −0.24", max(abs(x + 0.24) for x in middle), 0.01
        )
    )
    return judged("a·S + Σ S′ d/2π ∬ (x² − y²)/(x² + y²)² over exact cells", checks)


def aspect() -> Outcome:
    """Cells of any shape: what is left is second order in the longer side."""
    checks = []
    for ratio in (0.5, 1.0, 2.0, 4.0):
        longer = 0.1 * max(ratio, 1.0)
        checks.append(
            error(f"aspect {ratio:g}, over its longer side squared", Gaussian(0.1, ratio).error() / longer**2, 0.025)
        )
    return judged("the same current on cells of 1:2 to 4:1", checks)


PROBLEMS = (
    Problem("B1", "Symbol of the bidomain", "Fourier transform of (6)", "quick", symbol, (6, 9)),
    Problem("B2", "Equal anisotropy", "algebra of (6) and (11)", "quick", equal_anisotropy, (6, 11)),
    Problem("B3", "Gauge and compatibility", "closed surface, no flux", "quick", gauge, (6,)),
    Problem(
        "B4",
        "Kernel form and its misprints",
        "Green's function of the anisotropic plane",
        "quick",
        kernel,
        (7, 8, 9, 10),
    ),
    Problem("B5", "Shape of the cells", "exact integrals over cells", "quick", aspect, (7, 8)),
)
