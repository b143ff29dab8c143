"""Classes of the scene that are the schema of their mapping in a file: one declaration of a key.

    @schema_class
    class Plane(SchemaClass):
        point: of.Point
        "A point of the plane."
        normal: of.Direction
        "Direction away from the plane."
        body: StrictStr | None = None
        "Body that the plane is fixed to."

is a frozen dataclass. pydantic reads it from a mapping in a file, with the checks and messages of
`SchemaModel`. In Python, ``Plane(("1 m", 0, 0), (0, 0, 1))`` is checked in the same way: a wrong
value is an `InputError`. The docstring below a field is the meaning of the key.

Where a file gives something else than the scene has, the annotation names both,

    length: Annotated[Signal | float, ReadAs(LengthOverTime)]

A file is read as the form. Its ``build_for(element, where)`` gives the scene's value, by
`with_built_parts`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar, dataclass_transform, get_args

import numpy as np
from pydantic import (
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidationInfo,
    model_serializer,
    model_validator,
)
from pydantic.dataclasses import dataclass
from pydantic_core import CoreSchema, core_schema

from hydrosim.errors import InputError
from hydrosim.files.messages import fields_of, validation_problems

C = TypeVar("C", bound=type)


def add_example(schema: dict[str, Any], model: Any) -> None:
    """Add the ``example`` of a class to its JSON schema. A test builds it."""
    if example := getattr(model, "example", None):
        schema["examples"] = [example]


CONFIG = ConfigDict(
    extra="forbid",
    defer_build=True,
    arbitrary_types_allowed=True,
    populate_by_name=True,
    json_schema_extra=add_example,
)


class CheckedClass(type):
    """Class of `SchemaClass`: values in Python are read as those in a file are."""

    if not TYPE_CHECKING:  # there calls are those of the dataclass

        def __call__(cls, *values: Any, **named: Any) -> Any:
            if "__pydantic_fields__" not in vars(cls):  # a plain dataclass below
                return super().__call__(*values, **named)
            names = [field.name for field in dataclasses.fields(cls) if not field.kw_only]
            if len(values) > len(names) or named.keys() & {*names[: len(values)]}:
                raise TypeError(
                    f"{cls.__name__}: found too many values; expected {', '.join(names)}"
                )
            given = dict(zip(names, values, strict=False)) | named
            plain = {
                key: x.tolist() if isinstance(x, np.ndarray) else x for key, x in given.items()
            }
            readers: dict[int | str, Any] = {}
            validator = cls.__pydantic_validator__
            made = object.__new__(cls)
            try:
                validator.validate_python(plain, self_instance=made, context=readers)
            except ValidationError as error:
                problems = validation_problems(error, plain, readers)
                texts = [
                    ": ".join((".".join(map(str, (cls.__name__, *keys))), text))
                    for keys, text in problems
                ]
                raise InputError("\n".join(texts)) from None
            return made


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field, Field))
def schema_class(cls: C) -> C:
    """Make a frozen dataclass of ``cls``, a `SchemaClass`. A class may extend the configuration by
    its ``__pydantic_config__``."""
    config = {**CONFIG, **cls.__dict__.get("__pydantic_config__", {})}
    made: Any = dataclass(frozen=True, config=ConfigDict(**config))(cls)
    return made


@schema_class
class SchemaClass(metaclass=CheckedClass):
    """Base of the classes that `schema_class` makes. Unknown keys are errors."""

    if TYPE_CHECKING:
        __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]

    @model_validator(mode="wrap")
    @classmethod
    def _tell_who_reads(cls, value: Any, read: Callable[[Any], Self], info: ValidationInfo) -> Self:
        if info.context is not None:
            info.context.update({id(value): cls, cls.__name__: cls})
        made = read(value)
        if isinstance(value, dict):
            vars(made)["_keys"] = frozenset(value)
        return made

    @model_serializer(mode="wrap")
    def _write_keys(self, write: SerializerFunctionWrapHandler, info: Any) -> dict[str, Any]:
        names = fields_of(type(self))
        given = vars(self).get("_keys", ())
        return {
            name: value
            for name, value in write(self).items()
            if not info.exclude_unset or {name, names[name].alias} & {*given}
        }

    def keys_with_value(self, *keys: str) -> list[str]:
        """The ``keys`` that have a value."""
        return [key for key in keys if getattr(self, key) is not None]

    def with_built_parts(self, where: Any) -> Self:
        """The same with what its parts that have a `build_for` build for it at the place ``where``
        in the case."""
        parts = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        built = {k: x.build_for(self, where) for k, x in parts.items() if hasattr(x, "build_for")}
        return dataclasses.replace(self, **built)


@dataclasses.dataclass(frozen=True)
class ReadAs:
    """Annotation of a field that a file gives in another ``form`` than the annotated type."""

    form: Any

    def __get_pydantic_core_schema__(self, source: Any, get: GetCoreSchemaHandler) -> CoreSchema:
        classes = tuple(kind for kind in (get_args(source) or (source,)) if kind is not type(None))

        def read(value: Any, read_form: Callable[[Any], Any]) -> Any:
            return value if isinstance(value, classes) else read_form(value)

        return core_schema.no_info_wrap_validator_function(read, get.generate_schema(self.form))


@dataclasses.dataclass(frozen=True)
class ArrayOf:
    """Annotation of an array of floats that a file gives as lists of such ``rows``."""

    rows: Any

    def __get_pydantic_core_schema__(self, _: Any, get: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(
            lambda rows: np.array(rows, float),
            get.generate_schema(self.rows),
            serialization=core_schema.plain_serializer_function_ser_schema(np.ndarray.tolist),
        )
