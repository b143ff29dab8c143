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

    length: Annotated[Signal | float, ReadAs(LengthOverTime, (float, Signal))]

A file is read as the form. Its ``build_for(element, where)`` gives the scene's value, by
`with_built_parts`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from functools import partial
from inspect import isfunction
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Self,
    TypeVar,
    dataclass_transform,
    get_args,
    get_type_hints,
)

import numpy as np
import pydantic
from pydantic.fields import FieldInfo
from pydantic_core import (
    CoreSchema,
    PydanticCustomError,
    PydanticKnownError,
    core_schema,
    to_jsonable_python,
)

from hydrosim.errors import InputError
from hydrosim.files.key_rules import Rules, check_key_rules
from hydrosim.files.messages import Keys, Readers, fields_of, validation_problems
from hydrosim.files.units import problem, value_text

C = TypeVar("C", bound=type)


def add_example(schema: dict[str, Any], model: Any) -> None:
    """Add the ``example`` of a class to its JSON schema. A test builds it."""
    if example := getattr(model, "example", None):
        schema["examples"] = [example]


CONFIG = pydantic.ConfigDict(
    extra="forbid",
    arbitrary_types_allowed=True,
    json_schema_extra=add_example,
)


def input_error(
    error: pydantic.ValidationError, name: str, values: dict[str, Any], readers: Readers
) -> InputError:
    """What was wrong in the ``values`` of a class of this ``name`` in Python."""
    problems = validation_problems(error, values, readers)
    texts = (f"{'.'.join((name, *_given_keys(keys, values)))}: {text}" for keys, text in problems)
    return InputError("\n".join(dict.fromkeys(texts)))


def _given_keys(keys: Keys, values: Any) -> Iterator[str]:
    """The ``keys`` of a problem without the names of forms, which ``values`` do not have."""
    for position, key in enumerate(keys):
        if isinstance(values, dict) and (key in values or position == len(keys) - 1):
            values = values.get(key)
        elif isinstance(values, list | tuple) and isinstance(key, int):
            values = values[key] if key < len(values) else None
        else:
            continue
        yield str(key)


class CheckedClass(type):
    """Class of `SchemaClass`: values in Python are read as those in a file are."""

    if not TYPE_CHECKING:  # there calls are those of the dataclass

        def __call__(cls, *values: Any, **named: Any) -> Any:
            if "_schema" not in vars(cls):  # a plain dataclass below
                return super().__call__(*values, **named)
            if cls.has_valid_defaults and not values and not named:
                return cls._made_of_defaults()
            names = cls.positional or [f.name for f in dataclasses.fields(cls) if not f.kw_only]
            if len(values) > len(names) or named.keys() & {*names[: len(values)]}:
                raise TypeError(
                    f"{cls.__name__}: found too many values; expected {', '.join(names)}"
                )
            given = dict(zip(names, values, strict=False)) | named
            forms = {name for name, _ in _conversions(cls)}
            fields = cls.schema_fields()
            plain = {
                fields[key].alias or key if key in fields else key: (
                    x.tolist()
                    if isinstance(x, np.generic) or (isinstance(x, np.ndarray) and key not in forms)
                    else x
                )
                for key, x in given.items()
            }
            readers: dict[int | str, Any] = {}
            validator = cls.type_adapter().validator
            made = object.__new__(cls)
            try:
                validator.validate_python(plain, self_instance=made, context=readers)
            except pydantic.ValidationError as error:
                raise input_error(error, cls.__name__, plain, readers) from None
            return made


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field, pydantic.Field))
def schema_class(cls: C, *, kw_only: bool = False) -> C:
    """Make a frozen dataclass of ``cls``, a `SchemaClass`; its fields are given by their names if
    ``kw_only``. A class may extend the configuration by its ``__pydantic_config__``."""
    config = {**CONFIG, **cls.__dict__.get("__pydantic_config__", {})}
    options = {"eq": False, "repr": False, "init": False, "kw_only": kw_only}
    made: Any = dataclasses.dataclass(frozen=True, **options)(cls)
    made.__pydantic_config__ = config
    made._schema = {}
    return made


class EqualByValue:
    """A dataclass whose arrays are compared by their values."""

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return False
        names = [field.name for field in dataclasses.fields(self)]
        return all(_are_equal(getattr(self, name), getattr(other, name)) for name in names)

    def __hash__(self) -> int:
        values = (getattr(self, field.name) for field in dataclasses.fields(self))
        return hash((type(self), *(x for x in values if isinstance(x, str | float))))


