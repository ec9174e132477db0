"""Results are read, never changed: tables and arrays that refuse to be written to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray


class ReadOnly(dict[str, Any]):
    """A dictionary that refuses every change; tables in it do as well, and lists are tuples."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        super().__init__({key: frozen(value) for key, value in content.items()})

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("a result is read-only; make a dictionary of your own with dict(...)")

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[type[ReadOnly], tuple[dict[str, Any]]]:
        return ReadOnly, (dict(self),)


def frozen(value: Any) -> Any:
    """The same with tables and lists in it that cannot be changed."""
    if isinstance(value, ReadOnly):
        return value
    if isinstance(value, Mapping):
        return ReadOnly(value)
    if isinstance(value, list | tuple):
        return tuple(frozen(item) for item in value)
    return value


def unwritable(values: Any) -> NDArray[Any]:
    """The same numbers as an array that cannot be written to."""
    array: NDArray[Any] = np.asarray(values).view()
    array.flags.writeable = False
    return array
