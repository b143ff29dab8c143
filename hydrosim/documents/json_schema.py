"""JSON schemas of the files that hydrosim reads, for editors that complete and check as one types.

They are made of the models that read the files, so they know every key, value and default, and what
a value means. They cannot tell one unit from another, nor what several keys have to agree in.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaWarningKind

DIALECT = "https://json-schema.org/draft/2020-12/schema"
REFERENCE = "#/$defs/"
NULL = {"type": "null"}
EXTENDS = {"type": "string", "description": "the file that this one is laid over, key by key"}
ALIKE = {"oneOf": "anyOf"}  # lists and mappings are told apart by validators, not by schemas


class _Plain(GenerateJsonSchema):
    """Without warnings about defaults that JSON does not know, such as an infinite depth."""

    def emit_warning(self, kind: JsonSchemaWarningKind, detail: str) -> None:
        """Says nothing of what a schema leaves out."""


def json_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of the files that ``model`` reads. A file with the key `extends`
    may leave keys out, and null removes what the file below has."""
    whole = model.model_json_schema(schema_generator=_Plain)
    shared, whole = _told(whole.pop("$defs", {})), _told(whole)
    lean = {f"Part_{name}": _partial(each) for name, each in shared.items()}
    part = _partial(whole)
    whole["properties"] = {"extends": False, **whole["properties"]}
    part["properties"] = {"extends": EXTENDS, **part["properties"]}
    return {
        "$schema": DIALECT,
        "title": title,
        "type": "object",
        "if": {"required": ["extends"]},
        "then": {"$ref": f"{REFERENCE}Over"},
        "else": {"$ref": f"{REFERENCE}Whole"},
        "$defs": {"Whole": whole, "Over": part, **shared, **lean},
    }


def either(
    title: str, key: str, with_it: dict[str, Any], without: dict[str, Any]
) -> dict[str, Any]:
    """JSON schema of files of two kinds, which a ``key`` tells apart."""
    found: dict[str, Any] = {"$schema": DIALECT, "title": title, "type": "object"}
    found |= {"if": {"required": [key]}, "$defs": {}}
    for branch, prefix, schema in (("then", "With_", with_it), ("else", "Without_", without)):
        text = json.dumps(schema).replace(REFERENCE, f"{REFERENCE}{prefix}")
        own = json.loads(text)
        found["$defs"] |= {f"{prefix}{name}": each for name, each in own.pop("$defs").items()}
        found[branch] = {k: x for k, x in own.items() if k in ("if", "then", "else")}
    return found


def _told(schema: Any) -> Any:
    """The schema with alternatives that are told apart by what they say they are, so that an editor
    shows what is wrong in one and not that none of them fits; others may hold at the same time."""
    if isinstance(schema, list):
        return [_told(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    named = schema.get("discriminator")
    if isinstance(named, dict) and "mapping" in named:
        return _chosen(named["propertyName"], named["mapping"])
    return {ALIKE.get(key, key): _told(each) for key, each in schema.items()}


def _chosen(key: str, mapping: dict[str, str]) -> dict[str, Any]:
    """The schema of mappings whose ``key`` says which of several they are."""
    each = [
        {"if": {"properties": {key: {"const": name}}, "required": [key]}, "then": {"$ref": where}}
        for name, where in mapping.items()
    ]
    known = {"properties": {key: {"enum": list(mapping)}}, "required": [key]}
    return {"type": "object", **known, "allOf": each}


def _partial(schema: Any) -> Any:
    """The schema, `_told`, with no key required and with null for each."""
    if isinstance(schema, list):
        return [_partial(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: each if key == "if" else _partial(each) for key, each in schema.items()}
    if isinstance(schema.get("$ref"), str):
        found["$ref"] = schema["$ref"].replace(REFERENCE, f"{REFERENCE}Part_")
    if schema.get("type") == "object":
        found.pop("required", None)
        found["properties"] = {k: _or_none(x) for k, x in found.get("properties", {}).items()}
        if isinstance(found.get("additionalProperties"), dict):
            found["additionalProperties"] = _or_none(found["additionalProperties"])
    return found


def _or_none(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, NULL]}
