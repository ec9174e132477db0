"""What is known of each field: its kind, unit, choices and bounds, by key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic.fields import FieldInfo

from peristalsis import units
from peristalsis.inputs.choices import declared
from peristalsis.inputs.parameters import Parameter, shipped
from peristalsis.inputs.recording import CHOICES as FIELD_CHOICES

from .fields import Section, Sections, kind_of, unit_of


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """What is known of a field: where it is, what it takes, and how to say so."""

    key: str
    section: str
    name: str
    kind: str
    unit: str
    choices: tuple[str, ...]
    bounds: Mapping[str, float]

    def allowed(self) -> str:
        """The allowed range in words."""
        words = {"gt": "more than", "ge": "at least", "lt": "less than", "le": "at most"}
        return " and ".join(f"{words[bound]} {self._written(limit)}" for bound, limit in self.bounds.items())

    def _written(self, limit: float) -> str:
        unit = "" if self.unit == units.DIMENSIONLESS else f" {self.unit}"
        return f"{limit:.12g}{unit}"


SECTIONS: dict[str, type[Section]] = {
    name: field.annotation
    for name, field in Sections.model_fields.items()
    if isinstance(field.annotation, type) and issubclass(field.annotation, Section)
}


def _bounds(field: FieldInfo) -> dict[str, float]:
    """Bounds of a number, or of the items of a list."""
    constraints: list[Any] = list(field.metadata)
    if kind_of(field) == "list":
        item = get_args(field.annotation)[0]
        constraints = [inner for outer in item.__metadata__ for inner in outer.metadata]
    return {
        bound: getattr(constraint, bound)
        for bound in ("gt", "ge", "lt", "le")
        for constraint in constraints
        if hasattr(constraint, bound)
    }


def _specs() -> Iterator[FieldSpec]:
    for section, table in SECTIONS.items():
        for name, field in table.model_fields.items():
            kind = kind_of(field)
            yield FieldSpec(
                key=f"{section}.{name}",
                section=section,
                name=name,
                kind=kind,
                unit=unit_of(field),
                choices=get_args(field.annotation) if kind == "choice" else FIELD_CHOICES if kind == "names" else (),
                bounds=_bounds(field),
            )


class _Fields(Mapping[str, FieldSpec]):
    """Every field by its key; numbers of known parts are found by theirs and not listed."""

    def __init__(self, specs: Iterator[FieldSpec]) -> None:
        self._own = {spec.key: spec for spec in specs}

    def __getitem__(self, key: str) -> FieldSpec:
        if key in self._own:
            return self._own[key]
        one = declared(key)
        if one is None:
            raise KeyError(key)
        section, _, name = key.partition(".")
        return FieldSpec(key, section, name, "number", one.unit, (), one.bounds())

    def __iter__(self) -> Iterator[str]:
        return iter(self._own)

    def __len__(self) -> int:
        return len(self._own)


FIELDS: Mapping[str, FieldSpec] = _Fields(_specs())


class _Units(Mapping[str, str]):
    """Every numeric parameter with its canonical unit; those of known parts are found and not listed."""

    def __getitem__(self, key: str) -> str:
        if key not in FIELDS or FIELDS[key].kind != "number":
            raise KeyError(key)
        return FIELDS[key].unit

    def __iter__(self) -> Iterator[str]:
        return (key for key, spec in FIELDS.items() if spec.kind == "number")

    def __len__(self) -> int:
        return sum(1 for _ in self)


_UNITS = _Units()


def units_of_numbers() -> Mapping[str, str]:
    """Every numeric parameter with its canonical unit."""
    return _UNITS


KEYS = ("reading", "scenario", "protocols", "stimuli", "regions", "drugs", *FIELDS)


def parameters_of(reading: str) -> Iterator[tuple[str, Parameter]]:
    values = shipped(reading)
    return ((key, values[key]) for key in FIELDS)
