"""Kernels bound to an exchanged part: the part is used, the rest is shared, and the next process compiles nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import peristalsis
from peristalsis.numerics.binding import SHIPPED, bind
from peristalsis.numerics.sources import dependencies, kernel_digest

PACKAGE = Path(peristalsis.__file__).parent
SLOT = PACKAGE / "wall" / "active.py"
DOUBLED = """
from typing import NamedTuple
from peristalsis.numerics.compiled import inlined
class ActiveConstants(NamedTuple):
    c7: float
    c8: float
    c9: float
@inlined
def active_tension(stretch: float, constants: ActiveConstants) -> tuple[float, float]:
    return {} * stretch, {}
"""
ASK = """
import sys
from pathlib import Path
from peristalsis.numerics.binding import bind
from peristalsis.numerics.compiled import compiled
import peristalsis.wall.membrane as shipped
bound = bind({"wall.active": Path(sys.argv[1])})
membrane = bound.module("wall.membrane")
value = bound.module("wall.active").active_tension(2.0, bound.module("wall.active").ActiveConstants(1.0, 2.0, 3.0))
print(value[0], sum(bound.module("wall.active").active_tension.stats.cache_misses.values()))
"""


@pytest.fixture
def law(tmp_path: Path) -> Path:
    """Another active law, in a file of the user's."""
    file = tmp_path / "doubled.py"
    file.write_text(DOUBLED.format(2.0, 2.0), encoding="utf-8")
    return file


def test_nothing_exchanged_is_the_package_itself() -> None:
    from peristalsis.wall import membrane

    assert bind({}) is SHIPPED
    assert bind({"wall.active": SLOT}) is SHIPPED
    assert SHIPPED.module("wall.membrane") is membrane


def test_what_depends_on_the_part_is_renewed_and_nothing_else(law: Path) -> None:
    import peristalsis.geometry.grid
    from peristalsis.wall import active, membrane

    bound = bind({"wall.active": law})
    other = bound.module("wall.membrane")
    assert other is not membrane
    assert other.active_tension is bound.module("wall.active").active_tension
    assert membrane.active_tension is active.active_tension
    assert other.__file__ == membrane.__file__
    assert bound.module("geometry.grid") is peristalsis.geometry.grid
    assert bound.module("wall.passive") is sys.modules["peristalsis.wall.passive"]
    assert peristalsis.geometry.grid.__spec__ is not None
    assert peristalsis.geometry.grid.__spec__.name == "peristalsis.geometry.grid"


def test_records_are_the_same_classes_but_those_of_the_exchanged_file() -> None:
    """numba tells arguments apart by structure first: of two classes alike it finds only the first without Python."""
    bound = bind(
        {
            "pellet.shapes.sphere": PACKAGE / "pellet" / "shapes" / "capsule.py",
            "wall.laws.tong_fung": PACKAGE / "wall" / "laws" / "fung.py",
        }
    )
    exchanged = {f"{bound.prefix}.pellet.shapes.sphere", f"{bound.prefix}.wall.laws.tong_fung"}
    names = [".".join(file.relative_to(PACKAGE).with_suffix("").parts) for file in bound.renewed]
    own = {
        thing.__module__
        for name in names
        for thing in vars(bound.module(name)).values()
        if isinstance(thing, type) and issubclass(thing, tuple) and thing.__module__.startswith(bound.prefix)
    }
    assert {"model.wall_step", "wall.surface", "pellet.surface_contact"} <= set(names)
    assert own == exchanged


def test_equal_content_is_one_binding(law: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.py"
    copy.write_bytes(law.read_bytes())
    assert bind({"wall.active": law}) is bind({"wall.active": copy})
    copy.write_text(DOUBLED.format(3.0, 3.0), encoding="utf-8")
    assert bind({"wall.active": law}) is not bind({"wall.active": copy})


def test_a_slot_that_is_none_is_refused(law: Path) -> None:
    with pytest.raises(KeyError, match=r"wall\.activ"):
        bind({"wall.activ": law})


def test_digest_follows_the_exchanged_file(law: Path) -> None:
    """A kernel that calls the part is another one; what the part imports of the package counts too."""
    membrane = PACKAGE / "wall" / "membrane.py"
    exchanged = ((SLOT, law),)
    assert law in dependencies(membrane, exchanged)
    assert SLOT not in dependencies(membrane, exchanged)
    assert PACKAGE / "numerics" / "compiled.py" in dependencies(law)
    assert kernel_digest(membrane, exchanged) != kernel_digest(membrane)


def ask(law: Path, cache: Path) -> tuple[float, int]:
    """(tension by the law at stretch 2, kernels compiled for it) in a fresh process."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("COV")}
    environment |= {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(PACKAGE.parent)}
    words = [sys.executable, "-c", ASK, str(law)]
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=environment)
    value, misses = done.stdout.split()
    return float(value), int(misses)


def test_the_next_process_loads_from_the_cache_and_a_changed_part_is_compiled(law: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert ask(law, cache) == (4.0, 1)
    assert ask(law, cache) == (4.0, 0)
    law.write_text(DOUBLED.format(5.0, 5.0), encoding="utf-8")
    assert ask(law, cache) == (10.0, 1)
