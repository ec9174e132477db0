"""Inputs in time: the line of text, its round trip, what may change, and the same bits either way."""

from __future__ import annotations

import pickle
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis import units
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import tables
from peristalsis.inputs.config import FIELDS, Configuration, FieldSpec
from peristalsis.inputs.protocols import Protocol, changeable, parse, parse_all
from peristalsis.storing.checkpoint import Checkpoints
from peristalsis.storing.store import Workspace

UNITS = {"lumen.pressure": "kPa", "longitudinal.active": "1", "pellet.radius": "cm"}
TINY = {"grid.n_z": 300, "grid.n_z_wall": 100, "run.duration": "0.1 s", "output.interval": "10 ms"}


def test_ramp_and_step() -> None:
    ramp = parse("lumen.pressure: ramp 0.1 kPa at 1 s, 0.3 kPa at 2000 ms", UNITS)
    assert [ramp.at(t) for t in (0.0, 1.0, 1.5, 2.0, 9.0)] == pytest.approx([0.1, 0.1, 0.2, 0.3, 0.3], abs=1e-15)
    step = parse("longitudinal.active: step 1 at 0 s, 0.5 at 1 s", UNITS)
    assert [step.at(t) for t in (0.0, 0.999, 1.0, 5.0)] == [1.0, 1.0, 0.5, 0.5]


def test_step_takes_its_value_at_a_time_made_of_steps() -> None:
    """500 steps of 2 ms are 1 s but for roundoff, which must not put the step off by one."""
    step = Protocol("lumen.pressure", "step", (0.0, 1.0), (0.1, 0.2))
    assert step.at(500 * 0.002) == 0.2
    assert step.at(np.nextafter(1.0, 0.0)) == 0.2
    assert step.at(499 * 0.002) == 0.1


@given(
    st.lists(st.floats(0, 50, allow_subnormal=False), min_size=1, max_size=6, unique=True),
    st.lists(st.floats(0, 100, allow_subnormal=False), min_size=6, max_size=6),
    st.sampled_from(("step", "ramp")),
)
def test_text_reads_back_identically(times: list[float], values: list[float], shape: str) -> None:
    protocol = Protocol("lumen.pressure", shape, tuple(sorted(times)), tuple(values[: len(times)]))
    assert parse(protocol.text("kPa"), UNITS) == protocol


def test_configuration_round_trip() -> None:
    config = Configuration().with_changes({"protocols": ["lumen.pressure: ramp 1 mmHg at 0 s, 2 mmHg at 1 s"]})
    assert Configuration.from_toml(config.to_toml()) == config
    assert config.digest() != Configuration().digest()


