"""Configuration and batch files from anywhere: whatever they hold, one sentence and nothing computed."""

from __future__ import annotations

import math
import re
import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from peristalsis import scenarios
from peristalsis.cli import main
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import consistency
from peristalsis.inputs.config import FIELDS, KEYS, LARGEST_TEXT, Configuration
from peristalsis.many.plan import TABLES, read_plan

NAMES = st.sampled_from([*KEYS, *TABLES, "pellet", "wall", "a", "__class__", "../x"])
UNITS = st.sampled_from(["cm", "mN*s/cm", "kPa", "s", "ms", "parsec", "cm**cm", "1/0", "°", "\\x00", "{}"])
NUMBERS = st.one_of(
    st.integers(-(10**30), 10**30).map(str),
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.sampled_from(["1e400", "-1e400", "0x10", "1_000", "9" * 400, "inf", "nan", "-0.0", "1979-05-27"]),
)
VALUES = st.one_of(
    NUMBERS,
    st.tuples(NUMBERS, UNITS).map(lambda pair: f'"{pair[0]} {pair[1]}"'),
    st.sampled_from(["true", "false", '""', "[]", "{}", "[[]]", "[1, [2]]", "{a = {b = {c = 1}}}", "'''\n'''"]),
    st.text(max_size=30).map(lambda text: f'"{text}"'),
    st.lists(NUMBERS, max_size=4).map(lambda items: f"[{', '.join(items)}]"),
    st.integers(1, 4000).map(lambda depth: "[" * depth),
    st.integers(1, 400).map(lambda depth: "[" * depth + "]" * depth),
    st.integers(1, 400).map(lambda depth: "{a = " * depth + "1" + "}" * depth),
)
LINES = st.one_of(
    st.tuples(NAMES, VALUES).map(lambda pair: f"{pair[0]} = {pair[1]}"),
    NAMES.map(lambda name: f"[{name}]"),
    NAMES.map(lambda name: f"[[{name}]]"),
    st.text(max_size=20),
)
FILES = st.lists(LINES, max_size=12).map("\n".join)
READERS: dict[str, Callable[[str], Any]] = {"configuration": Configuration.from_toml, "batch": read_plan}


def refused_or_read(reader: str, text: str) -> None:
    said = ""
    try:
        READERS[reader](text)
    except ConfigurationError as error:
        said = str(error)
    assert said.isprintable(), "one line, and nothing that a terminal would obey"


@pytest.mark.parametrize("reader", READERS)
@given(text=FILES)
@settings(max_examples=100, suppress_health_check=[HealthCheck.too_slow])
def test_any_file_is_read_or_refused_in_one_sentence(reader: str, text: str) -> None:
    """R7 in short."""
    refused_or_read(reader, text)


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
@given(text=FILES)
@settings(max_examples=10_000, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_ten_thousand_files_are_read_or_refused_in_one_sentence(reader: str, text: str) -> None:
    """R7."""
    refused_or_read(reader, text)


@given(key=st.sampled_from(list(FIELDS)), number=st.one_of(st.floats(), st.integers(-(10**400), 10**400)))
@settings(max_examples=100)
def test_every_number_of_every_field_is_taken_or_refused(key: str, number: float) -> None:
    """Bare numbers of any size, as Python hands them over."""
    try:
        value = Configuration.from_mapping({key: number}).flat()[key]
    except ConfigurationError:
        return
    assert not isinstance(value, float) or math.isfinite(value)


BOMBS = {
    "1e9 nodes": {"grid.n_z": 10**9},
    "nodes by columns": {"grid.n_z": 20_000, "grid.n_theta": 4096, "grid.n_theta_conduction": 4096},
    "1e12 steps": {"run.duration": "1e5 s", "step.conduction": "1e-4 ms", "step.wall": "1e-4 ms"},
    "huge output": {"run.duration": "1e4 s", "output.interval": "1 ms", "step.wall": "1 ms"},
    "huge number": {"pellet.radius": "9" * 100_000 + " cm"},
    "huge integer": {"grid.n_z": 10**100_000},
    "many probes": {"output.probes": ["1 cm"] * 100_000},
    "many protocols": {"protocols": ["lumen.pressure: ramp 0.1 kPa at 0 s"] * 10_000},
    "long protocol": {"protocols": ["lumen.pressure: step " + ", ".join(f"0.1 kPa at {k} s" for k in range(20_000))]},
    "many pulses": {"pacemaker.kind": "periodic", "pacemaker.count": 10**12},
}


def test_both_grids_count_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(consistency, "LARGEST_GRID", 1000)
    with pytest.raises(ConfigurationError, match="1350 nodes"):
        Configuration()


PACED = {"trigger.rule": "pacemaker", "pacemaker.kind": "cell"}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"protocols": 5}, "protocols"),
        ({"protocols": ["lumen.pressure: step 1 kPa at 0 s"] * 51}, "too many"),
        ({"output.probes": 5}, "not a list"),
        ({"output.probes": ["1 cm"] * 1001}, "at most 1000"),
        ({"pellet.radius": []}, "pellet.radius"),
        (PACED, "pacemaker.kind = cell has none"),
    ],
)
def test_things_of_another_kind(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(said)):
        Configuration.from_mapping(changes)


@pytest.mark.parametrize("bomb", BOMBS)
def test_bombs_are_refused_at_once(bomb: str) -> None:
    """S6: within a second and 50 MiB, before anything is allocated."""
    Configuration()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.process_time()
    with pytest.raises(ConfigurationError):
        scenarios.configuration(changes=BOMBS[bomb])
    assert time.process_time() - begin < 1.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50 * 1024


TEXTS = {
    "deep arrays": "a = " + "[" * 30_000,
    "deep tables": "a = " + "{a = " * 10_000,
    "deep keys": "a" + ".a" * 30_000 + " = 1",
    "deep quoted keys": "x = {" + " . ".join(['"a b"'] * 8_000) + " = 1}",
    "deep headers": "[" + "a." * 30_000 + "a]",
    "one long word": "a" * 60_000,
    "quotes": '"a' * 30_000,
    "many tables": "\n".join(f"[a{k}]" for k in range(9_000)),
    "long": "#" * (LARGEST_TEXT + 1),
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("text", TEXTS)
def test_deep_and_huge_texts_are_refused_at_once(text: str, reader: str) -> None:
    begin = time.process_time()
    with pytest.raises(ConfigurationError):
        READERS[reader](TEXTS[text])
    assert time.process_time() - begin < 1.0


PATHS = (
    "../up",
    "/etc/passwd",
    "..\\up",
    "a/../../b",
    "a\0b",
    "%2e%2e/x",
    "\\\\host\\share",
    "CON",
    "~root",
    "x" * 300,
)


@pytest.mark.parametrize("path", PATHS)
def test_names_are_no_paths(path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """S3: wherever a name is taken, one that leads elsewhere is refused, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    for words in (["run", path], ["show", path], ["run", "baseline", "--reading", path]):
        assert main(words) == 2
    with pytest.raises(ConfigurationError):
        Configuration(scenario=path)
    with pytest.raises(ConfigurationError):
        read_plan(f"[[points]]\nname = {path!r}")
    assert list(tmp_path.iterdir()) == []
