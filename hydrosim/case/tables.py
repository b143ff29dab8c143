"""A case in short: tables of its surroundings, bodies and force elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePath
from typing import Any

import yaml

from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.files.document_layout import text_of
from hydrosim.files.document_nodes import Sentence, Table, Value

SEA_ROWS = {
    "spectrum": ("spectrum", ""),
    "significant_height": ("significant height", "m"),
    "peak_period": ("peak period", "s"),
    "peak_enhancement": ("peak enhancement", ""),
    "amplitude": ("amplitude", "m"),
    "period": ("period", "s"),
    "heading": ("goes to", "rad"),
    "seed": ("seed", ""),
}
SEA_LINE_LABELS = {
    "spectrum": "",
    "significant_height": "Hs",
    "peak_period": "Tp",
    "amplitude": "amplitude",
    "period": "period",
    "heading": "going to",
    "seed": "seed",
}
"""What a line on a sea says, and how."""
WATER_ROWS = {
    "water_depth": ("Water depth", "m"),
    "water_density": ("Water density", "kg/m^3"),
    "gravity": ("Gravity", "m/s^2"),
}
BODY = {
    "mass": "kg",
    "centre_of_gravity": "m",
    "radii_of_gyration": "m",
    "heading": "rad",
    "dofs": "",
    "hydrodynamics": "",
    "hydrostatics": "",
    "weight": "",
}
DEFAULTS_NOT_SHOWN = {"heading": 0.0}
"""What is not worth a row where it is so."""
CELL_DIGITS = 6


def case_tables(data: Mapping[str, Any]) -> Iterator[Table]:
    """The tables of a resolved case; none of one that holds nothing."""
    if data:
        yield Table(("environment", ""), [*_environment_rows(data.get("environment"))])
        yield Table(("body", ""), [*_body_rows(data.get("bodies"))])
        if forces := data.get("forces"):
            yield Table(("force element", "type", "on"), [*_force_rows(forces)])
        if joints := data.get("joints"):
            yield Table(("joint", "type", "between"), [*_joint_rows(joints)])


def seas(data: Mapping[str, Any], units: Units = DEFAULT) -> list[str]:
    """The waves of a resolved case, a line for each: "jonswap, Hs 1.5 m, Tp 8 s, ..."."""
    trains = (data.get("environment") or {}).get("waves") or []
    return [text_of(_describe_train(train, SEA_LINE_LABELS), units) for train in trains]


def plain(text: str) -> dict[str, Any]:
    """A resolved case as it is; empty where it is none."""
    try:
        data = yaml.safe_load(text)
        ok = isinstance(data, dict) and all(
            isinstance(body, dict)
            for key in ("bodies", "forces")
            for body in (data.get(key) or {}).values()
        )
    except (yaml.YAMLError, AttributeError, RecursionError):
        return {}
    return data if ok else {}


def shorten_path(text: str) -> str:
    """Of a path the last two parts: folders of a machine mean nothing elsewhere. Other texts stay
    as they are."""
    path = PurePath(text)
    return "/".join(path.parts[-2:]) if path.is_absolute() else text


def _environment_rows(water: Any) -> Iterator[tuple[str, Sentence]]:
    for key, (label, unit) in WATER_ROWS.items():
        if key in (water or {}):
            yield label, _value_text(water[key], unit)
    for key in ("current", "wind"):
        stream = (water or {}).get(key) or {}
        profile = stream.get("profile")
        table = profile if isinstance(profile, Mapping) and "depth" in profile else {}
        speed = stream.get("speed") or max(table.get("speed") or [0.0])
        if speed:
            heading = (table.get("heading") or [stream.get("heading", 0.0)])[0]
            parts = (_shown_value(speed, "m/s"), _shown_value(heading, "rad"))
            shown = "" if profile in (None, "none") else ", with a profile"
            yield key.capitalize(), Sentence("{}, goes to {}" + shown, parts)
        if gusts := stream.get("gusts"):
            parts = (gusts.get("spectrum", ""), str(gusts.get("seed", "")))
            yield "Gusts", Sentence("{}, seed {}", parts)
    waves = (water or {}).get("waves") or []
    labels = {key: label for key, (label, _) in SEA_ROWS.items()}
    for k, train in enumerate(waves if isinstance(waves, list) else [waves]):
        yield f"Waves {k + 1}", _describe_train(train, labels)


def _describe_train(train: Mapping[str, Any], labels: Mapping[str, str]) -> Sentence:
    """A train of waves: each of its ``labels`` with the value."""
    given_keys = [key for key in labels if key in train]
    text = ", ".join(f"{labels[key]} {{}}".strip() for key in given_keys)
    return Sentence(text, [_shown_value(train[key], SEA_ROWS[key][1]) for key in given_keys])


def _body_rows(bodies: Any) -> Iterator[tuple[str, Sentence]]:
    for name, body in (bodies or {}).items():
        for key, unit in BODY.items():
            if body.get(key) not in (None, DEFAULTS_NOT_SHOWN.get(key)):
                yield f"{name}, {key.replace('_', ' ')}", _value_text(body[key], unit)


def _force_rows(forces: Any) -> Iterator[tuple[str, str, str]]:
    for name, element in forces.items():
        kind = str(element.get("type", "")).replace("_", " ")
        yield str(name), kind, str(element.get("body", ""))


def _joint_rows(joints: Any) -> Iterator[tuple[str, str, str]]:
    for name, joint in joints.items():
        other = joint.get("to") or "the earth"
        yield str(name), str(joint.get("type", "")), f"{joint.get('body', '')} and {other}"


def _value_text(value: Any, unit: str) -> Sentence:
    """A value of a case, or each of a list of them."""
    items = value if isinstance(value, list) else [value]
    return Sentence(", ".join("{}" for _ in items), [_shown_value(x, unit) for x in items])


def _shown_value(value: Any, unit: str) -> Value | str:
    if isinstance(value, str):
        return shorten_path(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return str(value) if isinstance(value, int) and not unit else Value(value, unit, CELL_DIGITS)
