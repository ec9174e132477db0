"""A stored run as an RO-Crate: what the description says is in the zip, and what judges of it accept it."""

from __future__ import annotations

import hashlib
import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError, DamagedResult
from peristalsis.results.bundle import CRATE, DESCRIPTION, PROFILE, bundle

SMALL = {"grid.n_z": 50, "grid.n_z_wall": 40, "run.duration": "10 ms"}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short run."""
    folder = tmp_path_factory.mktemp("bundled") / "short"
    ps.run("baseline", SMALL, out=folder)
    return folder


def entities(file: Path) -> dict[str, dict[str, Any]]:
    """The description in a bundle, by name."""
    with zipfile.ZipFile(file) as archive:
        about = json.loads(archive.read(DESCRIPTION))
    return {one["@id"]: one for one in about["@graph"]}


def test_every_file_is_described_with_its_size_and_hash(run: Path, tmp_path: Path) -> None:
    """Nothing is in the zip that the description does not name, and nothing is named that is not in it."""
    file = bundle(run, tmp_path / "short.zip")
    known = entities(file)
    with zipfile.ZipFile(file) as archive:
        contents = {name: archive.read(name) for name in archive.namelist() if name != DESCRIPTION}
    described = {name: one for name, one in known.items() if one["@type"] == "File"}
    assert described.keys() == contents.keys() >= {"result.nc", "config.toml", "summary.json", "manifest.json"}
    assert {one["@id"] for one in known["./"]["hasPart"]} == contents.keys()
    for name, one in described.items():
        assert int(one["contentSize"]) == len(contents[name])
        assert one["sha256"] == hashlib.sha256(contents[name]).hexdigest()


def test_what_is_named_is_described(run: Path, tmp_path: Path) -> None:
    """Each reference leads to an entity; the run names its program, its input and its results."""
    known = entities(bundle(run, tmp_path / "short.zip", "A. Researcher", "https://spdx.org/licenses/CC-BY-4.0"))

    def named(value: Any) -> list[str]:
        if isinstance(value, list):
            return [name for one in value for name in named(one)]
        return [value["@id"]] if isinstance(value, dict) else []

    wanted = {name for one in known.values() for key, value in one.items() if key != "@id" for name in named(value)}
    assert wanted - known.keys() == {CRATE}
    action = known["#run"]
    assert named(action["object"]) == ["config.toml"]
    assert named(known["./"]["license"]) == ["https://spdx.org/licenses/CC-BY-4.0"]
    assert set(named(action["result"])) == {"result.nc", "summary.json"}
    assert known[named(action["instrument"])[0]]["softwareVersion"] == ps.__version__
    assert known[named(action["agent"])[0]]["name"] == "A. Researcher"
    assert named(known["./"]["conformsTo"]) == [PROFILE]


def test_what_is_not_known_is_not_said(run: Path, tmp_path: Path) -> None:
    """Neither a person nor a licence is made up."""
    known = entities(bundle(run, tmp_path / "short.zip"))
    assert "agent" not in known["#run"]
    assert "author" not in known["./"]
    assert known[known["./"]["license"]["@id"]]["name"] == "No licence is stated"


def test_a_run_has_one_bundle(run: Path, tmp_path: Path) -> None:
    """The same run gives the same bytes."""
    assert bundle(run, tmp_path / "a.zip").read_bytes() == bundle(run, tmp_path / "b.zip").read_bytes()


def test_what_a_bundle_holds_opens_as_a_run(run: Path, tmp_path: Path) -> None:
    """Unpacked, it is a stored run with every hash in order."""
    with zipfile.ZipFile(bundle(run, tmp_path / "short.zip")) as archive:
        archive.extractall(tmp_path / "unpacked")
    assert ps.load(tmp_path / "unpacked").fingerprint == ps.load(run).fingerprint


def test_what_cannot_be_bundled_is_refused(run: Path, tmp_path: Path) -> None:
    """A damaged run, a folder without one, another ending, a licence without address; and no file is left."""
    changed = tmp_path / "changed"
    ps.load(run).save(changed)
    with (changed / "summary.json").open("a", encoding="utf-8") as file:
        file.write(" ")
    with pytest.raises(DamagedResult):
        bundle(changed, tmp_path / "x.zip")
    with pytest.raises(ConfigurationError):
        bundle(tmp_path, tmp_path / "x.zip")
    with pytest.raises(ConfigurationError, match=r"ending in \.zip"):
        bundle(run, tmp_path / "x.tar")
    with pytest.raises(ConfigurationError, match="no address"):
        bundle(run, tmp_path / "x.zip", licence="mine")
    assert not list(tmp_path.glob("*.zip"))


@pytest.mark.parametrize("given", [(), ("A. Researcher", "https://spdx.org/licenses/CC-BY-4.0")])
def test_the_validator_of_the_profile_accepts_it(given: tuple[str, ...], run: Path, tmp_path: Path) -> None:
    """Every requirement of RO-Crate 1.1 and of the profile is met, in the words of roc-validator.

    It reads the vocabulary of RO-Crate from the net; where it cannot, what does not need it is judged all the same.
    """
    services = pytest.importorskip("rocrate_validator.services")
    models = pytest.importorskip("rocrate_validator.models")
    settings = services.ValidationSettings(
        rocrate_uri=str(bundle(run, tmp_path / "short.zip", *given)),
        profile_identifier="process-run-crate-0.5",
        requirement_severity=models.Severity.REQUIRED,
    )
    said = [issue.message for issue in services.validate(settings).get_issues()]
    unreachable = [text for text in said if "/context" in text]
    assert [text for text in said if text not in unreachable] == []
    if unreachable:
        pytest.skip("the vocabulary of RO-Crate cannot be reached")
