"""Cohorts: who is accepted, and what interventions shift, member by member, against a formula in place of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many import sweep as engine_sweep
from peristalsis.many.rows import Row
from peristalsis.many.studies.cohort import TABLES
from peristalsis.many.studies.study import read_study

COHORT = """
outputs = ["transit_s", "max_axial_force_mN"]
[changes]
grid.n_z = 50
grid.n_z_wall = 40
[design]
samples = 60
seed = 1
[cohort]
slow = "3 s"
[accept]
max_axial_force_mN = { to = 350 }
[parameters.viscous]
keys = ["pellet.viscous_friction"]
distribution = "lognormal"
median = "200 mN*s/cm"
spread = 1.5
source = "chosen"
[interventions.lubricant]
pellet.viscous_friction = { factor = 0.5 }
[interventions.dry]
pellet.dry_friction = "150 mN"
"""


@pytest.fixture(autouse=True)
def counted(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Replaces the run by a formula: transit is proportional to friction; above 300 mN s/cm the pellet stays."""
    made: list[float] = []

    def run_one(configuration: Configuration, measure: object) -> Row:
        viscous, dry = configuration.pellet.viscous_friction, configuration.pellet.dry_friction
        made.append(viscous)
        out = viscous + (100.0 if dry > 100.0 else 0.0) < 300.0
        numbers = {"transit_s": viscous / 100.0 if out else None, "max_axial_force_mN": viscous}
        return Row({"status": "expelled" if out else "arrested", "error": None, **numbers})

    monkeypatch.setattr(engine_sweep, "run_one", run_one)
    return made


def made(text: str, out: Path, **how):
    return ps.cohort(read_study(text, TABLES, ("random",)), out, **how)


def test_members_that_pass_and_what_shifts_in_them(tmp_path: Path, counted: list[float]) -> None:
    found = made(COHORT, tmp_path / "c")
    viscous = np.array(found.table.values("viscous"))
    assert found.accepted == (viscous <= 350.0).sum() < 60
    accepted = viscous[viscous <= 350.0]
    assert found.classes() == {
        "normal": (accepted < 300.0).sum(), "slow": 0, "not expelled": (accepted >= 300.0).sum(),
    }  # fmt: skip
    before, lubricant, dry = found.shifts
    assert before.shift is None
    out = accepted[accepted < 300.0]
    assert lubricant.expelled == accepted.size
    assert (lubricant.gained, lubricant.lost) == ((accepted >= 300.0).sum(), 0)
    assert lubricant.shift == pytest.approx(-0.5 * np.median(out) / 100.0, rel=1e-12)
    assert lubricant.band[0] < lubricant.shift < lubricant.band[1] < 0.0
    assert (dry.gained, dry.lost) == (0, ((accepted >= 200.0) & (accepted < 300.0)).sum())
    assert dry.shift == 0.0
    assert len(counted) == 60 + 2 * accepted.size
    lines = (tmp_path / "c" / "members.csv").read_text(encoding="utf-8").splitlines()
    assert sum(line.split(",")[-2] == "no" for line in lines) == 60 - found.accepted
    assert len((tmp_path / "c" / "shifts.csv").read_text(encoding="utf-8").splitlines()) == 4


def test_slow_is_beyond_the_stated_transit(tmp_path: Path) -> None:
    found = made(COHORT.replace('"3 s"', '"1.5 s"'), tmp_path / "c")
    times = found.transits["before"]
    assert found.classes()["slow"] == (times > 1.5).sum() > 0


def test_another_intervention_runs_only_itself(tmp_path: Path, counted: list[float]) -> None:
    said: list[str] = []
    first = made(COHORT, tmp_path / "c")
    runs = len(counted)
    made(
        COHORT + "[interventions.thin]\npellet.viscous_friction = { factor = 0.25 }\n", tmp_path / "c", say=said.append
    )
    assert len(counted) == runs + first.accepted
    assert said == ["the study has changed: more: interventions is another"]


def test_a_distribution_without_a_source_is_said(tmp_path: Path) -> None:
    said: list[str] = []
    made(COHORT.replace('source = "chosen"\n', ""), tmp_path / "c", say=said.append)
    assert said == ["viscous: its distribution names no source"]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("{ to = 350 }", "{ to = 1 }", "none of 60 members passes"),
        ("{ to = 350 }", "{ under = 1 }", "no output of a study"),
        ("{ to = 350 }", "{ from = 2, to = 1 }", "exchange them"),
        ("max_axial_force_mN = {", "max_force = {", "no output of a study"),
        ("{ to = 350 }", '{ to = "350 mN" }', "accept"),
        ('slow = "3 s"', "slow = 3", "the unit is missing"),
        ('slow = "3 s"', 'fast = "3 s"', "give a table with slow"),
        ("[interventions.dry]", "[interventions.before]", "choose another name"),
        ('pellet.dry_friction = "150 mN"', 'pellet.dry_frction = "150 mN"', "did you mean pellet.dry_friction"),
        ('pellet.dry_friction = "150 mN"', "pellet.shape = { factor = 2 }", "has no factor"),
        ('pellet.dry_friction = "150 mN"', 'pellet.dry_friction = "150 mm"', "dry_friction"),
    ],
)
def test_refusals(tmp_path: Path, old: str, new: str, text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        made(COHORT.replace(old, new), tmp_path / "c")


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.toml").write_text(COHORT, encoding="utf-8")
    assert dispatch(["cohort", "c.toml"]) == 0
    assert "not medical advice" in capsys.readouterr().out
    assert sorted(path.name for path in Path("out/c").iterdir()) == [
        "cohort.png", "members.csv", "shifts.csv", "study.json", "table.csv", "times.csv",
    ]  # fmt: skip
