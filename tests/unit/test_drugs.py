"""Agents on channels: Hill's curve, agents side by side, libraries, and what a configuration keeps of them."""

from pathlib import Path

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.build import cell_of_layer
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.drugs import (
    Dose,
    amount,
    changes_by,
    doubtful,
    factor,
    factors,
    from_line,
    library,
    mixed,
    named,
)
from peristalsis.inputs.preflight import remarks
from peristalsis.tissue.cells.plant import CHANNELS


def dose(concentration, ic50=10.0, slope=1.0, maximum=0.0, agent="a", target="L-type"):
    return Dose(agent, concentration, target, ("plant.slow_calcium",), ic50, slope, maximum, "somewhere", "", "chosen")


@pytest.mark.parametrize("slope", [0.71, 1.0, 1.4, 3.0])
@pytest.mark.parametrize("maximum", [0.0, 0.3, 1.5])
def test_one_agent_follows_hills_curve(slope, maximum):
    # Half the effect at the IC50 whatever the slope, and the slope is that of the logarithm of the odds.
    assert factor([dose(0.0, slope=slope, maximum=maximum)]) == 1.0
    assert factor([dose(10.0, slope=slope, maximum=maximum)]) == pytest.approx(0.5 * (1.0 + maximum), rel=1e-14)
    concentrations = np.geomspace(0.1, 1000.0, 9)
    bound = np.array(
        [(factor([dose(c, slope=slope, maximum=maximum)]) - 1.0) / (maximum - 1.0) for c in concentrations]
    )
    odds = np.log(bound / (1.0 - bound))
    np.testing.assert_allclose(np.diff(odds) / np.diff(np.log(concentrations)), slope, rtol=1e-9)
    assert factor([dose(1e9, slope=slope, maximum=maximum)]) == pytest.approx(maximum, abs=1e-4)


def test_agents_compete_for_one_target():
    # Two doses of one agent under two names are one dose of their sum (exact for slope 1).
    halves = [dose(4.0, agent="a"), dose(6.0, agent="b")]
    assert factor(halves) == pytest.approx(factor([dose(10.0)]), rel=1e-15)
    # An opener is displaced by a blocker: both bind, and neither effect is whole.
    both = factor([dose(10.0), dose(10.0, maximum=1.5, agent="opener")])
    assert both == pytest.approx((1.0 + 0.0 + 1.5) / 3.0, rel=1e-15)
    # Independent action would be the product.
    assert both != pytest.approx(factor([dose(10.0)]) * factor([dose(10.0, maximum=1.5)]), rel=1e-3)


def test_agents_at_different_targets_act_independently():
    one, two = from_line("nifedipine 8.1 nM"), from_line("iberiotoxin 1.16 nM")
    found = dict(zip(CHANNELS, factors([*one, *two], "plant", CHANNELS), strict=True))
    assert found == pytest.approx(
        {"fast_calcium": 1.0, "slow_calcium": 0.5, "potassium": 1.0, "calcium_potassium": 0.5, "leak": 1.0}
    )
    # Two targets that a library puts on one channel: the product.
    same = [dose(10.0, target="one"), dose(10.0, target="two")]
    assert factors(same, "plant", ["slow_calcium"]) == [0.25]


def test_conductances_of_both_layers_and_of_the_pacemaker_cell_are_multiplied():
    plain = ps.configuration("baseline", changes={"pacemaker.kind": "cell"})
    drugged = plain.with_changes({"drugs": ["nifedipine 8.1 nM"]})
    ratio = {"slow_calcium": 0.5}
    for layer in ("longitudinal", "circular"):
        before, after = (cell_of_layer(c, layer)[2] for c in (plain, drugged))
        np.testing.assert_allclose(after / before, [ratio.get(name, 1.0) for name in CHANNELS], rtol=1e-14)
    from peristalsis.inputs.build import build

    before, after = (build(c).pacemaker_cell.conductances[:, 0] for c in (plain, drugged))
    np.testing.assert_allclose(after / before, [ratio.get(name, 1.0) for name in CHANNELS], rtol=1e-14)


