"""Cells of the stomach, export and import: equal equations on both ways, each construct, each refusal."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from peristalsis.cells import description
from peristalsis.cells.description import described, shipped
from peristalsis.cells.exporting import equations, export, written
from peristalsis.cli import main
from peristalsis.errors import ConfigurationError

FOREIGN = Path(__file__).parents[1] / "cells"
SHIPPED = ("corrias_buist_2007", "du_2013", "fitzhugh_nagumo", "hodgkin_huxley", "morris_lecar")
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def myokit() -> object:
    return pytest.importorskip("myokit")


def test_shipped_cells_are_found() -> None:
    assert set(SHIPPED) <= set(shipped())


@pytest.mark.parametrize("name", ["corrias_buist_2007", "du_2013"])
def test_a_cell_declares_what_it_takes(name: str) -> None:
    module = described(name).module
    assert tuple(one.name for one in module.PARAMETERS) == module.CellConstants._fields
    assert tuple(one.name for one in module.CONDUCTANCES) == module.CHANNELS
    assert all(one.source for one in (*module.PARAMETERS, *module.CONDUCTANCES) if one.tag == "sourced")
    assert len(module.START) == 1 + len(module.STATES)
    for value, (_, low, high) in zip(module.START[1:], module.STATES, strict=True):
        assert low <= value <= high


def course(name: str, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """(times, potential) of a cell left alone, by SciPy."""
    from scipy.integrate import solve_ivp

    cell = described(name)
    of = description.rates(cell)
    solved = solve_ivp(lambda t, y: of(float(y[0]), y[1:], 0.0), (0.0, duration), description.start(cell),
                       method="LSODA", rtol=1e-7, atol=1e-9, max_step=200.0)  # fmt: skip
    return solved.t, solved.y[0]


def test_the_pacemaker_makes_three_slow_waves_a_minute_by_itself() -> None:
    times, v = course("du_2013", 45000.0)
    rises = times[1:][(v[:-1] < -50.0) & (v[1:] >= -50.0)]
    assert np.diff(rises)[-1] == pytest.approx(20100.0, abs=120.0)
    late = v[times > 21000.0]
    assert late.min() == pytest.approx(-71.9, abs=0.3)
    assert late.max() == pytest.approx(-32.7, abs=0.3)


def test_the_muscle_rests_near_minus_seventy() -> None:
    _, v = course("corrias_buist_2007", 20000.0)
    assert v[-1] == pytest.approx(-70.0, abs=0.3)


def test_calcium_of_the_muscle_falls_by_the_exchange_that_is_declared() -> None:
    """Sizes by hand: 77 pA of calcium current change 3500 um^3 by 0.114 mM/s."""
    cell = described("corrias_buist_2007")
    m = cell.module
    states = np.array(m.START[1:])[:, None]
    row = np.zeros(5)
    m.others(-70.0, states, np.zeros((8, 1)), 0, m.SHIPPED, row)
    assert row[2] == 0.0
    calcium = states[m.CALCIUM, 0]
    assert row[3] * calcium == pytest.approx(0.31705 * calcium**1.34, rel=1e-12)
    open_ = states.copy()
    open_[[0, 1, 11], 0] = 1.0
    channels = np.zeros((8, 1))
    reversal = 0.5 * 8314.4 * 310.0 / 96486.0 * np.log(2.5 / calcium)
    channels[0, 0] = 1.0 / (reversal + 70.0)  # 1 uA/cm^2 inward
    m.others(-70.0, open_, channels, 0, m.SHIPPED, row)
    assert row[2] == pytest.approx(77.0e-12 / (2.0 * 96486.0 * 3500e-15) * 1e3 / 1e3, rel=1e-9)


# --- export ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHIPPED)
def test_export_says_the_same_equations(name: str, myokit: object) -> None:
    import myokit as kit

    from peristalsis.cells.foreign import right_side

    cell = described(name)
    model = kit.parse_model(written(equations(name)))
    model.validate()
    theirs, ours = right_side(model), description.rates(cell)
    begin = description.start(cell)
    chance = np.random.default_rng(1)
    for _ in range(20):
        state = begin * (1.0 + 0.2 * chance.random(begin.size))
        expected = ours(float(state[0]), state[1:], 0.0)
        assert np.array(theirs(0.0, state)) == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("name", "said"), [("hodgkin_huxley", "dot(m) ="), ("plant", "dot(h) =")])
def test_mmt_needs_no_library(name: str, said: str, tmp_path: Path) -> None:
    export(name, tmp_path / "cell.mmt")
    assert said in (tmp_path / "cell.mmt").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["plant", "hodgkin_huxley", "du_2013"])
def test_there_and_back_by_cellml(name: str, tmp_path: Path, myokit: object) -> None:
    from peristalsis.cells.importing import import_cell

    file = tmp_path / f"{name}.cellml"
    export(name, file)
    back = import_cell(file, tmp_path / "back.py", duration=200.0)
    assert back.rates < 1e-9
    assert back.trace < 1e-4
    if name == "plant":
        assert set(back.cell.module.CHANNELS) == {
            "fast_calcium", "slow_calcium", "potassium", "calcium_potassium", "leak",
        }  # fmt: skip
        return
    own = described(name)
    places = [own.states.index(state) for state in back.cell.states]
    begin = description.start(own)
    for shift in (0.0, 5.0, 20.0):
        expected = description.rates(own)(begin[0] + shift, begin[1:], 0.0)
        found = description.rates(back.cell)(begin[0] + shift, begin[1:][places], 0.0)
        assert found[0] == pytest.approx(expected[0], rel=1e-9, abs=1e-11)
        assert found[1:] == pytest.approx(expected[1:][places], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("line", "what"), [("for i in range(2):\n        v = v + 1.0", "for i"), ("v = sorted([v])[0]", "[v]")]
)
def test_export_refuses_what_it_cannot_follow(line: str, what: str, tmp_path: Path) -> None:
    text = (description.FOLDER / "morris_lecar.py").read_text(encoding="utf-8").replace("from ...", "from peristalsis.")
    where = text.index("    row[0] = 0.5")
    file = tmp_path / "odd.py"
    file.write_text(f"{text[:where]}    {line}\n{text[where:]}", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=re.escape(what)):
        equations(str(file))


# --- import ------------------------------------------------------------------------------------------

CONSTRUCTS = {
    "axon_in_si_units.cellml": SimpleNamespace(gates=1, others=0, channels={"g_K", "g_leak"}, stimuli=[]),
    "driven_piecewise.cellml": SimpleNamespace(gates=1, others=0, channels={"g", "g_leak"}, stimuli=["cell.i_stim"]),
    "calcium_oscillator.mmt": SimpleNamespace(gates=0, others=2, channels={"g_ca", "g_k"}, stimuli=["membrane.i_stim"]),
    "constant_field.mmt": SimpleNamespace(gates=1, others=1, channels={"P_Ca", "i_pump", "g_b"}, stimuli=[]),
    "compartments.xml": SimpleNamespace(gates=1, others=0, channels={"g_Ca", "g_K", "g_L"}, stimuli=[]),
}


@pytest.mark.parametrize("name", CONSTRUCTS)
def test_foreign_constructs(name: str, tmp_path: Path, myokit: object) -> None:
    from peristalsis.cells.importing import import_cell

    expected = CONSTRUCTS[name]
    found = import_cell(FOREIGN / name, tmp_path / "cell.py", duration=300.0)
    assert (found.rates, found.trace) < (1e-9, 1e-4)
    assert (len(found.anatomy.gates), len(found.anatomy.others)) == (expected.gates, expected.others)
    assert set(found.cell.module.CHANNELS) == expected.channels
    assert found.anatomy.stimuli == expected.stimuli
    head = found.cell.module.__doc__ or ""
    assert all(one in head for one in expected.stimuli)
    module = found.cell.module
    assert tuple(one.name for one in module.PARAMETERS) == module.CellConstants._fields
    assert max(map(len, (tmp_path / "cell.py").read_text(encoding="utf-8").splitlines())) <= 125


def test_units_of_a_whole_cell_become_those_of_an_area(tmp_path: Path, myokit: object) -> None:
    """8 nS of 20 pF at 1 uF/cm^2 are 0.4 mS/cm^2; seconds and volts become ms and mV."""
    from peristalsis.cells.importing import import_cell

    cell = import_cell(FOREIGN / "axon_in_si_units.cellml", tmp_path / "cell.py").cell
    numbers = {one.name: one for one in cell.module.CONDUCTANCES}
    assert (numbers["g_K"].value, numbers["g_K"].unit) == (pytest.approx(0.4), "mS/cm^2")
    assert cell.module.SHIPPED.capacitance == pytest.approx(1.0)
    assert cell.module.START[0] == pytest.approx(-60.0)
    row = np.zeros(3)
    cell.module.gates(-50.0, cell.module.SHIPPED, row)  # 0 / 0 in the file
    assert row[1] == pytest.approx(0.1 + 0.12 * np.exp(-10.0 / 80.0), rel=1e-5)


def test_uptake_of_calcium_is_a_decay(tmp_path: Path, myokit: object) -> None:
    """Losses that are no straight line divide by the state, so that no concentration falls below 0."""
    from peristalsis.cells.importing import import_cell

    cell = import_cell(FOREIGN / "calcium_oscillator.mmt", tmp_path / "cell.py").cell
    row = np.zeros(5)
    cell.module.others(-60.0, np.array([[0.3], [1.5]]), cell.conductances[:, None], 0, cell.module.SHIPPED, row)
    assert row[1] == pytest.approx((3.0 * 0.3 / 1.09 + 0.66) / 1000.0, rel=1e-12)
    assert row[3] > 0.0


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("imports.cellml", "imports parts of other CellML files; flatten"),
        ("loop.mmt", "algebraic loop"),
        ("no_potential.mmt", "no membrane potential"),
        ("two_potentials.mmt", "could each be the membrane potential"),
        ("clamp.mmt", "voltage clamp"),
        ("unit.cellml", "unit that is not known"),
        ("seconds_of_kilograms.mmt", "no multiple of ms"),
        ("broken.cellml", "could not be read"),
        ("text.xml", "neither CellML nor SBML"),
        ("absent.cellml", "there is no file"),
    ],
)
def test_refusals_are_one_sentence(name: str, said: str, myokit: object) -> None:
    from peristalsis.cells.importing import import_cell

    with pytest.raises(ConfigurationError) as caught:
        import_cell(FOREIGN / "refused" / name)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


# --- the command line --------------------------------------------------------------------------------


def test_show_names_states_channels_and_sources(capsys: Capture) -> None:
    assert main(["cell", "show", "du_2013", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["channels"] == ["sodium", "calcium", "calcium_potassium", "ip3_voltage_production"]
    assert answer["numbers"]["sodium"]["unit"] == "mS/cm^2"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["show", "unicorn"], "there is no cell 'unicorn'"),
        (["show", "absent.py"], "could not read"),
        (["run", "du_2013", "--duration", "-1 s"], "must be above 0"),
        (["run", "du_2013", "--stimulus", "3 mV"], "--stimulus"),
        (["export", "du_2013", "--out", "cell.txt"], "ends with neither"),
    ],
)
def test_bad_words_are_one_line(words: list[str], said: str, capsys: Capture, tmp_path: Path,
                                monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["cell", *words]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert len(err.strip().splitlines()) == 1


def test_without_myokit_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "myokit", None)
    from peristalsis.cells.foreign import read

    with pytest.raises(ConfigurationError, match=r"peristalsis\[cells\]"):
        read(FOREIGN / "compartments.xml")


@pytest.mark.slow
def test_a_foreign_cell_runs_as_in_its_own_simulator(tmp_path: Path, myokit: object, capsys: Capture) -> None:
    words = ["cell", "run", str(FOREIGN / "driven_piecewise.cellml"), "--duration", "200 ms", "--stimulus", "4 uA/cm^2"]
    words += ["--from", "20 ms", "--for", "5 ms", "--every", "80 ms", "--out", str(tmp_path / "out"), "--json"]
    assert main(words) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["difference"] < 1e-3
    table = np.loadtxt(tmp_path / "out" / "trace.csv", delimiter=",", skiprows=1)
    assert table.shape == (1001, 4)
    assert (tmp_path / "out" / "trace.png").stat().st_size > 1000


def test_the_example_of_the_page_is_a_cell(tmp_path: Path) -> None:
    """docs/cells.md: the file that it shows is read, rests, and goes out as a model."""
    page = (Path(__file__).parents[2] / "docs" / "cells.md").read_text(encoding="utf-8")
    file = tmp_path / "two_currents.py"
    file.write_text(page.split("```python\n")[1].split("```")[0], encoding="utf-8")
    cell = description.read(file)
    begin = description.start(cell)
    assert np.abs(description.rates(cell)(float(begin[0]), begin[1:], 0.0)).max() < 1e-6
    assert cell.module.LOWEST < begin[0] < cell.module.HIGHEST
    assert "dot(recovery) =" in written(equations(str(file)))
