"""Validation of files with messages to act on: "found X; expected Y; remedy", and suggestions.

One mistake gives one message. An unknown key is matched with the missing key beside it. A mapping
with many unknown keys gives one message.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from yaml.nodes import Node

from hydrosim.errors import InputError
from hydrosim.files.units import Quantity, value_text
from hydrosim.files.yaml_nodes import empty_keys, locate_value, place_text, plain_values, with_hint

# Suggestions for an unknown word: synonyms, capitals, typing errors.

MIN_SIMILARITY = 0.7  # similarity of words, 0 to 1: below it no word is suggested
SYNONYMS = {
    "significant_height": "hs hsig hm0 h_s swh significant_wave_height wave_height",
    "peak_period": "tp t_p wave_period",
    "peak_enhancement": "gamma peakedness peak_factor peak_enhancement_factor",
    "amplitude": "a wave_amplitude height h",
    "period": "t",
    "heading": "direction dir angle course azimuth mean_direction wave_direction bearing",
    "spreading": "s spread spreading_exponent",
    "seed": "random_seed rng",
    "water_depth": "depth d h waterdepth",
    "water_density": "rho density sea_density rho_water",
    "density": "rho water_density",
    "gravity": "g gravity_acceleration",
    "waves": "wave sea seastate",
    "depth": "water_depth d h",
    "speed": "velocity v u magnitude",
    "spectrum": "type spectrum_type",
    "jonswap": "jonswop jons",
    "pierson_moskowitz": "pm pierson moskowitz",
    "regular": "airy linear sinusoidal monochromatic",
    "none": "no off still calm",
    "mass": "m displacement weight",
    "centre_of_gravity": "cog cg com center_of_gravity centre_of_mass center_of_mass",
    "centre_of_buoyancy": "cob cb center_of_buoyancy",
    "radii_of_gyration": "kxx kyy kzz rxx ryy rzz gyradii radius_of_gyration k_xx k_yy k_zz",
    "inertia": "ixx iyy izz i44 i55 i66 moments_of_inertia moment_of_inertia",
    "draught": "draft t",
    "length": "l lpp loa unstretched_length l0 pretension",
    "capacity": "mbl wll swl breaking_load minimum_breaking_load",
    "compression": "deflection",
    "drag": "cd drag_coefficient",
    "force": "reaction",
    "beam": "breadth width b",
    "database_body": "body body_number number index",
    "hydrodynamics": "database hydro bem rao wamit",
    "location": "place xy origin",
    "dofs": "dof degrees_of_freedom free",
    "initial": "start initial_condition initial_conditions",
    "position": "offset offsets displacement",
    "forces": "elements force connections constraints",
    "bodies": "body vessels vessel objects",
    "environment": "env sea metocean ocean",
    "duration": "simulation_time t_end end_time length end stop",
    "step": "dt time_step timestep h delta_t",
    "method": "integrator scheme",
    "solver": "integration numerics time_integration simulation",
    "output": "outputs results record",
    "title": "name",
    "stiffness": "k spring spring_constant ks",
    "damping": "c damper dashpot",
    "damping_ratio": "zeta xi",
    "static": "mu_s mus static_friction mu friction_static coefficient",
    "kinetic": "mu_k muk dynamic kinetic_friction mu_d friction_kinetic",
    "coefficient": "mu friction_coefficient",
    "law": "type model",
    "type": "kind law element",
    "normal": "n direction normal_vector",
    "points": "point locations positions fender_points",
    "anchor": "end fairlead_b end_b",
    "point": "position location fairlead",
    "hinge": "revolute pin",
    "slider": "prismatic",
    "ball": "spherical ball_joint",
    "universal": "cardan hooke",
    "fixed": "weld rigid",
    "spring": "line rope cable hawser wire",
    "catenary": "mooring_line chain anchor_line",
    "linear_mooring": "mooring",
    "winch": "tugger drum hoist capstan",
    "strut": "rod two_sided_spring link spring_damper",
    "power_take_off": "pto",
    "rotary_power_take_off": "rotary_pto",
    "torsion_spring": "rotational_spring angular_spring",
    "to": "other_body",
    "fender": "bumper contact quay",
    "applied_force": "force load external_force",
    "linear_damping": "damper",
    "quadratic_damping": "drag viscous_damping morison",
    "viscous_roll": "roll_damping bilge bilge_keels",
    "wind_load": "wind wind_force",
    "current_load": "current current_force",
    "coulomb": "dry",
    "automatic": "auto",
    "rk4": "runge_kutta runge_kutta_4",
    "rk2": "midpoint",
    "convolution": "cummins impulse_response",
    "parameters": "parameter variables vary",
    "seeds": "seed",
    "figures": "results outputs statistics",
    "criteria": "limits criterion",
    "latin_hypercube": "lhs latin lhc",
    "sobol": "qmc quasi_monte_carlo",
    "grid": "full_factorial factorial",
    "one_at_a_time": "oat ofat",
    "largest": "max maximum",
    "smallest": "min minimum",
    "largest_absolute": "max_abs maximum_absolute absmax amax",
    "lowest": "min minimum lower",
    "highest": "max maximum upper",
    "stop": "end_stop bumper limit_stop hard_stop",
    "dry_friction": "friction coulomb_friction brake",
    "drive": "prescribed_motion motion shaker",
    "std": "sigma rms sd stdev standard_deviation",
    "mean": "average avg",
    "end": "last final",
    "surge": "x",
    "sway": "y",
    "heave": "z",
    "roll": "rx phi",
    "pitch": "ry theta",
    "yaw": "rz psi",
}
"""Other technical words for keys and values of hydrosim, in lower case."""

KEY_REMEDIES = {
    ("height", "amplitude"): "give the amplitude, which is half of the height",
    ("wave_height", "amplitude"): "give the amplitude, which is half of the height",
    ("end_stops", ""): "an end stop is an element of its own, beside this one: type: stop",
    ("end_stop", ""): "an end stop is an element of its own, beside this one: type: stop",
    ("stops", ""): "an end stop is an element of its own, beside this one: type: stop",
}
"""Remedies for an unknown key that is not another word for the known key beside it."""


def suggestion(word: str, candidates: Iterable[str]) -> str:
    """Question with the word of ``candidates`` that was probably meant; empty without a similar
    one."""
    closest = closest_word(word, candidates)
    return f'did you mean "{closest}"?' if closest else ""


def closest_word(word: str, candidates: Iterable[str]) -> str:
    """The word of ``candidates`` that was probably meant; empty without a similar one."""
    return next(_closest_words(_plain_word(word), list(candidates)), "")


def _closest_words(word: str, candidates: list[str]) -> Iterator[str]:
    plain = {_plain_word(name): name for name in candidates}
    yield from [plain[word]] if word in plain else []
    yield from (name for name in candidates if word in SYNONYMS.get(name, "").split())
    yield from (name for name in candidates if "_" in word and _has_words(name, word))
    yield from (plain[name] for name in get_close_matches(word, plain, n=1, cutoff=MIN_SIMILARITY))


def _has_words(name: str, word: str) -> bool:
    """Whether a name has all words of ``word``, in any order."""
    return {*word.split("_")} <= {*_plain_word(name).split("_")}


def _plain_word(word: str) -> str:
    """A word in lower case, with its parts joined by one underscore."""
    parts = re.sub(r"([a-z0-9])([A-Z][a-z])", r"\1_\2", word)
    return re.sub(r"[\s_-]+", "_", parts.strip().lower())


Keys = tuple[str | int, ...]
Reader = Any
"""A model, or a class that `hydrosim.files.schema_class` makes."""
Readers = Mapping[int | str, Reader]
"""By the ``id`` of the mapping that they read, and by their names."""
Details = Mapping[str, Any]

UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
"""Errors of pydantic: of models, and of dataclasses."""
MANY_UNKNOWN = 4  # keys of one mapping that one message reports
MANY_KNOWN = 12  # keys are not all listed where one of them is suggested
MAX_PLACES = 3  # places of a key in a suggestion
MAX_LIST_LETTERS = 60  # characters of a list


class Problem(NamedTuple):
    """A mistake: the keys to its place, and a text "found X; expected Y; remedy"."""

    keys: Keys
    text: str


EXPECTED = {
    "model_type": "a mapping of keys and values",
    "dataclass_type": "a mapping of keys and values",
    "model_attributes_type": "a mapping of keys and values",
    "dict_type": "a mapping of names and values",
    "tuple_type": "a list",
    "string_type": "text; put it in quotes if it looks like something else",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "greater_than_equal": "a number that is not negative",
}


def validation_problems(error: ValidationError, data: Any, readers: Readers) -> Iterator[Problem]:
    """Each mistake in ``data`` with its place; ``readers`` are the models that read it."""
    every: list[Details] = list(error.errors(include_url=False))
    renamed = {*_renamed_keys(every, data, readers)}
    for details in every:
        if details["loc"] not in renamed:
            yield _problem_of_error(details, data, readers, every)


def _problem_of_error(
    details: Details, data: Any, readers: Readers, every: Sequence[Details]
) -> Problem:
    keys, value, context = details["loc"], details["input"], details.get("ctx", {})
    match details["type"]:
        case "hydrosim":
            return Problem(keys, context["text"])
        case kind if kind in UNKNOWN_KEY:
            reader = readers.get(id(_value_at(data, keys[:-1])))
            return _unknown_key_problem(keys, reader, _similar_errors(details, every), data)
        case "missing" if isinstance(keys[-1], int):
            return Problem(keys[:-1], _too_few(value, _similar_errors(details, every)))
        case "missing":
            return Problem(keys, _missing_keys_text(keys, readers[id(value)]))
        case "union_tag_invalid":
            key = context["discriminator"].strip("'")
            return Problem((*keys, key), _choice_text(context["tag"], context["expected_tags"]))
        case "union_tag_not_found":
            key = context["discriminator"].strip("'")
            kinds = re.findall(r"'([^']*)'", context.get("expected_tags", ""))
            kinds_text = f": {', '.join(kinds)}" if 0 < len(kinds) <= MANY_KNOWN else ""
            text = f'found no key "{key}"; expected it to say which kind this is{kinds_text}'
            return Problem(keys, with_hint(text, _misspelt_key_advice(key, value)))
        case "literal_error" | "enum":
            return Problem(keys, _choice_text(value, context["expected"]))
        case "greater_than_equal" if context["ge"] > 0:
            return Problem(keys, f"found {value_text(value)}; expected {context['ge']} or more")
        case "too_long":
            return Problem(
                keys, f"found {value_text(value)}; expected {context['max_length']} values"
            )
        case "too_short":
            least = context["min_length"]
            return Problem(
                keys, f"found {value_text(value)}; expected {_count_text(least)} or more"
            )
        case "tuple_type" if len(_similar_errors(details, every)) > 1:
            return Problem(keys[:-1], _flat_text(_value_at(data, keys[:-1])))
        case "tuple_type" if isinstance(value, str):
            return Problem(
                keys, f"found {value_text(value)}; expected a list, in brackets: [{value}]"
            )
        case "model_type" | "dataclass_type":
            reader = readers.get(context["class_name"])
            return Problem(keys, f"found {value_text(value)}; expected {_mapping_text(reader)}")
        case kind:
            expected = EXPECTED.get(kind, details["msg"].removeprefix("Input should be "))
            return Problem(keys, f"found {value_text(value)}; expected {expected}")


def _similar_errors(details: Details, every: Sequence[Details]) -> list[Details]:
    """The errors of the same kind in the same mapping or list."""
    kind, above = details["type"], details["loc"][:-1]
    return [error for error in every if error["type"] == kind and error["loc"][:-1] == above]


def _renamed_keys(every: Sequence[Details], data: Any, readers: Readers) -> Iterator[Keys]:
    """The missing keys that exist under another name."""
    missing = {error["loc"] for error in every if error["type"] == "missing"}
    for error in every:
        keys = error["loc"]
        reader = readers.get(id(_value_at(data, keys[:-1])))
        if error["type"] in UNKNOWN_KEY and reader:
            corrected = (*keys[:-1], closest_word(str(keys[-1]), _fields_of_reader(reader)))
            yield from {corrected} & missing


def _count_text(count: int) -> str:
    return "one" if count == 1 else f"{count}"


def _unknown_key_problem(
    keys: Keys, reader: Reader | None, alike: Sequence[Details], data: Any
) -> Problem:
    fields = _fields_of_reader(reader) if reader else {}
    if len(alike) >= MANY_UNKNOWN:
        names = ", ".join(str(error["loc"][-1]) for error in alike)
        text = f"found {len(alike)} unknown keys, {names}; expected some of: {', '.join(fields)}"
        return Problem(keys[:-1], text)
    key = str(keys[-1])
    if comma := _comma_remedy(key):
        return Problem(keys, f"found a key that begins with a digit; {comma}")
    elsewhere = _nested_keys(key, fields) if keys[:-1] else _places_of(key, data)
    remedy = (
        _colon_remedy(key, fields)
        or KEY_REMEDIES.get((_plain_word(key), closest_word(key, fields)))
        or suggestion(key, fields)
        or _place_advice([*elsewhere])
    )
    expected = (
        "" if remedy and len(fields) > MANY_KNOWN else f"expected one of: {', '.join(fields)}"
    )
    text = "; ".join(part for part in ("found an unknown key", expected, remedy) if part)
    return Problem(keys, text)


def _nested_keys(key: str, fields: Mapping[str, FieldInfo]) -> Iterator[str]:
    """Dotted keys of the mappings in ``fields`` that have this key, such as segments.drag, or one
    that it is another word for."""
    for name, field in fields.items():
        readers = [*_readers_in(field.annotation), *_readers_in(field.metadata)]
        inside = dict.fromkeys(inner for reader in readers for inner in _fields_of_reader(reader))
        for inner in [key] if key in inside else inside:
            if inner == key or _plain_word(key) in SYNONYMS.get(inner, "").split():
                yield f"{name}.{inner}"


def _readers_in(annotation: Any) -> Iterator[Reader]:
    """The models in an annotation, or in the form that a file gives it in."""
    if isinstance(annotation, type) and (
        issubclass(annotation, BaseModel) or hasattr(annotation, "schema_fields")
    ):
        yield annotation
    parts = annotation if isinstance(annotation, list) else get_args(annotation)
    for part in (*parts, getattr(annotation, "form", None)):
        yield from _readers_in(part) if part is not None else ()


def _place_advice(places: Sequence[str]) -> str:
    """Question with the places where a key belongs, unless these are many."""
    quoted = " or ".join(f'"{place}"' for place in places)
    return f"did you mean {quoted}?" if 0 < len(places) <= MAX_PLACES else ""


def _places_of(key: str, data: Any, above: str = "") -> Iterator[str]:
    """Dotted keys of all mappings below ``data`` with this key."""
    entries = data.items() if isinstance(data, dict) else ()
    for name, value in entries:
        if isinstance(value, dict) and key in value:
            yield f"{above}{name}.{key}"
        yield from _places_of(key, value, f"{above}{name}.")


def _comma_remedy(key: str) -> str:
    """The remedy for the part after a decimal comma, which begins a new entry in braces."""
    if re.fullmatch(r"\d+( .*)?", key):
        return f'is it the end of a number with a decimal comma? Write a point, as in "2.{key}"'
    return ""


def _colon_remedy(key: str, fields: Mapping[str, Any]) -> str:
    """The remedy if a colon, or the blank after it, is missing after a known key."""
    first = re.split(r"[\s:]", key)[0]
    return f'write "{first}: value", with a colon and a blank' if first in {*fields} - {key} else ""


def _misspelt_key_advice(key: str, value: Any) -> str:
    """The key of a mapping that probably stands for ``key``."""
    names = [str(name) for name in value] if isinstance(value, dict) else []
    given = next((name for name in names if _colon_remedy(name, {key: None})), "")
    if given:
        return f'write "{key}: value", with a colon and a blank, not "{given}"'
    other_name = next((name for name in names if closest_word(name, [key])), "")
    return f'is "{other_name}" meant as "{key}"?' if other_name else ""


def _too_few(value: Any, alike: Sequence[Details]) -> str:
    count = 1 + max(error["loc"][-1] for error in alike)
    return f"found {value_text(value)}; expected {count} values"


def _flat_text(value: Sequence[Any]) -> str:
    inside = ", ".join(map(str, value))
    example = f", [[{inside}]]" if len(inside) < MAX_LIST_LETTERS else ""
    return f"found a list of values; expected a list of lists; put it in brackets{example}"


def _mapping_text(reader: Reader | None) -> str:
    """Description of the mapping that a model reads."""
    if reader is None:
        return EXPECTED["model_type"]
    fields = _fields_of_reader(reader)
    needed = [name for name, field in fields.items() if field.is_required()]
    if not needed:
        return f"a mapping with some of {', '.join(fields)}"
    return f"a mapping with the key{'s' * (len(needed) > 1)} {', '.join(needed)}"


def _missing_keys_text(keys: Keys, reader: Reader) -> str:
    field = _fields_of_reader(reader)[str(keys[-1])]
    values = get_args(field.annotation) if get_origin(field.annotation) is tuple else ()
    form = f"a list of {len(values)} values" if values and Ellipsis not in values else "one"
    expected = next((q.expected_text for q in field.metadata if isinstance(q, Quantity)), form)
    return f'found no key "{keys[-1]}"; expected {expected}'


def _fields_of_reader(reader: Reader) -> dict[str, FieldInfo]:
    """The fields of a model, by the keys of a file."""
    return {field.alias or name: field for name, field in fields_of(reader).items()}


def fields_of(reader: Reader) -> dict[str, FieldInfo]:
    """The fields of a model by their names, in the order of their declaration."""
    fields = reader.model_fields if issubclass(reader, BaseModel) else reader.schema_fields()
    return dict(fields)


def _choice_text(value: Any, expected: str) -> str:
    choices = re.findall(r"'([^']*)'", expected)
    text = f"found {value_text(value)}; expected one of: {', '.join(choices)}"
    return with_hint(text, suggestion(str(value), choices))


def _value_at(data: Any, keys: Keys) -> Any:
    """The value at ``keys``; keys that do not exist are skipped, as in `locate_value`."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(key, data)
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
    return data


