"""A case turned as a whole about the vertical through the origin."""

from copy import deepcopy
from math import cos, sin
from typing import Any

from tests.generators.random_cases import Case


def turned_case(case: Case, by: float) -> Case:
    """The ``case`` turned by an angle [rad]. Bodies keep their angles relative to their headings.
    Springs at the centre must be alike in all directions, and forces upright or of the body."""
    turned = deepcopy(case)
    if not by:
        return turned
    for body in turned["bodies"].values():
        body["location"] = _turned(body.get("location", [0.0, 0.0]), by)
        body["heading"] = body.get("heading", 0.0) + by
        for key in ("position", "velocity"):
            if key in body.get("initial", {}):
                body["initial"][key][:2] = _turned(body["initial"][key], by)
    for force in turned["forces"].values():
        if "anchor" in force and "anchor_body" not in force:
            force["anchor"][:2] = _turned(force["anchor"], by)
        plane = force.get("plane", {"body": ""})
        if "body" not in plane:
            plane["point"][:2] = _turned(plane["point"], by)
            plane["normal"][:2] = _turned(plane["normal"], by)
    for stream in ("waves", "current", "wind"):
        if stream in turned["environment"]:
            _turn_stream(turned["environment"][stream], by)
    return turned


def _turned(vector: list[float], by: float) -> list[float]:
    """The horizontal part of a vector."""
    x, y = vector[:2]
    return [cos(by) * x - sin(by) * y, sin(by) * x + cos(by) * y]


def _turn_stream(stream: Any, by: float) -> None:
    """Turn where waves, current or wind go to."""
    table = stream.get("profile", {})
    if "heading" in table:
        table["heading"] = [heading + by for heading in table["heading"]]
    else:
        stream["heading"] = stream.get("heading", 0.0) + by
