"""M5-M7, M9-M11: small motions of the pressurised tube from the package's own tangent, end layers, gas."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvalsh
from scipy.optimize import brentq

from peristalsis.errors import DivergenceError
from peristalsis.geometry.tube import lumen_volume
from peristalsis.inputs.parameters import shipped
from peristalsis.model.explicit.limits import limits
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.model.step import advance
from peristalsis.wall.constants import WallConstants
from peristalsis.wall.passive import PassiveConstants, passive_tension

from .exact.runs import EXACT, IDLE, March, march, moved, started
from .exact.wall import InflatedTube, assembled, relax, settle, wall_constants
from .problem import Check, Outcome, Problem, equal, error, judged, order

Floats = NDArray[np.float64]

PRESSURE = 10.0


@dataclass(frozen=True)
class UniformTube:
    """A long straight tube at equilibrium: stretches, and the coefficients A and B of its small motions."""

    wall: WallConstants
    pressure: float
    longitudinal: float
    circumferential: float

    @property
    def derivatives(self) -> tuple[float, float, float, float, float]:
        """W_1, W_2, W_11, W_12, W_22 there [mN/cm]."""
        return passive_tension(self.longitudinal, self.circumferential, self.wall.passive)

    @property
    def a(self) -> float:
        """A = (W_22 - W_2/lambda_2)/R0^2."""
        _, w2, _, _, w22 = self.derivatives
        return (w22 - w2 / self.circumferential) / self.wall.radius**2

    @property
    def b(self) -> float:
        """B = (W_12 - W_2/lambda_1)/R0."""
        _, w2, _, w12, _ = self.derivatives
        return (w12 - w2 / self.longitudinal) / self.wall.radius

    def frequencies(self, k: float) -> tuple[float, float]:
        """Both roots of (m w^2 - W_11 k^2)(m w^2 - W_1 k^2/lambda_1 - A) = k^2 B^2 [1/s], the lower one first."""
        w1, _, w11, _, _ = self.derivatives
        along, across = w11 * k**2, w1 * k**2 / self.longitudinal + self.a
        half, root = 0.5 * (along + across), math.hypot(0.5 * (along - across), k * self.b)
        return tuple(math.sqrt(x / self.wall.surface_density) for x in (half - root, half + root))  # type: ignore

    @property
    def end_layer(self) -> float:
        """Reference length over which a clamped end is forgotten [cm]: l^2 = (W_1/lambda_1)/(A - B^2/W_11)."""
        w1, _, w11, _, _ = self.derivatives
        return math.sqrt(w1 / self.longitudinal / (self.a - self.b**2 / w11))


def inflated(wall: WallConstants, stretch: float, pressure: float = PRESSURE) -> UniformTube:
    """The passive tube at this pressure and longitudinal stretch."""
    return UniformTube(wall, pressure, stretch, InflatedTube(pressure, wall, stretch).hoop_stretch())


def tangent(tube: UniformTube, elements: int, slope: float = 0.0) -> Floats:
    """Dense tangent of wall and pressure on the straight tube per 2 pi r0, rates with this slope [1/s].

    Both ends are mirrors: half of the row of an infinite tube, whose next node moves as the one within does.
    """
    n, h = elements + 3, tube.wall.element_size
    rho = np.full(n, tube.wall.radius * tube.circumferential)
    zeta = np.asarray(np.arange(n) * h * tube.longitudinal, dtype=np.float64)
    histories = np.full(n - 1, tube.longitudinal), np.full(n, tube.circumferential)
    _, whole = assembled(rho, zeta, tube.wall, slope, histories, pressure=tube.pressure)
    matrix = whole[2:-2, 2:-2].copy()
    for beyond, within in ((0, 2), (2 * n - 2, 2 * n - 8)):
        matrix[:, within] += whole[2:-2, beyond]
        matrix[:, within + 1] -= whole[2:-2, beyond + 1]
    matrix[[0, 1, -2, -1]] *= 0.5
    return matrix


def standing(elements: int, half_waves: int) -> Floats:
    """Radial cosine and axial sine, shape (2n, 2): on the grid an exact pair of the straight tube."""
    phase = half_waves * np.pi * np.arange(elements + 1) / elements
    modes = np.zeros((2 * elements + 2, 2))
    modes[0::2, 0], modes[1::2, 1] = np.cos(phase), np.sin(phase)
    return modes


def lumped(tube: UniformTube, elements: int) -> Floats:
    """Masses of the unknowns, half at the ends."""
    mass = np.full(2 * elements + 2, tube.wall.surface_density * tube.wall.element_size)
    mass[[0, 1, -2, -1]] *= 0.5
    return mass


def grid_frequencies(tube: UniformTube, elements: int, half_waves: int) -> tuple[Floats, float]:
    """The two frequencies of a standing wave on the grid, and how much the tangent leaves its pair of shapes."""
    modes, mass = standing(elements, half_waves), lumped(tube, elements)
    modes = modes[:, np.abs(modes).max(axis=0) > 0.0]  # breathing has no axial part
    matrix = tangent(tube, elements)
    image = matrix @ modes
    image[[1, -1]] = 0.0  # reactions of the ends, which may not move along z
    small = modes.T @ (mass[:, None] * modes)
    stiff = modes.T @ image
    left = image - mass[:, None] * modes @ np.linalg.solve(small, stiff)
    values = np.linalg.eigvals(np.linalg.solve(small, stiff)).real
    return np.sqrt(np.sort(values)), float(np.abs(left).max() / np.abs(image).max())


def small_waves() -> Outcome:
    """Frequencies of the two branches at 32 to 256 cells per wave, for m = 0."""
    checks = []
    for stretch in (1.05, 1.3):
        sizes, slow, fast, leaves = [], [], [], 0.0
        for per_wave in (32, 64, 128, 256):
            wall = wall_constants(per_wave // 2, 1.0, surface_density=1e-3)
            tube = inflated(wall, stretch)
            found, left = grid_frequencies(tube, per_wave // 2, 1)
            exact = tube.frequencies(np.pi)
            sizes.append(1.0 / per_wave)
            slow.append(abs(found[0] / exact[0] - 1.0))
            fast.append(abs(found[1] / exact[1] - 1.0))
            leaves = max(leaves, left)
        name = f"λ₁ = {stretch:g}"
        checks += [
            error(f"slow branch at 64 cells, {name}", slow[1], 1e-3),
            error(f"fast branch at 64 cells, {name}", fast[1], 3e-3),
            order(f"slow branch, {name}", sizes, slow, 2.0),
            order(f"fast branch, {name}", sizes, fast, 2.0),
            error(f"the pair of shapes is exact, {name}", leaves, 1e-10),
        ]
    linear = wall_constants(8, 1.0, passive=PassiveConstants(10.0, 10.0, 3.0, 0.0, 0.0, 0.0, 0.0), surface_density=1e-3)
    free = UniformTube(linear, 0.0, 1.0, 1.0)
    ring, bar = math.sqrt(10.0 / 1e-3) / linear.radius, math.sqrt((10.0 - 0.9) / 1e-3)
    checks += [
        error("limit: ring, ω = √(C/m)/R₀", grid_frequencies(free, 8, 0)[0][-1] / ring - 1.0, 1e-10),
        error("limit: bar, c = √(Eh/m)", free.frequencies(1e-3)[0] / 1e-3 / bar - 1.0, 1e-6),
    ]
    return judged(
        "(mω² − W₁₁k²)(mω² − W₁k²/λ₁ − A) = k²B²",
        checks,
        "Axisymmetric (m = 0), from the assembled tangent of wall and pressure and lumped masses; half a wave of 1 cm.",
    )


def bulging() -> Outcome:
    """Onset of bulging between clamped ends, from both sides, by eigenvalues and by viscous motion."""
    linear = PassiveConstants(10.4, 10.4, 2.59, 0.0, 0.0, 0.0, 0.0)
    elements, length = 160, 8.0
    wall = wall_constants(elements, length, passive=linear)

    free = slice(2, 2 * elements)

    def surplus(pressure: float) -> float:
        """Positive while stable: A + (W_1/lambda_1) k^2 - B^2/W_11 for k = 2 pi/length."""
        tube = inflated(wall, 1.0, pressure)
        w1, _, w11, _, _ = tube.derivatives
        return tube.a + w1 * (2.0 * np.pi / length) ** 2 - tube.b**2 / w11

    def least_eigenvalue(pressure: float) -> float:
        inner = tangent(inflated(wall, 1.0, pressure), elements)[free, free]
        return float(eigvalsh(0.5 * (inner + inner.T), subset_by_index=(0, 0))[0])

    high = 10.4 / wall.radius * 0.53
    critical = float(brentq(surplus, 1.0, high, xtol=1e-12))
    onset = float(brentq(least_eigenvalue, 0.97 * critical, 1.03 * critical, xtol=1e-6))
    checks = [error("pressure at which the tangent turns indefinite, relative", onset / critical - 1.0, 1e-3)]
    for factor, stable in ((0.99, True), (1.01, False)):
        tube = inflated(wall, 1.0, factor * critical)
        least = least_eigenvalue(tube.pressure)
        z = np.linspace(0.0, length, elements + 1)
        straight = wall.radius * tube.circumferential
        rho = straight + 1e-5 * np.sin(2.0 * np.pi * z / length)
        zeta = z.copy()
        before = float(np.abs(rho - straight).max())
        grown = []
        for _ in range(2):
            relax(rho, zeta, tube.pressure, wall, 300.0, 30)
            grown.append(float(np.abs(rho - straight).max()) / before)
        if stable:
            checks.append(Check("least eigenvalue at 0.99 p_cr", least, 1e-12))
            checks.append(Check("disturbance after two spans at 0.99, of the first", grown[1] / grown[0], 0.0, 0.99))
        else:
            checks.append(Check("least eigenvalue at 1.01 p_cr", least, high=-1e-12))
            checks.append(Check("disturbance after two spans at 1.01, of the first", grown[1] / grown[0], 1.01))
    try:
        started({"lumen.pressure": "5 kPa", "wall.c10": "0 mN/cm", "pellet.enabled": False})
        said = 0.0
    except DivergenceError as refused:
        said = float("lumen.pressure = 5 kPa" in str(refused))
    checks.append(Check("a pressure that nothing holds is refused in a sentence", said, 1.0, 1.0))
    return judged(
        "W₁₁(A + (W₁/λ₁)k²) = B², k = 2π/L between clamped ends (k → 0: W₁₁(W₂₂ − W₂/λ₂) = (W₁₂ − W₂/λ₁)²)",
        checks,
        "Eq. (4) without its exponential, which stiffens and does not bulge.",
    )


def end_layer() -> Outcome:
    """Decay from a clamped end, fitted, against the length; the length under the shipped readings."""
    stretch = 1.3
    length = inflated(wall_constants(4, 1.0), stretch).end_layer
    elements = 200
    wall = wall_constants(elements, 20.0 * length)
    tube = inflated(wall, stretch)
    rho = np.full(elements + 1, wall.radius * tube.circumferential)
    zeta = np.linspace(0.0, 20.0 * length * stretch, elements + 1)
    far = rho[0]
    rho[0] *= 1.0 - 1e-4
    settle(rho, zeta, PRESSURE, wall)
    part = slice(10, 50)
    z = np.arange(elements + 1) * wall.element_size
    slope = np.polyfit(z[part], np.log(np.abs(rho - rho[120:180].mean())[part]), 1)[0]
    checks = [
        error("fitted length at h = ℓ/10, relative", -1.0 / slope / length - 1.0, 0.01),
        Check("disturbance of the clamped end [cm]", float(far - rho[0]), 1e-6),
    ]
    for reading, expected in (("tight", 0.014), ("stretched", 0.096)):
        given = shipped(reading)
        passive = PassiveConstants(
            *(float(given[f"wall.{name}"].value) for name in ("c1", "c2", "c3", "c4", "c5", "c6", "c10"))  # type: ignore
        )
        floor = wall_constants(4, 1.0, passive=passive)
        found = inflated(floor, 1.0).end_layer
        checks.append(Check(f"length in {reading} at 0.1 kPa, λ₁ = 1 [cm]", found, 0.93 * expected, 1.07 * expected))
    return judged(
        "ℓ² = (W₁/λ₁)/(A − B²/W₁₁)",
        checks,
        "At the shipped element of 0.0154 cm the passive end layer of `tight` (0.014 cm) is about one element long; "
        "the preflight warns where elements are longer than 1.3 end layers.",
    )


def damped_ring() -> Outcome:
    """Uniform breathing with viscosity: frequency and decay from the assembled matrices; the rod in time."""
    wall = wall_constants(8, 1.0, surface_density=2e-2, viscosity=0.3)
    tube = inflated(wall, 1.2)
    elastic, rated = tangent(tube, 8), tangent(tube, 8, 1.0)
    mode, mass = standing(8, 0)[:, 0], lumped(tube, 8)
    m, c, k = mode @ (mass * mode), mode @ ((rated - elastic) @ mode), mode @ (elastic @ mode)
    found = np.roots([m, c, k])
    natural = math.sqrt(tube.a / wall.surface_density)
    _, w2, _, _, w22 = tube.derivatives
    share = wall.viscosity / (2.0 * wall.radius * math.sqrt(wall.surface_density * (w22 - w2 / tube.circumferential)))
    exact = natural * complex(-share, math.sqrt(1.0 - share**2))
    levels = [8e-3, 4e-3, 2e-3, 1e-3]
    rods = [damped_rod(dt) for dt in levels]
    return judged(
        "mω² + iωκk² − Ck² = 0; ring with ξ = κ/(2R₀√(m(W₂₂ − W₂/λ₂)))",
        [
            error(
                "ring: complex frequency, relative",
                abs(found[0] - exact) / abs(exact) if found[0].imag > 0.0 else abs(found[1] - exact) / abs(exact),
                1e-10,
            ),
            error("rod: logarithmic decrement at 1 ms, relative", rods[-1][1], 5e-3),
            order("rod: amplitude in time", levels, [rod[0] for rod in rods], 2.0),
        ],
        "The rod by the coupled step (2 s of a standing axial wave), against the frequency of its grid.",
    )


LINEAR_ROD = {
    "wall.c1": "40 mN/cm",
    "wall.c3": "0 mN/cm",
    "wall.c10": "0 mN/cm",
    "lumen.pressure": "0 kPa",
    "pellet.enabled": False,
    "grid.n_z": 8,
    "grid.n_z_wall": 32,
}
"""Without pressure, coupling and exponential the tube is a linear Kelvin-Voigt rod along z, clamped at its ends."""


def rod_amplitudes(dt: float, end: float, changes: dict[str, object]) -> Floats:
    """Amplitude of the first axial mode [cm] at every step, by the coupled step; ValueError if it is not one mode."""
    steps = {"step.wall": f"{1e3 * dt} ms", "step.conduction": f"{1e3 * dt / 4} ms", "output.interval": "0.1 s"}
    model, state = started(EXACT, IDLE, LINEAR_ROD, steps, changes)
    shape = np.sin(np.pi * model.grid.nodes / 10.0)
    position = state.wall.position.copy()
    position[:, 0, 2] += 0.05 * shape
    state = moved(state, position)
    amplitudes = [0.05]
    for _ in range(round(end / dt)):
        state, _ = advance(model, state)
        displacement = state.wall.position[:, 0, 2] - model.grid.nodes
        amplitudes.append(float(displacement @ shape / (shape @ shape)))
    bulge = np.abs(state.wall.position[:, 0, 0] - 0.795).max()
    if max(bulge, np.abs(displacement - amplitudes[-1] * shape).max()) > 1e-9:
        raise ValueError("the rod bulges or leaves its mode: it is no linear rod any more")
    return np.array(amplitudes)


def damped_rod(dt: float) -> tuple[float, float]:
    """Error of the amplitude after 2 s [cm] and of the logarithmic decrement (relative)."""
    density, viscosity, h = 20e3, 3.0, 10.0 / 32
    mass = density * 1e-5
    symbol = (2.0 / h * np.sin(0.05 * np.pi * h)) ** 2
    damping = 0.5 * viscosity * symbol / mass
    rate = complex(-damping, np.sqrt(40.0 * symbol / mass - damping**2))
    found = rod_amplitudes(
        dt,
        2.0,
        {
            "wall.inertia": True,
            "wall.surface_density": f"{density} mg/cm^2",
            "wall.viscosity": f"{viscosity} mN*s/cm",
        },
    )
    exact = 0.05 * (np.exp(rate * 2.0) * (1.0 + 1j * rate.real / rate.imag)).real
    peaks = [k for k in range(1, found.size - 1) if abs(found[k]) > max(abs(found[k - 1]), abs(found[k + 1]))]
    heights = [vertex(np.abs(found[k - 1 : k + 2])) for k in peaks]
    decrement = math.log(heights[0] / heights[-1]) / (len(heights) - 1)
    return abs(float(found[-1] - exact)), abs(decrement / (damping * math.pi / rate.imag) - 1.0)


def vertex(three: Floats) -> float:
    """Height of the parabola through three neighbours of a maximum."""
    low, top, high = (float(x) for x in three)
    return top - (high - low) ** 2 / (8.0 * (high - 2.0 * top + low))


def explicit_wall() -> Outcome:
    """The explicit scheme's limit by its dashpots, and steps on either side of the limit of all parts, Eq. (57)."""
    checks = []
    for density in ("26.14 mg/cm^2", "26.14 g/cm^2"):
        changes = {"grid.n_z_wall": 100, "lumen.pressure": "0 kPa", "wall.surface_density": density}
        model, state = started(IDLE, changes, {"solver.integrator": "explicit", "pellet.enabled": False})
        wall, found = model.wall, limits(model, state)
        dashpot = wall.surface_density * wall.element_size**2 / (2.0 * wall.viscosity)
        checks += [
            error(f"dashpot limit, relative, {density}", found.dashpot / dashpot - 1.0, 0.005),
            equal(f"refused at 0.9, {density}", _refused(model, state, 0.9 * found.least), 0.0),
            equal(f"refused at 1.1, {density}", _refused(model, state, 1.1 * found.least), 1.0),
        ]
    return judged("dt ≤ (2/ω_max)(√(1 + ξ²) − ξ) → γ0h²/(2k) where the dashpots rule", checks)


