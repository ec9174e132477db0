"""The import rule: arrows point down, siblings never meet, numba has one door, the package imports lightly."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import peristalsis
from tools import structure

PACKAGE = Path(peristalsis.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
PHYSICS = {"numerics", "geometry", "tissue", "wall", "pellet", "control", "model"}
WORDS = {"errors", "units", "paths"}
ALLOWED = {
    "errors": set(),
    "declared": set(),
    "names": set(),
    "units": {"errors"},
    "paths": {"errors"},
    "numerics": set(),
    "geometry": {"numerics"},
    "tissue": {"numerics", "geometry", "declared"},
    "wall": {"numerics", "geometry", "declared"},
    "pellet": {"numerics", "geometry", "declared"},
    "control": {"numerics", "geometry"},
    "model": PHYSICS | {"errors"},
    "storing": {"numerics.sources", "errors", "names", "_version"},
    "storing.disk": {"errors"},
    "inputs": PHYSICS | WORDS | {"storing.disk", "names", "declared"},
    "inputs.parameters": {"units", "errors"},
    "inputs.tables": WORDS,
    "inputs.parts": WORDS | {"declared"},
    "inputs.choices": WORDS | {"declared", "inputs.parts"},
    "inputs.protocols": WORDS | {"inputs.tables", "inputs.choices"},
    "inputs.regions": WORDS | {"storing.disk", "inputs.parts"},
    "inputs.drugs": WORDS | {"storing.disk"},
    "inputs.stimuli": WORDS | {"inputs.tables"},
    "inputs.recording": {"names", "inputs.parts"},
    "inputs.consistency": {"units", "errors"}
    | {
        f"inputs.{name}" for name in ("parameters", "parts", "choices", "recording", "regions", "drugs", "pellet_rules")
    },
    "inputs.pellet_rules": {"errors"},
    "inputs.config": WORDS
    | {"storing.disk"}
    | {
        f"inputs.{name}"
        for name in (
            *("consistency", "protocols", "tables", "stimuli", "recording", "regions", "drugs", "parameters"),
            *("parts", "choices"),
        )
    },
    "scenarios": {"inputs", "errors"},
    "plugins": {"names", "paths", "errors", "inputs", "scenarios", "plots"},
    "cells": {"numerics", "tissue", "model"} | WORDS | {"inputs", "scenarios", "declared"},
    "results": PHYSICS | WORDS | {"inputs", "storing", "names", "_version"},
    "plots": PHYSICS | WORDS | {"inputs", "results", "names"},
    "maps": WORDS | {"plots.data", "plots.style", "plots.canvas", "plots.placing"},
    "running": PHYSICS | WORDS | {"plugins", "inputs", "scenarios", "storing", "results", "names", "_version"},
    "many": PHYSICS | WORDS | {"inputs", "scenarios", "storing", "results", "running", "plots", "maps", "names"},
    "scoring": WORDS | {"inputs", "scenarios", "results", "running", "plots", "many", "_version"},
    "app": WORDS | {"inputs", "scenarios", "results", "running", "plots", "names", "_version"},
    "scoring.bench": {"scoring", "inputs", "results", "running", "plots", "many"},
    "scoring.paper": {"scoring", "inputs", "scenarios", "plots", "many"},
}
"""What each room, or part of one, may import of the package beside itself; `cli` stands above all of these."""
TYPES = {
    "results": {"plots", "maps"},
    "maps": {"results"},
    "inputs.consistency": {"inputs.config"},
    "inputs.pellet_rules": {"inputs.config"},
}
"""What they may name as a type besides, below `if TYPE_CHECKING`."""


def imports(file: Path, root: Path = PACKAGE) -> list[structure.Import]:
    """What a file imports of the package, wherever in it the import stands, names of types among it."""
    return list(structure.imports(file, root, types=True))


def outer(file: Path) -> set[str]:
    """First names of what a file imports of other packages."""
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module and not node.level]
    return {name.split(".")[0] for name in names}


def owner(name: str) -> str:
    """The room, or the part of one with a rule of its own, that a dotted name within the package belongs to."""
    parts = name.split(".")
    longest = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((key for key in longest if key in ALLOWED), parts[0])


def violations(file: Path, root: Path = PACKAGE) -> list[str]:
    """Imports of a file that its room may not have."""
    own = owner(".".join(file.relative_to(root).with_suffix("").parts))
    if own not in ALLOWED:
        return []
    allowed = {own, *ALLOWED[own]}
    types = allowed | TYPES.get(own, set())
    found = [(one.module, types if one.type else allowed) for one in imports(file, root) if one.module]
    return sorted(name for name, may in found if not any(name == one or name.startswith(f"{one}.") for one in may))


def test_every_layer_is_there() -> None:
    """The rule must not go silent when a folder is renamed."""
    for name in ALLOWED:
        place = PACKAGE.joinpath(*name.split("."))
        assert place.is_dir() or place.with_suffix(".py").is_file(), name
    rooms = {file.relative_to(PACKAGE).parts[0].removesuffix(".py") for file in MODULES}
    assert rooms - ALLOWED.keys() == {"__init__", "__main__", "_version", "cli"}, "every room has its rule"


@pytest.mark.parametrize("file", MODULES, ids=lambda f: f.relative_to(PACKAGE).as_posix())
def test_arrows_point_down(file: Path) -> None:
    assert violations(file) == []


@pytest.mark.parametrize(
    ("place", "line"),
    [
        ("wall/new.py", "from ..tissue import sheet"),
        ("tissue/cells/new.py", "from ...wall.passive import strain_energy"),
        ("numerics/new.py", "from peristalsis.geometry.grid import Grid"),
        ("control/new.py", "def f():\n    from ..pellet import sphere"),
        ("geometry/new.py", "from .. import model"),
        ("model/new.py", "import peristalsis.inputs.config"),
    ],
)
def test_rule_can_be_broken(tmp_path: Path, place: str, line: str) -> None:
    """Each of these is a way around the rule, and each is found."""
    root = tmp_path / "peristalsis"
    file = root / place
    file.parent.mkdir(parents=True)
    file.write_text(line + "\n", encoding="utf-8")
    assert violations(file, root) != []


def test_rooms_have_no_circles() -> None:
    """Nor have modules while they are imported, so that any of them can be the first."""
    assert structure.circle(structure.rooms()) == []
    assert structure.circle(structure.graph(late=False)) == []
    assert structure.floors(structure.rooms()) <= 11


def test_circles_are_found(tmp_path: Path) -> None:
    package = tmp_path / "house"
    for name, line in (
        ("hall/door.py", "from ..attic import stairs"),
        ("attic/stairs.py", "def f():\n    import house.hall.door"),
    ):
        (package / name).parent.mkdir(parents=True)
        (package / name).write_text(line + "\n", encoding="utf-8")
    assert set(structure.circle(structure.rooms(package))) == {"hall", "attic"}
    assert structure.circle(structure.graph(package, late=False)) == []


def test_sizes() -> None:
    """Ceilings that may be lowered and not raised: rooms, lengths of files, arguments."""
    folders = [room for room in structure.rooms() if (PACKAGE / room).is_dir()]
    assert len(folders) <= 19
    assert len(structure.rooms()) - len(folders) <= 8
    assert not structure.long_files()
    assert structure.longest_arguments()[0][0] <= 10


def test_the_scorer_knows_no_source() -> None:
    """Sources are folders in its room, found by being there: the engine imports none, and none imports another."""
    room = PACKAGE / "scoring"
    folders = {place.name for place in room.iterdir() if (place / "source.py").is_file()}
    assert "paper" in folders
    for file in room.rglob("*.py"):
        own = file.relative_to(room).parts[0]
        met = {one.module.split(".")[1] for one in imports(file) if one.module.startswith("scoring.")} & folders
        assert met <= {own}, file.name


def test_numba_has_one_door() -> None:
    """Eq. of the cache: every kernel is compiled by `numerics.compiled`, or its cache folder would be a lie."""
    users = {f.relative_to(PACKAGE).as_posix() for f in MODULES if "numba" in outer(f)}
    assert users == {"numerics/compiled.py"}


def test_kernels_live_where_the_cache_looks() -> None:
    """A kernel outside the hashed folders could go stale unseen."""
    from peristalsis.numerics.sources import KERNEL_FOLDERS

    homes = {
        f.relative_to(PACKAGE).parts[0]
        for f in MODULES
        if "numerics.compiled.compiled" in {one.module for one in imports(f)}
    }
    assert homes <= set(KERNEL_FOLDERS)


def test_every_kernel_file_is_part_of_runs() -> None:
    """The code version hashes these folders: one that no run needs would void every checkpoint when it is edited."""
    from peristalsis.numerics.sources import KERNEL_FOLDERS, dependencies

    outside = [f for f in MODULES if f.relative_to(PACKAGE).parts[0] not in KERNEL_FOLDERS]
    needed = set().union(*(dependencies(file) for file in outside))
    kernels = {f for f in MODULES if f.relative_to(PACKAGE).parts[0] in KERNEL_FOLDERS and f.name != "__init__.py"}
    unneeded = {f.relative_to(PACKAGE).as_posix() for f in kernels - needed}
    # Parts are chosen by file, and what is bound to them is asked of the binding: neither is imported by name.
    chosen = {
        "model/guards.py",
        "model/insertion.py",
        "model/stepping.py",
        "tissue/activating.py",
        "tissue/general_rest.py",
        "tissue/surface_sheet.py",
    }
    homes = ("tissue/cells/", "wall/laws/", "wall/muscles/", "pellet/shapes/", "tissue/activations/", "tissue/hill.py")
    assert {name for name in unneeded if not name.startswith(homes)} <= chosen


def test_the_package_stands_without_what_is_beside_it() -> None:
    """Verification, benchmarks and tests import the package and never the other way: they are not in the wheel."""
    beside = {"verification", "benchmarks", "robustness", "evidence", "tests"}
    assert [name for file in MODULES for name in outer(file) if name in beside] == []
    assert not any((PACKAGE / name).exists() for name in ("verification", "benchmark", "benchmarks"))


def test_units_are_converted_at_the_edge_only() -> None:
    """Below the model numbers are bare."""
    for file in MODULES:
        if file.relative_to(PACKAGE).parts[0] in PHYSICS:
            assert not any(owner(one.module) == "units" for one in imports(file)), file.name


@pytest.mark.parametrize("module", ["peristalsis", "peristalsis.inputs.config", "peristalsis.scenarios"])
def test_imports_are_light(module: str) -> None:
    """Reading a configuration must not wait for numpy, a compiler or a plotting library."""
    heavy = ("numpy", "numba", "scipy", "matplotlib", "xarray", "h5py")
    code = f"import sys, {module}; print(*[m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
