"""A case in short: tables of its surroundings, bodies and force elements."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any, NamedTuple

import yaml

from hydrosim.documents.digits import digits_of

SEA = {
    "spectrum": ("spectrum", 1.0, ""),
    "significant_height": ("significant height", 1.0, "m"),
    "peak_period": ("peak period", 1.0, "s"),
    "peak_enhancement": ("peak enhancement", 1.0, ""),
    "amplitude": ("amplitude", 1.0, "m"),
    "period": ("period", 1.0, "s"),
    "heading": ("goes to", degrees(1.0), "deg"),
    "seed": ("seed", 1.0, ""),
}
SHORT = {
    "spectrum": "",
    "significant_height": "Hs",
    "peak_period": "Tp",
    "amplitude": "amplitude",
    "period": "period",
    "heading": "going to",
    "seed": "seed",
}
"""What a line on a sea says, and how."""
WATER = {
    "water_depth": ("Water depth", 1.0, "m"),
    "water_density": ("Water density", 1.0, "kg/m^3"),
    "gravity": ("Gravity", 1.0, "m/s^2"),
}
BODY = {
    "mass": (1.0, "kg"),
    "centre_of_gravity": (1.0, "m"),
    "radii_of_gyration": (1.0, "m"),
    "heading": (degrees(1.0), "deg"),
    "dofs": (1.0, ""),
    "hydrodynamics": (1.0, ""),
    "hydrostatics": (1.0, ""),
    "weight": (1.0, ""),
}
USUAL = {"heading": 0.0}
"""What is not worth a row where it is so."""


class CaseTable(NamedTuple):
    """Rows under a ``head``; the first cell of a row says what it is of."""

    head: tuple[str, ...]
    rows: list[tuple[str, ...]]


def tables(data: dict[str, Any]) -> Iterator[CaseTable]:
    """The tables of a resolved case; none of one that holds nothing."""
    if data:
        yield CaseTable(("environment", ""), [*_environment(data.get("environment"))])
        yield CaseTable(("body", "", ""), [*_bodies(data.get("bodies"))])
        if forces := data.get("forces"):
            yield CaseTable(("force element", "type", "on"), [*_forces(forces)])


def seas(data: dict[str, Any]) -> list[str]:
    """The waves of a resolved case, a line for each: "jonswap, Hs 1.5 m, Tp 8 s, ..."."""
    trains = (data.get("environment") or {}).get("waves") or []
    return [
        ", ".join(
            f"{short} {_scaled(train[key], *SEA[key][1:])}".strip()
            for key, short in SHORT.items()
            if key in train
        )
        for train in trains
    ]


def _environment(water: Any) -> Iterator[tuple[str, str]]:
    for key, (label, scale, unit) in WATER.items():
        if key in (water or {}):
            yield label, _scaled(water[key], scale, unit)
    for key in ("current", "wind"):
        stream = (water or {}).get(key) or {}
        if stream.get("speed"):
            heading = _scaled(stream.get("heading", 0.0), degrees(1.0), "deg")
            yield key.capitalize(), f"{_scaled(stream['speed'], 1.0, 'm/s')}, goes to {heading}"
    waves = (water or {}).get("waves") or []
    for k, train in enumerate(waves if isinstance(waves, list) else [waves]):
        said = [
            f"{label} {_scaled(train[key], scale, unit)}"
            for key, (label, scale, unit) in SEA.items()
            if key in train
        ]
        yield f"Waves {k + 1}", ", ".join(said)


def _bodies(bodies: Any) -> Iterator[tuple[str, str, str]]:
    for name, body in (bodies or {}).items():
        for key, (scale, unit) in BODY.items():
            if body.get(key) not in (None, USUAL.get(key)):
                yield str(name), key.replace("_", " "), _scaled(body[key], scale, unit)


def _forces(forces: Any) -> Iterator[tuple[str, str, str]]:
    for name, element in forces.items():
        kind = str(element.get("type", "")).replace("_", " ")
        yield str(name), kind, str(element.get("body", ""))


def _scaled(value: Any, scale: float, unit: str) -> str:
    """A value of a case in a unit that people read."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        return str(value)
    if isinstance(value, int) and not unit:
        return str(value)
    each = value if isinstance(value, list) else [value]
    shown = [digits_of(scale * x, 6) if isinstance(x, int | float) else str(x) for x in each]
    return f"{', '.join(shown)} {unit}".strip()


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
