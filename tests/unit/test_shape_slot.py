"""The slot of the pellet's shape: chosen by configuration, from any file, refused in words, never a silent sphere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import parts
from peristalsis.inputs.asked import remarks
from peristalsis.inputs.build import build
from peristalsis.inputs.shape import shape_of, size_in_words
from peristalsis.model.constants import packed
from peristalsis.model.initial import initial_state, straight_state
from peristalsis.model.step import advance
from peristalsis.model.step_summary import summary_of_step
from peristalsis.pellet.constants import PELLET_DRY

SMALL = {"grid.n_z": 60, "grid.n_z_wall": 60}
CAPSULE = {"pellet.shape": "capsule", "pellet.radius": "0.55 cm", "pellet.capsule.length": "2.6 cm"}
SPHEROID = Path(ps.__file__).parent / "pellet" / "shapes" / "spheroid.py"


def configured(*changes: dict[str, Any]) -> Any:
    """The baseline on a small grid with these changes."""
    merged = dict(SMALL)
    for one in changes:
        merged.update(one)
    return ps.configuration("baseline", changes=merged)


@pytest.fixture
def outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A spheroid of another name in a folder of the user's, which imports the package by its name."""
    text = SPHEROID.read_text(encoding="utf-8").replace("from ...", "from peristalsis.")
    file = tmp_path / "egg.py"
    file.write_text(text.replace('NAME = "spheroid"', 'NAME = "egg"'), encoding="utf-8")
    monkeypatch.setenv(parts.VARIABLE, str(file))
    parts._known.cache_clear()
    yield file
    monkeypatch.undo()
    parts._known.cache_clear()


def test_poles_volume_and_place_follow_from_the_shape() -> None:
    model = build(configured(CAPSULE, {"wall.oral_end": "closed", "wall.anal_end": "closed"}))
    pellet = model.pellet
    assert (pellet.radius, pellet.oral, pellet.anal) == (0.55, 1.3, 1.3)
    assert pellet.volume == pytest.approx(np.pi * 0.55**2 * 1.5 + 4.0 / 3.0 * np.pi * 0.55**3)
    assert model.start_position == pytest.approx(0.3 + 1.3)
    assert (pellet.lowest, pellet.highest) == (1.3, pytest.approx(10.0 - 1.3))


def test_packed_numbers_are_as_many_as_the_shape_has() -> None:
    """Three numbers for a stool, one for a sphere; friction stands at the same place from the end."""
    stool = configured({"pellet.shape": "stool"})
    for config, count in ((configured(), 1), (stool, 3)):
        pellet = shape_of(config).pellet(dry=17.0, viscous=3.0, tangential=True, lowest=0.25)
        numbers = packed(pellet)
        assert numbers.size == 16 + count
        assert numbers[PELLET_DRY] == 17.0
        unpacked = shape_of(config).binding.module("pellet.body").unpack_pellet(numbers)
        assert tuple(unpacked.shape) == tuple(pellet.shape)
        assert unpacked._replace(shape=None) == pellet._replace(shape=None)


def test_a_file_outside_the_package_is_a_shape(outside: Path) -> None:
    """Bound kernels of the contact take its gap; the spheroid of the package gives the same force."""
    rng = np.random.default_rng(3)
    rho, zeta, density = rng.uniform(0.5, 1.0, 20), np.linspace(4.0, 6.0, 20), rng.uniform(0.0, 9.0, 20)
    forces = []
    for name in ("egg", "spheroid"):
        shape = shape_of(configured({"pellet.shape": name, f"pellet.{name}.aspect": 1.4}))
        contact = shape.binding.module("pellet.contact")
        forces.append(contact.axial_force(rho, zeta, density, 5.1, shape.constants, 0.1))
        assert shape.oral == pytest.approx(1.4 * 0.9)
        assert contact.__file__ == str(SPHEROID.parents[1] / "contact.py")
    assert forces[0] == forces[1] != 0.0
    assert shape_of(configured({"pellet.shape": "egg"})).binding.exchanged[SPHEROID.with_name("sphere.py")] == outside


def test_kernels_refuse_a_pellet_of_another_shape() -> None:
    """A spheroid handed to kernels that are bound to the sphere is no silent sphere, on any path."""
    for more in ({}, {"grid.n_theta": 8}, {"solver.integrator": "explicit"}):
        model = build(configured({"pellet.shape": "spheroid"}, more))
        state = straight_state(model)
        for wrong in (
            lambda m=model: initial_state(m),
            lambda m=model, s=state: advance(m, s),
            lambda m=model, s=state: summary_of_step(m, s, s),
        ):
            with pytest.raises(TypeError, match=r"sphere were handed a pellet of peristalsis\.bound\.\w+\.pellet"):
                wrong()


