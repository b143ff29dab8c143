"""A mooring system as MoorDyn and MoorPy describe it: types of lines, points, and lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from hydrosim.documents.units import Quantity
from hydrosim.scene import LeftOut, Question

DIAMETER = Quantity("diameter", "m", "0.1", at_least=0)
MASS_PER_LENGTH = Quantity("mass per length", "kg/m", "150", at_least=0)
AXIAL_STIFFNESS = Quantity("axial stiffness EA", "N", "1e8", above=0)
BENDING_STIFFNESS = Quantity("bending stiffness", "N*m^2", "0", at_least=0)
DRAG_COEFFICIENT = Quantity("drag coefficient", "", "1.2", at_least=0)
MASS = Quantity("mass", "kg", "0", at_least=0)
VOLUME = Quantity("volume", "m^3", "0", at_least=0)
PLACE = Quantity("coordinate", "m", "-150")
LENGTH = Quantity("length", "m", "300", above=0)
ANY_FORCE = Quantity("force", "N", "0")
DENSITY = Quantity("density", "kg/m^3", "1025", above=0)
GRAVITY = Quantity("acceleration", "m/s^2", "9.81", above=0)
DEPTH = Quantity("depth", "m", "150", above=0)
FRICTION = Quantity("coefficient of friction", "", "0.5", at_least=0, at_most=3)

MAX_SEGMENTS = 100
"""Segments of one line. With 300 the touch-down passes more of their ends in a step than a run
follows."""
Place = tuple[float, float, float]


class Held(StrEnum):
    """What holds a point."""

    EARTH = "the earth"
    BODY = "a body"
    LINES = "its lines alone"


@dataclass(frozen=True)
class LineType:
    """Cross-section: volumetric ``diameter`` [m], ``mass`` per length [kg/m], ``stiffness`` EA [N],
    transverse ``drag`` coefficient."""

    diameter: float
    mass: float
    stiffness: float
    drag: float = 0.0


@dataclass(frozen=True)
class Point:
    """``place`` [m]: in the axes of the body if one holds it, else in those of the file. ``body``
    is its name there. ``mass`` [kg], ``volume`` [m^3]."""

    held: Held
    place: tuple[float, float, float]
    mass: float = 0.0
    volume: float = 0.0
    body: str = ""


@dataclass(frozen=True)
class Piece:
    """A line of a file: its ``type``, the points at both ``ends``, its unstretched ``length``
    [m]."""

    type: str
    ends: tuple[str, str]
    length: float


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
    left_out: tuple[LeftOut, ...] = ()


@dataclass(frozen=True)
class Segment:
    """A piece of a mooring line: ``length`` [m], ``weight`` in water [N/m], ``stiffness`` [N],
    ``hung`` [N] at its lower end, ``drag`` coefficient and its ``diameter`` [m]."""

    length: float
    weight: float
    stiffness: float
    hung: float
    drag: float
    diameter: float


@dataclass(frozen=True)
class MooringLine:
    """A line from a ``fairlead`` on a body, in the axes of the body, to an ``anchor`` on the earth,
    in the axes of the file [m]."""

    fairlead: tuple[float, float, float]
    anchor: tuple[float, float, float]
    segments: Sequence[Segment]


def left_out_bending(stiffness: float, name: str, place: str) -> LeftOut:
    """The bending stiffness [N m^2] of a type of line."""
    return LeftOut(
        Question.BENDING,
        f"EI of {stiffness:g} N m^2 for {name} in {place}",
        "lines in static balance have no bending stiffness here",
        "The shape is wrong near ends and touch-down, within some sqrt(EI / tension) of them.",
        refused=True,
    )


def left_out_option(name: str, value: str, line: int, advice: str) -> LeftOut:
    """An option of a file."""
    found = f"the option {name} {value}".strip()
    return LeftOut(Question.FILES, f"{found} in line {line}", "it is left out", advice)


def left_out_key(key: str, line: int) -> LeftOut:
    """A key of a YAML file."""
    advice = "No key of this name is known here; see that the line is as you mean it."
    found = f"the key {key} in line {line}"
    return LeftOut(Question.FILES, found, "it is left out", advice)


def left_out_body(number: str, line: int) -> LeftOut:
    """The mass and the loads of a free body, which the case has."""
    found = f"the free body {number} in line {line}"
    advice = "The body of the case has its place, with its own mass and buoyancy."
    return LeftOut(Question.FILES, found, "its mass and its loads are left out", advice)
