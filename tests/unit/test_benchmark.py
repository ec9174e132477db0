"""The bench itself: clocks, kept measurements, counting, pages, the command. No test looks at seconds."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import clock, counting, ledger, machine, process, report
from benchmarks.command import main
from benchmarks.ledger import FILE, Ledger
from benchmarks.myokit_cable import _difference, missing
from benchmarks.parts import SOLVER, STEP, clocked
from benchmarks.registry import chosen, sections
from benchmarks.runs import track_error, tracked
from benchmarks.section import Bench, Figure, Findings, Line, Plot, Section, Table
from benchmarks.sections.explicit import quoted
from peristalsis.errors import ConfigurationError, InterruptedRun, PeristalsisError, WriteError
from peristalsis.running.simulation import Simulation

FOUND = Findings(
    (
        Figure("rate", 93.46, "M/s", low=80.0),
        Figure("error", 2.0, "mV", high=1.0, note="too | large"),
        Figure("missing", None, "s", high=1.0),
        Figure("plain", 0.0),
    ),
    (Table("A table.", ("name", "value"), (("one", 1.0), ("two", None))),),
    ("A note.",),
    (Plot("picture", "title", "x", "y", (Line("a", (1.0, 10.0), (2.0, 20.0)), Line("b", (1.0,), (3.0,), "", "*"))),),
)
SECTION = Section("made", "Made up", "About it.", lambda bench: FOUND)


# --- clocks -----------------------------------------------------------------------------------------


def test_exponent_of_a_power() -> None:
    sizes = [1.0, 2.0, 4.0, 8.0]
    fit = clock.exponent(sizes, [3.0 * size**1.25 for size in sizes])
    assert fit.value == pytest.approx(1.25, abs=1e-12)
    assert fit.half_width < 1e-10


def test_interval_of_an_exponent() -> None:
    """Against the textbook's formula at three points: t(0.975, 1) = 12.706."""
    logs = np.array([0.0, 1.0, 3.0])
    fit = clock.exponent([1.0, math.e, math.e], [1.0, math.e, math.exp(3.0)])
    x = np.array([0.0, 1.0, 1.0])
    slope = ((x - x.mean()) * logs).sum() / ((x - x.mean()) ** 2).sum()
    left = ((logs - logs.mean() - slope * (x - x.mean())) ** 2).sum()
    assert fit.value == pytest.approx(slope)
    assert fit.half_width == pytest.approx(12.7062 * math.sqrt(left / ((x - x.mean()) ** 2).sum()), rel=1e-4)


@pytest.mark.parametrize(("sizes", "costs"), [([1.0, 2.0], [1.0, 2.0]), ([1.0, 2.0, 3.0], [1.0, 0.0, 2.0])])
def test_no_exponent_from_too_little(sizes: list[float], costs: list[float]) -> None:
    with pytest.raises(ValueError, match="no exponent"):
        clock.exponent(sizes, costs)


def test_calls_are_measured_in_turns() -> None:
    """After finding out how often each must be called: a, b, a, b, ..."""
    order: list[str] = []
    found = clock.in_turns({name: lambda name=name: order.append(name) for name in "ab"}, repeats=3, least=1e-9)
    assert order[-6:] == ["a", "b"] * 3
    assert found["a"].repeats == 3
    assert found["a"].cpu > 0.0


def test_medians() -> None:
    timing = clock.Timing.of([clock.Spent(wall, cpu) for wall, cpu in ((9.0, 1.0), (2.0, 2.0), (4.0, 6.0))])
    assert (timing.wall, timing.cpu, timing.least, timing.share) == (4.0, 2.0, 1.0, 0.5)


# --- processes --------------------------------------------------------------------------------------


def test_process_is_measured() -> None:
    ended = process.code("print(sum(range(1000)))")
    assert ended.output.strip() == "499500"
    assert 0.0 < ended.spent.cpu < 60.0


