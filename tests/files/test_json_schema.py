"""JSON schemas for editors: they take what hydrosim takes, and find mistakes where they are."""

import json
import re
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError, best_match
from markers import few

from hydrosim.files.yaml_nodes import compose_nodes, plain_values
from hydrosim.interface.new import FileKind, schema_of

ROOT = Path(__file__).parents[2]
CASES = sorted(path for path in (ROOT / "cases").rglob("*.yaml") if path.parent.name != "studies")
FILES = {
    FileKind.CASE: CASES,
    FileKind.STUDY: sorted((ROOT / "cases").rglob("studies/*.yaml")),
    FileKind.RECIPE: sorted((ROOT / "hydro_db").glob("*.yaml")),
}
BASE, STUDY = ROOT / "cases" / "reverse_float_over" / "base.yaml", FILES[FileKind.STUDY][0]
WHOLE = [(kind, path) for kind, paths in FILES.items() for path in paths]
BARGE, FENDER = "bodies.barge", "forces.interface"
GONE = object()


def content(path: Path) -> Any:
    return plain_values(compose_nodes(path.read_text(), str(path)))


@cache
def validator(kind: FileKind) -> Draft202012Validator:
    return Draft202012Validator(schema_of(kind))


@pytest.mark.parametrize("kind", few(sorted(FileKind, reverse=True), 2))
def test_schemas_are_schemas(kind: FileKind) -> None:
    Draft202012Validator.check_schema(schema_of(kind))


@pytest.mark.parametrize(("kind", "path"), WHOLE, ids=lambda x: getattr(x, "stem", str(x)))
def test_shipped_files_are_valid(kind: FileKind, path: Path) -> None:
    assert not list(validator(kind).iter_errors(content(path)))


MISTAKES = {
    "title": [GONE, 3],
    "duration": [GONE, "long", 0, "-5 s", [100]],
    "durration": ["100 s"],
    "bodies": [GONE, []],
    "environment.water_depth": ["deep", -10],
    "environment.water_density": ["heavy"],
    "environment.gravity": [0.0],
    "environment.depth": [10],
    "environment.waves.spectrum": ["jonswop", GONE],
    "environment.waves.peak_period": [0, "-8 s"],
    "environment.waves.peak_enhancement": [0.5],
    "environment.waves.seeds": [3],
    "environment.current": [{"heading": "10 deg"}, {"speed": "-1 m/s"}],
    "environment.wind": [12.0],
    f"{BARGE}.mass": ["-3 tonne", True],
    f"{BARGE}.mas": [100.0],
    f"{BARGE}.centre_of_gravity": [[0, 0], [0, 0, 0, 0], "0 m"],
    f"{BARGE}.radii_of_gyration": [[1, 0, 1], {"roll": "22 m", "pitch": "67 m"}],
    f"{BARGE}.dofs": ["surge", [1, 2]],
    f"{BARGE}.radiation": [
        *("states", {"model": "constant"}, {"model": "convolution", "lenght": "80 s"})
    ],
    f"{BARGE}.wave_forces.second_order": ["full"],
    f"{BARGE}.wave_forces.first_order": ["yes"],
    f"{BARGE}.weight": ["heavy"],
    f"{BARGE}.database_body": [0],
    f"{BARGE}.initial.position": [[0, 0, 0], {"heav": "1 m"}],
    f"{BARGE}.initial.velocity": [{"heave": True}],
    f"{BARGE}.inertia": [{"roll": 1e6, "pitch": 1e6, "jaw": 1e6}],
    f"{FENDER}.type": ["fenders", GONE],
    f"{FENDER}.body": [1],
    f"{FENDER}.points": [[[0, 0]]],
    f"{FENDER}.friction.law": ["slip_stick"],
    f"{FENDER}.friction.static": [-0.2],
    f"{FENDER}.plane.normal": [[0, 1]],
    "solver.method": ["rk5"],
    "solver.step": [0, "fast"],
    "solver.tolerance": [1e-6],
    "output.step": ["-1 s"],
    "output.states": [1],
    "output.wave_probes": [{"bow": [1, 2, 3]}],
    "accept": ["plane", ["plains"]],
    "initial": ["resting"],
}


