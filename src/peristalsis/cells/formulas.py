"""Formulas of a foreign model taken apart: what they depend on, sums, and the form a - b x."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from .foreign import myokit

Expression = Any
Variable = Any


def dependencies(expression: Expression) -> set[Variable]:
    """Literal constants, states and bound variables that an expression rests on in the end."""
    kit = myokit()
    found: set[Variable] = set()
    seen: set[Variable] = set()
    waiting = list(expression.references())
    while waiting:
        left = waiting.pop()
        variable = left.var()
        if isinstance(left, kit.Derivative):
            waiting += list(variable.rhs().references())
        elif variable.is_state() or variable.is_bound() or variable.is_literal():
            found.add(variable)
        elif variable not in seen:
            seen.add(variable)
            waiting += list(variable.rhs().references())
    return found


def definition(expression: Expression) -> Expression | None:
    """What a name stands for, where it is neither state nor constant nor bound."""
    kit = myokit()
    if isinstance(expression, kit.Derivative):
        return expression.var().rhs()
    if isinstance(expression, kit.Name):
        variable = expression.var()
        if not (variable.is_state() or variable.is_bound() or variable.is_literal()):
            return variable.rhs()
    return None


def rests_on(expression: Expression, variable: Variable) -> bool:
    """Whether an expression depends on a state or constant, at any depth."""
    return variable in dependencies(expression)


def summands(expression: Expression, apart: Callable[[Expression], bool]) -> list[Expression]:
    """Terms whose sum an expression is; a name or product is opened where `apart` says so."""
    kit = myokit()
    if isinstance(expression, kit.PrefixPlus):
        return summands(expression[0], apart)
    if isinstance(expression, kit.PrefixMinus):
        return [_minus(one) for one in summands(expression[0], apart)]
    if isinstance(expression, kit.Plus):
        return summands(expression[0], apart) + summands(expression[1], apart)
    if isinstance(expression, kit.Minus):
        return summands(expression[0], apart) + [_minus(one) for one in summands(expression[1], apart)]
    meant = definition(expression)
    if meant is not None:
        return summands(meant, apart) if apart(expression) else [expression]
    if isinstance(expression, kit.Multiply):
        sides = [summands(side, apart) if apart(side) else [side] for side in expression]
        return [kit.Multiply(a, b) for a in sides[0] for b in sides[1]]
    if isinstance(expression, kit.Divide) and apart(expression[0]):
        return [kit.Divide(one, expression[1]) for one in summands(expression[0], apart)]
    return [expression]


def _minus(expression: Expression) -> Expression:
    kit = myokit()
    return expression[0] if isinstance(expression, kit.PrefixMinus) else kit.PrefixMinus(expression)


def total(terms: Iterable[Expression]) -> Expression | None:
    """The sum of expressions, None of none."""
    kit = myokit()
    result = None
    for term in terms:
        if result is None:
            result = term
        elif isinstance(term, kit.PrefixMinus):
            result = kit.Minus(result, term[0])
        else:
            result = kit.Plus(result, term)
    return result


def relaxation(expression: Expression, state: Variable) -> tuple[Expression, Expression] | None:
    """(steady value, rate) where the text has the form of a relaxation, such as (steady - x) / tau."""
    kit = myokit()
    meant = definition(expression)
    if meant is not None:
        return relaxation(meant, state)
    if isinstance(expression, kit.Minus):
        left, right = expression
        if isinstance(right, kit.Name) and right.var() is state and not rests_on(left, state):
            return left, kit.Number(1)
        return None
    if isinstance(expression, kit.Multiply):
        for scale, inner in (tuple(expression), tuple(expression)[::-1]):
            if not rests_on(scale, state):
                found = relaxation(inner, state)
                if found is not None:
                    return found[0], scale if _is_one(found[1]) else kit.Multiply(scale, found[1])
        return None
    if isinstance(expression, kit.Divide) and not rests_on(expression[1], state):
        found = relaxation(expression[0], state)
        if found is not None:
            return found[0], kit.Divide(found[1], expression[1])
    return None


def _is_one(expression: Expression) -> bool:
    return isinstance(expression, myokit().Number) and expression.eval() == 1.0


def affine(expression: Expression, state: Variable) -> tuple[Expression | None, Expression | None] | None:
    """(a, b) with the expression equal to a + b x, either None where it is 0; None where it is no straight line."""
    kit = myokit()
    if not rests_on(expression, state):
        return expression, None
    if isinstance(expression, kit.Name) and expression.var() is state:
        return None, kit.Number(1)
    meant = definition(expression)
    if meant is not None:
        return affine(meant, state)
    if isinstance(expression, kit.PrefixMinus | kit.PrefixPlus):
        inner = affine(expression[0], state)
        if inner is None or isinstance(expression, kit.PrefixPlus):
            return inner
        return tuple(None if one is None else _minus(one) for one in inner)  # type: ignore[return-value]
    if isinstance(expression, kit.Plus | kit.Minus):
        left, right = affine(expression[0], state), affine(expression[1], state)
        if left is None or right is None:
            return None
        if isinstance(expression, kit.Minus):
            right = tuple(None if one is None else _minus(one) for one in right)  # type: ignore[assignment]
        return tuple(total([one for one in pair if one is not None]) for pair in zip(left, right, strict=True))  # type: ignore[return-value]
    if isinstance(expression, kit.Multiply):
        for scale, inner in (tuple(expression), tuple(expression)[::-1]):
            if not rests_on(scale, state):
                found = affine(inner, state)
                return found and tuple(  # type: ignore[return-value]
                    None if one is None else scale if _is_one(one) else kit.Multiply(scale, one) for one in found
                )
        return None
    if isinstance(expression, kit.Divide) and not rests_on(expression[1], state):
        found = affine(expression[0], state)
        return found and tuple(None if one is None else kit.Divide(one, expression[1]) for one in found)  # type: ignore[return-value]
    return None


def per_state(term: Expression, state: Variable) -> Expression | None:
    """A product divided by the state that is one of its factors, also as a power of at least 1; None without one."""
    kit = myokit()
    if isinstance(term, kit.Name) and term.var() is state:
        return kit.Number(1)
    meant = definition(term)
    if meant is not None:
        return per_state(meant, state) if rests_on(meant, state) else None
    if isinstance(term, kit.PrefixMinus):
        inner = per_state(term[0], state)
        return inner and kit.PrefixMinus(inner)
    if isinstance(term, kit.Multiply):
        for k in range(2):
            inner = per_state(term[k], state)
            if inner is not None:
                return kit.Multiply(inner, term[1 - k])
        return None
    if isinstance(term, kit.Divide):
        inner = per_state(term[0], state)
        return inner and kit.Divide(inner, term[1])
    of_state = isinstance(term, kit.Power) and isinstance(term[0], kit.Name) and term[0].var() is state
    if of_state and not rests_on(term[1], state) and value(term[1]) >= 1.0:
        return kit.Power(term[0], kit.Minus(term[1], kit.Number(1)))
    return None


def split(expression: Expression, state: Variable) -> tuple[Expression | None, Expression | None]:
    """(a, b) with the expression equal to a - b x and b, where that can be seen at the initial state, not negative."""
    kit = myokit()
    sources, decays = [], []
    for term in summands(expression, lambda one: rests_on(one, state)):
        straight = affine(term, state)
        if straight is not None:
            source, slope = straight
            if source is not None:
                sources.append(source)
            if slope is not None and value(slope) <= 0.0:
                decays.append(_minus(slope))
            elif slope is not None:
                sources.append(kit.Multiply(slope, kit.Name(state)))
            continue
        share = per_state(term, state) if value(term) < 0.0 else None
        if share is None:
            sources.append(term)
        else:
            decays.append(_minus(share))
    return total(sources), total(decays)


def value(expression: Expression, changed: dict[Variable, float] | None = None) -> float:
    """The number at the initial state, or with some constants and states changed; bound variables are 0."""
    kit = myokit()
    given = changed or {}
    known: dict[Any, float] = {}

    def of(variable: Variable) -> float:
        if variable not in known:
            if variable in given:
                known[variable] = given[variable]
            elif variable.is_state():
                known[variable] = float(variable.initial_value(as_float=True))
            elif variable.is_bound():
                known[variable] = 0.0
            else:
                known[variable] = evaluated(variable.rhs())
        return known[variable]

    def evaluated(one: Expression) -> float:
        names = {}
        for left in one.references():
            if isinstance(left, kit.Derivative):
                names[left] = evaluated(left.var().rhs())
            else:
                names[left] = of(left.var())
        try:
            return float(one.eval(subst=names))
        except kit.NumericalError:
            return float("nan")

    return evaluated(expression)


def zeros(denominator: Expression, potential: Variable, lowest: float, highest: float) -> list[float]:
    """Potentials (in the model's unit) at which a denominator that depends on the potential alone is 0."""
    grid = np.linspace(lowest, highest, 501)
    grid = grid + (grid[1] - grid[0]) * 0.0137
    values = np.array([value(denominator, {potential: float(v)}) for v in grid])
    found = []
    for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0):
        low, high = float(grid[k]), float(grid[k + 1])
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = np.sign(value(denominator, {potential: middle})) == np.sign(values[k])
            low, high = (middle, high) if same else (low, middle)
        found.append(0.5 * (low + high))
    return found