LAYERS = ("longitudinal", "circular")
SHORT = {"run.duration": "0.1 s", "grid.n_z": 100, "grid.n_z_wall": 100}


def test_a_drug_is_the_conductance_that_it_leaves():
    # The same run, to the bit, as one whose conductances are halved by hand.
    by_drug = ps.run("baseline", {**SHORT, "drugs": "nifedipine 8.1 nM"})
    by_hand = ps.run("baseline", SHORT | {f"{layer}.slow_calcium": "0.002 mS/cm^2" for layer in LAYERS})
    np.testing.assert_array_equal(by_drug.arrays["pellet_position"], by_hand.arrays["pellet_position"])
    np.testing.assert_array_equal(by_drug.arrays["radius"], by_hand.arrays["radius"])


def test_a_protocol_of_a_conductance_is_multiplied_too():
    def courses(first, second):
        step = f"step {first} mS/cm^2 at 0 s, {second} mS/cm^2 at 0.05 s"
        return [f"{layer}.slow_calcium: {step}" for layer in LAYERS]

    by_drug = ps.run("baseline", {**SHORT, "drugs": "nifedipine 8.1 nM", "protocols": courses(0.004, 0.006)})
    by_hand = ps.run("baseline", {**SHORT, "protocols": courses(0.002, 0.003)})
    np.testing.assert_array_equal(by_drug.arrays["radius"], by_hand.arrays["radius"])


def test_a_stored_configuration_holds_the_numbers_and_not_the_library(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        '[[agents]]\nagent = "mine"\ntarget = "SK"\ntissue = "nowhere"\nic50 = "3 uM"\nslope = 2.0\ntag = "chosen"\n'
        'source = "a test"\n\n[targets.SK]\nchannels = ["plant.calcium_potassium"]\nnote = "the nearest mechanism"\n'
    )
    given = ps.configuration("baseline", changes={"drugs": [{"dose": "mine 3 uM", "file": str(file)}]})
    assert dict(zip(CHANNELS, cell_of_layer(given, "circular")[2], strict=True))["calcium_potassium"] == 0.015
    text = given.to_toml()
    file.unlink()
    assert Configuration.from_toml(text) == given
    assert Configuration.from_toml(text).digest() == given.digest()
    # A file beside the configuration file is found beside it.
    file.write_text(
        '[[agents]]\nagent = "mine"\ntarget = "BK"\ntissue = "n"\nic50 = "1 nM"\ntag = "chosen"\nsource = "s"\n'
    )
    (tmp_path / "c.toml").write_text('drugs = [{dose = "mine 1 nM", file = "mine.toml"}, "nifedipine 1 nM"]\n')
    assert [one.agent for one in Configuration.from_toml(tmp_path / "c.toml").drugs] == ["mine", "nifedipine"]


def test_without_drugs_nothing_is_written_and_the_digest_is_as_before():
    plain = ps.configuration("baseline")
    assert "drugs" not in plain.to_toml()
    assert "drugs" not in plain.texts()
    assert plain.with_changes({"drugs": ["nifedipine 1 nM"]}).digest() != plain.digest()
    assert plain.with_changes({"drugs": []}).digest() == plain.digest()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("apamin 1 uM", "which the model does not have"),
        ("niflumic acid 10 uM", "not activated by calcium"),
        ("nifedipine", "no agent with a concentration"),
        ("nifedipin 3 nM", "did you mean nifedipine"),
        ("nifedipine 3 kPa", "cannot be converted"),
        ("nifedipine 3 nM in dogs", "in rabbit aorta and in cardiac cells"),
        ("nifedipine 2 M", "no concentration of an agent"),
        ("lubricant 0.5", "changes parameters and no channel"),
        ({"agent": "x", "concentration": "1 nM", "target": "y", "channels": ["plant.leak"]}, "ic50 is missing"),
        ({"agent": "x", "cells": 1}, "is no key of a dose"),
        ({"dose": "nifedipine 1 nM", "tissue": "x"}, "does not go with dose"),
        (7, "not a list"),
    ],
)
def test_what_is_no_dose_is_refused_with_its_reason(given, said):
    with pytest.raises(ConfigurationError, match=said):
        ps.configuration("baseline", changes={"drugs": given})


