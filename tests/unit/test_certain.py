"""`--certain`: the neighbour grid and step are run as well, and their answers compared."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.errors import ConfigurationError
from peristalsis.names import CERTAIN
from peristalsis.results.result import Result
from peristalsis.running import certain
from peristalsis.running.certain import Neighbour, compare, make_certain, neighbours, table_text
from peristalsis.running.pool import Failure

TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "40 ms"}
SET = tuple(word for key, value in TINY.items() for word in ("--set", f"{key}={value}"))


@pytest.fixture(scope="module")
def tiny() -> Result:
    """A run of a moment."""
    return ps.run("baseline", TINY)


def like(run: Result, **summary: Any) -> Neighbour:
    """A neighbour that came to something else."""
    kept = certain.kept_of(run)
    return Neighbour({**kept.summary, **summary}, kept.time, kept.position)


def test_neighbours_are_twice_as_fine() -> None:
    made = neighbours(ps.configuration("baseline"))
    assert (made["grid"].grid.n_z, made["grid"].grid.n_z_wall, made["grid"].step.wall) == (1400, 1300, 5.0)
    assert (made["step"].step.wall, made["step"].step.conduction, made["step"].grid.n_z) == (2.5, 0.5, 700)


def test_a_neighbour_that_cannot_be_is_refused_beforehand() -> None:
    """Before the run, not when its hours are over."""
    changes = {"grid.n_z": 12000, "output.interval": "1 s"}
    with pytest.raises(ConfigurationError, match="the neighbour with the doubled grid cannot be run"):
        ps.run("baseline", changes, certain=True)


def test_a_certain_run_says_so(tiny: Result) -> None:
    sure = ps.run("baseline", TINY, certain=True)
    verdict = sure.summary[CERTAIN]
    assert verdict["agrees"] is True
    assert verdict["within_percent"] < 2.0
    assert "agrees with its neighbours within" in verdict["sentence"]
    assert set(verdict["runs"]) == {"grid", "step"}
    assert verdict["runs"]["step"]["track_rms_cm"] < 1e-3
    assert sure.fingerprint == tiny.fingerprint


@pytest.mark.parametrize(
    ("own", "other", "expected"),
    [
        ({"transit_s": 1.974, "status": "expelled"}, {"transit_s": 2.799, "status": "expelled"}, 41.79),
        ({"transit_s": 2.0, "status": "expelled"}, {"transit_s": 2.01, "status": "expelled"}, 0.5),
        ({"final_position_cm": 2.76}, {"final_position_cm": 3.06}, 10.87),
        ({"status": "expelled", "transit_s": 3.0}, {"status": "arrested"}, None),
        ({"final_position_cm": None}, {"final_position_cm": None}, 0.0),
    ],
)
def test_change_of_the_outcome(
    tiny: Result, own: Mapping[str, Any], other: Mapping[str, Any], expected: float | None
) -> None:
    """Of the transit, else of the last position, else of the pressure; none where the runs end differently."""
    run = replace(tiny, summary={**tiny.summary, **own})
    verdict = compare(run, {"grid": like(tiny, **other)})
    found = verdict["runs"]["grid"]["change_percent"]
    assert found == (None if expected is None else pytest.approx(expected, abs=0.01))
    agrees = expected is not None and expected <= 2.0
    assert verdict["agrees"] is agrees
    assert ("do not use" in verdict["sentence"]) is not agrees


def test_a_neighbour_that_fails_is_no_agreement(tiny: Result) -> None:
    verdict = compare(tiny, {"grid": Failure("it died"), "step": like(tiny)})
    assert verdict["agrees"] is False
    assert "failed (it died)" in verdict["sentence"]
    diverged = compare(tiny, {"grid": like(tiny, status="diverged", error="no equilibrium")})
    assert diverged["agrees"] is False
    assert "diverged (no equilibrium)" in diverged["sentence"]
    rows = list(csv.reader(table_text(verdict, tiny.summary).splitlines()))
    assert [row[0] for row in rows] == ["run", "as asked", "doubled grid", "halved steps"]
    assert rows[2][-1] == "it died"


def test_interruption_leaves_the_run_and_says_that_nothing_is_known(
    tiny: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(certain, "_run", lambda _: like(tiny, status="interrupted"))
    verdict = make_certain(tiny).summary[CERTAIN]
    assert verdict["agrees"] is None
    assert "interrupted" in verdict["sentence"]


def test_runs_that_broke_off_are_not_compared(tiny: Result) -> None:
    broken = replace(tiny, summary={**tiny.summary, "status": "diverged"})
    assert make_certain(broken) is broken


def test_command_line_says_cost_verdict_and_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Cost beforehand; then sentence, JSON object, stored summary and CSV; --resume adds it to a finished run."""
    monkeypatch.chdir(tmp_path)
    assert main(["run", "baseline", *SET, "--no-plots", "--out", "r"]) == 0
    assert CERTAIN not in json.loads(Path("r/summary.json").read_text())
    before = ps.load("r").fingerprint
    capsys.readouterr()
    assert main(["run", "baseline", *SET, "--no-plots", "--out", "r", "--resume", "--certain"]) == 0
    said = capsys.readouterr()
    assert "costs about four times the run itself in addition" in said.err
    assert "certain: agrees with its neighbours" in said.out
    assert json.loads(Path("r/summary.json").read_text())[CERTAIN]["agrees"] is True
    assert Path("r/certain.csv").read_text().startswith("run,status,transit_s")
    assert ps.load("r").fingerprint == before
    assert main(["check", "r"]) == 0
    capsys.readouterr()
    monkeypatch.setattr(certain, "_run", lambda _: pytest.fail("it is known already"))
    assert main(["run", "baseline", *SET, "--no-plots", "--out", "r", "--resume", "--certain", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[CERTAIN]["agrees"] is True


def test_python_stores_the_verdict(tmp_path: Path) -> None:
    result = ps.run("baseline", TINY, out=tmp_path / "r", certain=True)
    assert ps.load(tmp_path / "r").summary[CERTAIN] == result.summary[CERTAIN]
    assert (tmp_path / "r" / "certain.csv").is_file()
    again = ps.run("baseline", TINY, out=tmp_path / "r", resume=True, certain=True)
    assert again.summary[CERTAIN]["agrees"] is True


@pytest.mark.slow
def test_neighbours_run_side_by_side() -> None:
    """Two processes give what one gives."""
    one, two = (ps.run("baseline", TINY, certain=True, workers=n).summary[CERTAIN] for n in (1, 2))
    assert one == two


def test_workers_beyond_the_neighbours_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "r")
    assert main(["run", "baseline", *SET, "--certain", "--workers", "3", "--out", out]) == 2
    assert "choose 1 or 2" in capsys.readouterr().err


def test_track_of_a_shorter_neighbour_is_compared_as_far_as_it_goes(tiny: Result) -> None:
    kept = certain.kept_of(tiny)
    shorter = Neighbour(kept.summary, kept.time[:10], kept.position[:10] + 0.1)
    assert compare(tiny, {"grid": shorter})["runs"]["grid"]["track_rms_cm"] == pytest.approx(0.1)
    assert np.isfinite(compare(tiny, {"grid": shorter})["within_percent"])
