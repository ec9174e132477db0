"""JSON Schema of configuration files."""

from __future__ import annotations

from typing import Any

from peristalsis import units
from peristalsis.inputs import choices
from peristalsis.inputs.drugs import schema as drugs_schema
from peristalsis.inputs.parameters import Parameter
from peristalsis.inputs.parts import Part, parts
from peristalsis.inputs.regions import schema as regions_schema

from .configuration import Configuration
from .specification import FIELDS, SECTIONS, FieldSpec, parameters_of


def json_schema() -> dict[str, Any]:
    """JSON Schema of the file format: quantities are strings with a unit, their bounds stand beside it."""
    sections: dict[str, Any] = {}
    for key, about in parameters_of("tight"):
        spec = FIELDS[key]
        table = sections.setdefault(spec.section, {"type": "object", "additionalProperties": False, "properties": {}})
        table["properties"][spec.name] = _schema_of(spec, about)
    for section, kinds in choices.SECTIONS.items():
        for part in (part for kind in kinds for part in parts(kind).values()):
            if part.numbers:
                sections[section]["properties"][part.name] = _schema_of_part(part)
    names: dict[str, Any] = {
        name: {"type": "string", "default": field.default, "description": field.description}
        for name, field in Configuration.model_fields.items()
        if name not in (*SECTIONS, "protocols", "stimuli", "regions", "drugs", "parts")
    }
    lines = Configuration.model_fields["protocols"].description
    names["protocols"] = {"type": "array", "items": {"type": "string"}, "default": [], "description": lines}
    file = {"type": "object", "properties": {"file": {"type": "string"}}, "additionalProperties": False}
    lines = Configuration.model_fields["stimuli"].description
    listed = {"anyOf": [{"type": "string"}, file | {"required": ["file"]}]}
    names["stimuli"] = {"type": "array", "items": listed, "default": [], "description": lines}
    names["regions"] = regions_schema()
    names["drugs"] = drugs_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "peristalsis configuration",
        "type": "object",
        "additionalProperties": False,
        "properties": names | sections,
    }


def _schema_of_part(part: Part) -> dict[str, Any]:
    table: dict[str, Any] = {
        "type": "object",
        "additionalProperties": False,
        "properties": {},
        "description": part.title,
    }
    for one in part.numbers:
        about = Parameter(one.name, float(one.value), one.unit, one.tag, one.source, one.description)
        spec = FieldSpec(one.name, "", one.name, "number", one.unit, (), one.bounds())
        table["properties"][one.name] = _schema_of(spec, about)
    return table


def _schema_of(spec: FieldSpec, about: Parameter) -> dict[str, Any]:
    names = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
    limits = {names[bound]: limit for bound, limit in spec.bounds.items()}
    schema: dict[str, Any]
    if spec.kind in ("choice", "names"):
        schema = {"type": "string", "enum": list(spec.choices)}
    elif spec.kind == "part":
        schema = {"type": "string"}
    elif spec.kind == "switch":
        schema = {"type": "boolean"}
    elif spec.kind == "integer":
        schema = {"type": "integer"} | limits
    elif spec.unit == units.DIMENSIONLESS:
        schema = {"type": "number"} | limits
    else:
        schema = {"type": "string", "pattern": units.pattern(spec.unit), "x-unit": spec.unit}
        schema |= {f"x-{name}": limit for name, limit in limits.items()}
    if spec.kind in ("list", "names"):
        schema = {"type": "array", "items": schema}
    origin = {"description": about.description, "x-tag": about.tag, "x-source": about.source}
    return schema | {"default": units.written(about.value, about.unit)} | origin