def test_one_agent_given_twice_is_refused():
    with pytest.raises(ConfigurationError, match="given twice"):
        ps.configuration("baseline", changes={"drugs": ["nifedipine 1 nM", "nifedipine 2 nM"]})


def test_a_target_that_no_cell_of_the_run_has_is_refused_and_one_that_some_lack_is_remarked_on():
    with pytest.raises(ConfigurationError, match="no cell of this run has"):
        ps.configuration("baseline", changes={"drugs": "iberiotoxin 1 nM", "tissue.cell": "morris_lecar"})
    some = ps.configuration("baseline", changes={"drugs": "iberiotoxin 1 nM", "circular.cell": "morris_lecar"})
    assert any("does nothing to the circular cells" in one for one in remarks(some))


@pytest.mark.parametrize(
    ("file", "channel", "other"), [(None, "slow", "with --drugs"), ("l_type_is_fast", "fast", "without --drugs")]
)
def test_a_calcium_blocker_says_which_channel_it_is_read_to_block(file, channel, other):
    doses = from_line("nifedipine 8.1 nM", library(file))
    (said,) = doubtful(doses, ["plant"])
    assert said.startswith(f"nifedipine: 0.5 of the {channel} calcium conductance is left")
    assert other in said
    assert doubtful(doses, ["corrias_buist_2007"]) == [] == doubtful(from_line("tetraethylammonium 1 mM"), ["plant"])
    dosed = ps.configuration("baseline", changes={"drugs": [{"dose": "nifedipine 8.1 nM"}]})
    assert any("that is a reading" in one for one in remarks(dosed))


def test_preparations_are_chosen_and_never_mixed_without_a_sentence():
    assert from_line("nifedipine 30 nM")[0].tissue == "rabbit aorta"
    assert from_line("nifedipine 30 nM in cardiac cells")[0].ic50 == 60.0
    assert mixed(from_line("nifedipine 1 nM") + from_line("verapamil 1 nM")) is None
    assert "differs" in mixed(from_line("nifedipine 1 nM") + from_line("diltiazem 1 nM"))
    both = ps.configuration("baseline", changes={"drugs": ["nifedipine 1 nM", "diltiazem 1 nM"]})
    assert any("different preparations" in one for one in remarks(both))


def test_every_shipped_agent_says_where_its_number_is_from():
    known = library()
    for one in known.agents:
        assert one.source
        assert one.tag in ("sourced", "derived", "chosen")
        assert one.range is None or one.range[0] <= one.ic50 <= one.range[1]
        assert one.target in known.targets
    cells = {"plant": CHANNELS}
    for target in known.targets.values():
        for channel in target.channels:
            cell, _, name = channel.partition(".")
            if cell not in cells:
                from peristalsis.inputs.parts import find

                cells[cell] = tuple(number.name for number in find("cell", cell).channels)
            assert name in cells[cell], f"{target.name}: {channel} is no channel"


def test_the_derived_number_of_otilonium_meets_both_points_of_its_source():
    found = from_line("otilonium 0.9 uM")[0], from_line("otilonium 9 uM")[0]
    assert [1.0 - factor([one]) for one in found] == pytest.approx([0.25, 0.90], abs=0.02)


def test_the_other_reading_of_the_calcium_channels_is_a_library():
    slow, fast = from_line("nifedipine 1 nM"), from_line("nifedipine 1 nM", library("l_type_is_fast"))
    assert "plant.slow_calcium" in slow[0].channels
    assert "plant.fast_calcium" in fast[0].channels


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[[agents]]\nagent = "x"\n', "target is missing"),
        ('[[agents]]\nagent = "x"\ntarget = "L-typ"\n', "did you mean L-type"),
        (
            '[[agents]]\nagent = "x"\ntarget = "BK"\ntissue = "t"\nic50 = 3\ntag = "chosen"\nsource = "s"\n',
            "unit is missing",
        ),
        ('[[agents]]\nagnt = "x"\n', "did you mean agent"),
        (
            '[[agents]]\nagent = "x"\ntarget = "BK"\ntissue = "t"\nic50 = "3 nM"\ntag = "read"\nsource = "s"\n',
            "tag = 'read'",
        ),
        ('[[agents]]\nagent = "x"\ntarget = "BK"\ntissue = "t"\nic50 = "3 nM"\nrange = ["5 nM", "1 nM"]\n', "falls"),
        ("agents = 3\n", "not a list of tables"),
        ('[[interventions]]\nname = "x"\nfactor = 2.0\nrange = [0.1, 1.0]\n', "outside of its range"),
        ("[[agents]\n", "not valid TOML"),
    ],
)
def test_a_wrong_library_says_what_is_wrong(tmp_path: Path, text, said):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=said):
        library(file)


