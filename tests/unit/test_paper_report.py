"""The report from made-up records: tables, figures, the page, and the command that writes them."""

from __future__ import annotations

import base64
import csv
import json
import re
import shlex
import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import scenarios
from peristalsis.cli import main, paper_command
from peristalsis.cli.inputs import read_settings
from peristalsis.cli.paper_command import PaperOrder, carry_out_order, paper
from peristalsis.cli.streams import Screen
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.inputs.parameters import READINGS
from peristalsis.many.rows import Point as NamedPoint
from peristalsis.many.rows import Row, Step
from peristalsis.many.sweep import run_one
from peristalsis.many.threshold import Point, Threshold
from peristalsis.plots import style
from peristalsis.scoring import measure as measures
from peristalsis.scoring import sources, tables
from peristalsis.scoring.drawing import COLOURS
from peristalsis.scoring.measure import FIELDS
from peristalsis.scoring.outcome import Condition, Outcome
from peristalsis.scoring.paper import tables as own_tables
from peristalsis.scoring.paper.figures import FIGURES
from peristalsis.scoring.paper.runs import RUNS
from peristalsis.scoring.paper.searches import SEARCHES
from peristalsis.scoring.paper.source import SOURCE
from peristalsis.scoring.paper.variants import VARIANTS
from peristalsis.scoring.report import scores_of, write_report
from peristalsis.scoring.runs import Bench, carry_out
from peristalsis.scoring.source import Source
from peristalsis.scoring.tables import all_tables, matrix, numbers


