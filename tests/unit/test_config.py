"""The configuration: exact round trips, changes by name, and one-line refusals of everything else."""

import contextlib
import json
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from peristalsis.errors import (
    ConfigurationError,
    DivergenceError,
    InterruptedRun,
    PeristalsisError,
    UnknownKeyError,
    WriteError,
    nearest,
)
from peristalsis.inputs.choices import SLOTS
from peristalsis.inputs.config import (
    FIELDS,
    KEYS,
    LARGEST_TEXT,
    Configuration,
    FieldSpec,
    Layer,
    Pellet,
    json_schema,
    parameter,
)
from peristalsis.inputs.parts import parts
from peristalsis.units import format_quantity

DEFAULT = Configuration()


# --- errors -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "code", "status"),
    [
        (ConfigurationError, 2, "invalid"),
        (UnknownKeyError, 2, "invalid"),
        (DivergenceError, 3, "diverged"),
        (WriteError, 4, "write_failed"),
        (InterruptedRun, 130, "interrupted"),
    ],
)
def test_errors_carry_exit_code_and_status(error: type[PeristalsisError], code: int, status: str) -> None:
    assert (error.exit_code, error.status) == (code, status)
    raised = pickle.loads(pickle.dumps(error("one\n  line")))  # errors cross process boundaries
    assert type(raised) is error
    assert str(raised) == "one line"


def test_nearest() -> None:
    assert nearest("pellet.radis", KEYS) == "pellet.radius"
    assert nearest("viscous_frictoin", KEYS) == "pellet.viscous_friction"
    assert nearest("PELLET.RADIUS", KEYS) == "pellet.radius"
    assert nearest("zzzz", KEYS) is None
    assert nearest("x" * 100_000, KEYS) is None


# --- round trips ------------------------------------------------------------------------------------


def valid(spec: FieldSpec) -> st.SearchStrategy[Any]:
    """Any value this field accepts, as it stands in a file."""
    if spec.kind == "switch":
        return st.booleans()
    if spec.kind == "choice":
        return st.sampled_from(spec.choices)
    if spec.kind == "part":
        return st.sampled_from(list(parts(SLOTS[spec.key])))
    if spec.kind == "names":
        return st.lists(st.sampled_from(spec.choices), max_size=5)
    low = spec.bounds.get("gt", spec.bounds.get("ge"))
    high = spec.bounds["le"]
    assert low is not None
    if spec.kind == "integer":
        return st.integers(int(low), int(high))
    numbers = st.floats(low, high, exclude_min="gt" in spec.bounds)
    written = numbers if spec.unit == "1" else numbers.map(lambda value: format_quantity(value, spec.unit))
    return st.lists(written, max_size=5) if spec.kind == "list" else written


CHANGES = st.lists(st.sampled_from(list(FIELDS.values())), max_size=8, unique_by=lambda spec: spec.key).flatmap(
    lambda specs: st.fixed_dictionaries({spec.key: valid(spec) for spec in specs})
)


@given(changes=CHANGES, reading=st.sampled_from(["tight", "stretched", "printed"]))
@settings(max_examples=200, deadline=None)
def test_what_is_accepted_is_written_and_read_back_identically(changes: dict[str, Any], reading: str) -> None:
    try:
        config = Configuration.from_mapping({**changes, "reading": reading})
    except ConfigurationError:  # values that are valid alone may not be valid together
        return
    text = config.to_toml()
    again = Configuration.from_toml(text)
    assert again == config
    assert again.to_toml() == text
    assert again.digest() == config.digest()
    assert repr(again.flat()) == repr(config.flat())  # bit for bit: == would not tell 0.0 from -0.0
    assert Configuration.from_mapping(config.texts()) == config
    assert Configuration.from_mapping(json.loads(json.dumps(config.texts()))) == config