def test_interventions_multiply_parameters_within_their_range():
    plain = ps.configuration("baseline")
    changes = changes_by(["lubricant 0.3", "mineral oil 0.5", "bulk former"], plain)
    after = plain.with_changes(changes)
    assert after.pellet.viscous_friction == pytest.approx(0.15 * plain.pellet.viscous_friction, rel=1e-14)
    assert after.pellet.dry_friction == pytest.approx(0.5 * plain.pellet.dry_friction, rel=1e-14)
    assert after.pellet.radius == pytest.approx(1.1 * plain.pellet.radius, rel=1e-14)
    with pytest.raises(ConfigurationError, match="out of its range"):
        changes_by(["lubricant 0.01"], plain)
    assert named("nifedipine 3 nM", library()) is None


def test_agents_of_the_command_line_come_beside_those_of_the_configuration():
    plain = ps.configuration("baseline", changes={"drugs": "nifedipine 1 nM"})
    after = plain.with_changes(changes_by(["iberiotoxin 1 nM"], plain))
    assert [one.agent for one in after.drugs] == ["nifedipine", "iberiotoxin"]


@pytest.mark.parametrize(
    ("number", "text"), [(30.0, "30 nM"), (1900.0, "1.9 uM"), (2e6, "2 mM"), (0.01, "10 pM"), (0.0, "0 nM")]
)
def test_amounts_are_written_with_few_digits(number, text):
    assert amount(number) == text


def test_where_drugs_show_they_are_said_to_be_no_advice(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    tiny = [word for key, value in SHORT.items() for word in ("--set", f"{key}={value}")]
    drugs = ["--drug", "nifedipine 8.1 nM", "--drug", "lubricant 0.5"]
    assert dispatch(["run", "baseline", *tiny, *drugs, "--no-plots"]) == 0
    assert "not medical advice" in capsys.readouterr().out
    stored = Configuration.from_toml(tmp_path / "out" / "baseline" / "config.toml")
    assert [one.agent for one in stored.drugs] == ["nifedipine"]
    assert stored.pellet.viscous_friction == 115.0
    for words in (["list", "drugs"], ["show", "baseline", *drugs]):
        assert dispatch(words) == 0
        assert "not medical advice" in capsys.readouterr().out
    assert dispatch(["cite", "out/baseline"]) == 0
    assert "pubmed 6185780" in capsys.readouterr().out


def test_a_library_without_an_agent_from_it_is_refused(capsys):
    assert dispatch(["show", "baseline", "--drugs", "l_type_is_fast"]) == 2
    assert "give --drug as well" in capsys.readouterr().err


def test_drugs_of_a_batch_act_on_every_point(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    changes = "\n".join(f"{key} = {value!r}" for key, value in SHORT.items())
    (tmp_path / "two.toml").write_text(f"[changes]\n{changes}\n[grid]\ndrugs = [['iberiotoxin 1 nM'], []]\n")
    assert dispatch(["batch", "two.toml", "--drug", "nifedipine 8.1 nM", "--out", "o"]) == 0
    stored = [Configuration.from_toml(file) for file in (tmp_path / "o" / "runs").glob("*/config.toml")]
    agents = sorted(tuple(one.agent for one in each.drugs) for each in stored)
    assert agents == [("iberiotoxin", "nifedipine"), ("nifedipine",)]
