"""A mooring system as MoorDyn and MoorPy describe it: types of lines, points, and lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Self

import numpy as np
from pydantic import model_validator

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import same_length
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem
from hydrosim.scene import OmittedEntry
from hydrosim.scene.force import MAX_CURVE_POINTS

MAX_SEGMENTS = 100
"""Segments of one line. With 300 the touch-down passes more of their ends in a step than a run
follows."""
Place = tuple[float, float, float]


class StretchCurve(SchemaModel):
    """Tension of a line over its stretch; straight lines, the last one continued."""

    key_rules = (same_length("stretch", "tension"),)

    stretch: of.Stretches
    """Elongation over length without tension, which rises from 0."""
    tension: of.RisingForces
    """Tension at each stretch, which rises from 0."""

    @model_validator(mode="after")
    def _check_points(self) -> Self:
        if len(self.stretch) > MAX_CURVE_POINTS:
            raise problem(f"{len(self.stretch)} points", f"at most {MAX_CURVE_POINTS}")
        return self


def stiffness_and_curves(
    stiffness: Sequence[float | StretchCurve],
) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """EA (n,) [N] of segments without tension, and curves (2, k) by their number."""
    curves = {
        i: np.array([s.stretch, s.tension])
        for i, s in enumerate(stiffness)
        if isinstance(s, StretchCurve)
    }
    slopes = {i: tension[1] / stretch[1] for i, (stretch, tension) in curves.items()}
    return np.array([slopes.get(i, s) for i, s in enumerate(stiffness)], float), curves


class PointSupport(StrEnum):
    """What holds a point."""

    EARTH = "the earth"
    BODY = "a body"
    LINES = "its lines alone"


@dataclass(frozen=True)
class LineType:
    """Cross-section: volumetric ``diameter`` [m], ``mass`` per length [kg/m], ``stiffness`` EA [N]
    or a curve, transverse ``drag`` coefficient."""

    diameter: float
    mass: float
    stiffness: float | StretchCurve
    drag: float = 0.0


@dataclass(frozen=True)
class Point:
    """``place`` [m]: in the axes of the body if one holds it, else in those of the file. ``body``
    is its name there. ``mass`` [kg], ``volume`` [m^3]. It stands in the line ``row`` of the
    file."""

    held: PointSupport
    place: tuple[float, float, float]
    mass: float = 0.0
    volume: float = 0.0
    body: str = ""
    row: int | None = None


@dataclass(frozen=True)
class Piece:
    """A line of a file: its ``type``, the points at both ``ends``, its unstretched ``length`` [m].
    It stands in the line ``row`` of the file."""

    type: str
    ends: tuple[str, str]
    length: float
    row: int | None = None


@dataclass(frozen=True)
class System:
    """What a ``file`` holds. ``density`` [kg/m^3], ``gravity`` [m/s^2] and ``depth`` [m] are None
    where it does not say; ``friction`` is that of the seabed along a line. ``left_out`` is what the
    file says and the system has not."""

    file: Path
    types: Mapping[str, LineType]
    points: Mapping[str, Point]
    pieces: Mapping[str, Piece]
    density: float | None = None
    gravity: float | None = None
    depth: float | None = None
    friction: float = 0.0
    left_out: tuple[OmittedEntry, ...] = ()


@dataclass(frozen=True)
class LinePiece:
    """A piece of a mooring line: ``length`` [m], ``weight`` in water [N/m], ``stiffness`` [N] or a
    curve, ``hung`` [N] at its lower end, ``drag`` coefficient and its ``diameter`` [m]."""

    length: float
    weight: float
    stiffness: float | StretchCurve
    hung: float
    drag: float
    diameter: float


@dataclass(frozen=True)
class MooringLine:
    """A line from a ``fairlead`` on a body, in the axes of the body, to an ``anchor`` on the earth,
    in the axes of the file [m]."""

    fairlead: tuple[float, float, float]
    anchor: tuple[float, float, float]
    segments: Sequence[LinePiece]
