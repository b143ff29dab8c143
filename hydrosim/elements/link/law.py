"""What a law of a link declares, and the constants of a link."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import ChartHint, Topic, Variable, range_columns
from hydrosim.elements.signal import SIGNAL
from hydrosim.modes import INACTIVE
from hydrosim.scene.links import Link

LOAD_OUTPUT, PLACE_OUTPUT, OFFSET_OUTPUT, POWER_OUTPUT, LINK_OUTPUTS = range(5)
"""Columns of what a run records of a link."""
ANYWHERE = (-inf, inf)

COORDINATE = [
    *(("coordinate", int), ("body", int), ("other", int)),
    *(("ends", float, 6), ("axes", float, 18), ("closest", float)),
    *(("motion", int), ("move", int), ("joint_axis", int)),
    *(("neutral", float), ("varies", bool), ("signal", SIGNAL)),
]
"""Fields of a coordinate (`hydrosim.elements.link.coordinate`), a distance, a twist or a motion of
a joint: the bodies; the points of both ends, and the closest that they may come; the triads of both
sides, each in the frame of its side, the axis first; the free coordinate of a motion, its move of
the tree of joints, and the axis of that; L0, or the signal of it if that ``varies``."""
LINK = np.dtype(
    [
        *(
            ("family", int),
            ("element", int),
            ("law", int),
            ("row", int),
            ("inactive", int),
            *COORDINATE,
        ),
        *(("state", int), ("states", int)),
        *(("damping", float), ("drag", float), ("absorbs", bool), ("pulls_only", bool)),
        ("constants", int),
        *(("first", int), ("last", int), ("steepest", float)),
        *(("idle", int), ("idle_range", float, 2), ("stiff", int), ("stiff_range", float, 2)),
    ]
)
"""Constants of a link: the family of its kind, and its class of elements; its law and its row of
forces; the mode in which it is inactive; its coordinate; the first of its ``states`` among those of
links, and their number; linear and quadratic damping; whether its power is recorded, and whether it
pulls only; its place in the constants of its law; the pieces ``first`` to ``last`` of its curve and
the ``steepest`` slope; the pieces on which it is linearised, without load and at its stiffest, and
the offsets between which it is then."""


class Column(NamedTuple):
    """A column of the outputs of a link, and the variable of results that has it."""

    output: int
    variable: Variable


def load_and_place(dimension: str) -> dict[str, Column]:
    """Columns of a link that any coordinate may have."""
    text = dimension.replace("_", " ")
    load = Variable(
        f"load of a {text} against its coordinate",
        "N or N m",
        chart=ChartHint(f"{text.capitalize()}: load", f"{text} load", Topic.COORDINATES),
        summary=range_columns("load"),
        is_load=True,
    )
    place = Variable(
        f"length, twist or place of a {text}",
        "m or rad",
        chart=ChartHint(f"{text.capitalize()}: place", f"{text} place", Topic.DETAILS + 10),
    )
    return {
        f"{dimension}_load": Column(LOAD_OUTPUT, load),
        f"{dimension}_place": Column(PLACE_OUTPUT, place),
    }


def no_curve(element: Any) -> np.ndarray:
    """No pieces (0,) of `curves.SEGMENT`, of a law without a curve."""
    return np.zeros(0, dtype=curves.SEGMENT)


def no_constants(element: Any) -> np.ndarray:
    """No constants (0,), of a law that has none but those of `LINK`."""
    return np.zeros(0)


class LinkClass(NamedTuple):
    """A class of ``element`` with one load along one coordinate.

    Its ``columns`` in results have the ``dimension``. ``law_fields`` (element, curve) are fields of
    `LINK`, with pieces counted from the first of the ``curve`` of the element. ``constants`` (1,)
    are those of its law. ``state_names`` are the states of one element.
    """

    element: type[Link]
    dimension: str
    columns: Mapping[str, Column]
    law_fields: Callable[[Any, np.ndarray], dict[str, Any]]
    curve: Callable[[Any], np.ndarray] = no_curve
    constants: Callable[[Any], np.ndarray] = no_constants
    inactive_mode: int = INACTIVE
    pulls_only: bool = False
    state_names: Sequence[str] = ()


def curve_fields(curve: np.ndarray, idle: int, idle_range: Sequence[float]) -> dict[str, Any]:
    """Fields of `LINK` of a link on a ``curve``, which is ``idle`` on one of its pieces."""
    stiff = int(np.argmax(curve["slope"]))
    return {
        "last": curve.size - 1,
        "steepest": np.abs(curve["slope"]).max(),
        "idle": idle,
        "idle_range": idle_range,
        "stiff": stiff,
    }
