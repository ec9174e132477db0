"""The algorithm of the source paper's flow chart: explicit finite differences of second order, inertia kept.

Procedures carry the paper's names: EXCLONG and EXCCIRC advance the depolarisation of a layer, BIOSHELL the wall,
TRSOLID the sphere, OUTPRN keeps results. All steps are Heun's; the wall's is bounded by its dashpot, γ0 Δs²/(2k), so
grids are coarse or the wall is heavy. Contact is a penalty. Shares no code with the package; see
docs/verification/independent.md. As a program, from the folder tests: python -m reference.finite_differences --help.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import brentq

from reference.constants import Constants, Layer, load

SAFETY = 0.6  # of the dashpot limit; published tensions raise the viscosity by the stretch over the pellet
RELAXATION_DENSITY = 0.26  # [mN s^2/cm^3] the initial state is static: any mass and viscosity lead to it
RELAXATION_VISCOSITY = 3.0  # [mN s/cm]
RELAXATION_TIME = 2.0  # [s]
LARGEST_CONDUCTION_STEP = 0.1  # [ms]


class Numbers(NamedTuple):
    """Constants of BIOSHELL and TRSOLID."""

    h: float
    r0: float
    density: float
    k: float
    elastic: tuple[float, float, float, float, float, float, float]  # c1 c2 c3 c4 c5 c6 c10
    long: tuple[float, float, float]
    circ: tuple[float, float, float]
    published: bool
    slack: tuple[float, float, float, float]  # blend, slope, fold stretch, fold tension
    bend: tuple[float, float]
    gas: tuple[float, float, float]  # p0, V0, exponent
    radius: float
    penalty: float
    friction: tuple[float, float]
    held: bool


@njit(cache=True)
def exc(
    fields: np.ndarray, spread: np.ndarray, source: np.ndarray, leak: np.ndarray, cell: np.ndarray, out: np.ndarray
):
    """Right sides [1/ms] of one layer's V, h, n, x, c; `spread` is d/Δ² between the grid points, ends are sealed."""
    kappa, capacitance = cell[0], cell[1]
    g_fast, g_slow, g_k, g_kca, g_cl = cell[2], cell[3], cell[4], cell[5], cell[6]
    v_ca, v_k, v_cl, c_half, c_rate, c_in, c_v, gate, slow = (
        cell[7], cell[8], cell[9], cell[10], cell[11], cell[12], cell[13], cell[14], cell[15],
    )  # fmt: skip
    last = fields.shape[1] - 1
    for j in range(last + 1):
        v, h, n, x, c = fields[0, j], fields[1, j], fields[2, j], fields[3, j], fields[4, j]
        u = (127.0 * v + 8265.0) / 105.0
        a, b = 50.0 - u, 55.0 - u
        alpha_m = 0.1 * a / (np.exp(0.1 * a) - 1.0) if abs(a) > 1e-6 else 1.0
        alpha_n = 0.01 * b / (np.exp(0.1 * b) - 1.0) if abs(b) > 1e-6 else 0.1
        beta_m = 4.0 * np.exp((25.0 - u) / 18.0)
        alpha_h = 0.07 * np.exp((25.0 - u) / 20.0)
        beta_h = 1.0 / (1.0 + np.exp(0.1 * b))
        beta_n = 0.125 * np.exp((45.0 - u) / 80.0)
        m = alpha_m / (alpha_m + beta_m)
        ionic = g_fast * m**3 * h * (v - v_ca) + g_slow * x * (v - v_ca) + g_k * n**4 * (v - v_k)
        ionic += g_kca * c / (c_half + c) * (v - v_k) + g_cl * (v - v_cl)
        flow = 0.0
        if j == 0:
            flow = 2.0 * spread[0] * (fields[0, 1] - v)
        elif j == last:
            flow = 2.0 * spread[last - 1] * (fields[0, last - 1] - v)
        else:
            flow = spread[j] * (fields[0, j + 1] - v) - spread[j - 1] * (v - fields[0, j - 1])
        out[0, j] = flow + (source[j] - kappa * ionic - leak[j] * (v - v_k)) / capacitance
        out[1, j] = kappa * (alpha_h * (1.0 - h) - beta_h * h) / gate
        out[2, j] = kappa * (alpha_n * (1.0 - n) - beta_n * n) / gate
        out[3, j] = kappa * (1.0 / (1.0 + np.exp(-0.15 * (v + 50.0))) - x) / slow
        out[4, j] = kappa * c_rate * (c_in * x * (c_v - v) - c)


