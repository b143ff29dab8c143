"""Mooring lines of a case file: `catenary`, and `lines` from a file of another program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from math import cos, isfinite, sin
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, StrictStr, Tag, model_validator

from hydrosim.case.lines.chains import mooring_lines, read_mooring_system, water_of_system
from hydrosim.case.lines.system import (
    MAX_SEGMENTS,
    MooringLine,
    StretchCurve,
    System,
    stiffness_and_curves,
)
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_most_one
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import schema_class
from hydrosim.files.text import Source
from hydrosim.files.units import problem
from hydrosim.modes import NO_INDEX
from hydrosim.scene.force import CHAIN, STEEL, BreakingElement, BuildContext
from hydrosim.scene.links import TwoPointElement
from hydrosim.scene.signal import LengthOverTime, RecordedColumns, length_signal

if TYPE_CHECKING:
    from hydrosim.elements.line.catenary import Catenary as BuiltCatenary
    from hydrosim.scene import ForceElement

ROUGHEST = 3.0  # friction of chain on sand or clay is about 1
MAX_CHAIN_DIAMETER_M = 0.4  # m: twice the largest chain that is made


class Chain(SchemaModel):
    """Weight and stiffness of chain by its bar diameter."""

    diameter: of.Diameter
    """Nominal diameter of the bar."""
    type: Literal["studless", "studlink"] = "studless"
    """Links without or with studs."""

    @model_validator(mode="after")
    def _check_diameter(self) -> Self:
        if self.diameter > MAX_CHAIN_DIAMETER_M:
            expected = f"{MAX_CHAIN_DIAMETER_M:g} m or less"
            remedy = 'a number without a unit is in m; write "100 mm"'
            raise problem(f"chain of {self.diameter:g} m", expected, remedy)
        return self

    def weight(self, density: float, gravity: float) -> float:
        """Weight in water [N/m]."""
        return CHAIN[self.type][0] * self.diameter**2 * gravity * (1.0 - density / STEEL)

    @property
    def stiffness(self) -> float:
        """EA [N]."""
        return CHAIN[self.type][1] * self.diameter**2


def _stiffness_form(value: object) -> str:
    return "curve" if isinstance(value, dict | StretchCurve) else "number"


AxialLaw = Annotated[
    Annotated[of.AxialStiffness, Tag("number")] | Annotated[StretchCurve, Tag("curve")],
    Discriminator(_stiffness_form),
]


class LineDrag(SchemaModel):
    """Drag of a segment across its length."""

    coefficient: of.Factor
    """Drag coefficient, of the force 1/2 rho C D v^2 per length."""
    diameter: of.Diameter
    """Diameter that the coefficient refers to. For chain often the bar diameter, with 2.4."""


class Segment(SchemaModel):
    """A uniform piece of a line; segments follow one another from the fairlead to the anchor."""

    key_rules = (at_most_one("clump", "buoy", expected="one of them at the end of a segment"),)

    length: LengthOverTime
    """Length without tension, or a table, recorded series or sine of it over time. It may change
    in the first segment alone."""
    weight: of.LineWeight | None = None
    """Weight in water per length; below 0 if it floats."""
    stiffness: AxialLaw | None = None
    """Axial stiffness EA, tension over stretch, or a curve of it. Example: 600 MN."""
    chain: Chain | None = None
    """Chain, in place of weight and stiffness."""
    drag: LineDrag | None = None
    """Drag of the segment. Without it, the segment has none."""
    clump: of.ReferenceForce | None = None
    """Weight in water of a clump at the lower end of the segment."""
    buoy: of.ReferenceForce | None = None
    """Net lift of a buoy at the lower end of the segment."""

    @model_validator(mode="after")
    def _check_segment(self) -> Self:
        given = self.keys_with_value("weight", "stiffness")
        if self.chain and given:
            raise problem(f"chain and {' and '.join(given)}", "either chain or both others")
        if not self.chain and len(given) < 2:
            lacks = {"weight", "stiffness"} - {*given}
            remedy = "a line without weight or stretch is not a catenary"
            raise problem(f"no {' and no '.join(sorted(lacks))}", "weight and stiffness", remedy)
        return self

    @property
    def hung(self) -> float:
        """Weight in water at the lower end [N]; the lift of a buoy below 0."""
        return (self.clump or 0.0) - (self.buoy or 0.0)

    @property
    def width(self) -> float:
        """Drag coefficient times diameter [m]."""
        return self.drag.coefficient * self.drag.diameter if self.drag else 0.0


class Seabed(SchemaModel):
    """The seabed, level and at the water depth."""

    friction: of.Factor = 0.0
    """Coefficient of friction along the line on the seabed. With it the line has no potential, and
    all its work is booked as its loss."""

    @model_validator(mode="after")
    def _check_friction(self) -> Self:
        if self.friction > ROUGHEST:
            expected = f"{ROUGHEST:g} or less"
            remedy = 'it is a part of the weight, such as 0.5 or "50 %"'
            raise problem(f"friction of {self.friction:g}", expected, remedy)
        return self


@schema_class
class CatenaryEntry(TwoPointElement, BreakingElement):
    """A mooring line with weight: segments between a point of a body and an anchor on the earth or
    on another body, in static balance."""

    tension_channel: ClassVar[str] = "line_tension"
    example: ClassVar[dict[str, Any]] = {
        "type": "catenary",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["2.5 m", "0.2 m", "4 m"],
        "anchor_body": "topside",
        "segments": [
            {"length": "5 m", "weight": "0.6 kN/m", "stiffness": "1 MN", "clump": "0.5 kN"},
            {
                "length": "2.5 m",
                "weight": "0.3 kN/m",
                "stiffness": {
                    "stretch": ["0 %", "10 %", "20 %"],
                    "tension": ["0 N", "9 kN", "99 kN"],
                },
            },
        ],
        "capacity": "200 kN",
    }

    type: Literal["catenary"] = field(default="catenary", kw_only=True)
    """A mooring line with weight, in static balance."""
    point: of.Point
    """Fairlead: end of the line on the body, in the body frame."""
    segments: Annotated[tuple[Segment, ...], AfterValidator(of.require_entries)]
    """Uniform pieces of the line from the fairlead to the anchor."""
    seabed: Seabed | None = None
    """Seabed at the water depth, on which the line may lie. Without it, the line touches no bed."""

    @model_validator(mode="after")
    def _check_lengths(self) -> Self:
        if len(self.segments) > MAX_SEGMENTS:
            found_text = f"{len(self.segments)} segments"
            raise problem(found_text, f"at most {MAX_SEGMENTS}", "join those that are alike")
        changing = [i for i, s in enumerate(self.segments) if not isinstance(s.length, float)]
        if any(changing):
            found_text = f"a length over time in segment {max(changing) + 1}"
            expected = "one in the first segment alone, where a winch pays out"
            raise problem(found_text, expected)
        return self

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        for i, segment in enumerate(self.segments):
            if isinstance(segment.length, RecordedColumns):
                yield ("segments", i, "length"), segment.length

    def build_active(self, where: BuildContext) -> BuiltCatenary:
        from hydrosim.elements.line.catenary import Catenary as BuiltCatenary  # loads numba
        from hydrosim.elements.signal import first_value

        paid = None
        first = self.segments[0].length
        if not isinstance(first, float):
            paid = length_signal(first, f"{where.key}.segments[0].length", where.path)
            first = first_value(paid)
        length = [first, *(s.length for s in self.segments[1:])]
        density, gravity = where.water
        weight = [s.chain.weight(density, gravity) if s.chain else s.weight for s in self.segments]
        laws = (s.chain.stiffness if s.chain else s.stiffness for s in self.segments)
        stiffness, curves = stiffness_and_curves([law for law in laws if law is not None])
        return BuiltCatenary(
            self.body,
            point=self.point,
            anchor=self.anchor,
            length=np.array(length, float),
            weight=np.array(weight, float),
            stiffness=stiffness,
            hung=np.array([s.hung for s in self.segments]),
            drag_width=np.array([s.width for s in self.segments]),
            friction=self.seabed.friction if self.seabed else None,
            anchor_body=self.anchor_body,
            paid=paid,
            paying=NO_INDEX if paid is None else 0,
            curves=curves,
            capacity=self.capacity,
            active=super().build_active(where).active,
        )


# `lines`: a mooring system in a file of MoorDyn or MoorPy, as catenaries.

NEARLY = 1e-6  # m: depths that are the same


class Vessel(NamedTuple):
    """A body at rest: ``place`` (x, y) [m] of its database's origin in the earth frame, ``heading``
    [rad], ``centre`` of gravity [m] in the frame of the database; ``depth`` [m] of the water."""

    place: tuple[float, ...]
    heading: float
    centre: tuple[float, ...]
    depth: float


@schema_class
class Lines(BreakingElement):
    """A mooring system from a file of MoorDyn or MoorPy: a catenary for each of its lines."""

    tension_channel: ClassVar[str] = "line_tension"
    example: ClassVar[dict[str, Any]] = {"type": "lines", "body": "barge", "file": "lines.txt"}

    type: Literal["lines"] = field(default="lines", kw_only=True)
    """A mooring system from a file, a catenary for each of its lines."""
    file: StrictStr
    """Input file of MoorDyn or MoorPy. The origin of its axes is the body's database at rest.
    Example: lines.txt."""
    capacity: of.ReferenceForce | None = None
    """Allowable tension of each line, which statistics compare with."""

    def source(self, where: BuildContext) -> Source:
        """The file."""
        return Source(where.path.parent / self.file, f"{where.path}: {where.key}.file")

    def elements(self, where: BuildContext, vessel: Vessel) -> dict[str, ForceElement]:
        """The elements of the scene by name: that of this element, and that of the line."""
        name = where.key.removeprefix("forces.")
        system = read_mooring_system(self.source(where))
        lines = {
            f"{name}_{key}": line.build_active(
                BuildContext(f"forces.{name}_{key}", where.path, where.water)
            )
            for key, line in self.read_lines(system, where, vessel).items()
        }
        left_out = tuple(entry._replace(key=f"{where.key}.file") for entry in system.left_out)
        first, line = next(iter(lines.items()))
        return {**lines, first: replace(line, left_out=left_out)}

    def read_lines(
        self, system: System, where: BuildContext, vessel: Vessel
    ) -> dict[str, CatenaryEntry]:
        """The lines of the ``system`` in the file, by their names there. Raises InputError for a
        file that does not fit the case."""
        source = self.source(where)
        _check_water(system, where.water, vessel.depth, source)
        lines = mooring_lines(system, water_of_system(system, where.water), source)
        depth = system.depth if system.depth is not None else vessel.depth
        bed = Seabed(friction=system.friction) if isfinite(depth) else None
        return {name: self._catenary(line, vessel, bed) for name, line in lines.items()}

    def _catenary(self, line: MooringLine, vessel: Vessel, bed: Seabed | None) -> CatenaryEntry:
        return CatenaryEntry.build_from(
            self,
            type="catenary",
            point=tuple(float(v) for v in np.subtract(line.fairlead, vessel.centre)),
            anchor=earth_place(line.anchor, vessel),
            segments=tuple(
                Segment.model_construct(
                    length=s.length,
                    weight=s.weight,
                    stiffness=s.stiffness,
                    drag=LineDrag.model_construct(coefficient=s.drag, diameter=s.diameter)
                    if s.drag > 0.0
                    else None,
                    clump=s.hung if s.hung > 0.0 else None,
                    buoy=-s.hung if s.hung < 0.0 else None,
                )
                for s in line.segments
            ),
            seabed=bed,
        )


def earth_place(place: tuple[float, ...], vessel: Vessel) -> tuple[float, ...]:
    """A place of the file in the earth frame."""
    x, y, z = place
    c = cos(vessel.heading)
    s = sin(vessel.heading)
    return vessel.place[0] + c * x - s * y, vessel.place[1] + s * x + c * y, z


def _check_water(system: System, water: tuple[float, float], depth: float, source: Source) -> None:
    """Refuse a file for other water than that of the case."""
    if system.depth is not None and not abs(system.depth - depth) <= NEARLY:
        found_text = "without end" if not isfinite(depth) else f"{depth:g} m"
        text = f"found depth {system.depth:g} m there and water {found_text} in the case"
        source.wrong(f"{text}; expected the same; set environment.water_depth")
    pairs: Mapping[str, tuple[float | None, float, str]] = {
        "density": (system.density, water[0], "kg/m^3"),
        "gravity": (system.gravity, water[1], "m/s^2"),
    }
    for name, (there, here, unit) in pairs.items():
        if there is not None and abs(there - here) > 0.01 * here:
            text = f"found {name} {there:g} {unit} there and {here:g} {unit} in the case"
            source.wrong(f"{text}; expected the same within 1 %")
