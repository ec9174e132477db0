"""Stimuli at listed times: read, refused, delivered once with their charge, noted, stored."""

from __future__ import annotations

import pickle
import re
import tempfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis import units
from peristalsis.control.pulses import Pulse, listed, overlap_in_time
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import stimuli, tables
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.stimuli import Stimulus, read
from peristalsis.many.comparing import changed_keys

ROOT = Path(__file__).parents[2]
LINE = "longitudinal: 2 uA/cm^2 at 0.5 s for 50 ms over 0 cm to 3 mm"
SMALL = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 50,
    "grid.n_z_wall": 60,
    "run.duration": "60 ms",
    "output.interval": "20 ms",
}


def test_a_line() -> None:
    assert read([LINE], 0.3) == (Stimulus("longitudinal", 0.5, 0.05, 2.0, 0.0, 0.3),)
    around = "circular: -1 uA/cm^2 at 2 s for 0.2 s over 4 cm to 6 cm around -90 deg by 45 deg"
    assert read(around, 0.3) == (Stimulus("circular", 2.0, 0.2, -1.0, 4.0, 6.0, -90.0, 45.0),)


@given(
    st.sampled_from(("longitudinal", "circular")),
    st.floats(0.0, 1e4),
    st.floats(1e-6, 1e3),
    st.floats(-1000.0, 1000.0),
    st.floats(0.0, 100.0),
    st.floats(1e-3, 50.0),
    st.sampled_from(((0.0, 360.0), (-12.5, 45.0))),
)
def test_text_reads_back_identically(
    layer: str, onset: float, duration: float, strength: float, low: float, width: float, around: tuple[float, float]
) -> None:
    one = Stimulus(layer, onset, duration, strength, low, low + width, *around)
    assert read([one.text()], 0.3) == (one,)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("longitudinal 2 uA/cm^2 at 0.5 s", "there is no 'at' in its place"),
        ("longitudinal: 2 uA/cm^2 at 0.5 s for 50 ms over 0 cm", "there is no 'to' in its place"),
        (LINE.replace("longitudinal", "longitudnal"), "did you mean longitudinal?"),
        (LINE.replace("0.5 s", "-1 s"), "onset = -1 s is out of range; give at least 0"),
        (LINE.replace("50 ms", "0 s"), "duration = 0 s is out of range; give more than 0"),
        (LINE.replace("2 uA/cm^2", "2 mV"), "cannot be converted"),
        (LINE.replace("3 mm", "0 mm"), "is no stretch"),
        (LINE.replace("3 mm", "200 cm"), "beyond the anal end"),
        (LINE + " around 0 deg by 90 deg", "one column cannot be driven in part"),
        (LINE + " around 0 deg by 400 deg", "sector = 400 deg is out of range"),
        (5, "not a line of text"),
        ({"fle": "x.csv"}, "has the key file alone"),
        ("table no.csv", "No such file"),
        ("table .", "is not a regular file"),
        (LINE + " " * 400, "not a line of text"),
    ],
)
def test_what_is_no_stimulus_is_refused(line: object, says: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(says)):
        ps.configuration("baseline", changes={"stimuli": [line]})


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("onset [s],duration [s],strength [uA/cm^2],place [cm]\n", "no rows below a header"),
        ("onset [s],duration [s],strength [uA/cm^2]\n0,1,1\n", "column place is missing"),
        ("onset,duration [s],strength [uA/cm^2],place [cm]\n0,1,1,0\n", "column onset has no unit"),
        ("onset [s],onset [s]\n0,1\n", "column onset is there twice"),
        ("onset [s],durations [s]\n0,1\n", "did you mean duration?"),
        ("onset [s],duration [s],strength [uA/cm^2],place [cm]\n0,1,1\n", "row 1 has 3 cells and the header 4"),
        ("onset [s],duration [s],strength [uA/cm^2],place [cm]\n0,x,1,0\n", "row 1: duration = 'x s'"),
        (
            "onset [ms],duration [s],strength [uA/cm^2],place [cm]\n1e99999999,1,1,0\n",
            "row 1: onset = 1e99999999 ms is out",
        ),
        ("onset [s],duration [ms],strength [uA/cm^2],place [cm]\n0,1e-99999999,1,0\n", "give more than 0"),
        ("x" * 16_000_001, "larger than 16000000 bytes"),
    ],
    ids=["none", "no place", "no unit", "twice", "misspelled", "three cells", "no number", "huge", "tiny", "too large"],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "x.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError, match=re.escape(says)):
        read([{"file": str(file)}], 0.3)


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(1e-4, 0.5)), min_size=1, max_size=20),
    st.integers(1, 300),
)
def test_every_stimulus_is_delivered_with_its_charge(times: list[tuple[float, float]], steps: int) -> None:
    found = listed(Pulse(begin, begin + length, 0.0, 1.0, 2.0) for begin, length in times)
    ends = np.linspace(0.0, 2.0, steps + 1)
    on = sum(
        float(overlap_in_time(pulse.begin, pulse.end, a, b)) * (b - a)
        for a, b in pairwise(ends)
        for pulse in found.between(a, b)
    )
    assert on == pytest.approx(sum(length for _, length in times), rel=1e-9)