@njit(cache=True)
def exclong(fields, spread, source, leak, cell, dt, steps):
    """Heun's method on one layer, `steps` steps of `dt` ms, in place. EXCCIRC is the same with its own numbers."""
    first, second = np.empty_like(fields), np.empty_like(fields)
    for _ in range(steps):
        exc(fields, spread, source, leak, cell, first)
        exc(fields + dt * first, spread, source, leak, cell, second)
        fields += 0.5 * dt * (first + second)


exccirc = exclong


@njit(cache=True)
def limited(elastic: float, rest: float, stretch: float, slack) -> float:
    """Elastic part and the rest together, without compression: (14), (15), (36)."""
    b, slope, fold, stiff = slack
    x = elastic / b
    if x < -1.0:
        elastic = 0.0
    elif x < 1.0:
        elastic = b * (0.1875 + x * (0.5 + x * (0.375 - 0.0625 * x * x)))
    total = elastic + rest
    x = total / b
    kept = total
    if x < -1.0:
        kept = 0.0
    elif x < 1.0:
        kept = b * (0.1875 + x * (0.5 + x * (0.375 - 0.0625 * x * x)))
    total = slope * total + (1.0 - slope) * kept
    if stretch < fold:
        total -= stiff * (fold / stretch - 1.0) ** 2
    return total


@njit(cache=True)
def trsolid(r, z, lam, centre, q, num):
    """Contact pressures per undeformed area by the penalty, (28) with Q̄ = 0; the sphere's velocity (27), F_z [mN]."""
    force = 0.0
    touched = False
    for i in range(1, r.shape[0] - 1):
        distance = np.sqrt(r[i] * r[i] + (z[i] - centre) ** 2)
        q[i] = num.penalty * max(0.0, num.radius - distance) * lam[i] * r[i] / num.r0
        if q[i] > 0.0:
            touched = True
            force -= q[i] * (z[i] - centre) / distance
    force *= 2.0 * np.pi * num.r0 * num.h
    eta, dry = num.friction
    if num.held or not touched or abs(force) <= dry:
        return 0.0, force
    return np.sign(force) * (abs(force) - dry) / eta, force


@njit(cache=True)
def forces(r, z, vr, vz, centre, drive_l, drive_c, num, ar, az, q, lam):
    """Accelerations of the inner nodes from (1); velocity of the sphere, F_z and p."""
    last = r.shape[0] - 1
    h, r0, k = num.h, num.r0, num.k
    c1, c2, c3, c4, c5, c6, c10 = num.elastic
    volume = 0.0
    for i in range(last):
        volume += (z[i + 1] - z[i]) * (r[i] * r[i] + r[i] * r[i + 1] + r[i + 1] * r[i + 1])
    volume = np.pi / 3.0 * volume - 4.0 / 3.0 * np.pi * num.radius**3
    p0, v0, exponent = num.gas
    p = p0 * (v0 / volume) ** exponent if exponent > 0.0 else p0
    for i in range(1, last):
        lam[i] = np.sqrt((r[i + 1] - r[i - 1]) ** 2 + (z[i + 1] - z[i - 1]) ** 2) / (2.0 * h)
    speed, force = trsolid(r, z, lam, centre, q, num)
    for i in range(last + 1):
        ar[i] = 0.0
        az[i] = 0.0
    for i in range(last):
        dr, dz = (r[i + 1] - r[i]) / h, (z[i + 1] - z[i]) / h
        stretch = np.sqrt(dr * dr + dz * dz)
        around = 0.5 * (r[i] + r[i + 1]) / r0
        el, ec = stretch - 1.0, around - 1.0
        grown = 2.0 * c10 * np.exp(c4 * el * el + c5 * ec * ec + 2.0 * c6 * el * ec)
        elastic = c1 * el + c3 * ec + grown * (c4 * el + c6 * ec)
        rate = (dr * (vr[i + 1] - vr[i]) + dz * (vz[i + 1] - vz[i])) / (h * stretch)
        pull = drive_l[i] * max(0.0, num.long[0] * stretch * stretch + num.long[1] * stretch + num.long[2])
        tension = limited(elastic, pull + k * rate, stretch, num.slack)
        if num.published:
            tension *= around
        tr, tz = tension * dr / stretch / h, tension * dz / stretch / h
        ar[i] += tr
        az[i] += tz
        ar[i + 1] -= tr
        az[i + 1] -= tz
    for i in range(1, last):
        around = r[i] / r0
        el, ec = lam[i] - 1.0, around - 1.0
        grown = 2.0 * c10 * np.exp(c4 * el * el + c5 * ec * ec + 2.0 * c6 * el * ec)
        elastic = c2 * ec + c3 * el + grown * (c5 * ec + c6 * el)
        pull = drive_c[i] * max(0.0, num.circ[0] * around * around + num.circ[1] * around + num.circ[2])
        tension = limited(elastic, pull + k * vr[i] / r0, around, num.slack)
        if num.published:
            tension *= lam[i]
        slope_r, slope_z = (r[i + 1] - r[i - 1]) / (2.0 * h), (z[i + 1] - z[i - 1]) / (2.0 * h)
        ar[i] += p * around * slope_z - tension / r0
        az[i] -= p * around * slope_r
        if q[i] > 0.0:
            distance = np.sqrt(r[i] * r[i] + (z[i] - centre) ** 2)
            ar[i] += q[i] * r[i] / distance
            az[i] += q[i] * (z[i] - centre) / distance
        stiff, thick = num.bend[0] / h**4, num.bend[1] / h**4
        mr = stiff * (r[i - 1] - 2.0 * r[i] + r[i + 1]) + thick * (vr[i - 1] - 2.0 * vr[i] + vr[i + 1])
        mz = stiff * (z[i - 1] - 2.0 * z[i] + z[i + 1]) + thick * (vz[i - 1] - 2.0 * vz[i] + vz[i + 1])
        ar[i - 1] -= mr
        ar[i] += 2.0 * mr
        ar[i + 1] -= mr
        az[i - 1] -= mz
        az[i] += 2.0 * mz
        az[i + 1] -= mz
    for i in range(1, last):
        ar[i] /= num.density
        az[i] /= num.density
    ar[0] = ar[last] = az[0] = az[last] = 0.0
    return speed, force, p