@pytest.fixture(autouse=True)
def coarse_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing is most of the time of these tests."""
    monkeypatch.setattr("peristalsis.plots.style.DPI", 30)
    monkeypatch.setitem(style._SETTINGS, "savefig.dpi", 30)


def record(transit: float = 2.4) -> Row:
    """A pellet in uniform motion, with all that a figure may ask for."""
    time = np.linspace(0.0, transit, 30)
    wall = np.linspace(0.0, 10.0, 41)
    arrays: dict[str, Any] = {"time_step": time, "time": time[::5], "z": wall}
    arrays |= {name: np.linspace(1.2, 9.1, 30) for name in ("pellet_position", "pellet_velocity", "circular_force")}
    arrays |= {name: np.ones((6, 41)) for name in FIELDS} | {"axial_position": np.tile(wall, (6, 1))}
    found = {
        "status": "expelled",
        "error": None,
        "transit_s": transit,
        "travel_cm": 7.9,
        "mean_velocity_cm_s": 7.9 / transit,
        "simulated_s": transit,
        "irregularity": 0.2,
        "stops": 0,
        "mixing": 0.2,
    }
    return Row(found, arrays)


def outcome(reading: str = "tight") -> Outcome:
    """One condition with every run, one of them refused, and every threshold."""
    records = {name: record() for name in RUNS}
    records["fig7c"] = Row({"status": "refused", "error": "the tube <cannot> hold this pellet"})
    measured: dict[str, Any] = {name: one.summary for name, one in records.items()}
    points = (Point(1.0, False), Point(2.0, True))
    thresholds = {name: Threshold(1.0, 2.0, points, ((1.0, 2.0),)) for name in SEARCHES}
    for name in SEARCHES:
        measured[name] = {"status": "finished", "threshold": 1.5}
    share = {"status": "finished"} | {
        f"{factor}{end}": 0.5 for factor in ("viscous", "dry") for end in ("", "_low", "_high")
    }
    measured |= {"equal_percentages": share, "paper_ranges": share}
    return Outcome(Condition(reading), records, thresholds, measured)


def test_the_matrix_has_every_claim_and_every_reading() -> None:
    outcomes = [outcome("tight"), outcome("stretched"), outcome("printed")]
    table = matrix(SOURCE, scores_of(SOURCE, outcomes))
    assert table.columns[-3:] == ("tight", "stretched", "printed")
    assert [row[0] for row in table.rows] == [*(str(number) for number in range(1, 31)), "–"]
    assert table.rows[-1][4].startswith("not testable")
    assert "r0 = 0.6 faster (not testable)" in "".join(table.rows[20])
    assert table.rows[0][3].startswith("calibrated")


def test_explanations_name_commands_that_are_valid() -> None:
    """Every command that is said to show a failure is one that the program takes."""
    with Path(own_tables.__file__).with_name("explanations.toml").open("rb") as file:
        entries = tomllib.load(file)["explanation"]
    for entry in entries:
        assert 1 <= entry["claim"] <= 30
        assert entry["reading"] in READINGS
        for text in (entry["command"], entry.get("shown", entry["command"])):
            for line in text.split("; "):
                program, command, name, *options = shlex.split(line)
                assert (program, command) == ("peristalsis", "run")
                pairs = list(zip(options[::2], options[1::2], strict=True))
                assert {key for key, _ in pairs} <= {"--set", "--reading"}
                reading = next((value for key, value in pairs if key == "--reading"), "tight")
                assert reading == entry["reading"]
                settings = read_settings([value for key, value in pairs if key == "--set"])
                scenarios.configuration(name, reading=reading, changes=settings)


def test_chosen_and_calibrated_numbers_come_from_the_parameters() -> None:
    calibrated, chosen = numbers("calibrated"), numbers("chosen")
    assert {row[0] for row in calibrated.rows} == {"longitudinal.conductivity_scale", "circular.conductivity_scale"}
    assert ("pellet.radius", "tight") in {row[:2] for row in chosen.rows}
    assert ("wall.c10", "tight") in {row[:2] for row in chosen.rows}


def test_the_page_is_self_contained_and_escaped(tmp_path: Path) -> None:
    page = write_report(SOURCE, [outcome(), outcome("printed")], tmp_path)
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:)', text)
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', text)
    assert len(pictures) == len(FIGURES)
    assert all(base64.b64decode(one).startswith(b"\x89PNG") for one in pictures)
    assert "&lt;cannot&gt;" in text
    assert "<cannot>" not in text
    for number in range(1, 8):
        assert f"Fig. {number}: " in text


@pytest.fixture
def two_figures(monkeypatch: pytest.MonkeyPatch) -> Source:
    """Where the drawing itself is not what is tested."""
    kept = replace(SOURCE, pictures=tuple(figure for figure in FIGURES if figure.name in ("fig2", "fig4")))
    monkeypatch.setattr(sources, "get", {"paper": kept}.__getitem__)
    return kept


def test_every_table_and_figure_is_a_file(tmp_path: Path, two_figures: Source) -> None:
    outcomes = [outcome()]
    write_report(two_figures, outcomes, tmp_path)
    for table in all_tables(SOURCE, outcomes, scores_of(SOURCE, outcomes)):
        with (tmp_path / f"{table.name}.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        assert rows == [list(table.columns), *(list(row) for row in table.rows)]
    for name in ("fig2", "fig4"):
        assert (tmp_path / f"{name}.png").is_file()
        assert (tmp_path / f"{name}.svg").is_file()


def test_one_figure_alone(tmp_path: Path) -> None:
    drawn = write_report(SOURCE, [outcome()], tmp_path, only="3")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fig3.png", "fig3.svg"]
    assert drawn.name == "fig3.png"


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(WriteError, match="choose another folder"):
        write_report(SOURCE, [outcome()], tmp_path / "file" / "report", only="2")


def test_a_refused_run_has_a_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fig. 7 C under `stretched` is refused; nothing is run for it."""
    seen: list[str] = []

    def made(configurations, *_: Any) -> dict[str, Row]:
        seen.extend(configurations)
        return {name: record() for name in configurations}

    monkeypatch.setattr("peristalsis.scoring.runs.sweep", made)
    found = carry_out(Bench(SOURCE, tmp_path), Condition("stretched"), ["fig7a", "fig7c"], searches=False)
    assert seen == ["fig7a"]
    assert found.measured["fig7c"]["status"] == "refused"