def test_a_stimulus_is_the_pulse_of_a_pacemaker_to_the_bit() -> None:
    """Alone, at the place and time of the shipped one; and on the circular layer nothing else begins."""
    line = "longitudinal: 2 uA/cm^2 at 0 s for 50 ms over 0 cm to 3 mm"
    paced = ps.Simulation(ps.configuration("baseline", changes=SMALL)).run()
    listed_alone = {"pacemaker.kind": "none", "stimuli": [line]}
    stimulated = ps.Simulation(ps.configuration("baseline", changes=SMALL | listed_alone)).run()
    for name, values in paced.arrays.items():
        if not name.startswith("event"):
            assert np.array_equal(values, stimulated.arrays[name], equal_nan=values.dtype.kind == "f"), name
    assert stimulated.arrays["event_kind"].tolist().count("stimulus") == 1
    assert stimulated.arrays["event_words"][0] == "2 uA/cm^2 for 0.05 s on the longitudinal layer"


def test_the_example_of_the_page_runs_and_its_result_does_not_need_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "docs/protocols.md").read_text(encoding="utf-8")
    blocks = [block for block in re.findall(r"```toml\n(.*?)```", page, re.S) if "stimuli" in block]
    assert len(blocks) == 2
    monkeypatch.chdir(ROOT)
    by_line, by_file = (ps.Configuration.from_toml(block) for block in blocks)
    assert len(by_line.stimuli) == 2
    monkeypatch.chdir(tmp_path)
    short = by_file.with_changes({**SMALL, "run.duration": "1.52 s"})
    result = ps.Simulation(short).run()
    kinds, times = result.arrays["event_kind"], result.arrays["event_time"]
    assert times[kinds == "stimulus"].tolist() == [0.0, 0.6, 1.2, 1.5, 1.5]
    result.save(tmp_path / "run")
    again = ps.load(tmp_path / "run").configuration
    assert again == short
    assert again.digest() == short.digest() != ps.configuration("baseline", changes=SMALL).digest()
    assert build(again).stimuli_circular.pulses[0].strength == -0.5
    assert ps.Configuration.from_toml(tmp_path / "run" / "config.toml").stimuli == short.stimuli


def test_a_long_stimulus_does_not_make_every_step_look_at_all() -> None:
    """Of thousands, those under way are found, and the look begins at the first that is not over."""
    short = [Pulse(0.01 * k, 0.01 * k + 0.005, 0.0, 1.0, 1.0) for k in range(5000)]
    found = listed([*short, Pulse(0.0, 60.0, 0.0, 1.0, 2.0), Pulse(60.0, 61.0, 0.0, 1.0, 3.0)])
    assert [pulse.strength for pulse in found.between(30.001, 30.003)] == [2.0, 1.0]
    assert [pulse.strength for pulse in found.between(60.0, 60.002)] == [3.0]
    assert found.between(61.0, 62.0) == []
    assert found.reach == tuple(sorted(found.reach))


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(1e-4, 0.5)), min_size=1, max_size=20),
    st.floats(0.0, 1.5),
    st.floats(1e-3, 0.1),
)
def test_what_is_under_way_is_what_a_look_at_all_finds(
    times: list[tuple[float, float]], start: float, step: float
) -> None:
    found = listed(Pulse(begin, begin + length, 0.0, 1.0, 2.0) for begin, length in times)
    stop = start + step
    assert found.between(start, stop) == [one for one in found.pulses if one.begin < stop and one.end > start]


