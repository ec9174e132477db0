"""Pages, tables and exit codes of `python -m verification`, with problems made up for the purpose."""

import csv
import io
import json
from pathlib import Path
from types import SimpleNamespace

import pytest

import benchmarks.command
from verification import command, credibility, registry, report
from verification.command import main
from verification.problem import Outcome, Problem, error, judged, not_applicable, order
from verification.report import carry_out, counts, pages, shortened, tally


def good() -> Outcome:
    return judged("1", [error("e", 0.5, 1.0), order("in h", [4, 2, 1, 0.5], [16, 4, 1, 0.25], 2.0)])


def bad() -> Outcome:
    return judged("1", [error("far | off", 2.0, 1.0)], "a note")


def broken() -> Outcome:
    raise ValueError("no root in the scan")


MADE_UP = (
    Problem("E1", "Good", "by hand", "quick", good, (1, 30)),
    Problem("M1", "Bad", "=by hand", "quick", bad),
    Problem("M2", "Broken", "by hand", "full", broken),
    Problem("X1", "Not posed", "by hand", "quick", lambda: not_applicable("2", "no such thing")),
)


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "problems", lambda: {problem.id: problem for problem in MADE_UP})


def test_findings_are_counted_and_breaking_off_is_a_failure() -> None:
    findings = carry_out(MADE_UP)
    assert counts(findings) == {"pass": 1, "fail": 2, "not applicable": 1, "elsewhere": 0}
    assert tally(findings) == "1 pass, 2 fail, 1 not applicable"
    assert findings[2].outcome.note == "Broke off with ValueError: no root in the scan"
    assert shortened(findings[1].outcome) == "far | off: 2, accepted ≤ 1"
    assert findings[0].row()[5:] == ("2.00", "pass")


def test_pages_hold_every_check() -> None:
    written = pages(carry_out(MADE_UP), "full")
    assert set(written) == {
        "README.md", "results.json", "results.csv", "cable_and_cell.md", "membrane_shell.md", "coupled_model.md",
    }  # fmt: skip
    assert "1 pass, 2 fail, 1 not applicable" in written["README.md"]
    assert "| far \\| off | 2 | ≤ 1 | **no** |" in written["membrane_shell.md"]
    assert "no such thing" in written["coupled_model.md"]
    content = json.loads(written["results.json"])
    assert content["counts"]["fail"] == 2
    assert content["problems"][0]["equations"] == [1, 30]
    rows = list(csv.DictReader(io.StringIO(written["results.csv"])))
    assert [row["id"] for row in rows] == ["E1", "E1", "M1", "M2", "X1"]
    assert rows[2]["source"] == "'=by hand", "no cell is a formula"


def test_pages_are_the_same_twice() -> None:
    assert pages(carry_out(MADE_UP), "full") == pages(carry_out(MADE_UP), "full")


@pytest.mark.usefixtures("made_up")
def test_command_fails_with_a_failed_problem(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 1, the table, and the pages all the same."""
    assert main(["--out", str(tmp_path / "pages")]) == 1
    said = capsys.readouterr()
    assert "far | off" in said.out
    assert "M1 Bad: fail" in said.err
    assert {"README.md", "trace.md", "credibility.md"} <= {file.name for file in (tmp_path / "pages").iterdir()}


@pytest.mark.usefixtures("made_up")
def test_named_problems_write_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["E1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["problems"][0]["verdict"] == "pass"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("made_up")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("Q7",), "problem = 'Q7': no such problem"),
        (("--quick", "--full"), "--quick and --full are both given"),
        (("E1", "--full"), "--full is given beside problem E1"),
    ],
)
def test_mistakes_are_one_line(words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(list(words)) == 2
    assert said in capsys.readouterr().err


def test_programs_beside_the_package_explain_themselves(capsys: pytest.CaptureFixture[str]) -> None:
    """`--help` ends with 0, shows every option and example, and names the program as it is called."""
    for program in (command, benchmarks.command):
        assert program.main(["--help"]) == 0
        said = capsys.readouterr().out
        home = program.__name__.partition(".")[0]
        assert f"Usage: python -m {home} [OPTIONS]" in said
        assert all(option in said for option in ("--quick", "--full", "--out", "--json", *program.EXAMPLES))
        assert program.main(["--nothing"]) == 2
        assert f"see python -m {home} --help" in capsys.readouterr().err


def test_credibility_says_what_is_not_validated() -> None:
    text = credibility.page(carry_out(MADE_UP), "full")
    for heading in ("Question of interest", "Context of use", "Verified", "Calibrated", "Chosen", "Not validated"):
        assert f"## {heading}" in text
    assert "conductivity_scale" in text
    assert "| M1 | Bad | fail | a note |" in text
    assert "Against no measurement" in text


def test_unwritable_place_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "problems", lambda: {"E1": MADE_UP[0]})
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["--out", str(tmp_path / "file" / "pages")]) == 4


def test_report_decides_nothing() -> None:
    """Verdict words come from the problems; the pages only count them."""
    assert report.VERDICTS == ("pass", "fail", "not applicable", "elsewhere")


def test_ids_are_given_once(monkeypatch: pytest.MonkeyPatch) -> None:
    module = SimpleNamespace(PROBLEMS=(MADE_UP[0], MADE_UP[0]))
    monkeypatch.setattr(registry.importlib, "import_module", lambda name: module)
    registry.problems.cache_clear()
    try:
        with pytest.raises(ValueError, match="E1 is defined twice; give 'Good' an id of its own"):
            registry.problems()
    finally:
        registry.problems.cache_clear()
