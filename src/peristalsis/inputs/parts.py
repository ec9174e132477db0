"""Which parts there are, cells, laws, shapes and others: the package's, those of installed packages, the user's files.

A part is one Python file that says what it is: KIND, NAME, TITLE and PARAMETERS, written out as literals. They are read
from the text without executing it, so that a configuration is checked without compiling anything. The file itself is
imported when a run binds it (`numerics.binding`).
"""

from __future__ import annotations

import ast
import math
import operator
import os
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

from .. import units
from ..declared import Declared, Tag, number
from ..errors import ConfigurationError, shown, suggestion
from ..paths import located

PACKAGE = Path(__file__).parents[1]
KINDS: Mapping[str, str] = {
    "cell": "tissue/cells",
    "activation": "tissue/activations",
    "law": "wall/laws",
    "muscle": "wall/muscles",
    "shape": "pellet/shapes",
}
"""Kind of a part to the folder of those that the package ships."""
SHIPPED: Mapping[str, str] = {
    "cell": "plant",
    "activation": "depolarisation",
    "law": "tong_fung",
    "muscle": "parabola",
    "shape": "sphere",
}
"""The part that stands in the slot unless another is chosen; its numbers are parameters of the configuration itself."""
GROUP = "peristalsis.parts"
"""Entry points of installed packages: each names a module that is a part."""
VARIABLE = "PERISTALSIS_PLUGINS"
"""Files of parts for this process and for those it starts, separated as in PATH."""
CODE_VARIABLE = "PERISTALSIS_PLUGIN_CODE"
"""Files that are executed, in the same way (`plugins`)."""
LARGEST_FILE = 1_000_000
UNITS_OF_CALCIUM: Mapping[str, float] = {"M": 1e6, "mM": 1e3, "uM": 1.0, "nM": 1e-3, "1": 1.0}
"""Unit in which a cell may have its calcium to its size in uM; 1 is what an activation says that it stands for."""

_NAME = re.compile(r"[a-z][a-z0-9_]{0,62}")


@dataclass(frozen=True)
class Part:
    """What a file says of itself. parameters: of all; channels: conductances of a cell, whose names regions know.

    states: names of the states of a cell or an activation. origin: "peristalsis", the name of an installed package, or
    the file. calcium: name and unit of a cell's calcium, both empty without any; the unit is "1" for a mere number.
    reads_calcium: whether an activation does.
    """

    kind: str
    name: str
    title: str
    file: Path
    parameters: tuple[Declared, ...] = ()
    channels: tuple[Declared, ...] = ()
    states: tuple[str, ...] = ()
    origin: str = "peristalsis"
    calcium: tuple[str, str] = ("", "")
    reads_calcium: bool = False

    @property
    def numbers(self) -> tuple[Declared, ...]:
        """Everything that a configuration may set of it."""
        return (*self.parameters, *self.channels)


_registered: dict[str, Path] = {}


def register(file: str | os.PathLike[str] | ModuleType) -> Part:
    """Make the part in a file, or in an imported module, known to this process and those it starts.

    Raises ConfigurationError if the file cannot be read, is no part, or has the name of another part.
    """
    place = located(file.__file__ if isinstance(file, ModuleType) and file.__file__ else str(file)).resolve()
    part = read_part(place)
    other = parts(part.kind).get(part.name)
    if other is not None and other.file != place:
        raise ConfigurationError(
            f"{shown(str(place))}: {part.kind} {part.name} is there already, in {shown(str(other.file))}; give it "
            "another NAME"
        )
    namesake = next((one for kind in KINDS if (one := parts(kind).get(part.name)) and one.kind != part.kind), None)
    if namesake is not None:
        raise ConfigurationError(
            f"{shown(str(place))}: {part.name} is the name of a {namesake.kind} already, and numbers go by it; "
            "give it another NAME"
        )
    if str(place) not in _registered:
        _registered[str(place)] = place
        given = os.environ.get(VARIABLE, "")
        os.environ[VARIABLE] = os.pathsep.join([*filter(None, given.split(os.pathsep)), str(place)])
        _known.cache_clear()
    return part


def forget_all() -> None:
    """Take out every part that was registered in this process or in the one that started it."""
    os.environ.pop(VARIABLE, None)
    _registered.clear()
    _known.cache_clear()


def is_part(file: Path) -> bool:
    """Whether a file says KIND, or cannot be read as a file of Python; `read_part` tells what is wrong then."""
    try:
        return "KIND" in _literals(ast.parse(file.read_text(encoding="utf-8")), "")
    except (OSError, SyntaxError, ValueError, RecursionError, ConfigurationError):
        return True


def parts(kind: str) -> Mapping[str, Part]:
    """The parts of a kind by name, the shipped one first."""
    return _known(os.environ.get(VARIABLE, ""))[kind]


