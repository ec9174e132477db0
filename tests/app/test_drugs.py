"""Drugs on the page: agents by name and dose, the same run by `--drug`, in the address, in TOML and in Python."""

import ast
import json
import tomllib
from collections.abc import Callable

import pytest

from peristalsis import scenarios
from peristalsis.app import agents
from peristalsis.app import asked as asking
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import drugs
from peristalsis.inputs.config import Configuration

from .visiting import IDLE, QUICK, Visit

SEVERAL = {"nifedipine": 30, "verapamil in cardiac cells": 100.0, "lubricant": 0.5}
LINES = ["nifedipine 30 nM", "verapamil 100 nM in cardiac cells", "lubricant 0.5"]


@pytest.mark.parametrize("library", agents.LIBRARIES)
def test_the_same_run_by_a_command_line(library: str) -> None:
    """Agents and interventions over numbers of the page are what --drug makes of the same configuration."""
    found = asking.read({"drugs": SEVERAL, "library": library, "values": {"viscous_friction": 300}}).configuration()
    own = scenarios.configuration("baseline", changes={"pellet.viscous_friction": "300 mN*s/cm"})
    source = None if library == "shipped" else library
    assert found.digest() == own.overlaid(drugs.changes_by(LINES, own, source)).digest()
    assert found.pellet.viscous_friction == pytest.approx(150.0)
    assert [dose.concentration for dose in found.drugs] == [30.0, 100.0]


def test_every_agent_of_the_library_is_offered_with_its_own_numbers() -> None:
    known = drugs.library()
    assert {name.partition(" in ")[0] for name in agents.offered()} == {*known.names(), *known.interventions}
    for name, one in agents.offered().items():
        assert one.low <= one.first <= one.high
        if one.refused:
            with pytest.raises(ConfigurationError, match="the model has no"):
                asking.read({"drugs": {name: one.first}})
            continue
        for dose in (one.low, one.first, one.high):
            found = asking.read({"drugs": {name: dose}}).configuration()
            if one.unit:
                half = [entry.ic50 for entry in found.drugs]
                assert any(drugs.amount(ic50) == f"{one.first:g} {one.unit}" for ic50 in half)
                assert found.drugs[0].concentration / half[0] == pytest.approx(dose / one.first)


@pytest.mark.parametrize("library", agents.LIBRARIES)
def test_toml_and_python_are_the_same_run(library: str) -> None:
    asked = asking.read({"drugs": SEVERAL, "library": library})
    own = asked.configuration()
    assert Configuration.from_toml(own.to_toml()).digest() == own.digest()
    assert [one["agent"] for one in tomllib.loads(own.to_toml())["drugs"]] == ["nifedipine", "verapamil"]
    text = asked.python()
    assert len(text.splitlines()) == 5
    changes = ast.literal_eval(ast.parse(text).body[1].value)  # type: ignore[attr-defined]
    assert scenarios.configuration("baseline", changes=changes).digest() == own.digest()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"drugs": {"<script>alert(1)</script>" * 40: 1}}, "not offered as an agent"),
        ({"drugs": {"../../etc/passwd": 1}}, "not offered as an agent"),
        ({"drugs": {"__proto__": 1}}, "not offered as an agent"),
        ({"drugs": {"nifedipine 30 nM": 1}}, "choose one of|did you mean"),
        ({"drugs": {"nifedipine": "30 nM"}}, "give a number from 0.01 to 1000 nM"),
        ({"drugs": {"nifedipine": True}}, "give a number from 0.01 to 1000 nM"),
        ({"drugs": {"nifedipine": float("nan")}}, "give a number from 0.01 to 1000 nM"),
        ({"drugs": {"nifedipine": 10**400}}, "give a number from 0.01 to 1000 nM"),
        ({"drugs": {"lubricant": 0}}, "give a number from 0.1 to 1, or leave it out"),
        ({"drugs": {"apamin": 300}}, "the model has no SK"),
        ({"drugs": ["nifedipine 30 nM"]}, "the list of drugs is described by names"),
        ({"drugs": {"nifedipine": 1}, "library": "/tmp/mine.toml"}, "not offered here"),
        ({"drugs": {"nifedipine": 1}, "library": 3}, "not offered here"),
        ({"drugs": {"nifedipine": 1, "nifedipine in cardiac cells": 1}}, "given twice on L-type"),
    ],
    ids=lambda value: repr(value)[:40],
)
def test_anything_else_is_one_sentence(content: object, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said) as refused:
        asking.read(content).configuration()
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 400


def test_a_change_on_the_way_leaves_doses() -> None:
    """A slider moved while a run is under way counts under the intervention that the run began with."""
    before = asking.read({"drugs": {"lubricant": 0.5, "nifedipine": 30}})
    after, changes = asking.read_live({"values": {"viscous_friction": 300}}, before)
    assert changes == {"pellet.viscous_friction": "150.0 mN*s/cm"}
    assert after.configuration().drugs == before.configuration().drugs
    with pytest.raises(ConfigurationError, match="no such part"):
        asking.read_live({"drugs": {"nifedipine": 1}}, before)