def _refused(model: Model, state: State, dt: float) -> float:
    """1 where a wall step of 100 explicit steps of dt [s] is refused, else 0."""
    if model.explicit is None:
        raise ValueError("the model has no explicit scheme")
    scheme = model.explicit._replace(micro=100)
    try:
        advance(replace(model, dt_wall=100.0 * dt, substeps=1, explicit=scheme), state)
    except DivergenceError:
        return 1.0
    return 0.0


@cache
def gas_run() -> March:
    """The baseline on a small grid over 0.4 s: the ring closes and compresses the lumen."""
    return march(0.4, {"grid.n_z_wall": 200})


def gas() -> Outcome:
    """p V^gamma in a run, its work in closed form, and the stiffness of sealed breathing."""
    taken = gas_run()
    lumen = taken.model.lumen

    def volume(position: Floats) -> float:
        rho, zeta = np.ascontiguousarray(position[:, 0, 0]), np.ascontiguousarray(position[:, 0, 2])
        return lumen_volume(rho, zeta) - taken.model.pellet.volume

    volumes = np.array([volume(s.wall.position) for s in taken.states])
    pressures = np.array([s.pressure for s in taken.states])
    drift = np.ptp(pressures * volumes**1.4) / (pressures * volumes**1.4).mean()
    v0 = lumen.reference_volume
    closed = lumen.pressure * v0 / 0.4 * (1.0 - (v0 / volumes[-1]) ** 0.4)
    quadrature = float(np.trapezoid(pressures, volumes))
    wall = wall_constants(8, 1.0)
    tube = inflated(wall, 1.2)
    rho = np.full(9, wall.radius * tube.circumferential)
    zeta = np.linspace(0.0, 1.2, 9)
    whole = lumen_volume(rho, zeta)

    def radial_force(change: float) -> float:
        """Force on the middle node per h and 2 pi r0 when the sealed tube breathes by `change` [cm]."""
        moved_rho = rho + change
        pressure = PRESSURE * (whole / lumen_volume(moved_rho, zeta)) ** 1.4
        residual, _ = assembled(moved_rho, zeta, wall, pressure=pressure)
        return float(residual[8] / wall.element_size)

    step = 1e-5
    stiffness = (radial_force(step) - radial_force(-step)) / (2.0 * step)
    exact = tube.a + 2.0 * 1.4 * PRESSURE * 1.2 / wall.radius
    return judged(
        "pV^γ = const; work p₀V₀/(γ−1)[1 − (V₀/V)^(γ−1)]; sealed breathing A + 2γpλ₁/R₀",
        [
            error("drift of pV^γ, relative", drift, 1e-12),
            error("work against ∫p dV, relative", quadrature / closed - 1.0, 1e-3),
            Check("largest pressure over p₀", float(pressures.max() / lumen.pressure), 1.02),
            error("frequency of sealed breathing, relative", math.sqrt(stiffness / exact) - 1.0, 1e-3),
        ],
    )


DERIVED = "linearised Eq. (1) on the straight tube"
PROBLEMS = (
    Problem("M5", "Small waves on the pressurised tube, m = 0", DERIVED, "quick", small_waves, (1, 3, 4, 18, 28)),
    Problem(
        "M6",
        "Bulging onset",
        DERIVED + "; Haughton & Ogden, J. Mech. Phys. Solids 27 (1979)",
        "quick",
        bulging,
        (1, 3, 4, 18, 32),
    ),
    Problem("M7", "Static end layer", DERIVED, "quick", end_layer, (1, 3, 4)),
    Problem("M9", "Damped modes", "roots of a quadratic", "quick", damped_ring, (1, 2, 32)),
    Problem("M10", "Explicit step limit of the wall", "von Neumann analysis", "quick", explicit_wall),
    Problem("M11", "Adiabatic gas", "first law; linearised Eq. (17)", "quick", gas, (17, 18, 29)),
)