def find(kind: str, name: str) -> Part:
    """The part of this kind and name. Raises ConfigurationError with what there is."""
    known = parts(kind)
    if name not in known:
        raise ConfigurationError(
            f"{shown(name)} is no {kind}; {suggestion(name, known)}, or register the file that holds it (--plugin FILE)"
        )
    return known[name]


@cache
def _known(given: str) -> Mapping[str, Mapping[str, Part]]:
    found: dict[str, dict[str, Part]] = {kind: {} for kind in KINDS}
    for part in _shipped():
        found[part.kind][part.name] = part
    for file, origin in [*_installed(), *((Path(name), name) for name in given.split(os.pathsep) if name)]:
        part = read_part(file, origin)
        found[part.kind].setdefault(part.name, part)
    for kind, first in SHIPPED.items():
        found[kind] = {first: found[kind].pop(first), **dict(sorted(found[kind].items()))}
    return found


@cache
def _shipped() -> tuple[Part, ...]:
    files = [file for folder in KINDS.values() for file in sorted((PACKAGE / folder).glob("*.py"))]
    found = [read_part(file) for file in files if re.search(r"^KIND\b", file.read_text(encoding="utf-8"), re.MULTILINE)]
    return tuple(found)


def _installed() -> Iterator[tuple[Path, str]]:
    for point in entry_points(group=GROUP):
        spec = find_spec(point.value)
        if spec is None or spec.origin is None:
            raise ConfigurationError(
                f"the installed package {point.dist.name if point.dist else '?'} offers {point.value} as a part, and "
                "there is no such module; mend or remove that package"
            )
        yield Path(spec.origin), point.dist.name if point.dist else point.value


def read_part(file: Path, origin: str | None = None) -> Part:
    """The part that a file says it is, without executing it. Raises ConfigurationError in one sentence."""
    where = shown(str(file))
    try:
        if file.stat().st_size > LARGEST_FILE:
            raise ConfigurationError(f"{where} is larger than {LARGEST_FILE} bytes; no part is")
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigurationError(f"{where} cannot be read: {error.strerror}; check the name of the plug-in") from None
    except (SyntaxError, ValueError, RecursionError) as error:
        line = f", line {error.lineno}" if isinstance(error, SyntaxError) else ""
        raise ConfigurationError(f"{where}{line} is not Python: {shown(str(error), 120)}; correct it") from None
    said = _literals(tree, where)
    kind, name = said.get("KIND"), said.get("NAME")
    if not isinstance(kind, str) or kind not in KINDS:
        raise ConfigurationError(f"{where}: KIND = {shown(kind)}; a part says one of {', '.join(KINDS)}")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ConfigurationError(
            f"{where}: NAME = {shown(name)}; a part has a name of lower-case letters, digits and _"
        )
    parameters = _numbers(said, "PARAMETERS", file)
    channels = _numbers(said, "CONDUCTANCES", file)
    states: tuple[str, ...] = tuple(state[0] for state in said.get("STATES", ()))
    calcium = ("", "")
    if kind == "cell":
        names = tuple(one.name for one in channels)
        if name != SHIPPED["cell"] and said.get("CHANNELS") != names:
            raise ConfigurationError(
                f"{where}: CHANNELS = {shown(said.get('CHANNELS'))} and CONDUCTANCES = {shown(names)} name different "
                "channels; name the same in the same order"
            )
        calcium = _calcium(said, states, where)
        if name != SHIPPED["cell"]:
            parameters = _with_tissue(parameters, float(said.get("CAPACITANCE", 1.0)))
    own = origin or ("peristalsis" if file.is_relative_to(PACKAGE) else str(file))
    reads = said.get("READS_CALCIUM", False) is True
    return Part(kind, name, str(said.get("TITLE", name)), file, parameters, channels, states, own, calcium, reads)


def _calcium(said: Mapping[str, Any], states: tuple[str, ...], where: str) -> tuple[str, str]:
    """Name and unit of a cell's calcium; without its word for it, that of a state of this name, in no known unit."""
    given = said.get("CALCIUM_STATE", ("calcium" if "calcium" in states else "", ""))
    if not (isinstance(given, tuple) and len(given) == 2 and all(isinstance(one, str) for one in given)):
        raise ConfigurationError(
            f'{where}: CALCIUM_STATE = {shown(given)}; write name and unit of a state, such as ("calcium", "uM")'
        )
    name, unit = given
    if name and name not in states:
        raise ConfigurationError(
            f"{where}: CALCIUM_STATE: {shown(name)} is none of STATES: {', '.join(states)}; name one of them"
        )
    if unit not in ("", *UNITS_OF_CALCIUM):
        raise ConfigurationError(
            f"{where}: CALCIUM_STATE: unit {shown(unit)} is none of {', '.join(UNITS_OF_CALCIUM)}; use one of them"
        )
    return name, unit