def test_peak_is_that_of_the_process_alone() -> None:
    """In bytes, and not what this process held when it started the other."""
    mine = np.ones(100_000_000)  # 800 MB
    peak = process.peak_bytes("x = bytearray(150_000_000); x[::4096] = b'1' * len(x[::4096])")
    assert mine.nbytes > 7e8
    assert 150e6 < peak < 400e6


def test_failing_process_says_why() -> None:
    with pytest.raises(PeristalsisError, match=r"code 3.*because"):
        process.code("import sys; print('because', file=sys.stderr); sys.exit(3)")


# --- kept measurements ------------------------------------------------------------------------------


def counted(bench: Bench, name: str, made: list[str], value: object = 1.0) -> object:
    return bench.piece(name, lambda: (made.append(name), value)[1])


def test_interrupted_bench_goes_on(tmp_path: Path) -> None:
    """What was measured before Ctrl-C is taken from the file, and comes back as it was."""
    made: list[str] = []

    def section(bench: Bench, stop: bool) -> object:
        first = counted(bench, "first", made, {"wall": 0.5, "nan": math.nan, "many": (1, 2)})
        if stop:
            raise KeyboardInterrupt
        return first, counted(bench, "second", made)

    with pytest.raises(KeyboardInterrupt):
        section(Bench("quick", Ledger(tmp_path)), stop=True)
    assert section(Bench("quick", Ledger(tmp_path)), stop=False) == ({"wall": 0.5, "nan": None, "many": [1, 2]}, 1.0)
    assert made == ["first", "second"]


def test_measurement_belongs_to_effort_and_stamp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    counted(Bench("quick", Ledger(tmp_path)), "one", made)
    counted(Bench("full", Ledger(tmp_path)), "one", made)
    assert made == ["one"] * 2
    monkeypatch.setattr(machine, "stamp", lambda: "another machine")
    later = Ledger(tmp_path)
    counted(Bench("quick", later), "one", made)
    assert made == ["one"] * 3
    assert set(later.current("quick")) == {"one"}
    assert later.current("full") == {}


def test_sections_can_be_forgotten(tmp_path: Path) -> None:
    made: list[str] = []
    for section in ("a", "b"):
        counted(Bench("quick", Ledger(tmp_path), section), f"of {section}", made)
    kept = Ledger(tmp_path)
    kept.forget("quick", ["a"])
    for section in ("a", "b"):
        counted(Bench("quick", kept, section), f"of {section}", made)
    assert made == ["of a", "of b", "of a"]


@pytest.mark.parametrize("content", ["{", "[]", '{"quick: one": 1}'])
def test_other_files_are_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / FILE).write_text(content, encoding="utf-8")
    with pytest.raises(ConfigurationError, match="move it away"):
        Ledger(tmp_path)


def test_unwritable_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises((WriteError, ConfigurationError), match="--out"):
        Ledger(tmp_path / "file").keep("quick", "one", 1.0)


def test_stamp_knows_the_source() -> None:
    assert machine.source() in {machine.source.__wrapped__()}
    assert len(machine.stamp()) == 16
    assert set(machine.about()) >= {"processor", "cores", "memory", "versions", "commit"}


# --- counting ---------------------------------------------------------------------------------------


def test_numbers_count_what_is_done_to_them() -> None:
    counting.counts.clear()
    a, b = counting.Number(2.0), counting.Number(3.0)
    c = 1.0 + a * b - 4.0 / b
    assert c.value == pytest.approx(1.0 + 6.0 - 4.0 / 3.0)
    assert dict(counting.counts) == {"multiply": 1, "add": 2, "divide": 1}
    assert c.depth == 3.0, "the division waits for nothing"
    assert abs(-c).depth == 3.0
    assert c > a
    assert int(c) == 5
    assert counting.counts["compare"] == counting.counts["convert"] == 1