@njit(cache=True)
def bioshell(r, z, vr, vz, centre, l0, l1, c0, c1, num, dt, steps):
    """Heun's method on wall and sphere, `steps` steps of `dt` s, in place; drives linear from (l0, c0) to (l1, c1).

    Returns the centre of the sphere, F_z and p of the last evaluation, and the contact pressures.
    """
    n = r.shape[0]
    a0r, a0z, a1r, a1z = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    q, lam = np.zeros(n), np.ones(n)
    force = p = 0.0
    for step in range(steps):
        w = step / steps
        s0, _, _ = forces(r, z, vr, vz, centre, l0 + w * (l1 - l0), c0 + w * (c1 - c0), num, a0r, a0z, q, lam)
        r1, z1 = r + dt * vr, z + dt * vz
        v1r, v1z = vr + dt * a0r, vz + dt * a0z
        w = (step + 1) / steps
        s1, force, p = forces(
            r1, z1, v1r, v1z, centre + dt * s0, l0 + w * (l1 - l0), c0 + w * (c1 - c0), num, a1r, a1z, q, lam
        )
        r += 0.5 * dt * (vr + v1r)
        z += 0.5 * dt * (vz + v1z)
        vr += 0.5 * dt * (a0r + a1r)
        vz += 0.5 * dt * (a0z + a1z)
        centre += 0.5 * dt * (s0 + s1)
    return centre, force, p, q


@dataclass
class Output:
    """OUTPRN: what is kept of a run."""

    time: np.ndarray
    position: np.ndarray
    force: np.ndarray
    pressure: np.ndarray
    radius: np.ndarray
    expelled: float | None
    wall_steps: int
    wall_step: float
    wall_seconds: float  # of the processor, in BIOSHELL
    seconds: float


def outprn(rows, radius, expelled, steps, dt, wall_seconds, seconds) -> Output:
    """Results as arrays."""
    return Output(*np.array(rows).T, radius, expelled, steps, dt, wall_seconds, seconds)


def dashpot_limit(density: float, h: float, k: float) -> float:
    """Largest stable explicit step [s] of a wall of intervals h: γ0 h²/(2k)."""
    return density * h * h / (2.0 * k)


def resting(cell: np.ndarray) -> np.ndarray:
    """Lowest steady state of a cell: V, h, n, x, c (23)."""
    spread, none = np.zeros(1), np.zeros(2)

    def rates(fields: np.ndarray) -> np.ndarray:
        both, out = np.column_stack([fields, fields]), np.empty((5, 2))
        exc(both, spread, none, none, cell, out)
        return out[:, 0]

    def steady(v: float) -> np.ndarray:
        zero, one = rates(np.array([v, 0.0, 0.0, 0.0, 0.0])), rates(np.array([v, 1.0, 1.0, 1.0, 0.0]))
        gates = zero[1:4] / (zero[1:4] - one[1:4])
        return np.array([v, *gates, cell[12] * gates[2] * (cell[13] - v)])

    low = -74.0
    while rates(steady(low))[0] * rates(steady(low + 0.05))[0] > 0.0:
        low += 0.05
    return steady(brentq(lambda v: rates(steady(v))[0], low, low + 0.05, xtol=1e-12))


