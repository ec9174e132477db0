"""What the functions of a description say, as formulas: Python's syntax followed by hand, text in Myokit's syntax."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

from ..errors import ConfigurationError

Value = Any
"""A `Formula`, a tuple of values, a number of Python (an index), or a name such as "states"."""
RESERVED = frozenset({"and", "or", "not", "if", "piecewise", "in", "bind", "label", "use", "as", "time", "dot"})


class Formula(str):
    """A formula with how tightly its outermost operation binds: 0 conditions, 1 sums, 2 products, 3 signs, 4 powers."""

    tightness: int

    def __new__(cls, text: str, tightness: int = 9) -> Formula:
        self = super().__new__(cls, text)
        self.tightness = tightness
        return self


def inside(part: Value, tightness: int) -> str:
    """A formula as part of another, in brackets where they are needed."""
    formula = as_formula(part)
    return f"({formula})" if formula.tightness < tightness else str(formula)


def as_formula(value: Value) -> Formula:
    """A value as a formula."""
    if isinstance(value, Formula):
        return value
    if isinstance(value, bool | int | float):
        return Formula(repr(float(value)), 9 if value >= 0 else 3)
    raise ConfigurationError(f"{value!r} is no formula; docs/cells.md says what an exported cell may contain")


OPERATORS = {ast.Add: ("+", 1, 1), ast.Sub: ("-", 1, 2), ast.Mult: ("*", 2, 2), ast.Div: ("/", 2, 3)}
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
MATHS = {"exp": "exp", "log": "log", "sqrt": "sqrt", "sin": "sin", "cos": "cos", "tan": "tan", "log10": "log10"}
MATHS |= {"floor": "floor", "ceil": "ceil", "fabs": "abs", "atan": "atan"}


class Reader:
    """Follows the functions of one file; what they assign becomes variables, kept by `note`."""

    def __init__(self, tree: ast.Module, module: ModuleType) -> None:
        self.functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        self.module = module
        self.lines: list[tuple[str, Formula]] = []
        self.taken: set[str] = set()

    def note(self, name: str, value: Value) -> Value:
        """A variable of this value; short values stay as they are."""
        if not isinstance(value, Formula) or re.fullmatch(r"[\w.]+", value):
            return value
        stem = re.sub(r"\W", "_", name).strip("_") or "part"
        stem = f"{stem}_" if stem in RESERVED else stem
        chosen, count = stem, 1
        while chosen in self.taken:
            count += 1
            chosen = f"{stem}_{count}"
        self.taken.add(chosen)
        self.lines.append((chosen, value))
        return Formula(chosen)

    def call(self, name: str, *arguments: Value) -> Value:
        """What a function of the file returns; row[...] of a dict argument is filled."""
        node = self.functions[name]
        scope = dict(zip((one.arg for one in node.args.args), arguments, strict=True))
        return self._run(node.body, scope)

    def _run(self, body: list[ast.stmt], scope: dict[str, Value]) -> Value:
        for k, line in enumerate(body):
            if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant):
                continue
            if isinstance(line, ast.Return):
                return None if line.value is None else self.value(line.value, scope)
            if isinstance(line, ast.Assign) and len(line.targets) == 1:
                self._assign(line.targets[0], self.value(line.value, scope), scope)
            elif isinstance(line, ast.AugAssign):
                operation = ast.BinOp(_load(line.target), line.op, line.value)
                self._assign(line.target, self.value(operation, scope), scope)
            elif isinstance(line, ast.If):
                condition = self.value(line.test, scope)
                yes = self._run([*line.body, *body[k + 1 :]], dict(scope))
                no = self._run([*line.orelse, *body[k + 1 :]], dict(scope))
                return _either(condition, yes, no)
            else:
                raise _strange(line)
        return None

    def _assign(self, target: ast.expr, value: Value, scope: dict[str, Value]) -> None:
        if isinstance(target, ast.Tuple):
            for one, part in zip(target.elts, value, strict=True):
                self._assign(one, part, scope)
        elif isinstance(target, ast.Name):
            scope[target.id] = self.note(target.id, value)
        elif isinstance(target, ast.Subscript) and isinstance(target.value, ast.Name):
            place = scope[target.value.id]
            index = self.value(target.slice, scope)
            if not isinstance(place, dict):
                raise _strange(target)
            place[index] = value
        else:
            raise _strange(target)

    def value(self, node: ast.expr, scope: Mapping[str, Value]) -> Value:
        """The value of an expression."""
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name):
            return scope[node.id] if node.id in scope else self._of_module(node)
        if isinstance(node, ast.Attribute):
            owner = self.value(node.value, scope)
            return owner[node.attr] if isinstance(owner, dict) else getattr(owner, node.attr)
        if isinstance(node, ast.Tuple):
            return tuple(self.value(one, scope) for one in node.elts)
        if isinstance(node, ast.Subscript):
            place, index = self.value(node.value, scope), self.value(node.slice, scope)
            return place[index[0] if isinstance(index, tuple) else index]
        if isinstance(node, ast.BinOp):
            return _operated(type(node.op), self.value(node.left, scope), self.value(node.right, scope), node)
        if isinstance(node, ast.UnaryOp):
            inner = self.value(node.operand, scope)
            if isinstance(inner, int | float):
                return -inner if isinstance(node.op, ast.USub) else inner
            return Formula(f"-{inside(inner, 3)}", 3) if isinstance(node.op, ast.USub) else inner
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            sides = (inside(self.value(side, scope), 1) for side in (node.left, node.comparators[0]))
            return Formula(f" {COMPARISONS[type(node.ops[0])]} ".join(sides), 0)
        if isinstance(node, ast.BoolOp):
            word = " and " if isinstance(node.op, ast.And) else " or "
            return Formula(word.join(f"({self.value(one, scope)})" for one in node.values), 0)
        if isinstance(node, ast.IfExp):
            parts = (self.value(one, scope) for one in (node.test, node.body, node.orelse))
            return _either(*parts)
        if isinstance(node, ast.Call) and not node.keywords:
            return self._called(node, [self.value(one, scope) for one in node.args])
        raise _strange(node)

    def _of_module(self, node: ast.Name) -> Value:
        if node.id in self.functions:
            return node.id
        found = getattr(self.module, node.id, None)
        if found is None:
            raise _strange(node)
        return found

    def _called(self, node: ast.Call, given: list[Value]) -> Value:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if isinstance(node.func, ast.Name) and name in self.functions:
            return self.call(name, *given)
        if name in MATHS:
            return Formula(f"{MATHS[name]}({as_formula(given[0])})")
        special: dict[str, Callable[..., Value]] = {
            "pow": lambda a, b: _operated(ast.Pow, a, b, node),
            "abs": lambda a: Formula(f"abs({as_formula(a)})"),
            "float": lambda a: a,
            "expm1": lambda a: Formula(f"exp({as_formula(a)}) - 1.0", 1),
            "tanh": lambda a: Formula(f"1.0 - 2.0 / (exp(2.0 * {inside(a, 3)}) + 1.0)", 1),
            "cosh": lambda a: Formula(f"0.5 * (exp({as_formula(a)}) + exp(-{inside(a, 3)}))", 2),
            "sinh": lambda a: Formula(f"0.5 * (exp({as_formula(a)}) - exp(-{inside(a, 3)}))", 2),
            "max": lambda a, b: _either(Formula(f"{inside(a, 1)} > {inside(b, 1)}", 0), a, b),
            "min": lambda a, b: _either(Formula(f"{inside(a, 1)} < {inside(b, 1)}", 0), a, b),
        }
        if name not in special:
            raise _strange(node)
        return special[name](*given)


def _operated(kind: type, left: Value, right: Value, node: ast.AST) -> Value:
    if isinstance(left, int | float) and isinstance(right, int | float):
        return eval(compile(ast.fix_missing_locations(
            ast.Expression(ast.BinOp(ast.Constant(left), kind(), ast.Constant(right)))), "", "eval"))  # fmt: skip
    if kind is ast.Pow:
        return Formula(f"{inside(left, 5)}^{inside(right, 5)}", 4)
    if kind not in OPERATORS:
        raise _strange(node)
    sign, own, beyond = OPERATORS[kind]
    return Formula(f"{inside(left, own)} {sign} {inside(right, beyond)}", own)


def _either(condition: Value, yes: Value, no: Value) -> Value:
    if isinstance(yes, tuple):
        return tuple(_either(condition, *pair) for pair in zip(yes, no, strict=True))
    if isinstance(condition, bool):
        return yes if condition else no
    return Formula(f"if({condition}, {as_formula(yes)}, {as_formula(no)})")


def _load(node: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(node), mode="eval").body


def _strange(node: ast.AST) -> ConfigurationError:
    return ConfigurationError(
        f"line {getattr(node, 'lineno', 0)} ({ast.unparse(node)[:60]}) cannot be exported: a cell for export is made "
        "of assignments, conditions and functions of math"
    )
