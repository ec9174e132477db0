"""Paths: what a file names lies beside it, "~" is the user's home, a byte-order mark is no fault."""

from __future__ import annotations

from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many.plan import read_plan
from peristalsis.paths import located

MARK = "\ufeff"
TABLE = "time [s],value [kPa]\n0,0.1\n1,0.2\n"
MAP = "z [cm] / angle [deg],0\n4.0,1.0\n5.0,0.5\n"
FILE = """protocols = ["lumen.pressure: table p.csv"]

[[regions]]
name = "biopsy"
shape = "map"
quantities = ["active"]
file = "maps/m.csv"
"""


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a configuration and what it names; the working folder and the home are others."""
    folder = tmp_path / "case"
    (folder / "maps").mkdir(parents=True)
    (folder / "p.csv").write_text(MARK + TABLE, encoding="utf-8")
    (folder / "maps" / "m.csv").write_text(MARK + MAP, encoding="utf-8")
    (folder / "c.toml").write_text(MARK + FILE, encoding="utf-8")
    for name in ("elsewhere", "home"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return folder


def test_files_that_a_file_names_lie_beside_it(case: Path) -> None:
    """Tables of protocols and maps of regions, whatever the working folder; all of them with a byte-order mark."""
    for config in (ps.configuration(file=case / "c.toml"), Configuration.from_toml(case / "c.toml")):
        assert config.protocols == ("lumen.pressure: ramp 0.1 kPa at 0.0 s, 0.2 kPa at 1.0 s",)
        assert config.regions[0].shape.values == ((1.0,), (0.5,))


def test_files_that_a_batch_names_lie_beside_it(case: Path) -> None:
    batch = (
        MARK + '[changes]\nprotocols = ["lumen.pressure: table p.csv"]\n[grid]\n"pellet.radius" = ["8 mm", "9 mm"]\n'
    )
    (case / "b.toml").write_text(batch, encoding="utf-8")
    plan = read_plan(case / "b.toml")
    assert all(point.configuration is not None and point.configuration.protocols for point in plan.points)


def test_paths_of_a_command_go_out_from_the_working_folder(case: Path) -> None:
    """What is typed is where the user stands."""
    with pytest.raises(ConfigurationError, match=r"p.csv.* cannot be read"):
        ps.configuration(changes={"protocols": ["lumen.pressure: table p.csv"]})
    assert ps.configuration(changes={"protocols": [f"lumen.pressure: table {case}/p.csv"]}).protocols


def test_tilde_is_the_home(case: Path) -> None:
    """In tables, maps, results, and in what a file names; a home that there is not is a sentence."""
    home = located("~")
    (home / "p.csv").write_text(TABLE, encoding="utf-8")
    assert ps.configuration(changes={"protocols": ["lumen.pressure: table ~/p.csv"]}).protocols
    (case / "t.toml").write_text('protocols = ["lumen.pressure: table ~/p.csv"]', encoding="utf-8")
    assert ps.configuration(file=case / "t.toml").protocols
    assert located("a/~") == Path("a/~")
    with pytest.raises(ConfigurationError, match="has no home folder"):
        located("~nobody-of-this-name/x")


@pytest.mark.parametrize("text", ["", " "])
def test_an_empty_path_is_named_and_is_not_the_working_folder(text: str) -> None:
    with pytest.raises(ConfigurationError, match=f"'{text}': an empty path; name a file or a folder"):
        located(text)


def test_results_go_to_and_come_from_the_home(case: Path) -> None:
    tiny = {"grid.n_z": 50, "grid.n_z_wall": 40, "run.duration": "10 ms"}
    result = ps.run("baseline", tiny, out="~/res")
    assert (located("~") / "res" / "result.nc").is_file()
    assert not Path("~").exists()
    assert ps.load("~/res").fingerprint == result.fingerprint
    assert [file.parent for file in result.plot.save("~/pictures", ["track"])] == [located("~/pictures")]


def test_text_with_a_byte_order_mark_is_read() -> None:
    assert Configuration.from_toml(MARK + 'scenario = "baseline"').scenario == "baseline"