def test_arrays_count_reads_and_writes() -> None:
    cells = counting.counted(np.arange(6.0).reshape(2, 3))
    counting.counts.clear()
    cells[0, 1] = cells[1, 2] + 1.0
    assert cells[0, 1].value == 6.0
    row = cells[1]
    row[:] = cells[0]
    assert [one.value for one in row] == [0.0, 6.0, 2.0]
    assert counting.counts["store"] == 4
    assert counting.counts["load"] >= 5


def test_kernel_is_counted() -> None:
    """A loop of two multiplications, an addition, two loads and a store for each of 5 cells."""

    def kernel(x: np.ndarray, factor: float, out: np.ndarray) -> None:
        for k in range(x.size):
            out[k] = factor * x[k] * x[k] + 1.0

    arguments = (np.linspace(1.0, 2.0, 5), 0.5, np.zeros(5))
    found = counting.count(SimpleNamespace(function=kernel, arguments=arguments, nodes=5))
    assert found == {"load": 2.0, "multiply": 2.0, "add": 1.0, "store": 1.0, "depth": 3.0 / 5.0}


# --- parts of a step --------------------------------------------------------------------------------


def test_parts_are_clocked_and_put_back() -> None:
    from peristalsis import scenarios
    from peristalsis.model import sheets, stepping

    names = {**SOLVER, **STEP}
    before = stepping.advance_run, sheets.advance_layer
    run = Simulation(scenarios.configuration("baseline", changes={"grid.n_z": 200, "grid.n_z_wall": 100}))
    run.advance("2 ms")
    with clocked(SOLVER) as whole, clocked(STEP) as parts:
        run.advance("20 ms")
    assert (stepping.advance_run, sheets.advance_layer) == before
    assert set(whole) | set(parts) == set(names)
    inside = sum(one.wall for one in parts.values())
    assert 0.2 * whole["solver"].wall < inside < whole["solver"].wall, "these are most of a step, and within it"


def test_renamed_part_is_noticed() -> None:
    with pytest.raises(AttributeError), clocked({"gone": ("model.step", "_no_such_function")}):
        pass


# --- errors of tracks -------------------------------------------------------------------------------


def test_track_error() -> None:
    """Two straight tracks 1 mm apart, one of which ends first."""
    one = {"until": 2.0, "places": np.linspace(0.0, 2.0, 501).tolist()}
    other = {"until": 1.5, "places": (np.linspace(0.0, 1.5, 501) + 0.1).tolist()}
    assert track_error(one, other) == pytest.approx(0.1, rel=1e-9)
    assert track_error(one, one) == 0.0


def test_interrupted_run_is_no_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run stops at Ctrl-C and returns what it has; the bench must stop as well, and keep nothing of it."""

    def stopped_at_once(simulation: Simulation) -> object:
        simulation.failure = InterruptedRun("interrupted at t = 0 s")
        return simulation.result()

    monkeypatch.setattr(Simulation, "run", stopped_at_once)
    with pytest.raises(InterruptedRun, match="interrupted"):
        tracked({"grid.n_z": 200, "grid.n_z_wall": 100})


# --- Myokit -----------------------------------------------------------------------------------------


def test_missing_myokit_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "pip install myokit" in (missing() or "")


def test_missing_compiler_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: SimpleNamespace())
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert "C compiler" in (missing() or "")


@pytest.mark.slow
@pytest.mark.skipif(missing() is not None, reason="Myokit is an extra and needs a C compiler")
def test_myokit_computes_the_same_cell() -> None:
    """Its method is of first order: the difference halves with its step, and vanishes with it."""
    coarse, fine = _difference(0.02), _difference(0.01)
    assert coarse[0] / fine[0] == pytest.approx(2.0, abs=0.05)
    assert np.abs(2.0 * fine[1] - coarse[1]).max() < 5e-3


# --- the explicit scheme ------------------------------------------------------------------------------

EXPLICIT = """# A page

