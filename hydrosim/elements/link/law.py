"""What a law of a link declares: the base of its elements, and the constants of a link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import Layout, Variable
from hydrosim.elements.link.coordinate import COORDINATE
from hydrosim.modes import INACTIVE
from hydrosim.scene import ForceElement

LOAD_OUTPUT, PLACE_OUTPUT, OFFSET_OUTPUT, POWER_OUTPUT, LINK_OUTPUTS = range(5)
"""Columns of what a run records of a link."""
ANYWHERE = (-inf, inf)

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
    load = Variable(f"load of a {text} against its coordinate", "N or N m")
    place = Variable(f"length, twist or place of a {text}", "m or rad")
    return {
        f"{dimension}_load": Column(LOAD_OUTPUT, load),
        f"{dimension}_place": Column(PLACE_OUTPUT, place),
    }


@dataclass(frozen=True)
class Link(ForceElement):
    """Base of elements with one load along one coordinate, by a law. ``dimension`` is that of their
    ``columns`` in results, ``state_names`` are the states of one element."""

    dimension: ClassVar[str]
    columns: ClassVar[Mapping[str, Column]]
    inactive_mode: ClassVar[int] = INACTIVE
    state_names: ClassVar[Sequence[str]] = ()
    pulls_only: ClassVar[bool] = False

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]

    def coordinate_fields(self, layout: Layout) -> dict[str, Any]:
        """Fields of `COORDINATE`."""
        raise NotImplementedError

    def curve(self) -> np.ndarray:
        """The pieces (n,) of `curves.SEGMENT` of its curve; none if it has none."""
        return np.zeros(0, dtype=curves.SEGMENT)

    def law_fields(self, curve: np.ndarray) -> dict[str, Any]:
        """The other fields of `LINK`; pieces are counted from the first of the ``curve``."""
        raise NotImplementedError

    def constants(self) -> np.ndarray:
        """The constants (1,) of its law, if that has its own."""
        return np.zeros(0)


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