def test_table(tmp_path: Path) -> None:
    file = tmp_path / "pressure.csv"
    file.write_text("time [ms],value [mbar]\n0,1\n500,2\n", encoding="utf-8")
    table = parse(f"lumen.pressure: table {file}", UNITS)
    assert table == Protocol("lumen.pressure", "ramp", (0.0, 0.5), (0.1, 0.2))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("lumen.pressure", "not a parameter, a shape and its values"),
        ("lumen.presure: step 1 kPa at 0 s", "did you mean lumen.pressure"),
        ("pellet.radius: step 1 cm at 0 s", "cannot change during a run"),
        ("lumen.pressure: jump 1 kPa at 0 s", "not one of step, ramp, table"),
        ("lumen.pressure: ramp 1 kPa at 1 s, 2 kPa at 1 s", "do not increase"),
        ("lumen.pressure: ramp 1 kPa", "no ' at '"),
        ("lumen.pressure: ramp 1 cm at 0 s", "cannot be converted to kPa"),
        ("lumen.pressure: ramp 1 at 0 s", "unit is missing"),
        ("lumen.pressure: ramp nan kPa at 0 s", "finite"),
        ("lumen.pressure: ramp 1000 kPa at 0 s", "out of range"),
        ("lumen.pressure: table nowhere.csv", "cannot be read"),
    ],
)
def test_mistakes_are_one_sentence(text: str, says: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        Configuration().with_changes({"protocols": [text]})
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_protocols_are_texts() -> None:
    with pytest.raises(ConfigurationError, match="protocols = 5: give each as text; write for example"):
        parse(5, UNITS)


MANY = "".join(f"{k},1\n" for k in range(1001))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("time [s],value [kPa]\n", "not a header and rows of two columns"),
        ("time [s],value [kPa]\n0,1,2\n", "row 1 has 3 cells and the header 2"),
        ("time,value [kPa]\n0,1\n", "the header has no units"),
        ("time [s],value\n0,1\n", "the header has no units"),
        ("time [s],longitudinal.active\n0,1\n", "has no column lumen.pressure but longitudinal.active"),
        ("time [s],a [kPa],b [kPa]\n0,1,2\n", "has no column lumen.pressure but a, b"),
        ("time [s],value [kPa]\n1,1\n0,2\n", "the times do not increase from 0 s on at row 2"),
        ("time [s],value [kPa]\n" + MANY + "2000,x\n", "could not convert"),
        ("time [s],value [kPa]\n" + MANY + "2000,nan\n", "row 1002 holds a number"),
        ("time [s],value [kPa]\n" + MANY + "5,1\n", "the times do not increase from 0 s on at row 1002"),
        ("time [s],value [kPa]\n" + MANY + "2000,0,5\n", "row 1002 has 3 cells and the header 2"),
        ("time [s],value [kPa]\n0,1\n1,high\n", "row 2 = 'high kPa'"),
        ("time [s],value [cm]\n" + MANY, "unit cm cannot be converted to kPa"),
    ],
)
def test_bad_tables_are_refused(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "table.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError) as caught:
        parse(f"lumen.pressure: table {file}", UNITS)
    assert says in str(caught.value)


def test_plain_numbers_have_no_unit(tmp_path: Path) -> None:
    """In a table neither; a text that is no number is said to be none."""
    units = {"circular.active": "1"}
    file = tmp_path / "factor.csv"
    file.write_text("time [s],factor\n0,0.5\n1,0.25\n", encoding="utf-8")
    assert parse(f"circular.active: table {file}", units).values == (0.5, 0.25)
    with pytest.raises(ConfigurationError, match=r"'half' is not a plain number for circular\.active; give one"):
        parse("circular.active: step half at 0 s", units)


def test_two_protocols_of_one_parameter_are_refused() -> None:
    line = "lumen.pressure: step 1 kPa at 0 s"
    with pytest.raises(ConfigurationError, match="two of them"):
        Configuration().with_changes({"protocols": [line, line]})


def test_what_may_change() -> None:
    assert all(changeable(key) for key in ("lumen.pressure", "reflex.delay", "circular.fast_calcium"))
    assert not any(changeable(key) for key in ("wall.radius", "grid.n_z", "pacemaker.kind"))


def test_protocol_and_set_between_advances_give_the_same_bits() -> None:
    """A pressure ramp and a conductance step, once as protocols and once by hand, step by step."""
    lines = [
        "lumen.pressure: ramp 0.1 kPa at 0.02 s, 0.3 kPa at 0.08 s",
        "longitudinal.slow_calcium: step 0.004 mS/cm^2 at 0 s, 0.006 mS/cm^2 at 0.05 s",
    ]
    whole = ps.run("baseline", {**TINY, "protocols": lines})
    courses = ps.configuration("baseline", changes={"protocols": lines}).time_courses()
    at_start = {"lumen.pressure": "0.1 kPa", "longitudinal.slow_calcium": "0.004 mS/cm^2"}
    sim = ps.Simulation(ps.configuration("baseline", changes=TINY | at_start))
    for _ in range(50):
        pressure, conductance = (course.at(sim.time) for course in courses)
        sim.set({"lumen.pressure": f"{pressure!r} kPa", "longitudinal.slow_calcium": f"{conductance!r} mS/cm^2"})
        sim.advance("2 ms")
    pieces = sim.result()
    assert whole.arrays["lumen_pressure"].max() > 0.25  # the ramp did act
    for name, values in whole.arrays.items():
        if not name.startswith("event"):
            assert np.array_equal(values, pieces.arrays[name], equal_nan=values.dtype.kind == "f"), name


def test_pressure_protocol_keeps_the_reference_volume() -> None:
    sim = ps.Simulation(ps.configuration("baseline", changes=TINY))
    before = sim.model.lumen.reference_volume
    sim.set({"lumen.pressure": "0.2 kPa"})
    assert sim.model.lumen.reference_volume == before
    assert sim.model.lumen.pressure == pytest.approx(20.0)


def test_set_refuses_what_cannot_change_and_changes_nothing() -> None:
    sim = ps.Simulation(ps.configuration("baseline", changes=TINY))
    model = sim.model
    for changes in ({"wall.radius": "1 cm"}, {"lumen.pressure": "1 cm"}, {"lumen.presure": "1 kPa"}):
        with pytest.raises(ConfigurationError):
            sim.set(changes)
    assert sim.model is model


SMALL = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 50,
    "grid.n_z_wall": 60,
    "run.duration": "0.02 s",
    "output.interval": "10 ms",
}
ONE_COLUMN = "pacemaker.angular_width"  # of which there can be but one value
CHANGED = [s for key, s in FIELDS.items() if changeable(key) and s.kind == "number" and key != ONE_COLUMN]