# `validate_document`: a YAML file as a pydantic model, or an error about every mistake.

M = TypeVar("M")
"""A model of pydantic, or a class of `hydrosim.files.schema_class`."""
Further = Callable[[M], Iterable[Problem]]

MOST_TOLD = 15  # problems in one error: nobody reads more, and a list may have thousands


def validate_document(document: Node, model: type[M], further: Further[M] = lambda _: ()) -> M:
    """The nodes of a YAML file as a ``model``; ``further`` finds problems in what it holds.

    Raises InputError with a line for each problem, and with the number of those after the
    first `MOST_TOLD`.
    """
    raw = plain_values(document)
    readers: dict[int | str, Any] = {}
    try:
        data: M = model.model_validate(raw, context=readers)  # type: ignore[attr-defined]
    except ValidationError as error:
        empty = [
            empty_value
            for empty_value in _empty_value_problems(document)
            if ":" not in str(empty_value.keys[-1])
        ]
        _raise_problems([*validation_problems(error, raw, readers), *empty], document)
        raise
    _raise_problems([*_empty_value_problems(document), *further(data)], document)
    return data


def _empty_value_problems(document: Node) -> Iterator[Problem]:
    for keys in empty_keys(document):
        yield Problem(keys, "found nothing; expected a value; give one or remove the key")


def _raise_problems(problems: Sequence[Problem], document: Node) -> None:
    """Raises one InputError with the first problem of each key; passes if there is none. What
    several mappings take from one anchor is told once."""
    problem_of_key: dict[str, tuple[str, str]] = {}
    for problem in problems:
        key, mark = locate_value(document, problem.keys)
        problem_of_key.setdefault(key, (place_text(mark), problem.text))
    keys_of_line: dict[tuple[str, str, str], list[str]] = {}
    for key, (place, text) in problem_of_key.items():
        keys_of_line.setdefault((place, key.rpartition(".")[2], text), []).append(key)
    lines = [
        ": ".join(part for part in (place, _keys_text(keys), text) if part)
        for (place, _, text), keys in keys_of_line.items()
    ]
    if lines:
        raise InputError("\n".join(_first_lines(lines)))


def _keys_text(keys: Sequence[str]) -> str:
    return keys[0] + (f" and {len(keys) - 1} like it" if len(keys) > 1 else "")


def _first_lines(lines: list[str]) -> list[str]:
    more = len(lines) - MOST_TOLD
    if more <= 0:
        return lines
    return [*lines[:MOST_TOLD], f"{more} more problems are not shown. Correct these first."]