def _with_tissue(parameters: tuple[Declared, ...], capacitance: float) -> tuple[Declared, ...]:
    """With the two numbers that every cell has."""
    own = {one.name for one in parameters}
    both = (
        number("capacitance", capacitance, "uF/cm^2", "capacitance of the membrane", lowest=1e-6, highest=1e6),
        number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", lowest=1e-6, highest=1e4),
    )
    return (*parameters, *(one for one in both if one.name not in own))


_SAID = ("KIND", "NAME", "TITLE", "PARAMETERS", "CONDUCTANCES", "CHANNELS", "STATES", "CAPACITANCE", "CALCIUM_STATE")


def _literals(tree: ast.Module, where: str) -> dict[str, Any]:
    """What the file assigns to the names that a part says; number(...) becomes a `Declared`."""
    found: dict[str, Any] = {}
    for name, value in _assignments(tree):
        try:
            found[name] = _value(value, found)
        except (ValueError, TypeError, ArithmeticError) as error:
            if name in _SAID:
                raise ConfigurationError(
                    f"{where}, line {value.lineno}: {name} is not written out ({shown(str(error), 120)}); use texts, "
                    "numbers and number(...) only"
                ) from None
    return found


def _assignments(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Name and value of every assignment at the top of a file; those of several names one by one."""
    for node in tree.body:
        value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        for target in targets:
            if isinstance(target, ast.Name) and value is not None:
                yield target.id, value
            elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                pairs = zip(target.elts, value.elts, strict=False)
                yield from ((name.id, one) for name, one in pairs if isinstance(name, ast.Name))


_ARITHMETIC: Mapping[type, Any] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def _value(node: ast.expr, known: Mapping[str, Any]) -> Any:
    """What an expression of literals, earlier names, sums, products and number(...) stands for."""
    if isinstance(node, ast.Tuple | ast.List):
        return tuple(_value(item, known) for item in node.elts)
    if isinstance(node, ast.Name) and node.id in known:
        return known[node.id]
    if isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
        left, right = _value(node.left, known), _value(node.right, known)
        if not isinstance(left, int | float) or not isinstance(right, int | float):
            raise ValueError("a sum or product of something else than numbers")
        return _ARITHMETIC[type(node.op)](left, right)
    if isinstance(node, ast.Call):
        if not (isinstance(node.func, ast.Name) and node.func.id == "number"):
            raise ValueError("a call of something else than number")
        return number(
            *(_value(item, known) for item in node.args),
            **{item.arg: _value(item.value, known) for item in node.keywords if item.arg},
        )
    return ast.literal_eval(node)


def _numbers(said: Mapping[str, Any], name: str, file: Path) -> tuple[Declared, ...]:
    where = shown(str(file))
    given = said.get(name, ())
    if not isinstance(given, tuple) or not all(isinstance(one, Declared) for one in given):
        raise ConfigurationError(
            f"{where}: {name} is not a tuple of number(...); write each as number(name, value, ...)"
        )
    # Those of the package are looked up by the tests: it takes half a second.
    known = {one.unit for one in given} if file.is_relative_to(PACKAGE) else units.CANONICAL_UNITS
    for one in given:
        problem = _problem(one, known)
        if problem:
            raise ConfigurationError(f"{where}: {name}: {shown(one.name)}: {problem}")
    names = [one.name for one in given]
    for one in names:
        if names.count(one) > 1:
            raise ConfigurationError(f"{where}: {name}: {one} is declared twice; keep one")
    return given


def _problem(one: Declared, known: Container[str]) -> str:
    """What is wrong with a declared number; empty if nothing is. known: units that need not be looked up."""
    if not isinstance(one.name, str) or not _NAME.fullmatch(one.name):
        return "no name of lower-case letters, digits and _"
    values = (one.value, one.lowest, one.highest)
    if any(isinstance(value, bool) or not isinstance(value, int | float) for value in values):
        return "value and bounds are numbers; correct them"
    if not math.isfinite(one.value) or not one.lowest <= one.value <= one.highest:
        return f"its value {one.value:g} is not within {one.lowest:g}...{one.highest:g}; correct one of them"
    if one.tag not in get_args(Tag):
        return f"tag {shown(one.tag)} is none of {', '.join(get_args(Tag))}"
    if one.tag != "chosen" and not one.source:
        return f"a {one.tag} value needs its source"
    if not isinstance(one.unit, str) or not (one.unit in known or units.is_known(one.unit)):
        return f"unit {shown(one.unit)} is not known; use one such as mV, ms, mS/cm^2, mN/cm, 1"
    return ""
