"""JSON schemas of the files that hydrosim reads, for editors that complete and check while one
types.

They are derived from the models that read the files. So they contain every key, value and default,
and its meaning. They cannot check units, nor conditions between several keys.

The meaning of a key is the docstring below its field, which may end with "Example: ...". A quantity
has two additional keywords: ``quantity``, its kind, and ``unit``, its SI unit. Frequent parts are
definitions of their own.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import count, pairwise
from typing import Any

import yaml
from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaWarningKind

from hydrosim.files.messages import fields_of

DIALECT = "https://json-schema.org/draft/2020-12/schema"
DEFINITION_PREFIX = "#/$defs/"
NULL = {"type": "null"}
EXTENDS = {"type": "string", "description": "The file that this one is laid over, key by key."}
EQUIVALENT_KEYWORDS = {"oneOf": "anyOf"}  # validators, not schemas, distinguish lists and mappings
REFERENCE_SIBLINGS = ("description", "default")  # of a key, beside the reference to its value
EXAMPLE = " Example: "
SEVERAL = ("prefixItems", "items", "anyOf")  # where a list or an alternative contains quantities
KINDS = ("type", "law", "model", "spectrum")
"""Keys that say which kind of mapping this is."""
Schema = dict[str, Any]


class _Described(GenerateJsonSchema):
    """Adds its meaning to each key."""

    def emit_warning(self, kind: JsonSchemaWarningKind, detail: str) -> None:
        """Ignore defaults that JSON cannot express, such as an infinite depth."""

    def model_schema(self, schema: Any) -> Schema:
        """Schema of a model, with the meaning of its keys."""
        return _describe_keys(super().model_schema(schema), schema["cls"])

    def dataclass_schema(self, schema: Any) -> Schema:
        """Schema of a class of the scene, with the meaning of its keys in their order. A file must
        say the kind of mapping, which Python leaves out."""
        model = _describe_keys(super().dataclass_schema(schema), schema["cls"])
        properties, needed = model["properties"], {*model.pop("required", ())}
        for key in {*KINDS} & properties.keys():
            value = properties[key]
            if "const" in value and value["const"] == value.get("default"):
                needed.add(key)
                del properties[key]["default"]
        keys = [field.alias or name for name, field in fields_of(schema["cls"]).items()]
        model["properties"] = {key: properties[key] for key in keys}
        return model | {"required": [key for key in keys if key in needed]} if needed else model


def _describe_keys(model: Schema, cls: type) -> Schema:
    """The schema of a class with the meaning of its keys."""
    for key, text in meanings(cls).items():
        model["properties"][key] |= _docstring_parts(text)
    return model


def _docstring_parts(text: str) -> Schema:
    """Meaning and example of a key in a schema, from its docstring."""
    meaning, _, example = text.partition(EXAMPLE)
    description = {"description": meaning}
    return (
        description | {"examples": [yaml.safe_load(example.removesuffix("."))]}
        if example
        else description
    )


def meanings(model: Any) -> dict[str, str]:
    """Meaning of each key of a ``model``: the docstring below its field."""
    texts: dict[str, str] = {}
    for base in reversed(model.__mro__):
        texts |= _field_docstrings(base.__module__).get(base.__qualname__, {})
    fields = fields_of(model).items()
    return {field.alias or name: texts[name] for name, field in fields if name in texts}


@lru_cache(maxsize=64)
def _field_docstrings(module: str) -> dict[str, dict[str, str]]:
    """Docstrings below the fields of each class of a module."""
    if not module.startswith("hydrosim."):
        return {}
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    return {node.name: dict(_documented_fields(node)) for node in classes}


def _documented_fields(node: ast.ClassDef) -> Iterator[tuple[str, str]]:
    for field, after in pairwise(node.body):
        match field, after:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(ast.Constant(str(text))):
                yield name, " ".join(text.split())


def json_schema(model: type[BaseModel], title: str) -> Schema:
    """JSON schema (draft 2020-12) of the files that ``model`` reads. A file with the key `extends`
    may leave keys out, and null removes a key of the file below."""
    whole = _tidy_schema(model.model_json_schema(schema_generator=_Described))
    shared, whole = _shorten_names(whole.pop("$defs", {}), whole)
    definitions: dict[str, Schema] = {}
    shared, whole = (_share_definitions(document, definitions) for document in (shared, whole))
    for document in (*shared.values(), whole):
        _append_units(document, definitions)
    shared |= definitions
    deep = _names_of_mappings(shared)
    parts = {
        f"Part_{name}": _partial_schema(shared[name], name, deep) for name in shared if name in deep
    }
    over = _partial_schema(whole, "Whole", deep)
    whole["properties"] = {"extends": False, **whole["properties"]}
    over["properties"] = {"extends": EXTENDS, **over["properties"]}
    return {
        "$schema": DIALECT,
        "title": title,
        "type": "object",
        "if": {"required": ["extends"]},
        "then": {"$ref": f"{DEFINITION_PREFIX}Over"},
        "else": {"$ref": f"{DEFINITION_PREFIX}Whole"},
        "$defs": {"Whole": whole, "Over": over, **shared, **parts},
    }


def either_schema(title: str, key: str, with_it: Schema, without: Schema) -> Schema:
    """JSON schema of files of two kinds, which a ``key`` distinguishes."""
    either: Schema = {"$schema": DIALECT, "title": title, "type": "object"}
    either |= {"if": {"required": [key]}, "$defs": {}}
    for branch, prefix, schema in (("then", "With_", with_it), ("else", "Without_", without)):
        text = json.dumps(schema).replace(DEFINITION_PREFIX, f"{DEFINITION_PREFIX}{prefix}")
        document = json.loads(text)
        either["$defs"] |= {
            f"{prefix}{name}": definition for name, definition in document.pop("$defs").items()
        }
        either[branch] = {k: x for k, x in document.items() if k in ("if", "then", "else")}
    return either


def _tidy_schema(schema: Any) -> Any:
    """The schema with alternatives selected by the kind that they name, so that an editor shows the
    mistake inside the right one. Titles and null are removed from keys."""
    if isinstance(schema, list):
        return [_tidy_schema(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    named = schema.get("discriminator")
    if isinstance(named, dict) and "mapping" in named:
        told = {key: schema[key] for key in ("description", "default") if key in schema}
        return {**_schema_by_kind(named["propertyName"], named["mapping"]), **told}
    tidy = {EQUIVALENT_KEYWORDS.get(key, key): _tidy_schema(item) for key, item in schema.items()}
    if isinstance(tidy.get("properties"), dict):
        tidy["properties"] = {k: _drop_null(x) for k, x in tidy["properties"].items()}
    return tidy


def _drop_null(schema: Schema) -> Schema:
    """The schema of a key that may be left out and then has no value."""
    without_title = {
        k: x for k, x in schema.items() if k != "title" and (k, x) != ("default", None)
    }
    values = [option for option in without_title.get("anyOf", ()) if option != NULL]
    if len(values) == 1:
        return {**values[0], **{key: x for key, x in without_title.items() if key != "anyOf"}}
    return {**without_title, "anyOf": values} if values else without_title


def _schema_by_kind(key: str, mapping: dict[str, str]) -> Schema:
    """The schema of mappings whose ``key`` names their kind."""
    branches = [
        {"if": {"properties": {key: {"const": name}}, "required": [key]}, "then": {"$ref": where}}
        for name, where in mapping.items()
    ]
    allowed = {"properties": {key: {"enum": list(mapping)}}, "required": [key]}
    return {"type": "object", **allowed, "allOf": branches}


def _shorten_names(shared: Schema, whole: Schema) -> tuple[Schema, Schema]:
    """Definitions and the whole with the names of models, numbered where several models share
    one."""
    names: dict[str, str] = {}
    for long, definition in shared.items():
        short = re.sub(r"\W.*", "", definition.get("title", long))
        tried = (short if k == 1 else f"{short}{k}" for k in count(1))
        names[long] = next(name for name in tried if name not in names.values())
    text = json.dumps([{names[long]: definition for long, definition in shared.items()}, whole])
    pattern = re.compile(rf'"{re.escape(DEFINITION_PREFIX)}([^"]*)"')
    short_text = pattern.sub(lambda match: f'"{DEFINITION_PREFIX}{names[match[1]]}"', text)
    renamed, rest = json.loads(short_text)
    return renamed, rest


def _share_definitions(schema: Any, definitions: dict[str, Schema]) -> Any:
    """The schema with references to its quantities, vectors and mappings of several kinds, which
    are added to the ``definitions``."""
    if isinstance(schema, list):
        return [_share_definitions(item, definitions) for item in schema]
    if not isinstance(schema, dict):
        return schema
    siblings = {
        key: sibling for key in REFERENCE_SIBLINGS if (sibling := schema.get(key)) is not None
    }
    rest = {
        key: _share_definitions(x, definitions) for key, x in schema.items() if key not in siblings
    }
    if isinstance(schema.get("quantity"), str):
        return {
            "$ref": f"{DEFINITION_PREFIX}{_quantity_text(siblings | rest, definitions)}"
        } | siblings
    if "prefixItems" in rest:
        name = _known_as(f"list_of_{len(rest['prefixItems'])}", rest, definitions)
        return {"$ref": f"{DEFINITION_PREFIX}{name}"} | siblings
    if "allOf" in rest:
        name = _known_as(f"by_{rest['required'][0]}", rest, definitions)
        return {"$ref": f"{DEFINITION_PREFIX}{name}"} | siblings
    return siblings | rest


def _quantity_text(schema: Schema, definitions: dict[str, Schema]) -> str:
    """The name of the definition of a quantity."""
    what, unit = schema["quantity"], schema["unit"]
    meaning = f"{what} in {unit}, or with a unit" if unit else what
    keywords = {key: x for key, x in schema.items() if key not in REFERENCE_SIBLINGS}
    definition = {"description": f"{meaning[0].upper()}{meaning[1:]}.", **keywords}
    return _known_as(re.sub(r"\W+", "_", f"{what} {unit}").strip("_"), definition, definitions)


def _known_as(stem: str, definition: Schema, definitions: dict[str, Schema]) -> str:
    """The name of a ``definition``, which is added to the ``definitions`` if it is new."""
    tried = (stem if k == 1 else f"{stem}_{k}" for k in count(1))
    return next(name for name in tried if definitions.setdefault(name, definition) == definition)


def _append_units(schema: Schema, definitions: Mapping[str, Schema]) -> None:
    """Append their units to the meanings of keys; editors show no other part of a reference."""
    for value in schema.get("properties", {}).values():
        units = [*dict.fromkeys(_units_of(value, definitions))]
        if isinstance(value, dict) and units:
            value["description"] = f"{value.get('description', '')} Unit: {', '.join(units)}."


def _units_of(value: Any, definitions: Mapping[str, Schema]) -> Iterator[str]:
    """Units of a value, or of the values in a list, but not in a mapping."""
    if isinstance(value, list):
        for item in value:
            yield from _units_of(item, definitions)
    elif isinstance(value, dict):
        definition = definitions.get(value.get("$ref", "").removeprefix(DEFINITION_PREFIX), {})
        yield from [definition["unit"]] if definition.get("unit") else []
        for key in SEVERAL:
            yield from _units_of(definition.get(key), definitions)
            yield from _units_of(value.get(key), definitions)


def _names_of_mappings(shared: Mapping[str, Schema]) -> set[str]:
    """The definitions that are mappings, or refer to one."""
    texts = {name: json.dumps(definition) for name, definition in shared.items()}
    deep = {name for name, text in texts.items() if '"type": "object"' in text}
    while more := {name for name, text in texts.items() if _refers_to(text, deep)} - deep:
        deep |= more
    return deep


def _refers_to(text: str, names: set[str]) -> bool:
    return any(f'"{DEFINITION_PREFIX}{name}"' in text for name in names)


def _partial_schema(schema: Schema, name: str, deep: set[str]) -> Schema:
    """The definition ``name`` with no key required and with null for each. Keys without mappings
    below are unchanged."""
    partial: Schema = _make_optional(schema, deep)
    for key, value in schema.get("properties", {}).items():
        text = json.dumps(value)
        if '"type": "object"' not in text and not _refers_to(text, deep):
            place = {"$ref": f"{DEFINITION_PREFIX}{name}/properties/{key}"}
            partial["properties"][key] = _allow_null(place)
    return partial


def _make_optional(schema: Any, deep: set[str]) -> Any:
    """The schema with no key required, with null for each, and with the partial form of nested
    definitions."""
    if isinstance(schema, list):
        return [_make_optional(item, deep) for item in schema]
    if not isinstance(schema, dict):
        return schema
    keywords = {key: item for key, item in schema.items() if key != "examples"}
    optional = {
        key: item if key == "if" else _make_optional(item, deep) for key, item in keywords.items()
    }
    name = str(schema.get("$ref", "")).removeprefix(DEFINITION_PREFIX)
    if name in deep:
        optional["$ref"] = f"{DEFINITION_PREFIX}Part_{name}"
    if schema.get("type") == "object":
        optional.pop("required", None)
        optional.pop("title", None)  # that of the whole mapping says it
        optional["properties"] = {
            k: _allow_null(x) for k, x in optional.get("properties", {}).items()
        }
        if isinstance(optional.get("additionalProperties"), dict):
            optional["additionalProperties"] = _allow_null(optional["additionalProperties"])
    return optional


def _allow_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, NULL]}