@schema_class
class SchemaClass(EqualByValue, metaclass=CheckedClass):
    """Base of the classes that `schema_class` makes. Unknown keys are errors."""

    positional: ClassVar[tuple[str, ...]] = ()
    """Fields that may be given by position, if not those that are not by keyword alone."""

    has_valid_defaults: ClassVar[bool] = False
    """Whether there is a value without any key. It needs no schema."""
    own_keys_first: ClassVar[bool] = False
    """Whether the keys of a file begin with those of the class, not with those of its bases."""
    key_rules: ClassVar[Rules] = ()
    """Which keys go together, besides what base classes say."""
    _schema: ClassVar[dict[str, Any]]
    """What pydantic makes of the class, from its first use on."""

    @classmethod
    def type_adapter(cls) -> pydantic.TypeAdapter[Any]:
        """pydantic's schema of the class, made at its first use."""
        if "adapter" not in cls._schema:
            cls._schema["adapter"] = pydantic.TypeAdapter(cls)
        adapter: pydantic.TypeAdapter[Any] = cls._schema["adapter"]
        return adapter

    @classmethod
    def model_validate(cls, value: Any, *, context: Any = None) -> Self:
        """One with the keys of a mapping, as of pydantic's models."""
        made: Self = cls.type_adapter().validate_python(value, context=context)
        return made

    @classmethod
    def schema_fields(cls) -> dict[str, FieldInfo]:
        """Its fields by their names, in the order of their declaration."""
        if "fields" not in cls._schema:
            hints = get_type_hints(cls, include_extras=True)
            ordered = list(dataclasses.fields(cls))
            if cls.own_keys_first:
                ordered.sort(key=lambda field: field.name not in vars(cls)["__annotations__"])
            cls._schema["fields"] = {
                field.name: FieldInfo.from_annotated_attribute(hints[field.name], field)
                for field in ordered
            }
        fields: dict[str, FieldInfo] = cls._schema["fields"]
        return fields

    @classmethod
    def build_from(cls, source: Any, /, **values: Any) -> Self:
        """One with the values that a ``source`` has of its fields, and other values. They were
        checked and are not checked again."""
        made = cls._made_of_defaults()
        names = {field.name for field in dataclasses.fields(cls)}
        taken = {name: x for name, x in vars(source).items() if name in names} | values
        forms = {k: x for k, x in vars(source).get("_forms", {}).items() if k in names - {*values}}
        vars(made).update(taken, _keys=vars(source).get("_keys", ()), _forms=forms)
        return made

    @classmethod
    def _made_of_defaults(cls) -> Self:
        made = object.__new__(cls)
        for field in dataclasses.fields(cls):
            value: Any = field.default
            if field.default_factory is not dataclasses.MISSING:
                value = field.default_factory()
            vars(made)[field.name] = value
        vars(made).update(_keys=frozenset(), _forms={})
        return made

    @pydantic.model_validator(mode="wrap")
    @classmethod
    def _tell_who_reads(
        cls, value: Any, read: Callable[[Any], Self], info: pydantic.ValidationInfo
    ) -> Self:
        if info.context is not None:
            info.context.update({id(value): cls, cls.__name__: cls})
        made = read(value)
        if isinstance(value, dict):
            vars(made)["_keys"] = frozenset(value)
            vars(made)["_forms"] = dict(made._converted_forms())
            check_key_rules(made)
        return made

    def _converted_forms(self) -> Iterator[tuple[str, Any]]:
        """Convert fields that are read as a form; yields their names and forms."""
        for name, annotation in _conversions(type(self)):
            form = getattr(self, name)
            if not annotation.has_value(form):
                vars(self)[name] = annotation.convert(form)
                yield name, form

    def __repr__(self) -> str:
        values = (
            f"{field.name}={getattr(self, field.name)!r}" for field in dataclasses.fields(self)
        )
        return f"{type(self).__name__}({', '.join(values)})"

    def as_written(self, key: str) -> Any:
        """The value of a key in the form that a file gives it in."""
        return vars(self).get("_forms", {}).get(key, getattr(self, key))

    @pydantic.model_serializer(mode="wrap")
    def _write_keys(
        self, write: pydantic.SerializerFunctionWrapHandler, info: Any
    ) -> dict[str, Any]:
        names = fields_of(type(self))
        given = vars(self).get("_keys", ())
        forms = {name: _plain_form(form, info) for name, form in vars(self)["_forms"].items()}
        return {
            name: value
            for name, value in (write(self) | forms).items()
            if not info.exclude_unset or {name, names[name].alias} & {*given}
        }

    def has_key(self, key: str) -> bool:
        """True if a ``key`` was given."""
        return key in vars(self)["_keys"]

    def keys_with_value(self, *keys: str) -> list[str]:
        """The ``keys`` that have a value."""
        return [key for key in keys if self.as_written(key) is not None]

    def with_built_parts(self, where: Any) -> Self:
        """The same with what its parts that have a `build_for` build for it at the place ``where``
        in the case."""
        parts = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        built = {k: x.build_for(self, where) for k, x in parts.items() if hasattr(x, "build_for")}
        return dataclasses.replace(self, **built)


