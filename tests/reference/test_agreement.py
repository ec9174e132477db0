"""The package against two independent implementations of the same equations: track of the pellet, wall, force.

The quick tier takes a wave that coarse grids resolve: sixteenfold conductivity makes its foot four times as long. The
slow tier takes the baseline. Figures and causes: docs/verification/independent.md.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

import peristalsis as ps
from reference import finite_differences, method_of_lines, mol_stepper
from reference.constants import Constants, load

WIDER = 16.0
HEAVY = 26140.0  # mg/cm^2: the surface density as the paper prints it
SHORT = 0.6  # s


class Track(NamedTuple):
    """Centre of the pellet [cm] over time [s]."""

    time: np.ndarray
    position: np.ndarray


def package(changes: dict[str, Any]) -> tuple[Track, ps.Result]:
    """A run of the package's baseline with some changes."""
    result = ps.run("baseline", changes)
    data = result.dataset
    return Track(data["time_step"].values, data["pellet_position"].values), result


def distance(one: Track, other: Track) -> float:
    """Largest distance of two tracks over the time both have, as a share of the first one's travel."""
    times = np.linspace(0.0, min(one.time[-1], other.time[-1]), 4001)
    apart = np.abs(np.interp(times, *one) - np.interp(times, *other))
    return float(apart.max() / abs(one.position[-1] - one.position[0]))


def wide(**changes: Any) -> Constants:
    """Constants with a longer foot of the wave in both layers."""
    c = load("tight", **changes)
    longer = (layer._replace(diffusivity=WIDER * layer.diffusivity) for layer in (c.longitudinal, c.circular))
    return c._replace(**dict(zip(("longitudinal", "circular"), longer, strict=True)))


def wide_package(elements: int, step: str, **changes: Any) -> Track:
    """The package with the same wave."""
    shipped = ps.configuration("baseline")
    settings = {
        "longitudinal.conductivity_scale": WIDER * shipped.longitudinal.conductivity_scale,
        "circular.conductivity_scale": WIDER * shipped.circular.conductivity_scale,
        "grid.n_z": 500,
        "grid.n_z_wall": elements,
        "step.wall": step,
        "run.duration": f"{SHORT} s",
    }
    return package(settings | changes)[0]


def fields(result: ps.Result) -> tuple[np.ndarray, np.ndarray]:
    """Radius and axial place of the wall at t = 0 [cm]."""
    return result.dataset["radius"].values[0, :, 0], result.dataset["axial_position"].values[0, :, 0]


def test_inflated_wall_around_the_pellet_is_the_same() -> None:
    apart = []
    for n in (100, 400):
        settings = {"grid.n_z": 200, "grid.n_z_wall": n, "run.duration": "0.01 s", "output.interval": "0.005 s"}
        result = package(settings)[1]
        _, wall, _ = mol_stepper.start(load("tight"), n)
        radius, place = fields(result)
        apart.append(max(np.abs(radius - wall.place[:, 0]).max(), np.abs(place - wall.place[:, 1]).max()))
    assert apart[1] < 6e-5  # cm; the pellet stretches the wall by 0.08 cm
    assert apart[0] > 4.0 * apart[1]


def test_cells_rest_at_the_same_potential() -> None:
    short = {"grid.n_z": 200, "grid.n_z_wall": 50, "run.duration": "0.01 s", "output.interval": "0.005 s"}
    c = load("tight")
    # The package reads its rates from tables unless told otherwise.
    for exact, apart in ((True, 1e-9), (False, 1e-5)):
        data = package({**short, "solver.exact_kinetics": exact})[1].dataset
        for layer, name in ((c.longitudinal, "longitudinal"), (c.circular, "circular")):
            shown = data[f"potential_{name}"].values[0, 150, 0]
            lines = method_of_lines.Sheet(c, layer, 10).cells[0, 0]
            explicit = finite_differences.resting(finite_differences.cell_numbers(c, layer))[0]
            assert shown == pytest.approx(lines, abs=apart)
            assert shown == pytest.approx(explicit, abs=apart)


def test_method_of_lines_follows_the_package_and_tells_conventions_apart() -> None:
    run = method_of_lines.run(wide(), method_of_lines.Resolution(200, 500, 2e-3, 0.25), SHORT)
    track = Track(run.time, run.position)
    assert distance(wide_package(400, "2 ms"), track) < 0.008
    assert distance(wide_package(400, "2 ms", **{"wall.tension": "consistent"}), track) > 0.05


def test_explicit_scheme_follows_the_package_with_the_printed_mass() -> None:
    c = wide(surface_density=1e-5 * HEAVY)
    run = finite_differences.run(c, 100, 500, SHORT, 1e6)
    heavy = {"wall.inertia": True, "wall.surface_density": f"{HEAVY} mg/cm^2"}
    assert distance(wide_package(400, "1 ms", **heavy), Track(run.time, run.position)) < 0.008
    assert distance(wide_package(400, "1 ms"), Track(run.time, run.position)) > 0.05


EXPLICIT = {"solver.integrator": "explicit", "wall.surface_density": f"{HEAVY} mg/cm^2", "grid.n_z": 1000}
EXPLICIT |= {"step.conduction": "0.125 ms"}
SPRING = 2e6  # mN/cm^3: the package's contact stiffness


