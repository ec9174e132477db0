"""Operations, loads, stores and dependences of kernels, counted by running their own Python source on counting numbers.

Run with compilation switched off (NUMBA_DISABLE_JIT=1) the kernels are plain Python: every number they meet is a
`Number` that counts what is done to it, every array one that counts scalar reads and writes. So a kernel that is
rewritten is counted anew without anyone counting by hand. `main` prints the counts.
"""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

CELLS, ELEMENTS = 64, 64
EXPONENTIAL = 31
"""Additions and multiplications of `numerics.exponential`, which works on the bits of numbers: counted as one block."""

_EMPTY = np.empty

counts: Counter[str] = Counter()
deepest = 0.0


def _value(other: Any) -> Any:
    return other.value if isinstance(other, Number) else other


class Number:
    """A float that counts the operations it takes part in.

    depth: multiplications and additions, one waiting for the other, that it takes to compute it; a division, a root
    or a library function counts as its own kind and as one.
    """

    __slots__ = ("depth", "value")

    def __init__(self, value: float, depth: float = 0.0) -> None:
        self.value = float(value)
        self.depth = depth

    def _with(self, other: Any, kind: str, value: float) -> Number:
        global deepest
        counts[kind] += 1
        below = other.depth if isinstance(other, Number) else 0.0
        depth = max(self.depth, below) + 1.0
        deepest = max(deepest, depth)
        return Number(value, depth)

    def __add__(self, other: Any) -> Number:
        return self._with(other, "add", self.value + _value(other))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Number:
        return self._with(other, "add", self.value - _value(other))

    def __rsub__(self, other: Any) -> Number:
        return self._with(other, "add", _value(other) - self.value)

    def __mul__(self, other: Any) -> Number:
        return self._with(other, "multiply", self.value * _value(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Number:
        return self._with(other, "divide", self.value / _value(other))

    def __rtruediv__(self, other: Any) -> Number:
        return self._with(other, "divide", _value(other) / self.value)

    def __pow__(self, power: Any) -> Number:
        return self._with(power, "function", self.value ** _value(power))

    def __neg__(self) -> Number:
        return Number(-self.value, self.depth)

    def __abs__(self) -> Number:
        return Number(abs(self.value), self.depth)

    def __float__(self) -> float:
        return self.value

    def __int__(self) -> int:
        counts["convert"] += 1
        return int(self.value)

    def __bool__(self) -> bool:
        return bool(self.value)

    def _compare(self) -> None:
        counts["compare"] += 1

    def __lt__(self, other: Any) -> bool:
        self._compare()
        return bool(self.value < _value(other))

    def __le__(self, other: Any) -> bool:
        self._compare()
        return bool(self.value <= _value(other))

    def __gt__(self, other: Any) -> bool:
        self._compare()
        return bool(self.value > _value(other))

    def __ge__(self, other: Any) -> bool:
        self._compare()
        return bool(self.value >= _value(other))

    def __eq__(self, other: object) -> bool:
        self._compare()
        return bool(self.value == _value(other))

    __hash__ = None  # type: ignore[assignment]


class Cells(np.ndarray[Any, Any]):
    """An array of numbers that counts its scalar reads and writes; whole-array copies count once an element."""

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        if not isinstance(found, np.ndarray):
            counts["load"] += 1
        return found

    def __setitem__(self, key: Any, value: Any) -> None:
        place = super().__getitem__(key)
        size = place.size if isinstance(place, np.ndarray) else 1
        counts["store"] += size
        if isinstance(value, np.ndarray):
            counts["load"] += size
        elif not isinstance(value, Number):
            value = Number(value)
        super().__setitem__(key, value)


def counted(array: np.ndarray[Any, Any]) -> Cells:
    """A counting copy of an array of floats."""
    made = _EMPTY(array.shape, dtype=object)
    flat = made.reshape(-1)
    for k, value in enumerate(np.ravel(array)):
        flat[k] = Number(value)
    return made.view(Cells)


def _argument(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return counted(value)
    if isinstance(value, tuple) and any(isinstance(one, np.ndarray) for one in value):  # a record of arrays
        inner = (_argument(one) if isinstance(one, np.ndarray) else one for one in value)
        return type(value)(*inner) if hasattr(value, "_fields") else tuple(inner)
    return Number(value) if type(value) is float else value


def _function(name: str, plain: Callable[..., float]) -> Callable[..., Any]:
    def call(*values: Any) -> Any:
        if not any(isinstance(value, Number) for value in values):
            return plain(*values)
        first = next(value for value in values if isinstance(value, Number))
        return first._with(None, name, plain(*(_value(value) for value in values)))

    return call


def _exponential(x: Any) -> Any:
    if not isinstance(x, Number):
        return math.exp(x)
    counts["add"] += 16
    counts["multiply"] += EXPONENTIAL - 16 - 1
    made = x._with(None, "multiply", math.exp(x.value))
    made.depth += EXPONENTIAL - 1
    return made


def switch_on() -> None:
    """Let functions of `math` and fresh arrays count, in this process from now on."""
    for name, kind in (("exp", "function"), ("expm1", "function"), ("log", "function"), ("sqrt", "root")):
        setattr(math, name, _function(kind, getattr(math, name)))
    for name in ("empty", "zeros", "empty_like", "zeros_like", "ones"):
        make = getattr(np, name)

        def fresh(
            *words: Any, _make: Callable[..., Any] = make, _value: float = float(name == "ones"), **more: Any
        ) -> Any:
            made = _make(*words, **more)
            if made.dtype not in (np.dtype(float), np.dtype(object)):
                return made
            return counted(np.broadcast_to(_value, made.shape))

        setattr(np, name, fresh)
    for module in list(sys.modules.values()):
        if module.__name__.startswith("peristalsis.") and hasattr(module, "exponential"):
            vars(module)["exponential"] = _exponential


def count(kernel: Any) -> dict[str, float]:
    """Operations of one call for each of its nodes, and `depth`: the longest chain of them, for each node too."""
    global deepest
    arguments = tuple(_argument(value) for value in kernel.arguments)
    counts.clear()
    deepest = 0.0
    kernel.function(*arguments)
    found = {kind: number / kernel.nodes for kind, number in counts.items()}
    found["depth"] = deepest / kernel.nodes
    return found


def main() -> None:
    """Print the counts of every kernel as JSON."""
    from . import kernels

    model = kernels.shipped_model(CELLS, ELEMENTS)
    tables = model.tables  # made before anything counts
    assert len(tables) == 2
    wanted = [
        kernels.gates(model, CELLS, exact=False),
        kernels.sheet(model, CELLS, exact=False, conducts=False),
        kernels.sheet(model, CELLS, exact=False, conducts=True),
        *kernels.wall(model)[:3],
    ]
    switch_on()
    print(json.dumps({kernel.name: count(kernel) for kernel in wanted}))