@pytest.mark.parametrize("spec", FIELDS.values(), ids=FIELDS)
def test_every_field_can_be_changed_or_says_why_not(spec: FieldSpec) -> None:
    before = DEFAULT.texts()[spec.key]
    config = DEFAULT.with_changes({spec.key: before})
    assert config == DEFAULT
    with pytest.raises(ConfigurationError, match=spec.key.replace(".", r"\.")):
        DEFAULT.with_changes({spec.key: {"not": "a value"}})
    with pytest.raises(ConfigurationError, match=spec.key.replace(".", r"\.")):
        DEFAULT.with_changes({spec.key: "nonsense"})


@pytest.mark.parametrize("spec", [spec for spec in FIELDS.values() if spec.kind == "number"], ids=lambda s: s.key)
def test_every_number_is_bounded_and_needs_its_unit(spec: FieldSpec) -> None:
    assert {"le", "lt"} & set(spec.bounds)
    assert {"ge", "gt"} & set(spec.bounds)
    for value in (1e300, -1e300):
        with pytest.raises(ConfigurationError, match=f"^{spec.key} = .*out of range; give a value of"):
            DEFAULT.with_changes({spec.key: format_quantity(value, spec.unit)})
    if spec.unit != "1":
        with pytest.raises(ConfigurationError, match="unit is missing"):
            DEFAULT.with_changes({spec.key: 1.0})


def test_equal_configurations_hash_and_digest_alike() -> None:
    same = DEFAULT.with_changes({"pellet.radius": "9 mm"})
    assert same == DEFAULT
    assert hash(same) == hash(DEFAULT)
    assert same.digest() == DEFAULT.digest()
    other = DEFAULT.with_changes({"pellet.radius": "9.000000000000002 mm"})
    assert other.digest() != DEFAULT.digest()
    assert pickle.loads(pickle.dumps(DEFAULT)) == DEFAULT


def test_a_file_is_read_from_a_path_only(tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    file.write_text(DEFAULT.to_toml(), encoding="utf-8")
    assert Configuration.from_toml(file) == DEFAULT
    with pytest.raises(ConfigurationError, match="give a Path"):
        Configuration.from_toml(os.fspath(file))


# --- the baseline -----------------------------------------------------------------------------------


def test_baseline_values() -> None:
    assert DEFAULT.reading == "tight"
    assert DEFAULT.scenario == "baseline"
    assert DEFAULT.pellet.radius == 0.9
    assert DEFAULT.pellet.viscous_friction == 230.0
    assert DEFAULT.lumen.pressure == 0.1
    assert DEFAULT.longitudinal.c8 == 120.0
    assert DEFAULT.circular.c8 == 75.0
    assert DEFAULT.rings.positions == (2.0, 4.0, 6.0, 8.0)
    assert (DEFAULT.pacemaker.kind, DEFAULT.trigger.rule, DEFAULT.reflex.enabled) == ("pulse", "active", True)


def test_configurations_cannot_be_changed_in_place() -> None:
    with pytest.raises(ValidationError):
        DEFAULT.pellet.radius = 1.0


def test_a_layer_has_no_defaults_of_its_own() -> None:
    """One class serves two layers: defaults of one would be silently wrong for the other."""
    with pytest.raises(ValidationError):
        Layer()
    assert Configuration(circular={"active": 0.5}).circular.c8 == 75.0
    assert Configuration(circular=DEFAULT.circular) == DEFAULT


def test_sections_may_be_given_as_objects() -> None:
    assert Configuration(pellet=Pellet(dry_friction="2 mN")).pellet.dry_friction == 2.0


def test_items_show_what_is_shipped_beside_what_is_set() -> None:
    entries = {entry.key: entry for entry in DEFAULT.with_changes({"pellet.dry_friction": "2 mN"}).items()}
    assert list(entries) == list(FIELDS)
    changed = entries["pellet.dry_friction"]
    assert (changed.value, changed.shipped, changed.tag) == (2.0, 20.0, "set by user")
    kept = entries["pellet.viscous_friction"]
    assert (kept.value, kept.unit, kept.tag, kept.printed) == (230.0, "mN*s/cm", "printed", "230 Ns/m")
    assert all(entry.source and entry.description for entry in entries.values())


def test_readings_change_three_numbers() -> None:
    stretched = DEFAULT.with_reading("stretched")
    changed = {key for key, value in stretched.flat().items() if value != DEFAULT.flat()[key]}
    assert changed == {"reading", "pellet.radius", "wall.c10"}
    assert stretched == Configuration(reading="stretched")
    assert stretched.with_reading("tight") == DEFAULT
    assert all(entry.tag != "set by user" for entry in stretched.items())
    assert DEFAULT.with_changes({"reading": "stretched", "pellet.radius": "1 cm"}).pellet.radius == 1.0


def test_json_schema_describes_every_key() -> None:
    schema = json_schema()
    json.dumps(schema)
    for spec in FIELDS.values():
        entry = schema["properties"][spec.section]["properties"][spec.name]
        assert entry["default"] == DEFAULT.texts()[spec.key]
        assert entry["description"]
    assert schema["properties"]["pellet"]["properties"]["radius"]["x-unit"] == "cm"
    assert schema["properties"]["wall"]["properties"]["tension"]["enum"] == ["published", "consistent"]


# --- texts of a command line ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "text", "expected"),
    [
        ("pellet.enabled", "false", False),
        ("pellet.enabled", "off", False),
        ("pellet.enabled", "on", True),
        ("grid.n_z", "400", 400),
        ("wall.tension", "consistent", "consistent"),
        ("wall.c4", "3.5", 3.5),
        ("pellet.viscous_friction", "120 mN*s/cm", 120.0),
        ("rings.positions", "[2 cm, 50 mm]", (2.0, 5.0)),
        ("rings.positions", "3 cm", (3.0,)),
        ("output.probes", "[]", ()),
        ("output.probes", "['1 cm', \"2 cm\"]", (1.0, 2.0)),
    ],
)
def test_texts_are_read_by_the_type_of_their_field(key: str, text: str, expected: object) -> None:
    assert DEFAULT.with_changes({key: text}).flat()[key] == expected