def test_what_the_page_is_given_is_plain() -> None:
    shown = [one.plain() for one in agents.offered().values()]
    assert json.loads(json.dumps(shown, allow_nan=False)) == shown


FIRST = "#drug-0"
"""The slider of nifedipine, the first agent of the library."""


@pytest.mark.browser
def test_agents_on_the_page(visit: Callable[..., Visit]) -> None:
    """Two agents by the keyboard, their doses by keys and by number, run, kept in words and in the address."""
    own = visit()
    page = own.open(QUICK)
    page.focus("#drug-name")
    page.keyboard.type("Nif")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert page.evaluate(f"document.activeElement.matches('{FIRST}')"), "the dose is the next to be set"
    assert page.get_attribute(FIRST, "aria-valuetext") == "8.1 nanomolar"
    page.keyboard.press("ArrowRight")
    assert page.get_attribute(FIRST, "aria-valuetext") == "8.9 nanomolar"
    page.fill(f"{FIRST} + input", "30")
    page.press(f"{FIRST} + input", "Tab")
    assert page.get_attribute(FIRST, "aria-valuetext") == "30 nanomolar"
    page.select_option("#drug-name", "lubricant")
    page.click("#drug-add")
    page.select_option("#drug-library", "l_type_is_fast")
    assert page.locator("#drug-list .control").count() == 2
    assert page.locator("#drug-name option[value=nifedipine]").is_disabled(), "an agent is given once"
    page.click("#python")
    own.until("document.getElementById('words').textContent.includes(\"'dose': 'nifedipine 30 nM'\")")
    page.click("#toml")
    own.until("document.getElementById('words').textContent.includes('[[drugs]]')")
    page.click("#permalink")
    own.until("document.getElementById('words').textContent.startsWith('http')")
    address = page.inner_text("#words")
    page.click("#run")
    own.state("a", "over")
    assert own.page.evaluate("window.peristalsis.records.get(window.peristalsis.shown.a).header.drugs") == [
        "nifedipine 30 nM"
    ]
    assert "nifedipine 30 nM" in page.inner_text("#tubes")
    other = own.tab()
    other.goto(address.replace("/#", f"/?key={own.live.key}#"))
    other.wait_for_selector("html[data-ready]")
    assert other.input_value(f"{FIRST} + input") == "30"
    assert other.input_value("#drug-library") == "l_type_is_fast"
    assert other.locator("#drug-list .control").count() == 2
    page.click("#drug-list .control:first-child .remove")
    assert page.evaluate("document.activeElement.id") == "drug-name", "the focus is not lost"
    assert page.locator("#drug-list .control").count() == 1


@pytest.mark.browser
def test_a_dose_that_is_none_is_a_sentence(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(f"{QUICK}&a.d.nifedipine=30+nM")
    page.fill(f"{FIRST} + input", "1e9")
    page.press(f"{FIRST} + input", "Tab")
    assert page.inner_text("#problem") == "Nifedipine = 1e9: give a number from 0.01 to 1000 nM"
    assert page.get_attribute(f"{FIRST} + input", "aria-invalid") == "true"
    page.press(FIRST, "ArrowLeft")
    assert page.inner_text("#problem") == ""
    page.select_option("#scenario", "slow_waves")
    assert page.locator("#drug-list .control").count() == 1, "an agent stays when the scenario changes"
    page.click("#reset")
    own.until("document.querySelectorAll('#drug-list .control').length === 0")


@pytest.mark.browser
@pytest.mark.parametrize(
    "state",
    [
        "a.d.<img src=x onerror=alert(1)>=1 nM",
        "a.d.__proto__=1 nM",
        "a.d.nifedipine=<script>alert(1)</script>",
        "a.d.nifedipine=1e999 nM",
        "a.d.nifedipine=1 parsec",
        "a.d.nifedipine=1 constructor",
        "a.d.nifedipine=30",
        "a.d.apamin=500 nM",
        "a.d.lubricant=0.5 nM",
        "a.library=/etc/passwd",
    ],
)
def test_a_hostile_dose_in_an_address_is_none(visit: Callable[..., Visit], state: str) -> None:
    own = visit()
    own.page.on("dialog", lambda dialog: own.complaints.append(f"a dialog: {dialog.message}"))
    page = own.open(QUICK + IDLE + "&" + state)
    assert page.locator("#drug-list .control").count() == 0
    assert page.input_value("#drug-library") == "shipped"
    assert page.locator("main img, main script").count() == 0


@pytest.mark.browser
def test_doses_of_another_unit_are_read(visit: Callable[..., Visit]) -> None:
    page = visit().open(f"{QUICK}&a.d.nifedipine=0.03 uM&a.d.4-aminopyridine=5 mM")
    assert page.input_value(f"{FIRST} + input") == "30"
    assert page.locator("#drug-list").inner_text().count("Remove") == 2
