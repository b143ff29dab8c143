"""Quantities of a case file, numbers in SI or texts with a unit, and factors between units.

    Mass = Annotated[float, Quantity("mass", "kg", "1000 tonne", above=0)]

makes a type for pydantic models. pint is loaded at the first unit that no earlier run has stored.
"""

from __future__ import annotations

import hashlib
import json
import re
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, isfinite, pi
from numbers import Real
from pathlib import Path
from typing import Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from hydrosim.files.cache import digest_of_sources, store, stored, version_of
from hydrosim.files.yaml_nodes import NUMBER

# Factors between units, stored on disk because pint takes half a second to load.

MAX_FACTORS = 1000  # factors in the file


def stored_factor(unit: str, si: str) -> float | None:
    """A factor that `store_factor` has stored, in this process or an earlier one; None if
    unknown."""
    return _load_factors().get(_key(unit, si))


def store_factor(unit: str, si: str, factor: float) -> None:
    """Store that a number in ``unit`` times ``factor`` is in ``si``."""
    factors = _load_factors()
    factors[_key(unit, si)] = factor
    if len(factors) <= MAX_FACTORS:
        store(_file_name(), json.dumps(factors).encode())


def _key(unit: str, si: str) -> str:
    return f"{unit} in {si}"


@lru_cache(maxsize=1)
def _load_factors() -> dict[str, float]:
    content = stored(_file_name())
    return {} if content is None else dict(json.loads(content))


def _file_name() -> str:
    """Name of the file; another version of pint or other rules for units give another name."""
    rules = digest_of_sources(Path(__file__).parent, "units.py")
    digest = hashlib.sha256(f"{version_of('pint')} {rules}".encode())
    return f"units-{digest.hexdigest()[:16]}.json"


MAX_VALUE_LETTERS = 200  # characters of the found value in a message
NO_NUMBER = {
    ",": "a number has no comma: write 1000 or 1.5",
    ":": "a time is a number and one unit: write 600 s or 10 min",
}
TONNE_FORCE = 9810.0  # N: the weight of 1000 kg at 9.81 m/s^2
# in SI: products of a few such numbers are still finite
MAX_QUANTITY = 1e20
SMALLEST = 1e-20
LARGEST_OF = {"m": 1e7, "m/s": 1e5, "rad": 1e5, "rad/s": 1e7, "kg": 1e17}  # squared, at times

# Products and quotients of names with small powers: pint would evaluate any other expression.
_FACTOR = r"(?:[A-Za-z_µ°%]+(?:\s*(?:\^|\*\*)\s*-?\d\b|[²³])?)"
UNIT = re.compile(rf"{_FACTOR}(?:(?:\s*[*/·.]\s*|\s+){_FACTOR})*")
SIGNED, UNSIGNED = (
    rf"^\s*{sign}(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(\s*[^\d\s].*)?$" for sign in ("[-+]?", "\\+?")
)
VAGUE = re.compile(r"\b(?:mt|(?:force_)?tons?(?:_force)?)\b")  # mt would be a millitonne
# pint treats rad as a plain number: a percentage is no angle, and a frequency in Hz is not in
# rad/s.
RADIAN_UNITS = ("", "rad", "rad/s", "m^2*s/rad")


def problem(value: str, expected: str, remedy: str = "") -> PydanticCustomError:
    """A validation error in the words of this package."""
    value = value if len(value) <= MAX_VALUE_LETTERS else f"{value[:MAX_VALUE_LETTERS]}..."
    text = f"found {value}; expected {expected}" + (f"; {remedy}" if remedy else "")
    return PydanticCustomError("hydrosim", "{text}", {"text": text})


def _number_or_text(what: str, unit: str, example: str, **bounds: float | None) -> dict[str, Any]:
    """JSON schema of a quantity; a schema cannot check its unit."""
    number = {"type": "number"} | {key: x for key, x in bounds.items() if x is not None}
    positive = bounds.get("exclusiveMinimum") == 0.0 or bounds.get("minimum") == 0.0
    text = {"type": "string", "pattern": UNSIGNED if positive else SIGNED}
    return {"anyOf": [number, text], "quantity": what, "unit": unit, "examples": [example]}


_WRITTEN: ContextVar[list[tuple[str, str]] | None] = ContextVar("written", default=None)


