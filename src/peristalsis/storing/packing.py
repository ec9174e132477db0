"""States and records as bytes and back, without naming them: whatever their types say they are made of.

A value is walked by its type: dataclasses, named tuples, tuples, lists, tables with text keys, arrays, plain values.
Every bit of every number is kept. The bytes are a numpy archive (no objects, no code) behind a line with its SHA-256;
no class is ever named in them, so nothing can be made from them but what the reader asked for.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import operator
import types
import typing
from collections.abc import Mapping
from functools import cache
from typing import Any, Union, get_args, get_origin

import numpy as np

HEAD = b"peristalsis checkpoint 1 "
_STRUCTURE = "structure"
_PLAIN = (float, int, bool, str)


class UnpackableError(TypeError):
    """A type that is not made of what can be packed."""


def pack(parts: Mapping[str, tuple[Any, Any]]) -> bytes:
    """The bytes of named values, each given with its type. Raises UnpackableError for a type that has no place here."""
    for _, hint in parts.values():
        if not packable(hint):
            raise UnpackableError(f"{hint} is not a type that checkpoints can hold")
    arrays: list[np.ndarray] = []
    tree = {name: _encode(value, hint, arrays) for name, (value, hint) in parts.items()}
    text = json.dumps(tree, allow_nan=False, separators=(",", ":")).encode("utf-8")
    image = io.BytesIO()
    numbered = {f"a{k}": array for k, array in enumerate(arrays)}
    np.savez(image, **{_STRUCTURE: np.frombuffer(text, dtype=np.uint8)}, **numbered)  # type: ignore[arg-type]
    payload = image.getvalue()
    return HEAD + hashlib.sha256(payload).hexdigest().encode("ascii") + b"\n" + payload


def unpack(content: bytes, hints: Mapping[str, Any]) -> dict[str, Any]:
    """The values of the named types in what `pack` made. Raises ValueError if a byte or a type is not as it was."""
    length = len(HEAD) + 65
    head, payload = content[:length], content[length:]
    if head != HEAD + hashlib.sha256(payload).hexdigest().encode("ascii") + b"\n":
        raise ValueError("its hash does not agree: it was cut short or changed")
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as stored:
            arrays = [stored[f"a{k}"] for k in range(len(stored.files) - 1)]
            tree = json.loads(stored[_STRUCTURE].tobytes())
        return {name: _decode(tree[name], hint, arrays) for name, hint in hints.items()}
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"it holds something else than is wanted ({type(error).__name__}: {error})") from None


def packable(hint: Any) -> bool:
    """Whether values of a type can be packed, judged by the type alone."""
    try:
        return _fits(hint)
    except (NameError, TypeError):  # an annotation that names nothing, or that is none
        return False


@cache
def fields_of(hint: type) -> dict[str, Any]:
    """Name to type of the fields of a dataclass or a named tuple."""
    hints = typing.get_type_hints(hint)
    if dataclasses.is_dataclass(hint):
        return {field.name: hints[field.name] for field in dataclasses.fields(hint)}
    return {name: hints[name] for name in hint._fields}  # type: ignore[attr-defined]


def _meant(hint: Any) -> Any:
    """What an annotation stands for: a named alias is what it names, with its parameters put in.

    numpy's NDArray is such an alias in some releases and plain shorthand for ndarray[...] in others.
    """
    while (named := getattr(alias := get_origin(hint) or hint, "__value__", None)) is not None:
        given = dict(zip(getattr(alias, "__type_params__", ()), get_args(hint), strict=False))
        free = getattr(named, "__parameters__", ())
        hint = named[tuple(given.get(one, Any) for one in free)] if free else named
    return hint


def _is_record(hint: Any) -> bool:
    return isinstance(hint, type) and (dataclasses.is_dataclass(hint) or hasattr(hint, "_fields"))


def _is_array(hint: Any) -> bool:
    return hint is np.ndarray or get_origin(hint) is np.ndarray


def _item(hint: Any) -> Any:
    """Type of the items of a list or of a tuple of any length, or None."""
    origin, given = get_origin(hint), get_args(hint)
    if origin is list and len(given) == 1:
        return given[0]
    if origin is tuple and len(given) == 2 and given[1] is Ellipsis:
        return given[0]
    return None


def _alternative(hint: Any) -> Any:
    """X of "X or None", or None."""
    if get_origin(hint) in (Union, types.UnionType):
        others = [other for other in get_args(hint) if other is not types.NoneType]
        if len(others) == 1 and len(get_args(hint)) == 2:
            return others[0]
    return None


def _fits(hint: Any) -> bool:
    hint = _meant(hint)
    if hint in _PLAIN or _is_array(hint):
        return True
    if _is_record(hint):
        return all(_fits(inner) for inner in fields_of(hint).values())
    inner = _item(hint) or _alternative(hint)
    if inner is not None:
        return _fits(inner)
    if get_origin(hint) is dict and get_args(hint)[0] is str:
        return _fits(get_args(hint)[1])
    return get_origin(hint) is tuple and all(_fits(one) for one in get_args(hint))


def _encode(value: Any, hint: Any, arrays: list[np.ndarray]) -> Any:
    hint = _meant(hint)
    if _is_array(hint):
        return _keep(np.asarray(value), arrays)
    if hint is float:
        return float(value).hex()
    if hint in (int, bool):
        return bool(value) if hint is bool else operator.index(value)
    if hint is str:
        return str(value)
    if _is_record(hint):
        return {name: _encode(getattr(value, name), inner, arrays) for name, inner in fields_of(hint).items()}
    other = _alternative(hint)
    if other is not None:
        return None if value is None else [_encode(value, other, arrays)]
    item = _item(hint)
    if item is not None:
        stack = _stacked(value, item)
        return [_encode(one, item, arrays) for one in value] if stack is None else {"stack": _keep(stack, arrays)}
    if get_origin(hint) is dict:
        return {name: _encode(one, get_args(hint)[1], arrays) for name, one in value.items()}
    return [_encode(one, inner, arrays) for one, inner in zip(value, get_args(hint), strict=True)]


def _keep(array: np.ndarray, arrays: list[np.ndarray]) -> int:
    if array.dtype.hasobject:
        raise UnpackableError("an array of objects cannot be kept in a checkpoint; use one of numbers or texts")
    arrays.append(array)
    return len(arrays) - 1


def _stacked(values: Any, item: Any) -> np.ndarray | None:
    """Many equal things as one array: numbers, rows of numbers, arrays; None if they are something else."""
    item = _meant(item)
    if len(values) == 0:
        return None
    if item is float or item is int:
        return np.array(values, dtype=np.float64 if item is float else np.int64)
    if _item(item) is float and get_origin(item) is tuple and len({len(row) for row in values}) == 1:
        return np.array(values, dtype=np.float64)
    if _is_array(item) and len({(one.shape, one.dtype.str) for one in values}) == 1:
        return np.stack(values)
    return None


def _decode(node: Any, hint: Any, arrays: list[np.ndarray]) -> Any:
    hint = _meant(hint)
    if _is_array(hint):
        return arrays[node]
    if hint is float:
        return float.fromhex(node)
    if hint in (int, bool, str):
        if type(node) is not hint:
            raise TypeError(f"{node!r} is no {hint.__name__}")
        return node
    if _is_record(hint):
        inner = fields_of(hint)
        if node.keys() != inner.keys():
            raise KeyError(f"fields of {hint.__name__}")
        return hint(**{name: _decode(node[name], one, arrays) for name, one in inner.items()})
    other = _alternative(hint)
    if other is not None:
        return None if node is None else _decode(node[0], other, arrays)
    item = _item(hint)
    if item is not None:
        found = _unstacked(arrays[node["stack"]], item) if isinstance(node, dict) else None
        if found is None:
            found = [_decode(one, item, arrays) for one in node]
        return found if get_origin(hint) is list else tuple(found)
    if get_origin(hint) is dict:
        return {name: _decode(one, get_args(hint)[1], arrays) for name, one in node.items()}
    return tuple(_decode(one, inner, arrays) for one, inner in zip(node, get_args(hint), strict=True))


def _unstacked(stack: np.ndarray, item: Any) -> list[Any]:
    item = _meant(item)
    if _is_array(item):
        return list(stack)
    return [tuple(row) for row in stack.tolist()] if get_origin(item) is tuple else stack.tolist()
