"""Descriptions of cells as plain Python: found by name or file, and read without compiling anything."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError, shown

Floats = NDArray[np.float64]

FOLDER = Path(__file__).parent.parent / "tissue" / "cells"
NEEDED = ("STATES", "GATES", "CHANNELS", "INSTANT", "LOWEST", "HIGHEST", "CellConstants", "SHIPPED", "CONDUCTANCES")
FUNCTIONS = ("gates", "instant", "others", "current")


@dataclass(frozen=True)
class Description:
    """A cell's file, its syntax and its plain module, whose functions are not compiled."""

    name: str
    file: Path
    tree: ast.Module
    module: ModuleType

    @property
    def title(self) -> str:
        """One line that says what the cell is."""
        return str(getattr(self.module, "TITLE", self.name))

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states besides the potential, gates first."""
        return tuple(state[0] for state in self.module.STATES)

    @property
    def conductances(self) -> Floats:
        """Values of the channels [mS/cm^2]."""
        return np.array([getattr(one, "value", one) for one in self.module.CONDUCTANCES], dtype=np.float64)


def shipped() -> tuple[str, ...]:
    """Names of the descriptions in the package."""
    return tuple(sorted(file.stem for file in FOLDER.glob("*.py") if _describes(file)))


def _describes(file: Path) -> bool:
    return file.stem not in ("__init__", "general", "plant") and "\nCHANNELS = " in file.read_text(encoding="utf-8")


def described(name: str) -> Description:
    """The description of a shipped name or of a Python file; a ConfigurationError says why there is none."""
    file = Path(name) if name.endswith(".py") else FOLDER / f"{name}.py"
    if not name.endswith(".py") and name not in shipped():
        raise ConfigurationError(f"there is no cell {shown(name)}; shipped are plant, {', '.join(shipped())}")
    return read(file)


def read(file: Path) -> Description:
    """Read a description; its functions stay plain Python, so nothing is compiled."""
    try:
        text = file.read_text(encoding="utf-8")
        tree = ast.parse(text)
    except OSError as error:
        raise ConfigurationError(f"could not read {shown(str(file))}: {error.strerror}; check the path") from None
    except (SyntaxError, ValueError) as error:
        raise ConfigurationError(f"{shown(str(file))} is no Python file: {error}; mend it") from None
    module = plain_module(file, tree)
    missing = [name for name in (*NEEDED, *FUNCTIONS) if not hasattr(module, name)]
    if missing:
        raise ConfigurationError(f"{shown(str(file))} lacks {', '.join(missing)}; docs/cells.md says what a cell has")
    return Description(str(getattr(module, "NAME", file.stem)), file, tree, module)


def plain_module(file: Path, tree: ast.Module) -> ModuleType:
    """A file executed with its decorators left out."""
    bare = ast.parse(ast.unparse(tree))
    for node in bare.body:
        if isinstance(node, ast.FunctionDef):
            node.decorator_list = []
    inside = file.resolve().parent == FOLDER.resolve()
    name = f"peristalsis.tissue.cells._plain_{file.stem}" if inside else f"_plain_{file.stem}"
    module = ModuleType(name)
    module.__file__ = str(file)
    module.__package__ = "peristalsis.tissue.cells" if inside else ""
    import sys

    sys.modules[name] = module  # named tuples and dataclasses look their module up
    try:
        exec(compile(bare, str(file), "exec"), module.__dict__)
    except Exception as error:
        raise ConfigurationError(
            f"{shown(str(file))} cannot be executed: {type(error).__name__}: {error}; mend it"
        ) from None
    finally:
        del sys.modules[name]
    return module


def rates(cell: Description, conductances: Floats | None = None) -> Callable[[float, Floats, float], Floats]:
    """The equations of one cell: (potential [mV], states, stimulus [uA/cm^2]) to the rates of both [1/ms]."""
    m: Any = cell.module
    gates, size, constants = m.GATES, len(m.STATES), m.SHIPPED
    channels = (cell.conductances if conductances is None else conductances)[:, None]
    row, instants, rest = np.zeros(2 * gates + 1), np.zeros((max(m.INSTANT, 1), 1)), np.zeros(2 * (size - gates) + 1)

    def of(v: float, states: Floats, stimulus: float) -> Floats:
        column = np.reshape(states, (-1, 1))
        m.gates(v, constants, row)
        m.instant(v, constants, instants[:, 0])
        m.others(v, column, channels, 0, constants, rest)
        ionic = m.current(v, column, channels, instants, 0, constants)
        found = np.empty(1 + size)
        found[0] = (stimulus - constants.kinetics_rate * ionic) / constants.capacitance
        found[1 : 1 + gates] = row[1 : 2 * gates : 2] * (row[0 : 2 * gates : 2] - states[:gates])
        found[1 + gates :] = rest[0 : 2 * (size - gates) : 2] - rest[1 : 2 * (size - gates) : 2] * states[gates:]
        found[1:] *= constants.kinetics_rate
        return found

    return of


def start(cell: Description) -> Floats:
    """Potential [mV] and states to begin with: the file's START, or rest if there is one in the range."""
    given = getattr(cell.module, "START", None)
    if given is not None:
        return np.array(given, dtype=np.float64)
    potentials = np.linspace(max(cell.module.LOWEST, -120.0) + 0.013, min(cell.module.HIGHEST, 60.0) - 0.013, 721)
    settled = [steady(cell, float(v)) for v in potentials]
    of = rates(cell)
    slopes = np.array([of(float(v), s, 0.0)[0] for v, s in zip(potentials, settled, strict=True)])
    crossings = np.flatnonzero((slopes[:-1] > 0.0) & (slopes[1:] <= 0.0))
    if crossings.size == 0:
        return np.concatenate([[-60.0], steady(cell, -60.0)])
    from scipy.optimize import brentq

    k = int(crossings[0])
    v = brentq(lambda x: of(x, steady(cell, x), 0.0)[0], potentials[k], potentials[k + 1], xtol=1e-12)
    return np.concatenate([[v], steady(cell, v)])


def steady(cell: Description, v: float) -> Floats:
    """States at rest at a held potential: gates at their steady values, the others by repeated a / b."""
    m: Any = cell.module
    row, rest = np.zeros(2 * m.GATES + 1), np.zeros(2 * (len(m.STATES) - m.GATES) + 1)
    m.gates(v, m.SHIPPED, row)
    states = np.array([0.5 * (low + min(high, 1.0)) for _, low, high in m.STATES])
    states[: m.GATES] = row[0 : 2 * m.GATES : 2]
    for _ in range(200 if len(states) > m.GATES else 0):
        m.others(v, states[:, None], cell.conductances[:, None], 0, m.SHIPPED, rest)
        with np.errstate(divide="ignore", invalid="ignore"):
            aim = rest[0:-1:2] / rest[1::2]
        states[m.GATES :] = np.where(np.isfinite(aim), aim, states[m.GATES :])
    return states
