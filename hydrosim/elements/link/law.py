"""What a law of a link declares: the base of its elements, and the constants of a link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import Layout
from hydrosim.elements.link.coordinate import COORDINATE
from hydrosim.modes import INACTIVE
from hydrosim.scene import ForceElement

TENSION, ELASTIC, GAS, STOP, DRY_FRICTION = range(5)
ANYWHERE = (-inf, inf)

LINK = np.dtype(
    [
        *(("family", int), ("law", int), ("row", int), ("inactive", int), *COORDINATE),
        *(("state", int), ("states", int)),
        *(("damping", float), ("drag", float), ("absorbs", bool), ("pulls_only", bool)),
        ("constants", int),
        *(("first", int), ("last", int), ("steepest", float)),
        *(("idle", int), ("idle_range", float, 2), ("stiff", int), ("stiff_range", float, 2)),
    ]
)
"""Constants of a link: the family of its kind; its law and its row of forces; the mode in which it
is inactive; its coordinate; the first of its ``states`` among those of links, and their number;
linear and quadratic damping; whether its power is recorded, and whether it pulls only; its place in
the `constants` of its law; the pieces ``first`` to ``last`` of its curve and the ``steepest``
slope; the pieces on which it is linearised, without load and at its stiffest, and the offsets
between which it is then."""


class LinkConstants(NamedTuple):
    """``links`` (n,) of `LINK`; the ``segments`` of their curves and the ``pieces`` of the signals
    of their lengths; constants of gas springs, stops and dry friction; the first of their rows of
    modes and of their states, and of the integrals of losses in y, row by row."""

    links: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    gases: np.ndarray
    stops: np.ndarray
    frictions: np.ndarray
    state: int
    mode: int
    losses: int


@dataclass(frozen=True)
class Link(ForceElement):
    """Base of elements with one load along one coordinate, by a ``law``. ``state_names`` are the
    states of one such element."""

    law: ClassVar[int]
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
