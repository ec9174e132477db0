"""The shipped numbers: each has a unit, a tag and a source, and those that can be recomputed are."""

import csv
import dataclasses
from pathlib import Path
from typing import get_args

import pytest

from peristalsis import scenarios
from peristalsis.errors import ReadingNotFound
from peristalsis.inputs import parameters
from peristalsis.inputs.config import FIELDS
from peristalsis.inputs.parameters import PARAMETERS, READINGS, SOURCES, Parameter, Tag, shipped
from peristalsis.scoring import sources
from peristalsis.units import CANONICAL_UNITS

TYPES = {"number": float, "integer": int, "switch": bool, "choice": str, "list": tuple, "names": tuple, "part": str}


def number(key: str) -> float:
    value = PARAMETERS[key].value
    assert isinstance(value, float)
    return value


def test_every_field_has_a_parameter_and_every_parameter_a_field() -> None:
    assert set(PARAMETERS) == set(FIELDS)


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("key", FIELDS)
def test_every_default_has_unit_tag_source_and_description(key: str, reading: str) -> None:
    about = shipped(reading)[key]
    spec = FIELDS[key]
    assert about.key == key
    assert type(about.value) is TYPES[spec.kind]
    assert about.tag in get_args(Tag)
    assert len(about.source) > 10
    assert about.description
    if spec.kind in ("number", "integer", "list"):
        assert about.unit in CANONICAL_UNITS
    else:
        assert about.unit == ""


@pytest.mark.parametrize(
    ("file", "tags"),
    [
        ("al_qatrawi_miftahof", {"printed", "corrected"}),
        ("plant_1981", {"sourced"}),
        ("tong_fung_1976", {"sourced"}),
        ("chosen", {"chosen", "calibrated"}),
    ],
)
def test_a_file_holds_one_kind_of_number(file: str, tags: set[str]) -> None:
    assert {about.tag for about in SOURCES[file].parameters.values()} == tags
    assert SOURCES[file].citation


def test_only_the_conductivity_scales_are_calibrated() -> None:
    calibrated = {key for key, about in PARAMETERS.items() if about.tag == "calibrated"}
    assert calibrated == {"longitudinal.conductivity_scale", "circular.conductivity_scale"}


@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_scaled_conductivities_give_the_calibrated_diffusivity(layer: str) -> None:
    inner, outer = number(f"{layer}.intracellular_axial"), number(f"{layer}.extracellular_axial")
    series = inner * outer / (inner + outer)
    per_ms = number("tissue.volume_to_surface") * series * number(f"{layer}.conductivity_scale")
    assert per_ms / number("tissue.capacitance") * 1000 == pytest.approx(0.0873, rel=1e-12)  # cm^2/s


def test_the_units_of_both_layers_agree() -> None:
    """One class serves both layers and takes its units from the first."""
    for key, about in PARAMETERS.items():
        if key.startswith("longitudinal."):
            twin = PARAMETERS[key.replace("longitudinal", "circular")]
            assert (twin.unit, twin.description) == (about.unit, about.description)


def test_doubtful_numbers_keep_the_words_of_the_paper() -> None:
    assert PARAMETERS["pellet.viscous_friction"].printed == "230 Ns/m"
    assert PARAMETERS["pellet.dry_friction"].printed == "20 N"
    assert PARAMETERS["wall.surface_density"].printed == "26.14 g/cm^2"
    assert PARAMETERS["circular.intracellular_circumferential"].printed == "2 mSm/cm^2"
    assert PARAMETERS["wall.length"].printed == ""


def test_readings() -> None:
    keys = ("wall.radius", "pellet.radius", "wall.c10")
    values = {name: tuple(one.parameters[key].value for key in keys) for name, one in READINGS.items()}
    assert values == {
        "tight": (0.795, 0.9, 10.0),
        "stretched": (0.795, 1.5, 0.00794),
        "printed": (0.795, 0.75, 0.00794),
        "edge": (0.795, 0.8924, 24.45),
    }
    for name, reading in READINGS.items():
        assert reading.why
        if name != "edge":
            assert set(reading.parameters) == set(keys)


def test_the_fitted_reading_is_a_point_of_the_search() -> None:
    """Its numbers are those of the best point that was drawn or refined once (0048), and nothing else was moved."""
    space = sources.get("paper").space
    assert space is not None
    table = Path(__file__).resolve().parents[2] / "docs" / "paper" / "candidates.csv"
    with table.open(encoding="utf-8", newline="") as stream:
        best = next(row for row in csv.DictReader(stream) if row["point"].count(".") <= 1)
    drawn = {one.name: float(best[one.name]) for one in space.free} | {
        one.name: best[one.name] for one in space.choices
    }
    changes = space.changes(drawn, float(best["force"]), scenarios.configuration(reading="tight").flat())
    found = scenarios.configuration(reading="edge").flat()
    expected = scenarios.configuration(reading="tight", changes=changes).flat()
    for key in set(found) - {"reading"}:
        assert found[key] == (pytest.approx(expected[key], rel=1e-8) if key.endswith("_scale") else expected[key]), key
    assert {one.tag for key, one in READINGS["edge"].parameters.items() if key != "wall.radius"} == {"fitted"}


def test_unknown_reading() -> None:
    with pytest.raises(ReadingNotFound, match="did you mean tight"):
        shipped("tigth")


def test_shipped_numbers_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        PARAMETERS["wall.c4"] = PARAMETERS["wall.c5"]  # type: ignore[index]
    with pytest.raises(dataclasses.FrozenInstanceError):
        PARAMETERS["wall.c4"].value = 1.0  # type: ignore[misc]
    assert isinstance(PARAMETERS["wall.c4"], Parameter)


def test_files_with_a_misspelt_tag_are_refused() -> None:
    table = {"value": 1.0, "tag": "printd", "source": "Table 1", "description": "a number"}
    with pytest.raises(ValueError, match=r"paper\.toml: wall\.radius has tag 'printd'; did you mean printed"):
        parameters._parameter("paper", "wall.radius", table, "Paper")


def test_a_number_has_one_source() -> None:
    one, two = list(SOURCES.values())[:2]
    twice = {"one": one, "two": dataclasses.replace(two, parameters=one.parameters)}
    with pytest.raises(ValueError, match=rf"is given by {one.name}\.toml and by {two.name}\.toml; keep one"):
        parameters._disjoint(twice)