@pytest.mark.parametrize(
    ("key", "value"), [(key, value) for key, values in MISTAKES.items() for value in values]
)
def test_mistakes_are_found_where_they_are(key: str, value: object) -> None:
    """The place of the most telling error begins with that of the mistake, or of what it is in."""
    case = deepcopy(content(BASE))
    *above, last = key.split(".")
    place = case
    for name in above:
        place = place.setdefault(name, {})
    if value is GONE:
        del place[last]
    else:
        place[last] = value
    errors = list(validator(FileKind.CASE).iter_errors(case))
    assert errors
    assert all(found(error)[: len(above)] == above for error in errors)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("initial", {"position": {"heave": "1 m", "pitch": "2 deg"}, "velocity": {"yaw": 0.1}}),
        ("radii_of_gyration", {"roll": "22 m", "pitch": "67 m", "yaw": "69 m"}),
        ("inertia", {"roll": 1e6, "pitch": 1e6, "yaw": "1e3 tonne*m^2"}),
    ],
)
def test_directions_by_name_are_taken(key: str, value: object) -> None:
    case = deepcopy(content(BASE))
    case["bodies"]["barge"][key] = value
    assert not list(validator(FileKind.CASE).iter_errors(case))


def found(error: ValidationError) -> list[str]:
    """The place of what is wrong, deep in the alternative that fits best."""
    best = best_match([error])
    assert best is not None
    return [str(x) for x in best.absolute_path]


def test_a_file_over_another_may_leave_keys_out_and_remove_them() -> None:
    over = {
        "extends": "base.yaml",
        "bodies": {"barge": {"mass": "3 tonne"}},
        "forces": {"lift": None},
    }
    case = validator(FileKind.CASE)
    assert not list(case.iter_errors(over))
    assert list(case.iter_errors(over | {"bodies": {"barge": {"mas": 3}}}))
    assert list(case.iter_errors({"title": "alone", "duration": 3}))


@pytest.mark.parametrize("kind", list(FileKind))
def test_every_key_has_a_meaning(kind: FileKind) -> None:
    """A sentence each, and the unit of what has one."""
    definitions = schema_of(kind)["$defs"]
    for name, definition in definitions.items():
        if "Part_" in name or name.endswith("Over"):
            continue
        for key, value in definition.get("properties", {}).items():
            if value is not False and "by_" not in name:
                text = value.get("description", "")
                assert re.fullmatch(r"[A-Z].*\.", text), (name, key)


def test_every_quantity_has_a_unit_and_an_example() -> None:
    definitions = schema_of(FileKind.CASE)["$defs"]
    quantities = [each for each in definitions.values() if "quantity" in each]
    assert len(quantities) > 40
    assert all(each["examples"] and each["unit"] is not None for each in quantities)
    mass = definitions["BodyEntry"]["properties"]["mass"]
    assert mass["description"].endswith("Unit: kg.")
    assert definitions["EnvironmentEntry"]["properties"]["gravity"]["default"] == 9.81


def test_every_key_has_an_example_or_its_choices() -> None:
    for kind in FileKind:
        definitions = schema_of(kind)["$defs"]
        for name, definition in definitions.items():
            if not any(part in name for part in ("Part_", "Over", "by_")):
                for key, value in definition.get("properties", {}).items():
                    assert value is False or exemplified(value, definitions), (kind, name, key)


def exemplified(value: dict[str, Any], definitions: dict[str, Any]) -> bool:
    """Whether a value has an example or says its choices, or what is in it does."""
    if "$ref" in value:
        return exemplified(definitions[value["$ref"].split("/")[2]], definitions)
    if value.get("type") in ("boolean", "integer"):
        return True
    if {"examples", "enum", "const", "properties", "allOf"} & value.keys():
        return True
    inside = [*value.get("anyOf", ()), *value.get("prefixItems", ())]
    inside += [value[key] for key in ("items", "additionalProperties") if key in value]
    return any(exemplified(each, definitions) for each in inside if isinstance(each, dict))


def test_the_schema_of_cases_is_small() -> None:
    """An element takes some 6000 characters."""
    assert len(json.dumps(schema_of(FileKind.CASE))) < 355_000


def test_definitions_are_all_there_and_used() -> None:
    for kind in FileKind:
        text = json.dumps(schema_of(kind))
        used = set(re.findall(r'"#/\$defs/(\w+)', text))
        assert used == {*schema_of(kind)["$defs"]}