def test_bodies_that_are_none_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"shape = capsule: a length of 1\.5 cm .* at least 1\.8 cm"):
        build(configured({"pellet.shape": "capsule", "pellet.capsule.length": "1.5 cm"}))
    with pytest.raises(ConfigurationError, match=r"wall\.length = 10\.0 cm: the capsule and its gap take 10\.3 cm"):
        build(configured({"pellet.shape": "capsule", "pellet.capsule.length": "10 cm"}))


def test_a_flat_pellet_needs_its_own_length_of_tube() -> None:
    """Not that of the sphere of its girth."""
    flat = {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 0.5, "wall.length": "2 cm"}
    assert build(configured(flat, {"output.probes": "1 cm"})).start_position == pytest.approx(0.3 + 0.45)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("def reach(", "def reached(", "does not define reach; a shape defines ShapeConstants"),
        ("    radius: float\n    aspect: float\n", "    aspect: float\n    radius: float\n", "name radius and then"),
        ("import math\n", "import maths\n", "cannot be imported"),
    ],
)
def test_a_bad_file_is_refused_in_a_sentence(outside: Path, old: str, new: str, words: str) -> None:
    outside.write_text(outside.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=words) as refused:
        build(configured({"pellet.shape": "egg"}))
    assert str(refused.value).startswith("pellet.shape = egg: ")
    assert "\n" not in str(refused.value)


def test_size_is_told_of_what_is_no_sphere() -> None:
    ((label, words),) = size_in_words(configured(CAPSULE))
    assert (label, words) == ("pellet", "capsule, 11 x 26 mm, 2.122 cm^3")
    assert size_in_words(configured()) == []


def test_a_place_to_stop_is_compared_with_where_the_longer_pellet_starts() -> None:
    asked = {"run.stop_position": "1.5 cm"}
    assert not any("stop_position" in text for text in remarks(configured(asked)))
    assert any("starts at 1.6 cm" in text for text in remarks(configured(asked, CAPSULE)))


def bound_run(config: Any, duration: float) -> list[Any]:
    """States of a run through the kernels bound to its shape."""
    shape = shape_of(config)
    model, state, _ = shape.binding.module("model.initial").initial_state(build(config))
    advance_safely = shape.binding.module("model.guards").advance_safely
    summary = shape.binding.module("model.step_summary").summary_of_step
    states = [state]
    while state.step * model.dt_wall < duration:
        before = state
        state, report = advance_safely(model, before)
        states.append(state)
        found = summary(model, before, state)
        if model.explicit is not None:
            assert found.contact.smallest_gap > -1e-3
            continue
        assert report.halved == ""
        assert abs(found.momentum.residual) < 1e-6 * max(abs(state.pellet.axial_force), 1.0)
        assert found.contact.smallest_gap > -1e-6
    return states


@pytest.mark.slow  # the kernels of each shape are compiled at the first run
@pytest.mark.parametrize("more", [{}, {"solver.integrator": "explicit", "step.wall": "0.25 ms"}])
def test_sphere_as_spheroid_of_ratio_one(more: dict[str, Any]) -> None:
    """Found in another way, it moves wall and pellet alike, by the implicit and the explicit scheme."""
    duration = 0.3 if not more else 0.002
    spheroid = {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 1.0}
    one, two = (bound_run(configured(more, shape), duration) for shape in ({}, spheroid))
    for a, b in zip(one, two, strict=True):
        assert b.wall.position == pytest.approx(a.wall.position, abs=1e-12)
        assert b.pellet.position == pytest.approx(a.pellet.position, abs=1e-12)


@pytest.mark.slow
def test_capsule_whose_curvature_jumps_is_inserted_and_moved() -> None:
    """Newton's method copes with the jump: no step is cut, and the pellet goes with the wave."""
    tight = {"wall.radius": "0.486 cm"}
    states = bound_run(configured(CAPSULE, tight), 1.2)
    assert states[-1].pellet.position > states[0].pellet.position + 0.1


@pytest.mark.slow
def test_ring_uniform_surface_gives_the_spheroid_of_the_column() -> None:
    """Eqs. (70) and (76): eight columns and one."""
    shape = {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 1.4}
    column = bound_run(configured(shape), 0.05)[-1]
    surface = bound_run(configured(shape, {"grid.n_theta": 8}), 0.05)[-1]
    assert surface.wall.position[:, :, 0] == pytest.approx(
        np.repeat(column.wall.position[:, :, 0], 8, axis=1), abs=1e-6
    )
    assert surface.pellet.position == pytest.approx(column.pellet.position, abs=1e-6)