@pytest.mark.parametrize("spec", CHANGED, ids=lambda spec: spec.key)
def test_a_value_and_a_protocol_that_has_it_from_the_start_give_the_same_bits(spec: FieldSpec) -> None:
    """Whatever may change: the start, its rest and its inflation too, knows the values at t = 0."""
    base = ps.configuration("baseline", changes=SMALL | OWN.get(spec.section, {}))
    value = base.flat()[spec.key]
    assert isinstance(value, float)
    other = value * 1.05 if value else 0.01
    changed = units.written(other if other <= spec.bounds.get("le", other) else value * 0.95, spec.unit)
    given = ps.Simulation(base.with_changes({spec.key: changed})).run()
    line = f"{spec.key}: step {changed} at 0 s"
    followed = ps.Simulation(base.with_changes({"protocols": [line]})).run()
    assert given.arrays.keys() == followed.arrays.keys()
    for name, values in given.arrays.items():
        assert np.array_equal(values, followed.arrays[name], equal_nan=values.dtype.kind == "f"), name
    assert given.remarks == followed.remarks


OWN: dict[str, dict[str, object]] = {
    "pacemaker": {"pacemaker.kind": "periodic", "trigger.rule": "pacemaker"},
    "rings": {"rings.enabled": True, "rings.positions": ["5 cm"], "pacemaker.kind": "none", "trigger.rule": "none"},
    "pellet": {"pellet.load": "weight"},
}
"""What makes the parameters of a section act."""


def test_what_is_set_ends_its_protocol() -> None:
    """And no other one; event, configuration and model agree."""
    lines = ["lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 1 s", "circular.active: step 0.2 at 0 s, 0.1 at 0.01 s"]
    sim = ps.Simulation(ps.configuration("baseline", changes=SMALL | {"protocols": lines}))
    sim.advance("4 ms")
    sim.set({"lumen.pressure": "0.3 kPa"})
    sim.advance("12 ms")
    assert sim.model.lumen.pressure == pytest.approx(30.0)
    assert sim.configuration.lumen.pressure == 0.3
    assert [course.parameter for course in sim.configuration.time_courses()] == ["circular.active"]
    assert sim.model.circular.force_factor == 0.1
    assert "lumen.pressure = 0.3 kPa (its protocol ends)" in [event.words for event in sim.events()]


def test_set_takes_keys_and_no_tables() -> None:
    sim = ps.Simulation(ps.configuration("baseline", changes=SMALL))
    with pytest.raises(ConfigurationError, match="cannot change"):
        sim.set({"pacemaker": {"kind": "none"}})


def table(folder: Path, rows: int, seconds: float) -> Path:
    """A CSV of pressure and force over `seconds`, in steps of the rows."""
    file = folder / "experiment.csv"
    time = np.linspace(0.0, seconds, rows)
    columns = (time, 0.2 + 0.1 * np.sin(time), 0.2 - 0.1 * time / seconds)
    head = "time [s],lumen.pressure [kPa],longitudinal.active"
    np.savetxt(file, np.transpose(columns), fmt="%.9g", delimiter=",", header=head, comments="")
    return file


