"""Every shape of the pellet: gap, normal, curvatures, volume and size, against what they are derivatives or sums of.

A new file in the folder is tested by being there; numbers besides its own stand in SIZES.
"""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from peristalsis.inputs.parts import find, parts
from peristalsis.inputs.shape import NEEDED, SLOT, PelletShape
from peristalsis.numerics.binding import SHIPPED, bind
from peristalsis.pellet.shapes import capsule, sphere, spheroid, stool

Floats = NDArray[np.float64]

SIZES: dict[str, list[tuple[float, ...]]] = {
    "spheroid": [(0.9, 0.7), (0.9, 1.0), (0.9, 1.5), (0.55, 4.0)],
    "capsule": [(0.55, 2.6), (0.9, 1.9), (0.9, 1.8)],
    "stool": [(0.9, 1.8, 2.5), (0.9, 0.6, 2.0), (0.7, 1.5, 6.0)],
}
STEP = 1e-6


def bodies() -> list[Any]:
    """Every shape that the package ships, with its own numbers and with more."""
    found = []
    for name, part in parts("shape").items():
        if part.origin == "peristalsis":
            own = (0.9, *(one.value for one in part.parameters))
            found += [pytest.param((name, size), id=f"{name}-{size}") for size in (own, *SIZES.get(name, []))]
    return found


def kernels(name: str) -> ModuleType:
    """The shape's file, in the slot."""
    return bind({SLOT: find("shape", name).file}).module(SLOT)


@pytest.fixture(params=bodies())
def body(request: pytest.FixtureRequest) -> tuple[ModuleType, Any]:
    """A shape's file and constants."""
    name, size = request.param
    shape = kernels(name)
    return shape, shape.ShapeConstants(*size)


def meridian(shape: ModuleType, constants: Any, count: int = 4001) -> tuple[Floats, Floats]:
    """(rho, axial) from pole to pole, dense at them and where the profile falls steeply."""
    turn = np.linspace(0.0, np.pi, count)
    fine = np.concatenate([np.cos(turn), 1.0 - np.geomspace(1e-14, 1e-2, 400), np.geomspace(1e-14, 1e-2, 400) - 1.0])
    share = np.unique(fine)
    oral, anal = shape.poles(constants)
    axial = 0.5 * (anal - oral) + 0.5 * (anal + oral) * share
    return shape.profile(axial, constants), axial


def points(shape: ModuleType, constants: Any, count: int, deepest: float) -> Floats:
    """Points (rho, axial) from `deepest` of the body's own size to twice it, some on the axis and on the equator."""
    rng = np.random.default_rng(4)
    rho, axial = meridian(shape, constants)
    chosen = rng.integers(0, rho.size, count)
    size = rng.uniform(deepest, 2.0, count)
    found = np.column_stack([size * rho[chosen], size * axial[chosen]])
    found[::9, 0] = 10.0 ** rng.uniform(-14, -3, found[::9, 0].size)
    found[1::9, 1] = 10.0 ** rng.uniform(-14, -3, found[1::9, 1].size)
    return found


def kinks(shape: ModuleType, constants: Any, place: Floats) -> bool:
    """Whether a point is beside a jump of the curvature: the capsule's, where its caps begin."""
    return shape.NAME == "capsule" and abs(abs(place[1]) - (0.5 * constants.length - constants.radius)) < 1e-3


def test_a_shape_defines_what_is_asked_of_it(body: tuple[ModuleType, Any]) -> None:
    shape, constants = body
    assert all(hasattr(shape, name) for name in NEEDED)
    assert constants._fields == ("radius", *(one.name for one in shape.PARAMETERS))
    assert shape.unpack_shape(np.array([*constants, 99.0])) == constants
    assert shape.refusal(constants) == ""


def test_gap_is_the_distance_from_the_meridian(body: tuple[ModuleType, Any]) -> None:
    """Inside, on the axis and on the equator too; signed by the similar body through the point."""
    shape, constants = body
    rho, axial = meridian(shape, constants)
    reached = 0.0
    for r, z in points(shape, constants, 150, 0.02):
        near = int(np.argmin((rho - r) ** 2 + (axial - z) ** 2))
        fine = np.linspace(axial[max(near - 1, 0)], axial[min(near + 1, axial.size - 1)], 2001)
        distance = float(np.sqrt((shape.profile(fine, constants) - r) ** 2 + (fine - z) ** 2).min())
        sign = 1.0 if shape.reach(r, z, constants) > constants.radius else -1.0
        reached = max(reached, abs(shape.gap_and_normal(r, z, constants)[0] - sign * distance))
    assert reached < 5e-6


