"""The matrix of Pythons and libraries: what it reads from pyproject.toml, and that no entry hides another."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from unit.programs import tool

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def matrix() -> ModuleType:
    return tool("matrix")


def test_lowest_versions_are_those_declared(matrix: ModuleType) -> None:
    project = {
        "dependencies": ["numpy>=2.1", "h5py >= 3.12.1", "typer>=0.16,<2"],
        "optional-dependencies": {"surface": ["PyVista>=0.44"]},
    }
    found = matrix.lowest(project)
    assert found == {"numpy": "2.1", "h5py": "3.12.1", "typer": "0.16", "pyvista": "0.44"}
    assert matrix.constraints(found) == "h5py==3.12.1\nnumpy==2.1\npyvista==0.44\ntyper==0.16\n"


@pytest.mark.parametrize("line", ["numpy", "numpy<3", "numpy>=2,>=2.1", "numpy>=2; python_version<'3.13'", "@"])
def test_a_dependency_without_one_lowest_version_is_refused(matrix: ModuleType, line: str) -> None:
    with pytest.raises(ValueError, match="lower bound"):
        matrix.lowest({"dependencies": [line]})


def test_every_dependency_of_this_package_has_a_lowest_version(matrix: ModuleType) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"numpy", "numba", "typer", "pytest"} <= matrix.lowest(project).keys()


def test_tests_are_counted_without_their_time(matrix: ModuleType) -> None:
    assert matrix.counted("....\n4 passed, 1 skipped in 3.21s\n") == "4 passed, 1 skipped"
    assert matrix.counted("== 1 failed, 2 passed in 63.00s (0:01:03) ==") == "1 failed, 2 passed"
    assert matrix.counted("ERROR: no module pytest") == "–"


def test_a_broken_entry_hides_no_other_and_outcomes_are_kept(
    matrix: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[str] = []

    def call(words: list[Any], folder: Path, what: str, log: Path) -> str:
        if what == "tests":
            log.write_text("5 passed in 1.00s\n", encoding="utf-8")
        if what == "environment":
            tried.append(folder.name)
        if what == "wheel":
            (folder / "wheel").mkdir()
            (folder / "wheel" / "it.whl").touch()
        if what == "install" and folder.name == "3.11-lowest":
            raise matrix.Failed("install: ERROR: no such version")
        if what == "tests" and log.name == "log.txt" and log.parent.name == "3.13-newest":
            raise OSError("no room")
        if what == "install" and log.name == "studies.txt":
            raise matrix.Failed("install: ERROR: no wheel of it")
        if what == "demo":
            (folder / "demo" / "figures").mkdir(parents=True)
            (folder / "demo" / "figures" / "track.png").touch()
        if what == "site":
            (log.parent / "site").mkdir()
            (log.parent / "site" / "index.html").touch()
        if what == "run of 1 s":
            return json.dumps(
                {"place": str(folder), "position": 2.5, "fingerprint": "abc", "versions": {"numpy": "2.1"}}
            )
        return ""

    monkeypatch.setattr(matrix, "call", call)
    monkeypatch.setattr(matrix, "find", lambda version: None if version == "3.12" else f"python{version}")
    words = ["--out", str(tmp_path / "kept"), "--page", str(tmp_path / "page.md")]
    assert matrix.main(words) == 1
    assert tried == ["3.11-newest", "3.11-lowest", "3.13-newest", "3.13-lowest"]
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| 3.11 | newest | works | 2.5 | abc | 1 pictures | 5 passed |" in text
    assert "| 3.11 | lowest | install: ERROR: no such version | – | – | – | – |" in text
    assert text.count("not tried: no such Python was found") == 2
    assert "| 3.13 | newest | OSError: no room | 2.5 | abc | 1 pictures | 5 passed |" in text
    assert "| 3.13 | lowest | works" in text
    assert "| extra | 3.11 newest | 3.13 lowest |" in text, "of entries that got so far"
    assert "| studies | install: ERROR: no wheel of it | install: ERROR: no wheel of it |" in text
    assert "| cluster | 5 passed | 5 passed |" in text
    assert "| docs | 1 pages | 1 pages |" in text
    assert matrix.main(words) == 1
    assert len(tried) == 4, "an outcome of the same sources is not computed again"
    (tmp_path / "kept" / "3.11-lowest.json").write_text("{", encoding="utf-8")
    matrix.main([*words, "--python", "3.11"])
    assert tried[4:] == ["3.11-lowest"], "one that was not kept whole is"


def test_every_extra_is_tried(matrix: ModuleType) -> None:
    """An extra without a test promises a lowest version that nobody has run."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set(matrix.EXTRAS) == set(project["optional-dependencies"])
    files = [word for words in matrix.EXTRAS.values() for word in words if word.endswith(".py")]
    assert all((ROOT / file).is_file() for file in files)