def test_one_file_of_several_columns(tmp_path: Path) -> None:
    """All of them with *, or one by its name; few rows are written out, whatever they came from."""
    file = table(tmp_path, 5, 1.0)
    both = Configuration().with_changes({"protocols": [f"*: table {file}"]})
    assert [course.parameter for course in both.time_courses()] == ["lumen.pressure", "longitudinal.active"]
    one = Configuration().with_changes({"protocols": [f"longitudinal.active: table {file}"]})
    assert one.protocols == both.protocols[1:]
    assert one.protocols[0].startswith("longitudinal.active: ramp 0.2 at 0.0 s, 0.175 at 0.25 s")
    file.write_text("time [s],lumen.presure [kPa]\n0,1\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"did you mean lumen\.pressure\?"):
        Configuration().with_changes({"protocols": [f"*: table {file}"]})
    file.write_text("time [s],wall.radius [cm]\n0,1\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"wall\.radius cannot change during a run"):
        Configuration().with_changes({"protocols": [f"*: table {file}"]})


def test_many_rows_give_the_values_of_the_same_ramp(tmp_path: Path) -> None:
    """A table of 4001 rows holds what interpolation of its file gives, in a foreign unit as in its own."""
    file = table(tmp_path, 4001, 2.0)
    (course,) = parse_all(f"lumen.pressure: table {file}", dict(UNITS))
    assert (course.file, len(course.times)) == (f"table-{course.file[6:70]}.npy", 4001)
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    for t in np.random.default_rng(1).uniform(-0.1, 2.2, 200):
        assert course.at(float(t)) == pytest.approx(np.interp(t, rows[:, 0], rows[:, 1]), abs=1e-14)
    file.write_text(file.read_text(encoding="utf-8").replace("time [s]", "time [ms]"), encoding="utf-8")
    (slow,) = parse_all(f"lumen.pressure: table {file}", dict(UNITS))
    assert slow.times[-1] == 2e-3
    assert slow.file != course.file


def test_a_run_with_a_long_table_stands_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stored, loaded, resumed and sent to other processes without the CSV; the digest is that of the content."""
    file = table(tmp_path, 3001, 3.0)
    changes = SMALL | {"protocols": [f"*: table {file}"]}
    configuration = ps.configuration("baseline", changes=changes)
    assert len(configuration.to_toml()) < 20_000
    run = ps.Simulation(configuration)
    run.advance("10 ms")
    Checkpoints(Workspace(tmp_path / "cut", tmp_path / "cut")).write(run.time, run.checkpoint())
    sent = pickle.dumps(configuration)
    whole = run.run()
    whole.save(tmp_path / "run")
    file.unlink()
    for again in (
        lambda: ps.Simulation.resume(tmp_path / "cut").run(),
        lambda: ps.load(tmp_path / "run"),
        lambda: ps.Simulation(pickle.loads(sent)).run(),
    ):
        monkeypatch.setattr(tables, "_held", {})  # as in another process
        assert again().fingerprint == whole.fingerprint
    monkeypatch.setattr(tables, "_held", {})
    with pytest.raises(ConfigurationError, match=r"beside the config\.toml of its run"):
        Configuration.from_toml(configuration.to_toml())
    monkeypatch.chdir(tmp_path / "run")
    assert Configuration.from_toml(Path("config.toml")).digest() == configuration.digest()
    (stored, *_) = Path().glob("table-*.npy")
    content = bytearray(stored.read_bytes())
    content[-1] ^= 1
    stored.write_bytes(content)
    monkeypatch.setattr(tables, "_held", {})
    with pytest.raises(ConfigurationError, match="its content has another hash"):
        Configuration.from_toml(Path("config.toml"))


@pytest.mark.slow
def test_a_million_rows_are_read_in_two_seconds(tmp_path: Path) -> None:
    file = table(tmp_path, 1_000_000, 100.0)
    begin = time.process_time()
    configuration = ps.configuration("baseline", changes=SMALL | {"protocols": [f"*: table {file}"]})
    assert time.process_time() - begin < 2.0
    (course, _) = configuration.time_courses()
    begin = time.process_time()
    for t in np.linspace(0.0, 100.0, 1000):
        course.at(float(t))
    assert time.process_time() - begin < 0.05


@pytest.mark.parametrize("content", [b"", b"x" * 100, b"\x93NUMPY\x01\x00\x10\x00{" + b"(" * 15])
def test_a_foreign_file_under_the_name_of_a_table_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / f"table-{'0' * 64}.npy"
    file.write_bytes(content)
    with pytest.raises(ConfigurationError, match="take it from its run again"):
        parse(f"lumen.pressure: table {file}", UNITS)


def test_protocols_too_long_together_become_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is stored can be read again, whatever the number of values: the longest are kept as tables, steps too."""
    knots = ", ".join(f"{0.1 + 1e-4 * k!r} at {float(k)!r} s" for k in range(999))
    keys = [f"{layer}.{name}" for layer in ("longitudinal", "circular") for name in ("active", "conductivity_scale")]
    lines = [f"{key}: step {knots}" for key in keys]
    config = Configuration().with_changes({"protocols": lines})
    assert config.protocols[:4] == tuple(lines[:4])
    more = [*lines, f"pellet.friction_coefficient: step {knots}"]
    config = Configuration().with_changes({"protocols": more})
    assert config.protocols[0].startswith(f"{keys[0]}: step table-")
    assert not any("table-" in line for line in config.protocols[1:])
    course = config.time_courses()[0]
    assert (course.shape, course.at(7.99), course.at(8.0)) == ("step", 0.1 + 7e-4, 0.1 + 8e-4)
    assert Configuration.from_toml(config.to_toml()) == config
    for name, content in tables.files_of(config.naming_tables()).items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "config.toml").write_text(config.to_toml(), encoding="utf-8")
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(tables, "_held", {})  # as in another process, in another folder
        assert Configuration.from_toml(tmp_path / "config.toml") == config
    units_of = {key: FIELDS[key].unit for key in CONDUCTANCES}
    everything = [f"{key}: step {knots.replace(' at', f' {unit} at')}" for key, unit in units_of.items()]
    config = Configuration().with_changes({"protocols": everything})
    assert len(everything) == 10
    assert Configuration.from_toml(config.to_toml()) == config


CONDUCTANCES = [
    f"{layer}.{name}"
    for layer in ("longitudinal", "circular")
    for name in ("slow_calcium", "fast_calcium", "calcium_potassium", "potassium", "leak")
]
