"""A description of a cell, in Python that people read, made from what `analysis` found."""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Iterable
from typing import Any

from .analysis import HIGHEST, LOWEST, Anatomy, as_sum
from .foreign import myokit
from .formulas import definition, dependencies, value, zeros

Expression = Any
Variable = Any

OWN = {"v", "row", "states", "channels", "instants", "node", "constants", "math", "np", "abs", "own", "total", "number"}
TAKEN = {"capacitance", "kinetics_rate", "gates", "instant", "others", "current", "compiled", "NamedTuple"}
WIDTH = 116


class Writer:
    """Writes one cell; `bounds`: of every state that is no gate."""

    def __init__(self, cell: Anatomy, name: str, header: str, bounds: dict[str, tuple[float, float]]) -> None:
        self.cell, self.name, self.header, self.bounds = cell, name, header, bounds
        self.kit = myokit()
        self.order = [gate.state for gate in cell.gates] + [other.state for other in cell.others]
        self.conductances = {c.conductance: k for k, c in enumerate(cell.channels) if c.conductance is not None}
        self.constants = self._constants()
        self.names = self._names()
        self.tabulated: list[Variable] = self._tabulated()
        self.poles = self._poles()

    def _everything(self) -> list[Expression]:
        cell = self.cell
        parts = [e for g in cell.gates for e in (g.steady, g.rate)]
        parts += [e for o in cell.others for e in (o.source, o.decay) if e is not None]
        return parts + [as_sum(channel) for channel in cell.channels]

    def _constants(self) -> list[Variable]:
        used: set[Variable] = set()
        for one in self._everything():
            used |= {v for v in dependencies(one) if v.is_literal() and not v.is_state() and not v.is_bound()}
        plain = [v for v in used if v not in self.conductances and v is not self.cell.capacitance]
        return sorted((v for v in plain if value(v.rhs()) != 0.0 or True), key=lambda v: v.qname())

    def _names(self) -> dict[Variable, str]:
        names: dict[Variable, str] = {}
        variables = list(self.cell.model.variables(deep=True))
        simple = [_safe(v.name()) for v in variables]
        for variable, short in zip(variables, simple, strict=True):
            if variable in self.order:  # never a local variable
                names[variable] = (
                    short
                    if [_safe(s.name()) for s in self.order].count(short) == 1
                    else _safe(variable.qname().replace(".", "_"))
                )
                continue
            clash = simple.count(short) > 1 or short in OWN | TAKEN
            names[variable] = _safe(variable.qname().replace(".", "_")) if clash else short
        return names

    def _tabulated(self) -> list[Variable]:
        """Variables of the current that depend on the potential alone and cost a function: read from a table."""
        kit, found, seen = self.kit, [], set()
        waiting = [as_sum(channel) for channel in self.cell.channels]
        while waiting:
            for left in waiting.pop().references():
                variable = left.var()
                if definition(left) is None or variable in seen:
                    continue
                seen.add(variable)
                rests = dependencies(variable.rhs())
                alone = all(one is self.cell.potential or one.is_literal() for one in rests)
                held = any(one in self.conductances or one is self.cell.capacitance for one in rests)
                costly = any(isinstance(e, kit.Function) for e in self._inside(variable))
                if alone and costly and not held and not isinstance(left, kit.Derivative):
                    found.append(variable)
                else:
                    waiting.append(variable.rhs())
        return sorted(found, key=lambda v: v.qname())

    def _inside(self, variable: Variable) -> Iterable[Expression]:
        waiting, seen = [variable.rhs()], set()
        while waiting:
            one = waiting.pop()
            yield from one.walk()
            for left in one.references():
                if definition(left) is not None and left not in seen:
                    seen.add(left)
                    waiting.append(definition(left))

    def _poles(self) -> list[float]:
        """Potentials [mV] at which a quotient is 0 / 0."""
        cell, kit = self.cell, self.kit
        found: set[float] = set()
        denominators = {}
        for part in self._everything():
            for one in [*part.walk(), *(e for left in part.references() for e in self._below(left))]:
                if isinstance(one, kit.Divide):
                    denominators[one[1].code()] = one[1]
        for denominator in denominators.values():
            rests = dependencies(denominator)
            if cell.potential in rests and all(one is cell.potential or one.is_literal() for one in rests):
                scale = cell.potential_scale
                for zero in zeros(denominator, cell.potential, LOWEST / scale, HIGHEST / scale):
                    found.add(round(zero * scale, 9))
        return sorted(found)

    def _below(self, left: Expression) -> Iterable[Expression]:
        return () if definition(left) is None else self._inside(left.var())

    def _gate_bounds(self, steady: Expression) -> tuple[float, float]:
        """0 and 1, or what the steady value reaches, with as much on either side."""
        grid = [LOWEST + 0.37 + 5.0 * k for k in range(int((HIGHEST - LOWEST) / 5.0))]
        reached = [value(steady, {self.cell.potential: v / self.cell.potential_scale}) for v in grid]
        low, high = min(reached), max(reached)
        return (0.0, 1.0) if low >= -1e-9 and high <= 1.0 + 1e-9 else (2.0 * low - high, 2.0 * high - low)

    # Text ------------------------------------------------------------------------------------------------------------

    def text(self) -> str:
        """The whole file."""
        cell = self.cell
        lines = [f'"""{self.header}"""', "", "from __future__ import annotations", "", "import math"]
        lines += ["from typing import NamedTuple", "", "import numpy as np", ""]
        lines += ["from peristalsis.declared import number", "from peristalsis.numerics.compiled import compiled", ""]
        lines += [f'KIND, NAME, TITLE = "cell", "{self.name}", "{cell.model.name() or self.name}, imported"']
        lines += [f'SOURCE = "{cell.model.name() or self.name}"', "", "STATES = ("]
        for gate in cell.gates:
            low, high = self._gate_bounds(gate.steady)
            lines.append(f'    ("{self.names[gate.state]}", {low!r}, {high!r}),')
        for other in cell.others:
            low, high = self.bounds.get(other.state.qname(), (-1e30, 1e30))
            lines.append(f'    ("{self.names[other.state]}", {low!r}, {high!r}),')
        lines += [")", f"GATES = {len(cell.gates)}"]
        lines += ["CHANNELS = (" + ", ".join(f'"{_safe(c.name)}"' for c in cell.channels) + ",)"]
        lines += [f"INSTANT = {len(self.tabulated)}", f"LOWEST, HIGHEST = {LOWEST}, {HIGHEST}"]
        begin = [value(self.kit.Name(cell.potential)) * cell.potential_scale]
        begin += [value(self.kit.Name(state)) for state in self.order]
        lines += [f"START = ({', '.join(repr(float(x)) for x in begin)},)", ""]
        lines += self._declared()
        lines += ["", "", "class CellConstants(NamedTuple):", '    """The values of PARAMETERS, in their order."""', ""]
        lines += [f"    {self.names[v]}: float" for v in self.constants]
        lines += ["    capacitance: float", "    kinetics_rate: float", "", ""]
        lines += ["SHIPPED = CellConstants(*(one.value for one in PARAMETERS))", ""]
        if self.poles:
            lines += ["", "@compiled", "def _beside(v: float) -> float:"]
            lines += ['    """The potential [mV], moved by 1e-6 mV off those at which a quotient is 0 / 0."""']
            lines += [f"    for pole in ({', '.join(map(repr, self.poles))},):"]
            lines += ["        if abs(v - pole) < 1e-6:", "            return pole + 1e-6", "    return v", ""]
        lines += self._gates() + self._instant() + self._others() + self._current()
        return "\n".join(_wrapped(line) for line in lines) + "\n"

    def _declared(self) -> list[str]:
        cell, lines = self.cell, ["PARAMETERS = ("]
        for variable in self.constants:
            unit = str(variable.unit() or "1").strip("[]")
            said = re.sub(r'[\\"\n]', " ", variable.meta.get("desc", "") or variable.qname())
            plain = re.fullmatch(r"[\w/*^.\-]+", unit) is not None
            said = said if plain else f"{said}, in {unit}"
            lines.append(f'    number("{self.names[variable]}", {value(variable.rhs())!r}, "{unit if plain else "1"}", '
                         f'"{said[:60]}", tag="sourced", source=SOURCE),')  # fmt: skip
        capacitance = 1.0
        if cell.capacitance is not None:
            capacitance = value(self.kit.Name(cell.capacitance)) * cell.capacitance_scale
        lines.append(f'    number("capacitance", {capacitance!r}, "uF/cm^2", "capacitance of the membrane", '
                     'tag="sourced", source=SOURCE),')  # fmt: skip
        lines.append('    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell"),')
        lines += [")", "CONDUCTANCES = ("]
        for channel in cell.channels:
            amount = 1.0 if channel.conductance is None else value(channel.conductance.rhs()) * channel.factor
            said = "share of this current" if channel.conductance is None else channel.conductance.qname()
            lines.append(f'    number("{_safe(channel.name)}", {amount!r}, "{channel.unit}", "{said}", tag="sourced", '
                         "source=SOURCE, lowest=0.0),")  # fmt: skip
        return [*lines, ")"]

    def _expression(self, one: Expression, tables: bool = False) -> str:
        writer = self.kit.formats.ewriter("python")
        writer.set_lhs_function(lambda left: self._left(left, tables))
        text = str(writer.ex(one))
        return _floats(text)

    def _left(self, left: Expression, tables: bool) -> str:
        variable = left.var()
        if isinstance(left, self.kit.Derivative):
            return f"d_{self.names[variable]}"
        if variable is self.cell.potential:
            return "v" if self.cell.potential_scale == 1.0 else "own"
        if variable in self.order:
            return f"states[{self.order.index(variable)}, node]"
        if variable in self.constants:
            return f"constants.{self.names[variable]}"
        if tables and variable in self.tabulated:
            return f"instants[{self.tabulated.index(variable)}, node]"
        return self.names[variable]

    def _locals(self, parts: list[Expression], tables: bool = False) -> list[str]:
        """Assignments of everything that the parts need, in order."""
        lines: list[str] = []
        done: set[str] = set()

        def need(left: Expression) -> None:
            variable, meant = left.var(), definition(left)
            if variable in self.conductances and not isinstance(left, self.kit.Derivative):
                k = self.conductances[variable]
                factor = self.cell.channels[k].factor
                text = f"{self.names[variable]} = channels[{k}, node]" + ("" if factor == 1.0 else f" / {factor!r}")
            elif variable is self.cell.capacitance:
                scale = self.cell.capacitance_scale
                text = f"{self.names[variable]} = constants.capacitance" + ("" if scale == 1.0 else f" / {scale!r}")
            elif meant is None or (tables and variable in self.tabulated):
                return
            else:
                if self._left(left, tables) in done:
                    return
                for inner in sorted(meant.references(), key=str):
                    need(inner)
                text = f"{self._left(left, tables)} = {self._expression(meant, tables)}"
            if text.split(" = ")[0] not in done:
                done.add(text.split(" = ")[0])
                lines.append(f"    {text}")

        for part in parts:
            for left in sorted(part.references(), key=str):
                need(left)
        return lines

    def _opening(self, body: str) -> list[str]:
        lines = []
        if self.poles and re.search(r"\b(v|own)\b", body):
            lines.append("    v = _beside(v)")
        if re.search(r"\bown\b", body):
            lines.append(f"    own = v / {self.cell.potential_scale!r}")
        return lines

    def _function(self, head: list[str], said: str, lines: list[str]) -> list[str]:
        return ["", "@compiled", *head, f'    """{said}"""', *self._opening("\n".join(lines)), *lines, ""]

    def _gates(self) -> list[str]:
        parts = [e for gate in self.cell.gates for e in (gate.steady, gate.rate)]
        lines = self._locals(parts)
        for k, gate in enumerate(self.cell.gates):
            lines.append(f"    row[{2 * k}] = {self._expression(gate.steady)}")
            lines.append(f"    row[{2 * k + 1}] = {self._per_ms(gate.rate)}")
        head = ["def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:"]
        return self._function(head, "Steady value and rate [1/ms] of every gate in turn, at the potential v.", lines)

    def _per_ms(self, rate: Expression) -> str:
        text = self._expression(rate)
        return text if self.cell.time_scale == 1.0 else f"({text}) / {self.cell.time_scale!r}"

    def _instant(self) -> list[str]:
        names = [self.kit.Name(v) for v in self.tabulated]
        lines = self._locals(names)
        lines += [f"    row[{k}] = {self.names[v]}" for k, v in enumerate(self.tabulated)]
        head = ["def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:"]
        said = "Functions of the potential alone: " + (", ".join(self.names[v] for v in self.tabulated) or "none")
        return self._function(head, f"{said[:90]}.", lines)

    def _others(self) -> list[str]:
        parts = [e for other in self.cell.others for e in (other.source, other.decay) if e is not None]
        lines = self._locals(parts)
        for k, other in enumerate(self.cell.others):
            for j, part in enumerate((other.source, other.decay)):
                lines.append(f"    row[{2 * k + j}] = {'0.0' if part is None else self._per_ms(part)}")
        head = ["def others(", "    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: "
                "CellConstants, row: np.ndarray", ") -> None:"]  # fmt: skip
        return self._function(head, "Source a and decay b [1/ms] of every state that is no gate, s' = a - b s.", lines)

    def _current(self) -> list[str]:
        parts = [as_sum(channel) for channel in self.cell.channels]
        lines = self._locals(parts, True)
        for k, (channel, part) in enumerate(zip(self.cell.channels, parts, strict=True)):
            share = f"channels[{k}, node] * " if channel.conductance is None else ""
            lines.append(f"    {'total =' if k == 0 else 'total +='} {share}({self._expression(part, True)})")
        if not parts:
            lines.append("    total = 0.0")
        scale = self.cell.potential_scale / self.cell.time_scale
        lines.append("    return -constants.capacitance * total" + ("" if scale == 1.0 else f" * {scale!r}"))
        head = ["def current(", "    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: "
                "int, constants: CellConstants", ") -> float:"]  # fmt: skip
        said = "Ionic current [uA/cm^2], outward positive, at the potential v; total is dV/dt as the source has it."
        return self._function(head, said, lines)[:-1]


def _wrapped(line: str) -> str:
    """A long assignment over several lines, in brackets; a declared number after its description."""
    if len(line) <= WIDTH:
        return line
    if line.startswith("    number("):
        return line.replace(", tag=", ",\n           tag=", 1)
    found = re.fullmatch(r"( +)(return|[^=]+? \+?=) (.*)", line)
    if found is None:
        return line
    lead, left, right = found.groups()
    body = textwrap.wrap(right, WIDTH - len(lead) - 4, break_long_words=False, break_on_hyphens=False)
    return "\n".join([f"{lead}{left} (", *(f"{lead}    {one}" for one in body), f"{lead})"])


def _floats(text: str) -> str:
    """Numbers as floats, save those that are places of arrays."""
    pieces = re.split(r"(\[[^\]]*\])", text)
    number = r"(?<![\w.])\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"
    return "".join(p if p.startswith("[") else re.sub(number, lambda m: repr(float(m.group())), p) for p in pieces)


def _safe(name: str) -> str:
    text = re.sub(r"\W", "_", name).strip("_") or "part"
    text = f"n{text}" if text[0].isdigit() else text
    return f"{text}_" if keyword.iskeyword(text) else text
