"""A mooring system as MoorDyn and MoorPy describe it: types of lines, points, and lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from hydrosim.scene import OmittedEntry
from hydrosim.scene.catenary import Segment, StretchCurve

Place = tuple[float, float, float]


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
class MooringLine:
    """A line from a ``fairlead`` on a body, in the axes of the body, to an ``anchor`` on the earth,
    in the axes of the file [m]."""

    fairlead: tuple[float, float, float]
    anchor: tuple[float, float, float]
    segments: Sequence[Segment]