def explicit_pair(elements: int) -> tuple[Track, Track]:
    """The package's explicit scheme and the reference, with the longer foot, on equal grids and steps of 0.25 ms."""
    run = finite_differences.run(wide(surface_density=1e-5 * HEAVY), elements, 1000, SHORT, SPRING, 0.25e-3)
    return wide_package(elements, "0.25 ms", **EXPLICIT), Track(run.time, run.position)


@pytest.mark.slow
def test_two_explicit_schemes_agree_on_a_coarse_wall() -> None:
    """0.1 cm: what is left is each grid's own error, and falls with it (the slow test); a light wall is far off."""
    ours, theirs = explicit_pair(100)
    assert distance(ours, theirs) < 0.015
    assert distance(wide_package(100, "1 ms"), theirs) > 0.05


@pytest.mark.slow
def test_two_explicit_schemes_agree_to_half_a_per_cent() -> None:
    ours, theirs = explicit_pair(200)
    assert distance(ours, theirs) < 0.005


def growth(dt: float) -> float:
    """Factor by which an axial ripple of the speed of a stretched wall grows in 100 explicit steps of `dt` s."""
    c, n = load("tight", published=False), 100
    num = finite_differences.numbers(c, c.length / n, 1e6)
    still, idle, idle_nodes = np.zeros(n + 1), np.zeros(n), np.zeros(n + 1)
    ends = []
    for size in (0.0, 1e-6):
        radius, place = np.full(n + 1, 1.05 * c.radius), 1.1 * np.linspace(0.0, c.length, n + 1)
        speed = size * (-1.0) ** np.arange(n + 1)
        speed[[0, -1]] = 0.0
        finite_differences.bioshell(
            radius, place, still.copy(), speed, 5.0, idle, idle, idle_nodes, idle_nodes, num, dt, 100
        )
        ends.append(speed)
    return float(np.abs(ends[1] - ends[0]).max() / 1e-6)


def test_explicit_scheme_is_bounded_by_the_dashpot() -> None:
    """Below γ0 Δs²/(2k) a ripple of a stretched wall decays, beyond it it grows."""
    limit = finite_differences.dashpot_limit(26.14e-5, 0.1, 33.3)
    assert limit == pytest.approx(3.92e-8, rel=0.01)
    assert growth(0.9 * limit) < 0.01
    assert growth(1.1 * limit) > 1000.0


BASELINE = {"grid.n_z": 2000, "grid.n_z_wall": 1600, "step.wall": "1 ms", "step.conduction": "0.125 ms"}


@pytest.mark.slow
@pytest.mark.parametrize("tension", ["published", "consistent"])
def test_baseline_by_the_method_of_lines(tension: str) -> None:
    track, result = package({**BASELINE, "wall.tension": tension})
    c = load("tight", published=tension == "published")
    run = method_of_lines.run(c, method_of_lines.Resolution(800, 4000, 1e-3, 0.25))
    assert distance(track, Track(run.time, run.position)) < 0.005
    assert run.expelled == pytest.approx(result.summary["transit_s"], rel=0.005)
    assert run.force.max() == pytest.approx(result.summary["max_axial_force_mN"], rel=0.005)


@pytest.mark.slow
def test_baseline_by_the_method_of_lines_converges() -> None:
    track, _ = package(BASELINE)
    apart = []
    for n in (200, 400):
        run = method_of_lines.run(load("tight"), method_of_lines.Resolution(n, 2000, 1e-3, 0.1))
        apart.append(distance(track, Track(run.time, run.position)))
    assert apart[0] < 0.05
    assert apart[1] < 0.01
    assert apart[0] > 2.5 * apart[1]


@pytest.mark.slow
def test_baseline_by_the_packages_explicit_scheme() -> None:
    """Its error on coarse walls is that of its elements, which it shares with the implicit wall, and falls alike."""
    heavy = {"wall.surface_density": f"{HEAVY} mg/cm^2", "step.wall": "1 ms", "step.conduction": "0.125 ms"}
    track, _ = package({**BASELINE, **heavy, "wall.inertia": True})
    apart = []
    for n in (100, 200):
        same = heavy | {"grid.n_z": 2000, "grid.n_z_wall": n}
        ours, _ = package(same | {"solver.integrator": "explicit"})
        implicit, _ = package(same | {"wall.inertia": True})
        assert distance(ours, implicit) < 0.01
        apart.append(distance(track, ours))
    assert apart[0] < 0.18
    assert apart[1] < 0.6 * apart[0]


@pytest.mark.slow
def test_baseline_by_the_explicit_scheme_with_the_printed_mass() -> None:
    """Coarse walls are all that an explicit scheme affords: its error is its own, and falls with the grid."""
    heavy = {"wall.inertia": True, "wall.surface_density": f"{HEAVY} mg/cm^2"}
    track, _ = package({**BASELINE, **heavy})
    apart = []
    for n in (100, 200):
        run = finite_differences.run(load("tight", surface_density=1e-5 * HEAVY), n, 2000, 10.0, 1e6)
        apart.append(distance(track, Track(run.time, run.position)))
    assert apart[0] < 0.12
    assert apart[1] < 0.035
    assert apart[0] > 2.5 * apart[1]