## On equal grids

| a | b |
| --- | --- |
| 1 | 2 |

## At the error of the default

The default is off by so much.

| mass | time (s) | over the default's time |
| --- | --- | --- |
| printed | 5067.3 | 2.5e+02 |
| read | 5e+06 | 2.5e+05 |
"""


def test_explicit_scheme_is_quoted() -> None:
    found = quoted(EXPLICIT)
    assert [one.value for one in found.figures] == [250.0, 250000.0]
    assert "mass printed" in found.figures[0].what
    assert found.notes[1].startswith("The default is off by so much.")
    assert "equal grids" not in found.notes[1]
    assert quoted("# Another page\n").figures == ()


# --- pages and command ------------------------------------------------------------------------------


def test_findings_are_kept_whole(tmp_path: Path) -> None:
    kept = Ledger(tmp_path)
    kept.keep("quick", f"{report.FINDINGS}made", FOUND.kept())
    found = report.collected(Ledger(tmp_path), "quick", {"made": SECTION})["made"]
    assert json.dumps(found.kept()) == json.dumps(FOUND.kept())
    assert [one.met for one in found.figures] == [True, False, None, None]


def test_pages(tmp_path: Path) -> None:
    kept = Ledger(tmp_path)
    kept.keep("quick", f"{report.FINDINGS}made", FOUND.kept())
    other = Section("other", "Another", "", lambda bench: FOUND)
    files = report.write(kept, "quick", {"made": SECTION, "other": other}, tmp_path)
    assert {file.name for file in files} == {"README.md", "figures.csv", "made.md", "picture.png"}
    index = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "| made | rate | 93.5 M/s | ≥ 80 M/s | yes |  |" in index
    assert "| made | error | 2 mV | ≤ 1 mV | **no** | too \\| large |" in index
    assert "| made | missing | not measured | ≤ 1 s | – |  |" in index
    assert "Not run: other (`python -m benchmarks other`)" in index
    assert "[Made up](made.md)" in index
    page = (tmp_path / "made.md").read_text(encoding="utf-8")
    assert "![title](picture.png)" in page
    assert "| two | – |" in page
    assert (tmp_path / "picture.png").read_bytes()[:4] == b"\x89PNG"


def test_sections_are_found_in_order() -> None:
    assert list(sections())[:3] == ["baseline", "ions", "explicit"]
    assert len(sections()) >= 9
    assert [one.name for one in chosen(["memory", "ions", "memory"])] == ["memory", "ions"]
    with pytest.raises(ConfigurationError, match="no such section"):
        chosen(["memry"])


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The one section that measures nothing, so that this is quick."""
    assert main(["explicit", "--out", str(tmp_path / "out"), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == "finished"
    assert answer["effort"] == "quick"
    assert (tmp_path / "out" / "explicit.md").is_file()
    assert (tmp_path / "out" / ledger.FILE).is_file()
    assert main(["explicit", "--out", str(tmp_path / "out"), "--anew"]) == 0
    assert "0 of 0 aims met" in capsys.readouterr().out


@pytest.mark.parametrize("words", [["nothing_such"], ["--quick", "--full"]])
def test_bad_orders(words: list[str], tmp_path: Path) -> None:
    assert main([*words, "--out", str(tmp_path)]) == 2


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (3, "3"),
        (True, "True"),
        (0.0, "0"),
        (1e-4, "1.00e-04"),
        (-0.002, "-0.002"),
        (12345.6, "12346"),
        (2e5, "2.00e+05"),
    ],
)
def test_cells_of_tables(value: object, text: str) -> None:
    assert report.number(value) == text