@contextmanager
def units_written() -> Iterator[list[tuple[str, str]]]:
    """Collects every quantity that is read with a unit in this context: its SI unit and the written
    one."""
    written: list[tuple[str, str]] = []
    token = _WRITTEN.set(written)
    try:
        yield written
    finally:
        _WRITTEN.reset(token)


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float that a case file may give with a unit.

    ``what`` names the quantity and ``example`` shows one in messages. ``unit`` is its SI unit,
    "rad" for angles and "" for plain ratios. The value must be ``above`` or ``at_least`` a bound,
    if given. ``infinite`` admits the word "infinite".
    """

    what: str
    unit: str
    example: str
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    infinite: bool = False

    def __get_pydantic_core_schema__(self, _: Any, __: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        limits = {"exclusiveMinimum": self.above, "minimum": self.at_least, "maximum": self.at_most}
        json_schema = _number_or_text(self.what, self.unit, self.example, **limits)
        if self.infinite:
            json_schema["anyOf"].append({"const": "infinite"})
        return json_schema

    def read(self, value: object) -> float:
        """The value in SI; raises PydanticCustomError if it is not such a quantity."""
        if self.infinite and value == "infinite":
            return inf
        number = self._convert(value) if isinstance(value, str) else self._plain(value)
        if not isfinite(number):
            raise self._wrong(value, "give a finite number")
        if abs(number) > (largest := LARGEST_OF.get(self.unit, MAX_QUANTITY)):
            raise self._wrong(value, f"it must be {largest:g} or less in SI")
        if self.above is not None and not number > self.above:
            raise self._wrong(value, f"it must be above {self.above:g}")
        if self.above == 0.0 and number < SMALLEST:
            raise self._wrong(value, f"it must be above {SMALLEST:g} in SI")
        if self.at_least is not None and not number >= self.at_least:
            raise self._wrong(value, f"it must be {self.at_least:g} or more")
        if self.at_most is not None and not number <= self.at_most:
            raise self._wrong(value, f"it must be {self.at_most:g} or less")
        return number

    def _plain(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self._wrong(value)
        try:
            return float(value)
        except OverflowError:  # a whole number of hundreds of digits
            return inf

    def _convert(self, text: str) -> float:
        number = NUMBER.match(text.strip())
        if number is None:
            raise self._wrong(text)
        unit = text.strip()[number.end() :].strip()
        if not unit:
            return float(number.group())
        if unit[0] in ",:":
            raise self._wrong(text, NO_NUMBER[unit[0]])
        factor = self._factor(text, unit)
        if (written := _WRITTEN.get()) is not None:
            written.append((self.unit, unit))
        return float(number.group()) * factor

    def _factor(self, text: str, unit: str) -> float:
        try:
            return factor(unit, self.unit)
        except ValueError as error:
            raise self._wrong(text, str(error)) from None

    def _wrong(self, value: object, remedy: str = "") -> PydanticCustomError:
        return problem(value_text(value), self.expected_text, remedy)

    @property
    def expected_text(self) -> str:
        """The expected value, for messages."""
        article = "an" if self.what[0] in "aeiou" else "a"
        unit = f" in {self.unit}, or with a unit" if self.unit else ""
        text = ', or "infinite"' if self.infinite else ""
        return f'{article} {self.what}{unit}, such as "{self.example}"{text}'


@dataclass(frozen=True)
class Cyclic(Quantity):
    """Annotation of a `Quantity` over angular frequency that may also be given over frequency in
    cycles. It is then in the unit ``cycles``, with Hz, and multiplied by ``radians`` to be in
    ``unit``."""

    cycles: str = "Hz"
    radians: float = 2.0 * pi

    def _factor(self, text: str, unit: str) -> float:
        if "Hz" not in unit:
            return super()._factor(text, unit)
        return self.radians * Quantity(self.what, self.cycles, self.example)._factor(text, unit)


class CoordinateValue(float):
    """A value along a coordinate that was given with a unit: in ``unit``, or in ``turn_unit`` if it
    ``turns``; ``text`` is what was written."""

    text: str
    turns: bool
    unit: str
    turn_unit: str

    def __reduce__(self) -> tuple[type[float], tuple[float], dict[str, Any]]:
        return type(self), (float(self),), vars(self)


@dataclass(frozen=True)
class CoordinateQuantity(Quantity):
    """Annotation of a `Quantity` along a coordinate: in ``unit`` along a line, in ``turn_unit``
    about an axis. The value is a `CoordinateValue` if a unit was given."""

    turn_unit: str = ""

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        units = f"{self.unit} or {self.turn_unit}"
        return super().__get_pydantic_json_schema__() | {"unit": units}

    def __get_pydantic_core_schema__(self, _: Any, __: GetCoreSchemaHandler) -> CoreSchema:
        written = core_schema.plain_serializer_function_ser_schema(float)
        return core_schema.no_info_plain_validator_function(self.read, serialization=written)

    def read(self, value: object) -> float:
        """The value in SI; raises PydanticCustomError if it is not such a quantity."""
        if isinstance(value, CoordinateValue):
            return value
        number = NUMBER.match(value.strip()) if isinstance(value, str) else None
        unit = str(value).strip()[number.end() :].strip() if number else ""
        if not unit:
            return super().read(value)
        turns = _has_dimension(unit, self.turn_unit)
        turned = replace(self, unit=self.turn_unit, turn_unit=self.unit) if turns else self
        read_value = CoordinateValue(Quantity.read(turned, value))
        vars(read_value).update(text=value, turns=turns, unit=self.unit, turn_unit=self.turn_unit)
        return read_value

    @property
    def expected_text(self) -> str:
        article = "an" if self.what[0] in "aeiou" else "a"
        return f'{article} {self.what} in {self.unit} or {self.turn_unit}, such as "{self.example}"'


def _has_dimension(unit: str, si: str) -> bool:
    """True if a ``unit`` converts to ``si``."""
    try:
        factor(unit, si)
    except ValueError:
        return False
    return True


@dataclass(frozen=True)
class Scale:
    """The factor ``value`` that converts a number to SI, the ``unit`` of that number if it was
    given, and the ``text`` that gave both."""

    value: float
    unit: str | None = None
    text: str = ""


@dataclass(frozen=True)
class AnyQuantity:
    """Annotation of a `Scale`: a number in SI, or a text with any unit; the value must be ``above``
    a bound, if given."""

    what: str
    example: str
    above: float | None = None

    def __get_pydantic_core_schema__(self, _: Any, __: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        return _number_or_text(self.what, "", self.example, exclusiveMinimum=self.above)

    def read(self, value: object) -> Scale:
        """The factor; raises PydanticCustomError if the value is not a factor."""
        scale = self._read(value)
        if self.above is not None and not scale.value > self.above:
            raise problem(value_text(value), self.expected_text, f"it must be above {self.above:g}")
        return scale

    def _read(self, value: object) -> Scale:
        text = value.strip() if isinstance(value, str) else ""
        number = NUMBER.match(text)
        if number is None or not text[number.end() :].strip():
            return Scale(Quantity(self.what, "", self.example).read(value))
        unit = text[number.end() :].strip()
        try:
            size = registry().Quantity(1.0, _known_unit(unit)).to_base_units().magnitude
        except ValueError as error:
            raise problem(value_text(value), self.expected_text, str(error)) from None
        return Scale(float(number.group()) * float(size), unit, text)

    @property
    def expected_text(self) -> str:
        """The expected value, for messages."""
        return f'a {self.what}, such as "{self.example}"'


def is_same_dimension(first: str, second: str, product: str) -> bool:
    """True if a quantity in ``first`` times one in ``second`` can be given in ``product``."""
    unit = registry().parse_units
    return bool((unit(first) * unit(second)).dimensionality == unit(product).dimensionality)


def value_text(value: object) -> str:
    """A value in the form that messages show."""
    match value:
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case dict():
            return "a mapping" if value else "an empty mapping"
        case list():
            return f"a list of {len(value)}" if value else "an empty list"
        case str():
            return f'"{textwrap.shorten(value, 60)}"'
    return str(value)


def factor(unit: str, si: str) -> float:
    """The factor that converts a number in ``unit`` to ``si``; raises ValueError with the reason if
    there is none."""
    known_factor = stored_factor(unit, si)
    if known_factor is None:
        known_factor = _computed_factor(unit, si)
        store_factor(unit, si, known_factor)
    return known_factor


def _computed_factor(unit: str, si: str) -> float:
    source = _known_unit(unit)
    target = registry().parse_units(si)
    if not _is_same_kind(source, target, si in RADIAN_UNITS):
        raise ValueError(_why_not(unit, source, target))
    return float(registry().convert(1.0, source, target))


def _known_unit(unit: str) -> Any:
    """pint's unit; raises ValueError with the reason if it is unknown."""
    if not UNIT.fullmatch(unit):
        raise ValueError(f'"{unit}" cannot be read as a unit')
    if VAGUE.search(unit):
        raise ValueError("tons differ; write tonne (1000 kg) or tonne_force (9810 N)")
    import pint

    try:
        return registry().parse_units(unit.replace(".", "*"))
    except pint.PintError:
        raise ValueError(f'"{unit}" has a unit that is not known') from None


def _is_same_kind(source: Any, target: Any, strict: bool) -> bool:
    if strict:
        root = registry().get_root_units
        return bool(root(source)[1] == root(target)[1])
    return bool(source.dimensionality == target.dimensionality)


def _why_not(unit: str, source: Any, target: Any) -> str:
    acceleration = registry().parse_units("m/s^2")
    if _is_same_kind(source * acceleration, target, strict=False):
        return f'"{unit}" has a mass where a force belongs: a weight is in tonne_force'
    if _is_same_kind(source / acceleration, target, strict=False):
        return f'"{unit}" has a force where a mass belongs: divide a weight by 9.81 m/s^2'
    return f'"{unit}" is another kind of quantity'


@lru_cache(maxsize=1)
def registry() -> Any:
    """pint's units and ours. They take half a second to load, so they are loaded at first use."""
    import pint

    units: Any = pint.UnitRegistry(on_redefinition="ignore")
    units.define(f"tonne_force = {TONNE_FORCE} newton = tf")
    units.define("@alias tonne = te")
    return units