def cell_numbers(c: Constants, layer: Layer) -> np.ndarray:
    """The numbers of `exc`."""
    return np.array([
        c.kinetics, c.capacitance, layer.fast, layer.slow, layer.potassium, layer.calcium_potassium, layer.leak,
        c.reversal_calcium, c.reversal_potassium, c.reversal_leak, c.half_saturation, c.calcium_rate, c.calcium_influx,
        c.calcium_entry, c.gate_factor, c.slow_time,
    ])  # fmt: skip


def numbers(c: Constants, h: float, penalty: float) -> Numbers:
    """Wall and sphere as they stand before the sphere is there: pressure and sphere held."""
    return Numbers(
        h, c.radius, c.surface_density, c.viscosity, (c.c1, c.c2, c.c3, c.c4, c.c5, c.c6, c.c10),
        c.longitudinal[:3], c.circular[:3], c.published, (c.blend, c.slope, c.fold_stretch, c.fold_tension),
        (c.bending, c.bending_viscosity), (c.pressure, 1.0, 0.0), 0.0, penalty,
        (c.viscous_friction, c.dry_friction), True,
    )  # fmt: skip


def run(
    c: Constants,
    wall: int = 100,
    points: int = 2000,
    duration: float = 10.0,
    penalty: float = 1.0e6,
    output_step: float = 1.0e-3,
) -> Output:
    """The main program: initial state, then steps of `output_step` s in which all procedures are called in turn."""
    clock = time.perf_counter()
    h = c.length / wall
    s = np.linspace(0.0, c.length, wall + 1)
    r, z = np.full(wall + 1, c.radius), s.copy()
    vr, vz = np.zeros(wall + 1), np.zeros(wall + 1)
    centre = c.start_gap + c.pellet_radius
    num = numbers(c, h, penalty)._replace(density=RELAXATION_DENSITY, k=RELAXATION_VISCOSITY)
    no_l, no_c = np.zeros(wall), np.zeros(wall + 1)

    def relax(num: Numbers, seconds: float) -> None:
        steps = int(np.ceil(seconds / (0.5 * min(dashpot_limit(num.density, h, num.k), 0.02 * h))))
        bioshell(r, z, vr, vz, centre, no_l, no_l, no_c, no_c, num, seconds / steps, steps)

    relax(num, RELAXATION_TIME)
    free = r.copy()
    for radius in np.linspace(0.8, 1.0, 21) * c.pellet_radius:
        num = num._replace(radius=float(radius))
        relax(num, RELAXATION_TIME / 40)
    relax(num, RELAXATION_TIME)
    vr[:], vz[:] = 0.0, 0.0
    squares = r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2
    volume = np.pi / 3.0 * float(np.sum(np.diff(z) * squares)) - 4.0 / 3.0 * np.pi * c.pellet_radius**3
    num = num._replace(density=c.surface_density, k=c.viscosity, gas=(c.pressure, volume, c.exponent), held=False)
    steps = int(np.ceil(output_step / (SAFETY * dashpot_limit(c.surface_density, h, c.viscosity))))

    gap = c.length / points
    at = np.linspace(0.0, c.length, points + 1)
    between = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[0.0], between, [c.length]])
    faces = 0.5 * (s[1:] + s[:-1])
    bounds = np.concatenate([[0.0], faces, [c.length]])
    layers = (c.longitudinal, c.circular)
    cells = [cell_numbers(c, layer) for layer in layers]
    fields = [np.tile(resting(cell)[:, None], (1, points + 1)) for cell in cells]

    def mean(values: np.ndarray, ends: np.ndarray) -> np.ndarray:
        whole = np.interp(ends, edges, np.concatenate([[0.0], np.cumsum(values * np.diff(edges))]))
        return np.diff(whole) / np.diff(ends)

    def pull(layer: int) -> np.ndarray:
        return np.maximum(fields[layer][0] - layers[layer].threshold, 0.0)

    onset = np.full(points + 1, -np.inf)
    active, earlier = np.zeros(points + 1), np.zeros(points + 1)
    discharged = -np.inf
    reach: list[
        tuple[float, float, float, float, float, float]
    ] = []  # first, last [cm], begin, end [s], current, shunt
    old_l, old_c = no_l, no_c
    stretch = np.hypot(np.diff(r), np.diff(z)) / h
    rows = [(0.0, centre, 0.0, c.pressure)]
    expelled, wall_seconds, total = None, 0.0, 0
    for index in range(round(duration / output_step)):
        t, later = index * output_step, (index + 1) * output_step

        def share(begin, end, t=t, later=later):
            return np.clip(np.minimum(end, later) - np.maximum(begin, t), 0.0, None) / (later - t)

        source = [np.zeros(points + 1), np.zeros(points + 1)]
        leak = [np.zeros(points + 1), np.zeros(points + 1)]
        source[0][at <= c.pacemaker_width] += c.pacemaker_intensity * share(0.0, c.pacemaker_duration)
        source[1] += c.trigger_intensity * share(onset, onset + c.trigger_duration)
        for first, last, begin, end, current, shunt in reach:
            inside = (at >= first) & (at <= last)
            source[1][inside] += current * share(begin, end)
            leak[1][inside] += shunt * share(begin, end)
        for i, advance in enumerate((exclong, exccirc)):
            spread = layers[i].diffusivity / np.interp(between, faces, stretch) / gap**2
            largest = min(LARGEST_CONDUCTION_STEP, 0.4 / spread.max())
            inner = int(np.ceil(1e3 * output_step / largest))
            advance(fields[i], spread, source[i], leak[i], cells[i], 1e3 * output_step / inner, inner)
        new_l, new_c = mean(pull(0), s), mean(pull(1), bounds)
        before = centre
        tick = time.process_time()
        centre, force, p, q = bioshell(
            r, z, vr, vz, centre, old_l, new_l, old_c, new_c, num, output_step / steps, steps
        )
        wall_seconds += time.process_time() - tick
        total += steps
        if not np.isfinite(r).all():
            raise FloatingPointError(f"the wall left its bounds at {t:.4f} s")
        old_l, old_c = new_l, new_c
        stretch = np.hypot(np.diff(r), np.diff(z)) / h
        long = layers[0]
        local = np.interp(at, faces, stretch)
        value = pull(0) * np.maximum(0.0, (long.c7 * local + long.c8) * local + long.c9)
        passed = (active > earlier) & (value < active) & (active > c.trigger_level)
        onset[passed & (later - onset >= c.trigger_refractory)] = later
        earlier, active = active, value
        wide = (q > 0.0) & (r > c.reflex_threshold * free)
        if c.reflex and wide.any() and later - discharged >= c.reflex_refractory:
            discharged = later
            oral, anal = s[wide][[0, -1]]
            begin = later + c.reflex_delay
            reach.append((oral - c.oral_length, oral, begin, begin + c.excitation_duration, c.excitation, 0.0))
            reach.append((anal, anal + c.anal_length, begin, begin + c.inhibition_duration, 0.0, c.inhibition))
        rows.append((later, centre, force, p))
        if centre + c.pellet_radius >= c.length:
            expelled = t + output_step * (c.length - c.pellet_radius - before) / (centre - before)
            break
    return outprn(rows, r, expelled, total, output_step / steps, wall_seconds, time.perf_counter() - clock)


