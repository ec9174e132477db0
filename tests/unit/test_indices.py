"""Indices of sensitivity against a function with known ones, and where they are refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many import sweep as engine_sweep
from peristalsis.many.rows import Row
from peristalsis.many.studies.indices import METHODS, last_if_missing
from peristalsis.many.studies.sensitivity import cost_words, read_sensitivity, sensitivity
from peristalsis.many.studies.study import read_study

NAMES = ("one", "two", "three")
A, B = 7.0, 0.1


def ishigami(shares: np.ndarray) -> np.ndarray:
    """Ishigami and Homma's function; its variables are uniform from -pi to pi."""
    x = math.pi * (2.0 * shares - 1.0)
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def exact() -> dict[str, tuple[float, float, float]]:
    """First and total indices of the function, from its variances in closed form."""
    one = 0.5 * (1.0 + B * math.pi**4 / 5.0) ** 2
    two = A**2 / 8.0
    both = B**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = one + two + both
    return {"first": (one / whole, two / whole, 0.0), "total": ((one + both) / whole, two / whole, both / whole)}


def test_sobol_indices_of_ishigamis_function() -> None:
    way = METHODS["sobol"]
    points = way.points(3, 1024, 3)
    assert points.shape == (way.runs(3, 1024), 3)
    found = way.indices(NAMES, points, ishigami(points), 3)
    for kind, values in exact().items():
        for index, value in zip([one for one in found if one.name == kind], values, strict=True):
            assert index.value == pytest.approx(value, abs=0.03)
            assert index.low <= value <= index.high
            assert index.high - index.low < 0.25


def test_bands_are_those_of_their_seed() -> None:
    way = METHODS["sobol"]
    points = way.points(3, 64, 3)
    assert way.indices(NAMES, points, ishigami(points), 3) == way.indices(NAMES, points, ishigami(points), 3)
    assert way.indices(NAMES, points, ishigami(points), 3) != way.indices(NAMES, points, ishigami(points), 4)


def test_more_samples_keep_the_points_of_before() -> None:
    few, many = (METHODS["sobol"].points(3, samples, 3) for samples in (16, 32))
    assert np.array_equal(few[:16], many[:16])
    assert np.array_equal(few[16:32], many[32:48])


def test_elementary_effects_of_a_plane_are_its_slopes() -> None:
    pytest.importorskip("SALib")
    way = METHODS["morris"]
    points = way.points(3, 6, 1)
    assert points.shape == (way.runs(3, 6), 3)
    found = way.indices(NAMES, points, points @ np.array([3.0, -2.0, 0.0]), 1)
    values = {(one.variable, one.name): one.value for one in found}
    assert [values[name, "mean size"] for name in NAMES] == pytest.approx([3.0, 2.0, 0.0], abs=1e-6)
    assert [values[name, "mean"] for name in NAMES] == pytest.approx([3.0, -2.0, 0.0], abs=1e-6)
    assert [values[name, "spread"] for name in NAMES] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_the_shared_random_numbers_are_left_alone() -> None:
    pytest.importorskip("SALib")
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    METHODS["morris"].points(3, 6, 1)
    assert np.array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_pawn_ranks_ishigamis_variables_and_one_that_does_nothing() -> None:
    """The order that Pianosi and Wagener (2015) find: x2 before x1 before x3, and what does nothing last."""
    pytest.importorskip("SALib")
    way = METHODS["pawn"]
    points = way.points(4, 1024, 1)
    found = way.indices((*NAMES, "none"), points, ishigami(points[:, :3]), 1)
    order = [one.variable for one in sorted(found, key=lambda one: -one.value)]
    assert order == ["two", "one", "three", "none"]
    assert all(one.low <= one.value <= one.high for one in found)