def _are_equal(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray):
        return np.array_equal(first, np.asarray(second))
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(_are_equal(first[k], second[k]) for k in first)
    return bool(first == second)


@dataclasses.dataclass(frozen=True)
class ReadAs:
    """Annotation of a field that a file gives in another ``form`` than the annotated type. What is
    an instance of ``built``, or for which it is true, is the scene's value already. ``convert``
    makes the value of the form where no place in a case is needed; the form stays known for
    `SchemaClass.as_written`."""

    form: Any
    built: Any
    convert: Callable[[Any], Any] | None = None

    def has_value(self, value: Any) -> bool:
        """True if a value is the scene's, not a form."""
        return self.built(value) if isfunction(self.built) else isinstance(value, self.built)

    def __get_pydantic_core_schema__(
        self, _: Any, get: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        def read(value: Any, read_form: Callable[[Any], Any]) -> Any:
            return value if self.has_value(value) else read_form(value)

        return core_schema.no_info_wrap_validator_function(
            read,
            get.generate_schema(self.form),
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda value, info: _plain_form(value, info), info_arg=True
            ),
        )


@dataclasses.dataclass(frozen=True)
class PythonObject:
    """Annotation of what Python alone gives: an instance of one of the ``kinds``."""

    kinds: Any

    def __get_pydantic_core_schema__(self, _: Any, __: pydantic.GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            self._check,
            serialization=core_schema.plain_serializer_function_ser_schema(
                _plain_form, info_arg=True
            ),
        )

    def _check(self, value: Any) -> Any:
        if not isinstance(value, self.kinds):
            names = [kind.__name__ for kind in get_args(self.kinds) or (self.kinds,)]
            raise problem(value_text(value), f"an object of {' or '.join(names)}")
        return value


def _conversions(cls: type) -> list[tuple[str, Any]]:
    """The fields with a ``convert``, and their annotations."""
    annotations = (
        (name, note) for name, field in fields_of(cls).items() for note in field.metadata
    )
    return [(name, x) for name, x in annotations if isinstance(x, ReadAs) and x.convert]


def _plain_form(value: Any, info: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, pydantic.BaseModel):
        return value.model_dump(mode="json", exclude_unset=info.exclude_unset, warnings=False)
    if isinstance(value, SchemaClass):
        serializer = value.type_adapter().serializer
        return serializer.to_python(value, mode="json", exclude_unset=info.exclude_unset)
    return to_jsonable_python(value)


@dataclasses.dataclass(frozen=True)
class ArrayOf:
    """Annotation of an array of floats that a file gives as lists of such ``rows``."""

    rows: Any

    def __get_pydantic_core_schema__(
        self, _: Any, get: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_after_validator_function(
            lambda rows: np.array(rows, float),
            get.generate_schema(self.rows),
            serialization=core_schema.plain_serializer_function_ser_schema(np.ndarray.tolist),
        )


@dataclasses.dataclass(frozen=True)
class ByKind:
    """Annotation of a union of classes, one of which a ``key`` of the mapping names. The schema of
    a class is built when it is first read: a case has few of the kinds that there are."""

    key: str

    def __get_pydantic_core_schema__(
        self, source: Any, _: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        classes = get_args(source)

        def read(value: Any, info: pydantic.ValidationInfo) -> Any:
            if isinstance(value, classes):
                return value
            if not isinstance(value, dict):
                raise PydanticKnownError("model_attributes_type")
            kinds = {kind: cls for cls in classes for kind in self._kinds_of(cls)}
            about = {"discriminator": repr(self.key), "expected_tags": ", ".join(map(repr, kinds))}
            if self.key not in value:
                raise PydanticCustomError("union_tag_not_found", "no key {discriminator}", about)
            kind = value[self.key]
            if not isinstance(kind, str) or kind not in kinds:
                raise PydanticKnownError("union_tag_invalid", about | {"tag": str(kind)})
            cls = kinds[kind]
            return cls.model_validate(value, context=info.context)

        union = core_schema.with_info_plain_validator_function(
            read,
            serialization=core_schema.plain_serializer_function_ser_schema(
                _plain_form, info_arg=True
            ),
        )
        return union | {"metadata": {"pydantic_js_functions": [partial(self._as_json, source)]}}

    def _kinds_of(self, cls: Any) -> tuple[str, ...]:
        kinds: tuple[str, ...] = get_args(fields_of(cls)[self.key].annotation)
        return kinds

    def _as_json(self, source: Any, _: CoreSchema, get: pydantic.GetJsonSchemaHandler) -> Any:
        union = Annotated[source, pydantic.Discriminator(self.key)]
        return get(pydantic.TypeAdapter(union).core_schema)