def test_searches_and_sensitivities_become_metrics(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Arrest above 9 kPa, below a ratio of 1.05 and above 700 mN; mean velocity falls with viscous friction alone."""

    def one(configuration) -> Row:
        pellet = configuration.pellet
        arrested = (
            configuration.lumen.pressure > 9.0
            or pellet.radius < 1.05 * configuration.wall.radius
            or pellet.dry_friction > 700.0
        )
        made = record(pellet.viscous_friction / 100.0)
        more: dict[str, Any] = {"inflated_ratio": pellet.radius / (1.03 * configuration.wall.radius)}
        more |= {"mean_velocity_cm_s": 790.0 / pellet.viscous_friction}
        if arrested:
            more |= {"status": "arrested", "transit_s": None}
        return Row({**made.summary, **more})

    monkeypatch.setattr(
        "peristalsis.scoring.runs.sweep", lambda configurations, *_: {n: one(c) for n, c in configurations.items()}
    )
    found = carry_out(Bench(SOURCE, tmp_path), Condition("tight"), [], searches=True)
    assert found.measured["pressure_of_arrest"]["threshold"] == pytest.approx(9.0, rel=0.02)
    assert found.measured["ratio_of_arrest"]["threshold"] == pytest.approx(1.05, rel=0.02)
    assert found.measured["ratio_of_arrest"]["threshold_inflated"] == pytest.approx(1.05 / 1.03, rel=0.02)
    assert found.measured["dry_friction_of_arrest"]["threshold"] == pytest.approx(700.0, rel=0.02)
    assert found.measured["equal_percentages"]["viscous_low"] == pytest.approx(1.0)
    assert found.measured["equal_percentages"]["dry_high"] == pytest.approx(0.0, abs=1e-12)


def test_force_that_rises_throughout_has_no_setback() -> None:
    position, rising = np.linspace(0.0, 8.0, 201), np.linspace(1.0, 3.0, 201)
    rise, setback = measures.force_course(position, rising)
    assert rise == pytest.approx(2.9 / 1.1, rel=0.01)
    assert setback == 0.0
    fallen = np.where(position > 4.0, rising - 1.0, rising)
    assert measures.force_course(position, fallen)[1] == pytest.approx(1.0 / fallen[10:191].max(), rel=0.05)
    assert measures.force_course(np.zeros(201), rising) == (None, None)


def test_the_anal_end_is_active_only_where_it_pulls() -> None:
    z = np.linspace(0.0, 10.0, 101)
    pull = np.zeros((3, 101, 1))
    pull[1, 50] = 10.0
    assert measures.anal_active_share(z, pull, np.zeros_like(pull)) == 0.0
    pull[2, -1] = 4.0
    assert measures.anal_active_share(z, pull, np.zeros_like(pull)) == pytest.approx(0.4)
    assert measures.anal_active_share(z, np.zeros_like(pull), np.zeros_like(pull)) is None


def test_ends_that_move_are_seen() -> None:
    axial = np.tile(np.linspace(0.0, 10.0, 11)[None, :, None], (3, 1, 1))
    assert measures.end_displacement(axial, np.ones_like(axial)) == 0.0
    axial[2, -1] += 0.25
    assert measures.end_displacement(axial, np.ones_like(axial)) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"figure": "8"}, "figures 1 to 7"),
        ({"reading": "tigth"}, "did you mean tight"),
        ({"workers": 0}, "1 to 64"),
        ({"variant": ["dubbled"]}, "doubled"),
    ],
)
def test_bad_options_are_refused_with_a_fix(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        paper(**{"figure": None, "reading": "tight", "workers": 1, "out": "x", "coarse": False, **options})


@pytest.mark.usefixtures("two_figures")
def test_the_command_runs_scores_and_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = []

    def made(bench: Bench, condition: Condition, names: Any, searches: bool) -> Outcome:
        asked.append((condition.reading, dict(condition.variant), names, searches))
        return outcome(condition.reading)

    monkeypatch.setattr("peristalsis.scoring.runs.carry_out", made)
    order = PaperOrder(None, "all", 1, tmp_path, coarse=False)
    assert carry_out_order(order, Screen(json=True)) == 0
    answer = json.loads(capsys.readouterr().out)
    assert list(answer["verdicts"]) == list(READINGS)
    assert set(answer["verdicts"]["tight"]) == {str(number) for number in range(1, 31)}
    assert Path(answer["written"]).is_file()
    assert [one[0] for one in asked] == list(READINGS)
    assert carry_out_order(PaperOrder("4", "tight", 1, tmp_path, coarse=True), Screen(json=False)) == 0
    reading, variant, names, searches = asked[-1]
    assert (reading, searches) == ("tight", False)
    assert set(names) == {"fig4a", "fig4b", "fig4c", "fig4d"}
    assert "grid.n_z" in variant
    asked.clear()
    varied = PaperOrder(None, "tight", 1, tmp_path, coarse=False, variants=("doubled", "moving-wall"))
    assert carry_out_order(varied, Screen(json=False)) == 0
    assert [one[1] for one in asked] == [{}, {"run.duration": "20 s"}, {"pellet.friction_frame": "wall"}]
    assert [one[3] for one in asked] == [True, True, False]


def test_variants_may_be_repeated_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[PaperOrder] = []

    def noted(order: PaperOrder, screen: Screen) -> int:
        asked.append(order)
        return 0

    monkeypatch.setattr(paper_command, "carry_out_order", noted)
    assert main(["paper", "--variant", "doubled", "--variant", "total"]) == 0
    assert asked[0].variants == ("doubled", "total")


@pytest.mark.parametrize("reading", ["tight", "stretched", "printed"])
def test_every_variant_is_a_configuration_that_differs(reading: str) -> None:
    plain = RUNS["baseline"].configuration(reading)
    for one in VARIANTS.values():
        varied = RUNS["baseline"].configuration(reading, one.changes)
        assert plain.digest() != varied.digest(), one.name


def test_importing_the_command_is_light() -> None:
    """The options are parsed before anything heavy is loaded."""
    source = Path(paper_command.__file__).read_text(encoding="utf-8")
    top = [line for line in source.splitlines() if line.startswith(("import ", "from "))]
    assert not any(word in line for line in top for word in ("scoring", "studies", "numpy", "matplotlib"))


def test_conditions_that_lack_runs_leave_gaps_and_no_error() -> None:
    """Of two readings the second has no usable baseline, no thresholds and nothing measured: the first is all there."""
    full = outcome()
    bare = Outcome(Condition("stretched"), {"baseline": Row({"status": "refused", "error": "no"})}, {}, {})
    nothing = Outcome(Condition("stretched"), {}, {}, {})
    for table in (partial(tables.velocities, SOURCE), partial(tables.sensitivities, SOURCE), own_tables.curves):
        assert table([full, nothing]).rows == table([full]).rows
    by_name = {figure.name: figure.draw for figure in FIGURES}
    for name in ("thresholds", "circular_force"):
        lines = [[len(axes.lines) for axes in by_name[name](given).axes] for given in ([full], [full, bare])]
        assert lines[0] == lines[1] != [0] * len(lines[0])
    for name in ("fig1", "abstract"):
        assert by_name[name]([full]).axes
        assert not any(axes.has_data() for axes in by_name[name]([bare]).axes)


def test_more_conditions_than_colours_are_drawn_and_told_apart() -> None:
    """A reading with every variant is nine conditions, and there are eight colours."""
    count = len(COLOURS) + 2
    many = [replace(outcome(), condition=Condition("edge", {}, f"edge, {number}")) for number in range(count)]
    empty = [Outcome(one.condition, {}, {}, {}) for one in many]
    for picture in FIGURES:
        if picture.drawable(many):
            figure = picture.draw(many)
            figure.draw_without_rendering()
            assert max(figure.get_size_inches()) < 30.0, picture.name
    channels = next(one for one in FIGURES if one.number == "5").draw(many)
    lines = channels.axes[3].get_lines()
    assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == len(lines) == count
    for picture in sources.get("bench").pictures:
        picture.draw(empty).draw_without_rendering()


def test_sensitivity_without_velocities_failed() -> None:
    failed = replace(outcome(), measured={"equal_percentages": {"status": "failed", "error": "no velocity"}})
    assert tables.sensitivities(SOURCE, [failed]).rows == ()


def test_every_step_of_the_paper_is_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    say = paper_command.RunProgress(Screen(json=False), "tight")
    broken = Row({"status": "refused", "error": "the tube cannot hold this pellet"})
    made_so_far = ((record(2.4), True), (Row({"status": "not_arrived"}), False), (broken, False))
    for done, (made, kept) in enumerate(made_so_far, start=1):
        say(Step(replace(made, point=NamedPoint("fig2")), done, 9, kept))
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "tight   1/9 fig2: expelled at 2.40 s (kept)",
        "tight   2/9 fig2: not arrived",
        "tight   3/9 fig2: refused: the tube cannot hold this pellet",
    ]


def test_a_real_run_is_measured() -> None:
    """What it kept of the run is the run's own, thinned, in single precision."""
    changes = {"grid.n_z": 200, "grid.n_z_wall": 100, "run.duration": "0.2 s"}
    found = run_one(scenarios.configuration("baseline", changes=changes), measures.measure)
    run = ps.run("baseline", changes)
    assert found.status == run.status
    assert found.summary["travel_cm"] == run.summary["travel_cm"]
    assert found.summary["drift_cm"] == abs(run.arrays["pellet_position"][-1] - run.arrays["pellet_position"][0])
    free = run.configuration.wall.radius
    assert 1.0 < found.summary["inflated_ratio"] < run.configuration.pellet.radius / free
    assert found.summary["pulses"] == int((run.arrays["event_kind"] == "pacemaker").sum())
    assert len(found.arrays["time_step"]) == min(len(run.arrays["time_step"]), measures.TIMES)
    assert {values.dtype for values in found.arrays.values()} == {np.dtype(np.float32)}
    assert np.array_equal(found.arrays["time"], run.arrays["time"].astype(np.float32))
    assert not {"drift_cm", "stops"} & set(
        run_one(scenarios.configuration("resting", changes=changes), measures.measure).summary
    )


def test_a_run_that_cannot_begin_is_a_record() -> None:
    changes = {"grid.n_z": 40, "grid.n_z_wall": 40, "pellet.radius": "1.74 cm", "wall.c5": 40.0}
    found = run_one(scenarios.configuration("baseline", changes=changes), measures.measure)
    assert found.status == "diverged"
    assert "cannot hold this pellet" in found.summary["error"]
    assert not found.arrays
