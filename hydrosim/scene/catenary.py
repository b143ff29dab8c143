"""Mooring lines of a scene, whose physics is in `hydrosim.elements.line`: `catenary` in a file."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Tag, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_most_one, same_length
from hydrosim.files.messages import Keys
from hydrosim.files.schema_class import ReadAs, SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene import signal
from hydrosim.scene.force import CHAIN, MAX_CURVE_POINTS, STEEL, BreakingElement, BuildContext
from hydrosim.scene.links import TwoPointElement

MAX_SEGMENTS = 100
"""Segments of one line. With 300 the touch-down passes more of their ends in a step than a run
follows."""
ROUGHEST = 3.0  # friction of chain on sand or clay is about 1
MAX_CHAIN_DIAMETER_M = 0.4  # m: twice the largest chain that is made


@schema_class
class StretchCurve(SchemaClass):
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


@schema_class
class Chain(SchemaClass):
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


@schema_class
class LineDrag(SchemaClass):
    """Drag of a segment across its length."""

    coefficient: of.Factor
    """Drag coefficient, of the force 1/2 rho C D v^2 per length."""
    diameter: of.Diameter
    """Diameter that the coefficient refers to. For chain often the bar diameter, with 2.4."""


@schema_class
class Segment(SchemaClass):
    """A uniform piece of a line; segments follow one another from the fairlead to the anchor."""

    key_rules = (at_most_one("clump", "buoy", expected="one of them at the end of a segment"),)

    length: Annotated[signal.Signal | float, ReadAs(signal.LengthOverTime, signal.Signal)]
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

    def build(self, where: BuildContext) -> Segment:
        """The same with a length over time as a signal, and with what its chain weighs."""
        length: Any = self.length
        if not isinstance(length, float | signal.Signal):
            length = signal.length_signal(length, f"{where.key}.segments[0].length", where.path)
        made: dict[str, Any] = {"weight": self.weight, "stiffness": self.stiffness}
        if self.chain is not None:
            made = {
                "weight": self.chain.weight(*where.water),
                "stiffness": self.chain.stiffness,
            }
        return replace(self, length=length, chain=None, **made)

    @property
    def is_built(self) -> bool:
        """True if nothing is left that `build` replaces."""
        return self.chain is None and isinstance(self.length, float | signal.Signal)

    @property
    def hung(self) -> float:
        """Weight in water at the lower end [N]; the lift of a buoy below 0."""
        return (self.clump or 0.0) - (self.buoy or 0.0)

    @property
    def width(self) -> float:
        """Drag coefficient times diameter [m]."""
        return self.drag.coefficient * self.drag.diameter if self.drag else 0.0


@schema_class
class Seabed(SchemaClass):
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
class Catenary(TwoPointElement, BreakingElement):
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

    def recorded_series(self) -> Iterator[tuple[Keys, signal.RecordedColumns]]:
        for i, segment in enumerate(self.segments):
            if isinstance(segment.length, signal.RecordedColumns):
                yield ("segments", i, "length"), segment.length

    def is_written(self) -> bool:
        return super().is_written() or not all(segment.is_built for segment in self.segments)

    def with_built_parts(self, where: BuildContext) -> Self:
        """The same with segments that have lengths, weights and stiffnesses of the scene."""
        if all(segment.is_built for segment in self.segments):
            return self
        return replace(self, segments=tuple(segment.build(where) for segment in self.segments))

    @property
    def paid(self) -> signal.Signal | None:
        """The length of the first segment over time [m], if it changes."""
        length = self.segments[0].length
        return None if isinstance(length, float) else length

    @property
    def drag_width(self) -> np.ndarray:
        """Drag coefficients times diameters [m] (n,) of the segments."""
        return np.array([segment.width for segment in self.segments])

    @property
    def friction(self) -> float | None:
        """Coefficient of friction of the seabed, None without a seabed."""
        return self.seabed.friction if self.seabed else None

    def dragging_streams(self) -> Collection[str]:
        return ("current",) if np.any(self.drag_width) else ()

    def can_add_energy(self) -> bool:
        return bool(self.friction) or self.paid is not None or bool(np.any(self.drag_width))

    def signals(self) -> Iterator[tuple[str, Any]]:
        if self.paid is not None:
            yield "segments[0].length", self.paid