def test_gap_vanishes_on_the_profile_and_at_the_poles(body: tuple[ModuleType, Any]) -> None:
    shape, constants = body
    rho, axial = meridian(shape, constants)
    gaps = [shape.gap_and_normal(r, z, constants)[0] for r, z in zip(rho, axial, strict=True) if r > 0.0]
    assert np.abs(gaps).max() < 1e-9
    oral, anal = shape.poles(constants)
    for pole, way in ((-oral, -1.0), (anal, 1.0)):
        gap, nr, nz, *_ = shape.gap_and_normal(0.0, pole, constants)
        assert (gap, nr, nz) == (pytest.approx(0.0, abs=1e-14), pytest.approx(0.0, abs=1e-14), pytest.approx(way))
    assert rho.max() == pytest.approx(constants.radius, rel=1e-6)


def test_normal_and_curvatures_are_derivatives_of_the_gap(body: tuple[ModuleType, Any]) -> None:
    """Central differences, Eqs. (70) and (71): along the meridian and around the axis; the normal has length one."""
    shape, constants = body

    def ask(r: float, z: float) -> Floats:
        return np.array(shape.gap_and_normal(r, z, constants))

    for r, z in points(shape, constants, 60, 0.9):
        gap, nr, nz, bend, hoop = ask(r, z)
        assert np.hypot(nr, nz) == pytest.approx(1.0, rel=1e-14)
        if r < 1e-2 or abs(z) < 1e-2 or kinks(shape, constants, np.array([r, z])):
            continue
        assert (ask(r + STEP, z)[0] - ask(r - STEP, z)[0]) / (2.0 * STEP) == pytest.approx(nr, abs=1e-8)
        assert (ask(r, z + STEP)[0] - ask(r, z - STEP)[0]) / (2.0 * STEP) == pytest.approx(nz, abs=1e-8)
        ahead, behind = ask(r - STEP * nz, z + STEP * nr), ask(r + STEP * nz, z - STEP * nr)
        turning = (ahead[1:3] - behind[1:3]) @ np.array([-nz, nr]) / (2.0 * STEP)
        assert turning == pytest.approx(1.0 / bend, rel=1e-5, abs=1e-6)
        assert r / nr == pytest.approx(hoop, rel=1e-9), "around the axis the normal turns by n_rho/rho"
        further = ask(r + 0.1 * nr, z + 0.1 * nz)
        assert further[0] == pytest.approx(gap + 0.1, rel=1e-12, abs=1e-12)
        assert further[1:3] == pytest.approx([nr, nz], abs=1e-9)
        assert further[3:] == pytest.approx([bend + 0.1, hoop + 0.1], rel=1e-6)


def test_volume_is_that_of_the_profile(body: tuple[ModuleType, Any]) -> None:
    shape, constants = body
    oral, anal = shape.poles(constants)
    nodes, weights = np.polynomial.legendre.leggauss(2000)
    axial = 0.5 * (anal - oral) + 0.5 * (anal + oral) * nodes
    quadrature = np.pi * 0.5 * (anal + oral) * float(weights @ shape.profile(axial, constants) ** 2)
    assert shape.volume(constants) == pytest.approx(quadrature, rel=1e-6)


def test_similar_bodies(body: tuple[ModuleType, Any]) -> None:
    """Eq. (72): all lengths in proportion; the similar body that reaches a point has it on its surface."""
    shape, constants = body
    half = shape.resized(constants, 0.5 * constants.radius)
    assert shape.poles(half) == pytest.approx(0.5 * np.array(shape.poles(constants)), rel=1e-14)
    assert shape.volume(half) == pytest.approx(0.125 * shape.volume(constants), rel=1e-12)
    for r, z in points(shape, constants, 60, 0.1):
        own = shape.reach(r, z, constants)
        assert shape.gap_and_normal(r, z, shape.resized(constants, own))[0] == pytest.approx(0.0, abs=1e-12)
        assert shape.reach(2.0 * r, 2.0 * z, constants) == pytest.approx(2.0 * own, rel=1e-12)
        assert shape.reach(r, z, half) == pytest.approx(own, rel=1e-12)