@pytest.mark.parametrize("value", ["true", "on", 1, 0, None, "yes"])
def test_a_file_knows_no_text_switches(value: object) -> None:
    with pytest.raises(ConfigurationError, match=r"pellet\.enabled = .*true or false"):
        Configuration.from_mapping({"pellet": {"enabled": value}})


# --- refusals ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pellet.radis": "1 cm"}, r"'pellet\.radis' is not a parameter; did you mean pellet\.radius\?"),
        ({"pelet": {"radius": "1 cm"}}, "did you mean pellet"),
        ({3: "1 cm"}, "keys are text"),
        ({"pellet": {3: "1 cm"}}, "keys are text"),
        ({"pellet": "1 cm"}, "pellet is a section"),
        ({"pellet.radius": "1 cm", "pellet": {"radius": "1 cm"}}, "given twice"),
        ({"pellet.radius": "-1 cm"}, r"-1\.0 cm.*more than 0 cm and at most 20 cm"),
        ({"pellet.radius": "-0 cm"}, "more than 0 cm"),
        ({"wall.radius": "0 cm"}, "more than 0 cm"),
        ({"pellet.radius": "1 kg"}, "cannot be converted to cm"),
        ({"reading": "strechted"}, "did you mean stretched"),
        ({"reading": ["tight"]}, "as text"),
        ({"scenario": "../etc"}, "lower-case letters"),
        ({"wall.tension": "publishd"}, "did you mean published"),
        ({"wall.tension": 3}, "not one of published, consistent"),
        ({"grid.n_z": 800.0}, "not a whole number"),
        ({"grid.n_z": True}, "not a whole number"),
        ({"grid.n_z": 10**5000}, "out of range"),
        ({"grid.n_z": 20_001}, "at most 20000"),
        ({"grid.n_theta": 3}, r"grid\.n_theta = 3: too few columns for a ring; use 1 \(axisymmetric\) or at least 4"),
        ({"grid.n_theta_conduction": 64}, r"grid\.n_theta = 1 is the axisymmetric model; use 0"),
        ({"grid.n_theta_wall": 4}, r"grid\.n_theta = 1 is the axisymmetric model; use 0"),
        ({"grid.n_theta": 16, "grid.n_theta_wall": 3}, r"too few columns for a ring; use 0, or at least 4"),
        ({"grid.n_theta": 64, "grid.n_theta_wall": 24}, r"does not divide grid\.n_theta = 64.*; use 16"),
        (
            {"grid.n_theta": 16, "grid.n_theta_wall": 8, "grid.n_theta_conduction": 36},
            r"not a multiple of grid\.n_theta_wall = 8; use 32, or 0",
        ),
        ({"grid.n_theta": 8, "grid.n_theta_conduction": 30}, r"not a multiple of grid\.n_theta = 8; use 32, or 0"),
        ({"grid.n_theta": 8, "pellet.friction_coefficient": 0.3}, "for the axisymmetric wall only"),
        ({"rings.positions": ["2 cm", "-1 cm"]}, r"rings\.positions = '-1\.0 cm': out of range"),
        ({"rings.positions": ["2 cm"] * 101}, "at most 100 items"),
        ({"rings.positions": [2.0]}, "unit is missing"),
        ({"rings.positions": [[2.0]]}, "not a quantity"),
        ({"rings.enabled": True, "rings.positions": []}, "have no place"),
        ({"rings.enabled": True, "rings.positions": ["11 cm"]}, "beyond the anal end"),
        ({"rings.enabled": True, "rings.period": "0.01 s"}, "overlap"),
        ({"pacemaker.kind": "periodic", "pacemaker.period": "0.01 s"}, "overlap"),
        ({"pacemaker.width": "11 cm"}, "beyond the anal end"),
        ({"output.probes": ["11 cm"]}, r"output\.probes"),
        ({"trigger.delay": "-0.5 s"}, "cannot come first"),
        ({"step.wall": "2.2 ms"}, r"2\.2 times step\.conduction.*use, for example, 2 ms"),
        ({"step.wall": "0.4 ms"}, r"0\.4 times"),
        ({"run.duration": "1 day", "step.conduction": "0.25 ms"}, "3.46e.08 steps"),
        ({"run.duration": "0.5 ms"}, "shorter than step.wall"),
        ({"output.interval": "0.1 ms"}, "shorter than step.wall"),
        ({"wall.length": "2 cm", "output.probes": []}, "the pellet and its gap take 2.1 cm"),
        ({"pellet.start_gap": "8.2 cm"}, "the pellet and its gap take 10 cm"),
    ],
)
def test_bad_input_is_refused_with_value_cause_and_fix(changes: dict[Any, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message) as caught:
        Configuration.from_mapping(changes)
    assert "\n" not in str(caught.value)


def test_the_tube_cannot_hold_every_pellet() -> None:
    """r0 = 0.6 cm under `stretched`: by hand, 2 c10 c5 e exp(c5 e^2) with e = 1.5 is 7.8e11 mN/cm."""
    stretched = DEFAULT.with_reading("stretched")
    with pytest.raises(ConfigurationError, match=r"cannot hold this pellet.*2\.5 and .* 7\.8e\+11 mN/cm"):
        stretched.with_changes({"wall.radius": "0.6 cm"})
    assert stretched.with_changes({"wall.radius": "0.6 cm", "pellet.enabled": False}).wall.radius == 0.6
    with pytest.raises(ConfigurationError, match="above 1e300 mN/cm"):
        DEFAULT.with_changes({"wall.radius": "0.05 cm", "wall.c5": 100.0})


def test_a_pacemaker_may_follow_the_circular_layer_under_its_own_rule() -> None:
    config = DEFAULT.with_changes({"trigger.rule": "pacemaker", "trigger.delay": "-0.5 s"})
    assert config.trigger.delay == -0.5


def test_the_pellet_is_not_checked_when_there_is_none() -> None:
    config = DEFAULT.with_changes({"wall.length": "1 cm", "output.probes": "[]", "pellet.enabled": "false"})
    assert config.wall.length == 1.0


@pytest.mark.parametrize(
    "text",
    [
        "pellet = ",
        "[pellet]\nradius = 0.9 cm",
        "a = " + "[" * 20_000,
        "grid = " + "{a=" * 5000,
        "[grid]\nn_z = " + "9" * 10_000,
        "[pellet]\nradius = 2020-01-01",
        "[pellet]\nradius = inf",
        "[wall]\nc4 = nan",
        "[wall]\nc4 = 1e400",
        "[pellet]\nradius = '1 cm'\nradius = '2 cm'",
        "#" * (LARGEST_TEXT + 1),
        "\x00",
    ],
    ids=lambda text: text[:20],
)
def test_bad_toml_is_refused(text: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        Configuration.from_toml(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"#" * (LARGEST_TEXT + 1), None])
def test_bad_files_are_refused(tmp_path: Path, content: bytes | None) -> None:
    file = tmp_path / "run.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ConfigurationError):
        Configuration.from_toml(file)
    with pytest.raises(ConfigurationError):
        Configuration.from_toml(tmp_path)


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(min_value=10**400, max_value=10**401),
    st.floats(),
    st.text(max_size=20),
    st.binary(max_size=5),
    st.sampled_from(["1 cm", "1e400 cm", "-1 cm", "nan", "1 kPa", "true", "[1 cm]", "periodic"]),
)
TREES = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner))
NAMES = st.one_of(st.sampled_from([*KEYS, *(spec.section for spec in FIELDS.values())]), st.text(max_size=10), LEAVES)
INNER_NAMES = st.one_of(st.sampled_from([spec.name for spec in FIELDS.values()]), st.text(max_size=10), st.integers())


