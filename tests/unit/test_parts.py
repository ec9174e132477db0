"""Parts chosen by configuration: read without being executed, numbers by key, refusals that say what to do."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import names, plugins, units
from peristalsis.__main__ import main
from peristalsis.errors import ConfigurationError, UnknownKeyError
from peristalsis.inputs import parts
from peristalsis.inputs.choices import SLOTS
from peristalsis.inputs.config import FIELDS, json_schema
from peristalsis.plots import registry

CELLS = parts.PACKAGE / "tissue" / "cells"
DESCRIBED = [name for name in parts.parts("cell") if name != "plant"]

HEAD = """
from peristalsis.declared import number
raise RuntimeError("a part is read and not executed")
KIND, NAME, TITLE = "cell", "mine", "my cell"
SOURCE = "a paper"
STATES = (("w", 0.0, 1.0),)
CHANNELS = ("potassium", "leak")
PARAMETERS = (number("half", -2.0 * 10.0, "mV", "where half is open", tag="sourced", source=SOURCE, lowest=-90.0),)
CONDUCTANCES = (
    number("potassium", 1.0, "mS/cm^2", "potassium", lowest=0.0, highest=10.0),
    number("leak", 0.5 / 2.0, "mS/cm^2", "leak", lowest=0.0, highest=10.0),
)
"""


@pytest.fixture
def outside(tmp_path: Path) -> Iterator[Path]:
    """A folder for the user's files; what is registered from it is forgotten."""
    yield tmp_path
    plugins.forget_all()


@pytest.fixture
def mine(outside: Path) -> Path:
    file = outside / "mine.py"
    file.write_text(HEAD, encoding="utf-8")
    return file


def with_(**changes: Any) -> ps.Configuration:
    return ps.configuration(changes={name.replace("__", "."): value for name, value in changes.items()})


# --- what a file says -------------------------------------------------------------------------------


def test_a_part_is_read_and_not_executed(mine: Path) -> None:
    part = parts.read_part(mine)
    assert (part.kind, part.name, part.title, part.states) == ("cell", "mine", "my cell", ("w",))
    assert [(one.name, one.value, one.source) for one in part.channels] == [("potassium", 1.0, ""), ("leak", 0.25, "")]
    half, capacitance, rate = part.parameters
    assert (half.name, half.value, half.source, half.lowest) == ("half", -20.0, "a paper", -90.0)
    assert (capacitance.name, rate.name) == ("capacitance", "kinetics_rate"), "every cell has these"


@pytest.mark.parametrize("name", DESCRIBED)
def test_shipped_cells_are_read(name: str) -> None:
    part = parts.find("cell", name)
    assert part.file == CELLS / f"{name}.py"
    assert part.title
    assert part.states
    assert part.channels
    assert {"capacitance", "kinetics_rate"} <= {one.name for one in part.parameters}
    assert all(one.source for one in part.numbers if one.tag != "chosen")
    assert [one.unit for one in part.numbers if not units.is_known(one.unit)] == []


WRONG = {
    "KIND = 'cel'": "KIND = 'cel'",
    "NAME = 'My Cell'": "NAME = 'My Cell'",
    "CHANNELS = ('potassium',)": "name different channels",
    "PARAMETERS = (1.0,)": r"not a tuple of number\(...\)",
    "PARAMETERS = tuple(range(3))": "PARAMETERS is not written out",
    "PARAMETERS = (number('a', 1.0, 'mV', ''), number('a', 2.0, 'mV', ''))": "a is declared twice",
    "PARAMETERS = (number('a', 1.0, 'foo/bars', ''),)": "unit 'foo/bars' is not known",
    "PARAMETERS = (number('a', 1.0, 'mV', '', highest=0.0),)": "is not within",
    "PARAMETERS = (number('a', 1.0, 'mV', '', tag='guess'),)": "tag 'guess' is none of",
    "PARAMETERS = (number('a', 1.0, 'mV', '', tag='sourced'),)": "needs its source",
    "PARAMETERS = (number('a', True, 'mV', ''),)": "value and bounds are numbers",
    "def f(:": "line .* is not Python",
}