@pytest.mark.parametrize(
    ("other", "size", "same", "like"),
    [
        (spheroid, (0.9, 1.0), sphere, (0.9,)),
        (capsule, (0.9, 1.8), sphere, (0.9,)),
        (stool, (0.9, 1.5, 2.0), spheroid, (0.9, 1.5)),
        (stool, (0.9, 0.7, 2.0), spheroid, (0.9, 0.7)),
    ],
)
def test_shapes_that_are_one_another(other: Any, size: Any, same: Any, like: Any) -> None:
    """Sphere, spheroid and superellipse are found in three ways: they agree to rounding."""
    one, two = other.ShapeConstants(*size), same.ShapeConstants(*like)
    assert other.volume(one) == pytest.approx(same.volume(two), rel=1e-14)
    for r, z in points(same, two, 200, 0.9):
        assert other.gap_and_normal(r, z, one) == pytest.approx(same.gap_and_normal(r, z, two), rel=1e-11, abs=1e-12)


def test_the_foot_on_a_superellipse_takes_few_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    """A last step that rounding puts beside the bounds is the end, and not the beginning of 45 bisections."""
    asked: list[float] = []
    evaluate = stool._meridian
    monkeypatch.setattr(stool, "_meridian", lambda v, shape: (asked.append(v), evaluate(v, shape))[1])
    size = stool.ShapeConstants(0.9, 1.5, 3.0)
    counts = []
    for r, z in zip(np.linspace(0.7, 0.95, 40), np.linspace(1.6, 3.0, 40), strict=True):
        asked.clear()
        stool.gap_and_normal.py_func(r, z, size)  # type: ignore[attr-defined]
        counts.append(len(asked))
    assert max(counts) <= 12


def test_a_capsule_shorter_than_wide_is_refused() -> None:
    assert "at least 1.8 cm" in capsule.refusal(capsule.ShapeConstants(0.9, 1.5))


@pytest.mark.parametrize(("name", "size"), [("sphere", (0.9,)), ("spheroid", (0.6, 1.6)), ("stool", (0.6, 1.6, 3.0))])
def test_contact_in_space_turns_about_both_curvatures(name: str, size: tuple[float, ...]) -> None:
    """Eq. (76), off the axis: gradient of the gap, and how the normal turns in any direction."""
    binding = bind({SLOT: find("shape", name).file})
    contact = binding.module("pellet.surface_contact")
    shape, across = kernels(name).ShapeConstants(*size), (0.11, -0.07, 0.3)
    places = np.random.default_rng(2).uniform(0.4, 0.9, (7, 3, 5))

    def ask(moved: Floats) -> Any:
        found = contact.no_contact(7, 5)
        contact.measure_contact(moved, np.zeros((7, 5)), *across, shape, found)
        return found

    found = ask(places)
    n, t = found.normal[3, :, 2], found.meridian[3, :, 2]
    around = np.cross(n, t)
    assert n @ n == pytest.approx(1.0, rel=1e-14)
    assert n @ t == pytest.approx(0.0, abs=1e-15)
    turning = np.outer(t, t) / found.bend[3, 2] + np.outer(around, around) / found.hoop[3, 2]
    for k in range(3):
        step = np.zeros_like(places)
        step[3, k, 2] = STEP
        ahead, behind = ask(places + step), ask(places - step)
        assert (ahead.gap[3, 2] - behind.gap[3, 2]) / (2.0 * STEP) == pytest.approx(n[k], abs=1e-8)
        difference = (ahead.normal[3, :, 2] - behind.normal[3, :, 2]) / (2.0 * STEP)
        assert difference == pytest.approx(turning[k], abs=1e-7)


def test_volume_oral_of_a_place_sums_up_to_the_volume(body: tuple[ModuleType, Any]) -> None:
    """Nothing lies oral of the oral pole, half of it oral of the middle, all of it oral of the anal pole."""
    shape, constants = body
    binding = bind({SLOT: Path(str(shape.__file__))})
    pellet = PelletShape("any", binding, constants)
    oral, middle, anal, beyond = pellet.volume_oral_of(
        np.array([-pellet.oral, 0.5 * (pellet.anal - pellet.oral), pellet.anal, 2.0 * pellet.anal])
    )
    assert oral == 0.0
    assert anal == beyond == pytest.approx(pellet.volume, rel=2e-4)
    assert middle == pytest.approx(0.5 * anal, rel=1e-9)


def test_volume_oral_of_a_place_is_that_of_a_cap() -> None:
    """pi h^2 (R - h/3) for a sphere, to rounding."""
    pellet = PelletShape("sphere", SHIPPED, sphere.ShapeConstants(0.9))
    height = np.linspace(0.0, 1.8, 37)
    assert pellet.volume_oral_of(height - 0.9) == pytest.approx(np.pi * height**2 * (0.9 - height / 3.0), abs=1e-13)