def test_page_of_a_bench_that_measured_nothing() -> None:
    """Nothing is left out of the list of sections, and neither load nor days are made up."""
    empty = Findings((), notes=("Only this.",))
    kept = Ledger(None)
    nothing = report.pages(kept, "quick", {"made": SECTION})
    assert "Measured never, with an unknown number of processes" in nothing["README.md"]
    kept.keep("quick", f"{report.FINDINGS}made", empty.kept())
    written = report.pages(kept, "quick", {"made": SECTION})
    assert "Not run" not in written["README.md"]
    assert written["made.md"].endswith("About it.\n\nOnly this.\n")
    assert len(written["figures.csv"].splitlines()) == 1


def test_machine_that_tells_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another system has no /proc, no load, no size of its memory; outside of a checkout there is no commit."""

    def refuse(*_: object, **__: object) -> None:
        raise OSError

    monkeypatch.setattr(machine.os, "sysconf", refuse)
    monkeypatch.setattr(machine.os, "getloadavg", refuse)
    monkeypatch.setattr(machine, "Path", lambda name: SimpleNamespace(read_text=refuse))
    monkeypatch.setattr(machine.platform, "processor", lambda: "")
    monkeypatch.setattr(machine.subprocess, "run", refuse)
    kind = machine.machine()["processor"]
    assert (machine.memory_bytes(), machine.load(), machine.processor()) == (0, -1.0, kind)
    about = machine.about()
    assert (about["memory"], about["commit"]) == ("unknown", "unknown")


@pytest.mark.parametrize(("changed", "said"), [("", "abc"), (" M step.py", "abc, changed")])
def test_commit_says_whether_the_package_was_changed(monkeypatch: pytest.MonkeyPatch, changed: str, said: str) -> None:
    def git(words: list[str], **_: object) -> object:
        return SimpleNamespace(stdout="abc\n" if "rev-parse" in words else changed)

    monkeypatch.setattr(machine.subprocess, "run", git)
    assert machine.commit() == said


def test_repeated_calls_are_counted() -> None:
    calls: list[int] = []
    assert clock.repeated(lambda: calls.append(1), 4).repeats == len(calls) == 4


@pytest.mark.parametrize(
    ("function", "kind", "value"),
    [
        (lambda x: 2.0 / x, "divide", 0.5),
        (lambda x: 1.0 - x, "add", -3.0),
        (lambda x: x**2, "function", 16.0),
        (counting._exponential, "multiply", math.exp(4.0)),
        (counting._function("root", math.sqrt), "root", 2.0),
    ],
)
def test_operations_of_numbers(function, kind: str, value: float) -> None:  # type: ignore[no-untyped-def]
    counting.counts.clear()
    found = function(counting.Number(4.0))
    assert found.value == pytest.approx(value)
    assert found.depth == (counting.EXPONENTIAL if kind == "multiply" else 1.0)
    assert counting.counts[kind] >= 1


def test_plain_numbers_are_not_counted() -> None:
    counting.counts.clear()
    assert counting._exponential(1.0) == math.exp(1.0)
    assert counting._function("root", math.sqrt)(9.0) == 3.0
    assert not counting.counts


@pytest.mark.parametrize(("other", "results"), [(3.0, (True, True, False, False)), (2.0, (False, True, False, True))])
def test_comparisons_are_counted(other: float, results: tuple[bool, ...]) -> None:
    counting.counts.clear()
    a, b = counting.Number(2.0), counting.Number(other)
    assert (a < b, a <= b, a > b, a >= b) == results
    assert (a == b) == (other == 2.0)
    assert counting.counts["compare"] == 5


@pytest.mark.parametrize("blocked", ["disk", "pages"])
def test_folders_that_cannot_be_written_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], blocked: str
) -> None:
    """By the measurement that is to be kept, or by the pages in the end."""

    def refuse(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    place = (ledger.disk, "replace_file") if blocked == "disk" else (report, "write")
    monkeypatch.setattr(*place, refuse)
    assert main(["explicit", "--out", str(tmp_path / "out")]) == 4
    said = capsys.readouterr().err
    assert "could not write" in said
    assert "No space left on device; choose another place with --out" in said
