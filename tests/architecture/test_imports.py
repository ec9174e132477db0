"""The import rule: arrows point down, siblings never meet, numba has one door, the package imports lightly."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import peristalsis

PACKAGE = Path(peristalsis.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
ALLOWED = {
    "numerics": {"numerics"},
    "geometry": {"numerics", "geometry"},
    "tissue": {"numerics", "geometry", "tissue", "declared"},
    "wall": {"numerics", "geometry", "wall", "declared"},
    "pellet": {"numerics", "geometry", "pellet", "declared"},
    "control": {"numerics", "geometry", "control"},
    "model": {"numerics", "geometry", "tissue", "wall", "pellet", "control", "model", "errors"},
    "declared": {"declared"},
    "units": {"units", "errors"},
    "errors": {"errors"},
    "parameters": {"parameters", "units", "errors"},
    "disk": {"disk", "errors"},
    "paths": {"paths", "errors"},
    "tables": {"tables", "paths", "units", "errors"},
    "protocols": {"protocols", "tables", "paths", "units", "errors"},
    "regions": {"regions", "disk", "paths", "units", "errors"},
    "stimuli": {"stimuli", "tables", "paths", "units", "errors"},
    "names": {"names"},
    "recording": {"recording", "names"},
    "consistency": {"consistency", "config", "parameters", "recording", "regions", "units", "errors"},
    "config": {
        "config",
        "consistency",
        "disk",
        "paths",
        "protocols",
        "tables",
        "stimuli",
        "recording",
        "regions",
        "parameters",
        "units",
        "errors",
    },
}
"""What each layer may import of the package; layers that are not named lie above all of these."""


def imports(file: Path, root: Path = PACKAGE) -> set[str]:
    """Absolute dotted names of everything a file imports, wherever in it the import stands."""
    package = ["peristalsis", *file.relative_to(root).parent.parts]
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            found |= {f"{stem}.{alias.name}" for alias in node.names}
    return found


def layer(name: str) -> str:
    """The layer a dotted name of the package belongs to."""
    return name.split(".")[1] if name.startswith("peristalsis.") else ""


def violations(file: Path, root: Path = PACKAGE) -> list[str]:
    """Imports of a file that its layer may not have."""
    own = file.relative_to(root).parts[0].removesuffix(".py")
    if own not in ALLOWED:
        return []
    return sorted(name for name in imports(file, root) if layer(name) and layer(name) not in ALLOWED[own])


def test_every_layer_is_there() -> None:
    """The rule must not go silent when a folder is renamed."""
    for name in ALLOWED:
        assert (PACKAGE / name).is_dir() or (PACKAGE / f"{name}.py").is_file(), name


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
    file = tmp_path / place
    file.parent.mkdir(parents=True)
    file.write_text(line + "\n", encoding="utf-8")
    assert violations(file, tmp_path) != []


def test_numba_has_one_door() -> None:
    """Eq. of the cache: every kernel is compiled by `numerics.compiled`, or its cache folder would be a lie."""
    users = {f.relative_to(PACKAGE).as_posix() for f in MODULES if any(n.split(".")[0] == "numba" for n in imports(f))}
    assert users == {"numerics/compiled.py"}


def test_kernels_live_where_the_cache_looks() -> None:
    """A kernel outside the hashed folders could go stale unseen."""
    from peristalsis.numerics.sources import KERNEL_FOLDERS

    homes = {f.relative_to(PACKAGE).parts[0] for f in MODULES if "peristalsis.numerics.compiled.compiled" in imports(f)}
    assert homes <= set(KERNEL_FOLDERS)


def test_every_kernel_file_is_part_of_runs() -> None:
    """The code version hashes these folders: one that no run needs would void every checkpoint when it is edited."""
    from peristalsis.numerics.sources import KERNEL_FOLDERS, dependencies

    outside = [f for f in MODULES if f.relative_to(PACKAGE).parts[0] not in KERNEL_FOLDERS]
    needed = set().union(*(dependencies(file) for file in outside))
    kernels = {f for f in MODULES if f.relative_to(PACKAGE).parts[0] in KERNEL_FOLDERS and f.name != "__init__.py"}
    unneeded = {f.relative_to(PACKAGE).as_posix() for f in kernels - needed}
    assert {name for name in unneeded if not name.startswith("tissue/cells/")} == set()  # cells are parts to choose


def test_the_package_stands_without_what_is_beside_it() -> None:
    """Verification, benchmarks and tests import the package and never the other way: they are not in the wheel."""
    beside = {"verification", "benchmarks", "robustness", "evidence", "tests"}
    assert {name for file in MODULES for name in imports(file) if name.split(".")[0] in beside} == set()
    assert not any((PACKAGE / name).exists() for name in ("verification", "benchmark", "benchmarks"))


def test_units_are_converted_at_the_edge_only() -> None:
    """Below the model numbers are bare."""
    for file in MODULES:
        if file.relative_to(PACKAGE).parts[0] in (
            "numerics",
            "geometry",
            "tissue",
            "wall",
            "pellet",
            "control",
            "model",
        ):
            assert not any(layer(name) == "units" for name in imports(file)), file.name


@pytest.mark.parametrize("module", ["peristalsis", "peristalsis.inputs.config", "peristalsis.scenarios"])
def test_imports_are_light(module: str) -> None:
    """Reading a configuration must not wait for numpy, a compiler or a plotting library."""
    heavy = ("numpy", "numba", "scipy", "matplotlib", "xarray", "h5py")
    code = f"import sys, {module}; print(*[m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
