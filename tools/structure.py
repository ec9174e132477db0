"""How the package is built: its rooms, what imports what, circles, long files, long lists of arguments.

`python tools/structure.py [FOLDER]` prints the numbers of a package (src/peristalsis unless given); the tests in
tests/architecture hold them. A room is a folder of the package, or a file beside the folders. An arrow is an import
of one room by another, wherever in a file it stands; what stands below `if TYPE_CHECKING` names a type and is none.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "peristalsis"
LONG = 400
"""Lines of a file above which it is long."""


class Import(NamedTuple):
    """One import in a file: the module, as a dotted name within the package, whether a function makes it, or none.

    type: it stands below `if TYPE_CHECKING` and is never carried out.
    """

    module: str
    late: bool
    type: bool


def modules(package: Path = PACKAGE) -> dict[str, Path]:
    """Every module by its dotted name within the package; "" is the package itself."""
    found = {}
    for file in sorted(package.rglob("*.py")):
        parts = file.relative_to(package).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imports(file: Path, package: Path = PACKAGE, types: bool = False) -> Iterator[Import]:
    """What a file imports of its package; dotted names may end in something that is no module.

    types: also what is imported below `if TYPE_CHECKING` alone.
    """
    own = (package.name, *file.relative_to(package).parent.parts)

    def walk(node: ast.AST, late: bool, type_: bool) -> Iterator[Import]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
                if types:
                    yield from walk(child, late, True)
                continue
            names: list[str] = []
            if isinstance(child, ast.ImportFrom):
                base = own[: len(own) - child.level + 1] if child.level else ()
                stem = ".".join((*base, *([child.module] if child.module else [])))
                names = [f"{stem}.{alias.name}" for alias in child.names]
            elif isinstance(child, ast.Import):
                names = [alias.name for alias in child.names]
            for name in names:
                if name.split(".")[0] == package.name:
                    yield Import(name.partition(".")[2], late, type_)
            yield from walk(child, late or isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef), type_)

    yield from walk(ast.parse(file.read_text(encoding="utf-8")), False, False)


def graph(package: Path = PACKAGE, late: bool = True) -> dict[str, set[str]]:
    """Module to the modules that it imports; late: also those that are imported inside functions."""
    known = modules(package)
    found: dict[str, set[str]] = {name: set() for name in known}
    for name, file in known.items():
        for one in imports(file, package):
            module = one.module
            while module not in known:
                module = module.rpartition(".")[0]
            if module != name and (late or not one.late):
                found[name].add(module)
    return found


def rooms(package: Path = PACKAGE) -> dict[str, set[str]]:
    """Room to the rooms that it imports; the package's own file, from which everything is reached, is none."""
    found: dict[str, set[str]] = {}
    for name, wanted in graph(package).items():
        room = name.split(".")[0]
        if room:
            others = {module.split(".")[0] for module in wanted} - {room, ""}
            found.setdefault(room, set()).update(others)
    return found


def circle(arrows: Mapping[str, set[str]]) -> list[str]:
    """One circle of a graph, its first member again at the end; empty if there is none."""
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        return [str(name) for name in error.args[1]]
    return []


def floors(arrows: Mapping[str, set[str]]) -> int:
    """Rooms on the longest way down; 0 if there is a circle."""
    if circle(arrows):
        return 0
    height: dict[str, int] = {}
    for name in TopologicalSorter(arrows).static_order():
        height[name] = 1 + max((height[other] for other in arrows.get(name, ())), default=0)
    return max(height.values())


def long_files(package: Path = PACKAGE) -> dict[str, int]:
    """Files of more than `LONG` lines, as paths within the package, with their lines."""
    lines = {file: len(file.read_text(encoding="utf-8").splitlines()) for file in modules(package).values()}
    return {file.relative_to(package).as_posix(): count for file, count in lines.items() if count > LONG}


def longest_arguments(package: Path = PACKAGE) -> list[tuple[int, str]]:
    """Number of arguments and name of every function, the longest first; commands, whose options they are, aside."""
    found = []
    for module, file in modules(package).items():
        if module.split(".")[0] == "cli":
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                a = node.args
                count = len(a.posonlyargs) + len(a.args) + len(a.kwonlyargs)
                count -= bool(a.args) and a.args[0].arg in ("self", "cls")
                found.append((count, f"{module}.{node.name}"))
    return sorted(found, reverse=True)


def main(words: list[str] | None = None) -> int:
    """Print the numbers."""
    given = sys.argv[1:] if words is None else words
    package = Path(given[0]).resolve() if given else PACKAGE
    files = list(modules(package).values())
    arrows = rooms(package)
    long, arguments = long_files(package), longest_arguments(package)
    print(f"lines: {sum(len(file.read_text(encoding='utf-8').splitlines()) for file in files)} in {len(files)} files")
    print(f"rooms: {len(arrows)}, of them folders {sum((package / name).is_dir() for name in arrows)}")
    print(f"arrows: {sum(map(len, arrows.values()))}, floors: {floors(arrows) or '-'}")
    print(f"circle of rooms: {' -> '.join(circle(arrows)) or 'none'}")
    print(f"circle of modules at import: {' -> '.join(circle(graph(package, late=False))) or 'none'}")
    print(f"files above {LONG} lines: {len(long)} ({', '.join(f'{name} {count}' for name, count in long.items())})")
    print(f"longest argument list: {arguments[0][0]} ({arguments[0][1]})")
    print(f"functions of more than 10 arguments: {sum(count > 10 for count, _ in arguments)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