def main() -> None:
    """Command line: one run, its transit, its cost and, on request, its track in a file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reading", default="tight")
    parser.add_argument("--consistent", action="store_true", help="tension per undeformed length (35)")
    parser.add_argument("--no-reflex", action="store_true")
    parser.add_argument("--wall", type=int, default=100, help="intervals of the wall")
    parser.add_argument("--points", type=int, default=2000, help="intervals of the sheets")
    parser.add_argument("--density", type=float, default=26140.0, help="wall mass per area, mg/cm^2; printed 26140")
    parser.add_argument("--penalty", type=float, default=1e6, help="contact stiffness, mN/cm^3")
    parser.add_argument("--output-step", type=float, default=1.0, help="coupling and output, ms")
    parser.add_argument("--duration", type=float, default=10.0, help="s")
    parser.add_argument("--out", help="file for the track (.npz)")
    a = parser.parse_args()
    c = load(a.reading, published=not a.consistent, reflex=not a.no_reflex, surface_density=1e-5 * a.density)
    o = run(c, a.wall, a.points, a.duration, a.penalty, 1e-3 * a.output_step)
    print(
        f"transit {o.expelled} s; {o.wall_steps} wall steps of {o.wall_step:.2e} s, "
        f"{1e6 * o.wall_seconds / o.wall_steps:.2f} µs each; {o.seconds:.1f} s on the clock"
    )
    if a.out:
        np.savez(a.out, **{key: value for key, value in vars(o).items() if value is not None})


if __name__ == "__main__":
    main()
