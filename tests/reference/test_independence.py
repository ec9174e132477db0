"""The reference implementations share no code with the package, and none but the constants with one another."""

import ast
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
METHOD_OF_LINES = {"method_of_lines", "mol_sheets", "mol_stepper", "mol_wall"}
FINITE_DIFFERENCES = {"finite_differences"}
SHARED = {"constants"}


def imported(file: Path) -> set[str]:
    """Every module that a file imports, written out."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file.name}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Name):
            assert node.id not in {"__import__", "importlib", "exec", "eval"}, f"{file.name}: {node.id}"
    return found


@pytest.mark.parametrize("name", sorted(METHOD_OF_LINES | FINITE_DIFFERENCES | SHARED))
def test_nothing_comes_from_the_package(name: str) -> None:
    family = next(family for family in (METHOD_OF_LINES, FINITE_DIFFERENCES, SHARED) if name in family)
    for module in imported(HERE / f"{name}.py"):
        top, *rest = module.split(".")
        if top == "reference":
            assert rest[0] in family | SHARED, f"{name} imports {module}"
        else:
            assert top in {"numpy", "scipy", "numba"} | set(sys.stdlib_module_names), f"{name} imports {module}"


def test_every_module_is_accounted_for() -> None:
    modules = {file.stem for file in HERE.glob("*.py") if not file.stem.startswith("test_")} - {"__init__"}
    assert modules == METHOD_OF_LINES | FINITE_DIFFERENCES | SHARED


def test_the_package_knows_nothing_of_them() -> None:
    for file in (HERE.parents[1] / "src").rglob("*.py"):
        assert not any(module.split(".")[0] == "reference" for module in imported_names(file)), file


def imported_names(file: Path) -> set[str]:
    """Top names of absolute imports of a file of the package."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(str(node.module))
    return found
