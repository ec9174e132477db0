"""Maps of recordings: read, treated, measured, written, drawn, all without a model."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from peristalsis import maps
from peristalsis.cli import main
from peristalsis.maps.synthetic import example

ALONE = """
import sys
from peristalsis import maps
from peristalsis.maps.drawing import map_figure
from peristalsis.maps.synthetic import example
from peristalsis.plots import style
place = sys.argv[1]
recorded = maps.read(maps.write(example()[0].part(times=(0.0, 60.0)), f"{place}/map.csv"))
found = maps.contractions(recorded)
with style.applied():
    style.write(map_figure.draw(recorded, found), __import__("pathlib").Path(place, "map.png"), "map", "map")
rooms = ("numerics", "geometry", "tissue", "wall", "pellet", "control", "model", "inputs", "running", "results")
print(len(found), *[name for name in sys.modules if name == "numba" or name.split(".")[1:2][:1] and
      name.startswith("peristalsis.") and name.split(".")[1] in rooms])
"""


def test_no_model_is_loaded(tmp_path: Path) -> None:
    """Reading, measuring and drawing a map load neither the compiler nor any room of the model."""
    done = subprocess.run(
        [sys.executable, "-c", ALONE, str(tmp_path)], capture_output=True, text=True, check=True, timeout=120
    )
    assert done.stdout.split() == ["1"], done.stdout
    assert (tmp_path / "map.png").stat().st_size > 10_000


@pytest.fixture(scope="module")
def rings() -> maps.Map:
    """The recording of the tutorial."""
    return example()[0]


def test_command_makes_reads_and_measures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["map", "rings.csv", "--synthetic", "--level", "60 s", "--write", "rings.tif", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    (about,) = answer["maps"]
    assert about["numbers"]["antegrade"] == 6
    assert about["numbers"]["retrograde"] == about["numbers"]["standing"] == 1
    assert any("running median of 60 s" in line for line in about["history"])
    assert {Path(file).name for file in answer["files"]} >= {"rings.tif", "contractions.csv", "diameter_map.png"}
    assert main(["map", "rings.csv", "--synthetic"]) == 4  # it is there


def test_a_map_cannot_be_changed(rings: maps.Map) -> None:
    with pytest.raises(ValueError, match="read-only"):
        rings.values[0, 0] = 1.0
    given = np.ones((2, 2))
    kept = maps.Map(given, np.arange(2.0), np.arange(2.0), "diameter")
    given[0, 0] = 5.0
    assert kept.values[0, 0] == 1.0


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (
            ("--resample", "1e-9 s"),
            r"a step of 1e-09 makes 6e\+10 by 101 values of 601 by 101, more than 2e\+08; resample",
        ),
        (("--resample", "1e9 s"), r"time_step \(--resample\) = 1e\+09 s must be above 0"),
        (("--level", "-60 s"), r"window \(--level\) = -60 s must be above 0"),
        (("--despike", "-1 s"), r"window \(--despike\) = -1 s must be above 0"),
    ],
)
def test_a_treatment_that_cannot_be_names_its_option(
    option: tuple[str, str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    maps.write(example()[0].part(times=(0.0, 60.0)), "map.csv")
    assert main(["map", "map.csv", *option]) == 2
    assert re.match(f"error: {said}", capsys.readouterr().err)