@pytest.mark.parametrize("line", WRONG)
def test_what_is_wrong_with_a_part_is_one_sentence(mine: Path, line: str) -> None:
    mine.write_text(HEAD + line + "\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=WRONG[line]) as caught:
        ps.register(mine)
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_taken_name(outside: Path, mine: Path) -> None:
    with pytest.raises(ConfigurationError, match="No such file"):
        ps.register(outside / "nothing.py")
    ps.register(mine)
    other = outside / "other.py"
    other.write_text(HEAD, encoding="utf-8")
    with pytest.raises(ConfigurationError, match="mine is there already"):
        ps.register(other)
    assert ps.register(mine).name == "mine", "the same file once more is nothing"


# --- choosing ---------------------------------------------------------------------------------------


def test_the_shipped_parts_leave_a_configuration_as_it_was() -> None:
    """Slots at their default are in no digest: results that are kept stay what they are."""
    plain = ps.Configuration()
    assert [plain.flat()[slot] for slot in SLOTS][:3] == ["plant", "tissue", "tissue"]
    assert with_(tissue__cell="plant").digest() == plain.digest()
    assert with_(tissue__cell="morris_lecar").digest() != plain.digest()
    assert with_(tissue__cell="morris_lecar").with_changes({"tissue.cell": "plant"}).digest() == plain.digest()


def test_numbers_of_a_part_are_parameters() -> None:
    chosen = with_(tissue__cell="morris_lecar", tissue__morris_lecar__calcium="5 mS/cm^2")
    flat = chosen.flat()
    assert (flat["tissue.morris_lecar.calcium"], flat["tissue.morris_lecar.potassium"]) == (5.0, 8.0)
    assert ps.Configuration.from_toml(chosen.to_toml()) == chosen
    tags = {entry.key: (entry.tag, entry.shipped) for entry in chosen.items()}
    assert tags["tissue.morris_lecar.calcium"] == ("set by user", 4.4)
    assert tags["tissue.morris_lecar.potassium"] == ("sourced", 8.0)
    assert FIELDS["tissue.morris_lecar.calcium"].unit == "mS/cm^2"
    table = json_schema()["properties"]["tissue"]["properties"]["morris_lecar"]["properties"]
    assert table["calcium"]["x-unit"] == "mS/cm^2"
    assert all(np.isfinite(limit) for one in table.values() for key, limit in one.items() if key.endswith("imum"))


def test_each_layer_may_have_its_own_cell_and_its_own_numbers() -> None:
    from peristalsis.inputs.build import build

    both = with_(
        longitudinal__cell="morris_lecar",
        circular__cell="fitzhugh_nagumo",
        longitudinal__morris_lecar__leak="3 mS/cm^2",
    )
    model = build(both)
    assert (model.longitudinal.cell.name, model.circular.cell.name) == ("morris_lecar", "fitzhugh_nagumo")
    assert model.longitudinal.conductances[:, 0].tolist() == [4.4, 8.0, 3.0]
    assert model.circular.conductances.shape[0] == 1
    shared = build(
        with_(
            tissue__cell="morris_lecar",
            tissue__morris_lecar__leak="3 mS/cm^2",
            circular__morris_lecar__leak="1 mS/cm^2",
        )
    )
    assert (shared.longitudinal.conductances[2, 0], shared.circular.conductances[2, 0]) == (3.0, 1.0)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "no such cell": ({"tissue.cell": "morris"}, r"tissue\.cell = 'morris' is no cell; did you mean morris_lecar\?"),
    "no name": ({"tissue.cell": 3}, "not the name of a cell"),
    "not chosen": ({"tissue.morris_lecar.leak": "1 mS/cm^2"}, r"no effect; set tissue\.cell = morris_lecar"),
    "no unit": ({"tissue.cell": "morris_lecar", "tissue.morris_lecar.leak": "1"}, "the unit is missing"),
    "out of range": ({"tissue.cell": "morris_lecar", "tissue.morris_lecar.leak": "-1 mS/cm^2"}, "at least 0 mS/cm"),
    "no such number": ({"tissue.cell": "morris_lecar", "tissue.morris_lecar.leek": 1.0}, r"did you mean leak\?"),
    "no such part": ({"tissue.moris_lecar.leak": "1 mS/cm^2"}, "'moris_lecar' is no cell"),
    "explicit": ({"tissue.cell": "morris_lecar", "solver.integrator": "explicit"}, "the cell of the paper only"),
    "protocol of another cell": (
        {"tissue.cell": "morris_lecar", "protocols": ["longitudinal.leak: step 1 mS/cm^2 at 0 s, 2 mS/cm^2 at 1 s"]},
        r"which has no such channel; use longitudinal\.morris_lecar",
    ),
    "region of another cell": (
        {
            "tissue.cell": "morris_lecar",
            "regions": [{"name": "a", "shape": "band", "z_from": "1 cm", "z_to": "2 cm", "slow_calcium": 0.5}],
        },
        "slow_calcium is no channel of morris_lecar",
    ),
    "network off": ({"network.du_2013.sodium": "1 mS/cm^2"}, r"set network\.enabled = true"),
    "region of no network": (
        {
            "regions": [
                {"name": "a", "layer": "network", "shape": "band", "z_from": "1 cm", "z_to": "2 cm", "sodium": 1}
            ]
        },
        r"network\.enabled = false",
    ),
    "explicit network": ({"network.enabled": True, "solver.integrator": "explicit"}, "has no network"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_would_have_no_effect_is_refused(case: str) -> None:
    changes, words = REFUSED[case]
    with pytest.raises((ConfigurationError, UnknownKeyError), match=words) as caught:
        ps.configuration(changes=changes)
    assert "\n" not in str(caught.value)


def test_channels_of_a_cell_are_known_to_protocols_and_regions() -> None:
    from peristalsis.inputs.build import build

    band = {"name": "weak", "shape": "band", "z_from": "2 cm", "z_to": "4 cm", "calcium": 0.5}
    course = "tissue.morris_lecar.potassium: step 8 mS/cm^2 at 0 s, 4 mS/cm^2 at 1 s"
    chosen = with_(tissue__cell="morris_lecar", regions=[band], protocols=[course])
    model = build(chosen)
    inside = (model.grid.cells > 2.0) & (model.grid.cells < 4.0)
    assert set(model.circular.conductances[0, inside]) == {2.2}
    assert set(model.circular.conductances[0, ~inside]) == {4.4}
    later = build(chosen.at_time({"tissue.morris_lecar.potassium": 4.0}), model, chosen)
    assert set(later.longitudinal.conductances[1]) == {4.0}


def test_a_foreign_file_is_part_of_the_digest(mine: Path) -> None:
    """The same name may stand for another file tomorrow."""
    ps.register(mine)
    first = with_(tissue__cell="mine").digest()
    mine.write_text(HEAD + "# another text\n", encoding="utf-8")
    assert with_(tissue__cell="mine").digest() != first


# --- the user's own code ----------------------------------------------------------------------------

CODE = """
import peristalsis as ps
from peristalsis.names import STEP
from peristalsis.plots.figure import Figure
ps.register(ps.Output("{name}", STEP, "cm", "twice the place", lambda now: 2.0 * now.state.pellet.position))
ps.register(ps.Scenario("{name}", "mine", "as the baseline", "as there", {{"pellet.radius": "0.8 cm"}}))
ps.register(Figure("{name}", "mine", "mine", lambda result: None))
"""


def test_a_file_registers_output_scenario_and_figure(outside: Path) -> None:
    file = outside / "code.py"
    file.write_text(CODE.format(name="my_own"), encoding="utf-8")
    try:
        ps.register(file)
        ps.register(file)  # is executed once: a second time would find its names taken
        assert ps.configuration("my_own").pellet.radius == 0.8
        assert {"my_own"} <= names.OUTPUTS.keys() & registry.figures().keys()
    finally:
        names.forget("my_own")


def test_what_goes_wrong_in_the_users_code_names_file_and_line(outside: Path) -> None:
    file = outside / "code.py"
    file.write_text("x = 1\ny = x / 0\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"plug-in .*, line 2: ZeroDivisionError"):
        ps.register(file)
    file.write_text("y = (\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="is not Python"):
        ps.register(file)
    with pytest.raises(ConfigurationError, match="'int' cannot be registered"):
        ps.register(3)


# --- command line -----------------------------------------------------------------------------------


def test_parts_are_listed(capsys: pytest.CaptureFixture[str], mine: Path) -> None:
    assert main(["list", "cells", "--plugin", str(mine), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["cells"][0]["name"] == "plant"
    (own,) = (one for one in answer["cells"] if one["name"] == "mine")
    assert (own["from"], own["channels"]) == (str(mine), ["potassium", "leak"])
    for kind in ("laws", "activations", "muscles", "shapes"):
        assert main(["list", kind]) == 0
    assert "Choose one by pellet.shape" in capsys.readouterr().out
    assert main(["list", "cels"]) == 2
    assert "did you mean cells?" in capsys.readouterr().err
    assert main(["list", "--plugin"]) == 2
    assert "--plugin needs a file" in capsys.readouterr().err


# --- runs -------------------------------------------------------------------------------------------

SMALL = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 60,
    "grid.n_z_wall": 40,
    "run.duration": "60 ms",
    "output.interval": "20 ms",
}


def test_two_cells_in_one_run() -> None:
    """An oscillator along the tube, the paper's cell around it; each records its own states."""
    strong = {"pacemaker.intensity": "60 uA/cm^2", "step.wall": "1 ms", "step.conduction": "0.1 ms"}
    result = ps.Simulation(ps.configuration(changes={**SMALL, **strong, "longitudinal.cell": "fitzhugh_nagumo"})).run()
    potential = result.arrays["potential_longitudinal"][:, :, 0]
    assert abs(potential[0] + 63.4).max() < 0.5, "at rest"
    assert potential[:, 0].max() > 0.0, "fires where it is stimulated"
    assert {"w_longitudinal_probe", "calcium_circular"} <= result.arrays.keys()
    assert not {"w_circular_probe", "calcium_longitudinal"} & result.arrays.keys()
    assert result.arrays["conductance_excitability_longitudinal_probe"].max() == 1.0


def test_numbers_of_a_part_that_is_not_chosen_are_told() -> None:
    from peristalsis.inputs import asked

    def said(**changes: Any) -> list[str]:
        return [text for text in asked.remarks(with_(**changes)) if "has no effect" in text]

    assert said(wall__law="fung", wall__c5="3") == ["wall.c5 is set and has no effect: wall.law = fung"]
    assert said(wall__law="fung", reading="printed") == []
    both = said(tissue__cell="morris_lecar", circular__leak="1 mS/cm^2", cell__calcium_rate="1e-3 1/ms")
    assert [text.split()[0] for text in both] == ["circular.leak", "cell.calcium_rate"]
    one = said(circular__cell="morris_lecar", longitudinal__leak="1 mS/cm^2", cell__calcium_rate="1e-3 1/ms")
    assert one == []