def test_pawn_takes_what_has_no_number_as_last() -> None:
    pytest.importorskip("SALib")
    way = METHODS["pawn"]
    points = way.points(2, 256, 1)
    values = np.where(points[:, 0] > 0.5, np.nan, points[:, 1])
    found = {one.variable: one.value for one in way.indices(("stalls", "moves"), points, values, 1)}
    assert found["stalls"] == pytest.approx(0.5, abs=0.05), "in each half all or none of the others' half is there"
    assert found["stalls"] > found["moves"]
    assert last_if_missing(np.array([np.nan, 1.0, 5.0])).tolist() == [6.0, 1.0, 5.0]


def test_nothing_varies() -> None:
    points = METHODS["sobol"].points(2, 8, 1)
    assert all(one.value == 0.0 for one in METHODS["sobol"].indices(("a", "b"), points, np.ones(len(points)), 1))


@pytest.mark.parametrize(("method", "samples", "said"), [("sobol", 12, "such as 8 or 16"), ("pawn", 8, "32 or more")])
def test_samples_that_do_not_fit(method: str, samples: int, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        METHODS[method].points(2, samples, 1)


STUDY = """
outputs = ["transit_s", "mean_velocity_cm_s"]
[changes]
grid.n_z = 50
grid.n_z_wall = 40
[design]
samples = 32
seed = 1
[parameters]
pellet.viscous_friction = { from = "60 mN*s/cm", to = "240 mN*s/cm" }
pellet.dry_friction = { from = "10 mN", to = "100 mN" }
"""


@pytest.fixture
def formula(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Replaces the run by a formula; the pellet stalls where friction is large."""
    made: list[float] = []

    def run_one(configuration: Configuration, measure: object) -> Row:
        viscous, dry = configuration.pellet.viscous_friction, configuration.pellet.dry_friction
        made.append(viscous)
        speed = 100.0 / (viscous + 0.1 * dry)
        out = viscous < 200.0
        numbers = {"transit_s": 10.0 / speed if out else None, "mean_velocity_cm_s": speed}
        numbers |= {"final_position_cm": 9.0, "travel_cm": 8.0}
        return Row({"status": "expelled" if out else "arrested", "error": None, **numbers})

    monkeypatch.setattr(engine_sweep, "run_one", run_one)
    return made


def test_variances_are_refused_where_pellets_stall_and_the_way_out_is_named(
    tmp_path: Path, formula: list[float]
) -> None:
    with pytest.raises(
        ConfigurationError, match=r"transit_s has no number at \d+ of 128 points \(arrested\)"
    ) as refused:
        sensitivity(read_sensitivity(read_study(STUDY, ("sensitivity",), ("sobol",))), tmp_path / "s")
    assert "--method pawn" in str(refused.value)
    assert "final_position_cm" in str(refused.value)
    assert (tmp_path / "s" / "table.csv").is_file(), "nothing that was run is lost"
    made = len(formula)
    one = read_study(STUDY.replace('"transit_s", ', ""), ("sensitivity",), ("sobol",))
    found = sensitivity(one, tmp_path / "s")
    assert len(formula) == made
    assert [index.variable for index in found.ranked("mean_velocity_cm_s")] == [
        "pellet.viscous_friction", "pellet.dry_friction",
    ]  # fmt: skip


def test_the_cost_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, formula: list[float], capsys) -> None:
    pytest.importorskip("SALib")
    study = read_study(STUDY, ("sensitivity",), ("sobol",))
    assert "32 samples x (2 parameters + 2) = 128 runs" in cost_words(study, "sobol")
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(STUDY, encoding="utf-8")
    assert dispatch(["sensitivity", "s.toml", "--method", "pawn"]) == 0
    assert "pawn: 32 samples = 32 runs" in capsys.readouterr().err
    assert sorted(path.name for path in Path("out/s").iterdir()) == [
        "indices.csv", "sensitivity.png", "study.json", "table.csv", "times.csv",
    ]  # fmt: skip
    assert dispatch(["sensitivity", "s.toml", "--method", "sobbol"]) == 2
