"""Active laws chosen by configuration: numbers of both layers and of one, laws from outside, what is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import asked, parts
from peristalsis.inputs.build import bound_to, build
from peristalsis.numerics.binding import SHIPPED
from peristalsis.wall.active import ActiveConstants
from peristalsis.wall.checking import muscle_faults

TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "60 ms", "output.interval": "20 ms"}

OWN = """
from typing import NamedTuple
from peristalsis.declared import number
from peristalsis.numerics.compiled import inlined

KIND, NAME, TITLE = "muscle", "own_parabola", "the paper's, from outside"
PARAMETERS = (
    number("top", -40.0, "mN/(cm*mV)", "quadratic", lowest=-1e3, highest=0.0),
    number("slope", 120.0, "mN/(cm*mV)", "linear", lowest=0.0, highest=1e3),
    number("shift", -50.0, "mN/(cm*mV)", "constant", lowest=-1e3, highest=0.0),
)

class ActiveConstants(NamedTuple):
    top: float
    slope: float
    shift: float

@inlined
def active_tension(stretch, c):
    value = (c.top * stretch + c.slope) * stretch + c.shift
    pulls = value > 0.0
    return (value if pulls else 0.0), (2.0 * c.top * stretch + c.slope if pulls else 0.0)
"""


def configured(**changes: Any) -> ps.Configuration:
    return ps.configuration(changes={**TINY, **{name.replace("__", "."): value for name, value in changes.items()}})


@pytest.fixture
def register(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Path]]:
    """Makes a muscle of a text known, for one test."""
    monkeypatch.setenv(parts.VARIABLE, "")
    monkeypatch.setattr(parts, "_registered", {})

    def one(text: str) -> Path:
        file = tmp_path / "muscle.py"
        file.write_text(text, encoding="utf-8")
        parts.register(file)
        return file

    yield one
    parts._known.cache_clear()


def test_the_shipped_muscle_is_bound_to_nothing() -> None:
    model = build(configured(wall__muscle="parabola"))
    assert model.binding is SHIPPED
    assert model.wall.circular == (-25.0, 75.0, -31.2)
    assert configured(wall__muscle="parabola").digest() == configured().digest()
    assert configured(wall__muscle="bell").digest() != configured().digest()


def test_numbers_of_both_layers_and_of_one() -> None:
    bell = {"wall.muscle": "bell", "wall.bell.best": 1.4, "longitudinal.bell.peak": "40 mN/(cm*mV)"}
    model = build(configured(**bell))
    assert tuple(model.wall.longitudinal) == (40.0, 1.4, 1.0)
    assert tuple(model.wall.circular) == (25.0, 1.4, 1.0)
    assert type(model.wall.circular) is model.binding.module("wall.active").ActiveConstants


@pytest.mark.parametrize("name", parts.parts("muscle"))
def test_shipped_muscles_are_what_the_kernels_take_them_for(name: str) -> None:
    part = parts.find("muscle", name)
    law = bound_to(configured(wall__muscle=name)).module("wall.active")
    if not part.parameters:  # its numbers are the configuration's
        assert muscle_faults(law, ActiveConstants(-25.0, 75.0, -31.2)) == [
            "PARAMETERS and the fields of ActiveConstants differ: c7, c8, c9; name the same in order"
        ]
    else:
        assert muscle_faults(law, law.ActiveConstants(*(one.value for one in part.parameters))) == []


@pytest.mark.slow
def test_a_muscle_from_outside_gives_the_bits_of_the_paper_s(register: Callable[[str], Path]) -> None:
    file = register(OWN)
    circular = {"top": "-25", "slope": "75", "shift": "-31.2"}
    numbers = {f"circular.own_parabola.{name}": f"{value} mN/(cm*mV)" for name, value in circular.items()}
    own = configured(wall__muscle="own_parabola", **numbers)
    assert file in bound_to(own).exchanged.values()
    one, other = ps.Simulation(own).run().arrays, ps.Simulation(configured()).run().arrays
    assert other["pellet_position"][-1] != other["pellet_position"][0]
    assert all(one[name].tobytes() == other[name].tobytes() for name in other if other[name].dtype.kind == "f")


@pytest.mark.slow
def test_a_bell_carries_the_pellet_otherwise() -> None:
    run = ps.Simulation(configured(wall__muscle="bell", longitudinal__bell__peak="40 mN/(cm*mV)"))
    one, other = run.run().arrays, ps.Simulation(configured()).run().arrays
    assert run.error is None
    away = np.abs(one["pellet_position"] - other["pellet_position"]).max()
    assert 1e-6 < away < 0.1
    scalars = run._recorders.scalars
    assert abs(scalars.done.residual) <= 1e-3 * scalars.absolute_work


FAULTS = {
    "broken": ("import nothing_of_this_name\n" + OWN, "cannot be taken up"),
    "nothing": (OWN[: OWN.index("@inlined")], "an active law has ActiveConstants and active_tension"),
    "numbers": (OWN.replace("    shift: float", "    other: float"), "PARAMETERS and the fields"),
    "slope": (OWN.replace("(2.0 * c.top", "(2.1 * c.top"), "its slope is"),
    "negative": (OWN.replace("pulls = value > 0.0", "pulls = True"), "muscle pushes there; cut it at zero"),
    "infinite": (OWN.replace("value > 0.0", "value > 0.0\n    value /= max(stretch - 1.0, 0.0)"), "cannot be used|inf"),
    "formula": (OWN.replace("c.slope) *", "c.slop) *"), "cannot be used"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_faulty_muscle_is_refused_in_a_sentence(name: str, register: Callable[[str], Path]) -> None:
    text, said = FAULTS[name]
    register(text)
    with pytest.raises(ConfigurationError, match=said) as caught:
        build(configured(wall__muscle="own_parabola"))
    assert "wall.muscle = own_parabola" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_muscle_may_push_where_it_says_why(register: Callable[[str], Path]) -> None:
    register(FAULTS["negative"][0] + '\nNEGATIVE = "an example of a muscle that pushes"\n')
    assert build(configured(wall__muscle="own_parabola")).wall.circular.top == -40.0


def test_numbers_without_effect_are_told_or_refused() -> None:
    said = list(asked.remarks(configured(wall__muscle="bell", circular__c7="-20 mN/(cm*mV)")))
    assert "circular.c7 is set and has no effect: wall.muscle = bell" in said
    with pytest.raises(ConfigurationError, match=r"set wall\.muscle = bell, or leave circular\.bell\.peak out"):
        configured(circular__bell__peak="3 mN/(cm*mV)")
    with pytest.raises(ConfigurationError, match=r"wall\.muscle = 'bel' is no muscle; did you mean bell\?"):
        configured(wall__muscle="bel")