def many(folder: Path, rows: int = 1500) -> Path:
    """A CSV of stimuli of both layers, one every 20 us."""
    file = folder / "many.csv"
    head = "onset [ms],duration [us],strength [uA/cm^2],place [mm],layer"
    lines = (f"{0.02 * k:.2f},10,{(-1) ** k * 2},{k % 90},{('longitudinal', 'circular')[k % 2]}" for k in range(rows))
    file.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return file


def test_a_run_with_thousands_stands_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are a file of the stored run, named by its content, that reading, other processes and resuming find."""
    file = many(tmp_path)
    config = ps.configuration("baseline", changes={**SMALL, "run.duration": "20 ms", "stimuli": f"table {file}"})
    assert len(config.stimuli) == 1500
    assert len(config.to_toml()) < 20_000
    assert config.with_changes({"run.duration": "40 ms"}).stimuli == config.stimuli
    run = ps.Simulation(config)
    run.advance("10 ms")
    checkpoint, sent = run.checkpoint(), pickle.dumps(config)
    whole = run.run()
    whole.save(tmp_path / "run")
    file.unlink()
    (tmp_path / "cut").mkdir()
    (tmp_path / "cut" / "checkpoint-a.bin").write_bytes(checkpoint)
    for again in (
        lambda: ps.Simulation.resume(tmp_path / "cut").run(),
        lambda: ps.load(tmp_path / "run"),
        lambda: ps.Simulation(pickle.loads(sent)).run(),
    ):
        monkeypatch.setattr(tables, "_lists", {})  # as in another process
        result = again()
        assert result.configuration.stimuli == config.stimuli
        assert result.fingerprint == whole.fingerprint
    monkeypatch.setattr(tables, "_lists", {})
    with pytest.raises(ConfigurationError, match=r"beside the config\.toml of its run"):
        Configuration.from_toml(config.to_toml())
    monkeypatch.chdir(tmp_path / "run")
    monkeypatch.setattr(tables, "_lists", {})
    assert Configuration.from_toml(Path("config.toml")).digest() == config.digest()
    (stored,) = Path().glob("stimuli-*.npy")
    content = bytearray(stored.read_bytes())
    content[-1] ^= 1
    stored.write_bytes(content)
    monkeypatch.setattr(tables, "_lists", {})
    with pytest.raises(ConfigurationError, match="its content has another hash"):
        Configuration.from_toml(Path("config.toml"))


def test_too_many_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stimuli, "MOST_STIMULI", 1400)
    with pytest.raises(ConfigurationError, match="more than 1400; give fewer"):
        read(f"table {many(tmp_path)}", 0.3)


def test_numbers_of_a_kept_list_are_within_their_bounds(tmp_path: Path) -> None:
    """As those of lines are: a file that somebody else made has the right name and what no stimulus can be."""
    good = read(f"table {many(tmp_path)}", 0.3)
    for wrong in ({"onset": -1.0}, {"high": good[7].low}, {"strength": float("nan")}, {"sector": 400.0}):
        bad = (*good[:7], replace(good[7], **wrong), *good[8:])
        with pytest.raises(ConfigurationError, match=r"number 8: \w+ = \S+ is out of range"):
            read(stimuli.texts(bad), 0.3)


def test_runs_that_differ_in_their_stimuli_are_compared() -> None:
    """Whether the first or the second has them."""
    plain = ps.Simulation(ps.configuration("baseline", changes=SMALL)).result()
    driven = ps.Simulation(ps.configuration("baseline", changes={**SMALL, "stimuli": [LINE]})).result()
    assert changed_keys({"a": plain, "b": driven})["stimuli"][0] == "none"
    assert changed_keys({"a": driven, "b": plain})["stimuli"] == [driven.configuration.stimuli[0].text(), "none"]


@pytest.mark.parametrize("unit", ["ms", "s", "us", "min"])
@given(st.decimals(0, 100, places=4))
def test_a_cell_is_read_as_a_quantity_is(unit: str, number: object) -> None:
    """To the bit, in whatever unit: the quick way and that of lines of text agree."""
    head = f"onset [{unit}],duration [s],strength [uA/cm^2],place [cm]"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.csv")
        file.write_text(f"{head}\n{number},1,1,0\n", encoding="utf-8")
        (one,) = read(f"table {file}", 0.3)
    assert one.onset == units.parse(f"{number} {unit}", "s", "onset")