@given(tree=st.dictionaries(NAMES, TREES | st.dictionaries(INNER_NAMES, TREES, max_size=3), max_size=3) | TREES)
@settings(max_examples=400, deadline=None)
def test_no_tree_raises_anything_but_a_configuration_error(tree: Any) -> None:
    for read in (Configuration.from_mapping, DEFAULT.with_changes, DEFAULT.overlaid):
        with contextlib.suppress(ConfigurationError):
            assert isinstance(read(tree), Configuration)


@given(text=st.text(max_size=200))
def test_no_text_raises_anything_but_a_configuration_error(text: str) -> None:
    with contextlib.suppress(ConfigurationError):
        Configuration.from_toml(text)


def test_a_field_cannot_be_declared_without_a_parameter() -> None:
    with pytest.raises(KeyError):
        parameter("pellet.colour")


def test_the_configuration_loads_nothing_heavy() -> None:
    code = (
        "import sys; import peristalsis.inputs.config, peristalsis.scenarios; "
        "print([name for name in ('numpy', 'numba', 'pint', 'scipy', 'xarray') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_schema_refuses_units_of_another_kind() -> None:
    """Every default and every unit of the same kind pass; kilograms are no length."""
    import re

    schema = json_schema()["properties"]
    for spec in FIELDS.values():
        entry = schema[spec.section]["properties"][spec.name]
        item = entry.get("items", entry)
        if "pattern" in item:
            default = entry["default"]
            for text in default if isinstance(default, list) else [default]:
                assert re.match(item["pattern"], text), (spec.key, text)
    radius = schema["pellet"]["properties"]["radius"]["pattern"]
    pressure = schema["lumen"]["properties"]["pressure"]["pattern"]
    for good in ("9 mm", "0.9cm", "1e-2 m", "9000 µm"):
        assert re.match(radius, good), good
    for bad in ("9 kg", "9", "9 s", "mm", "9 mN"):
        assert not re.match(radius, bad), bad
    for good in ("1 kPa", "1 mm Hg", "10 cmH₂O", "100 N/m^2", "100 N·m⁻²"):
        assert re.match(pressure, good), good
    assert not re.match(pressure, "1 mV")
