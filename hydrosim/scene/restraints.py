"""Restraints of bodies, which are their keys in a case file: linear moorings, bushings, drives."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, StrictStr, Tag, model_validator

from hydrosim.dofs import DOFS, LATERAL, MIRROR_SIGN, mirrored_vector
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one, exactly_one, value_for_each_time
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ReadAs, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import BuildContext, ForceElement, Turns
from hydrosim.scene.hydrodynamics import DampingMatrix, StiffnessMatrix
from hydrosim.scene.signal import (
    HarmonicEntry,
    RecordedColumns,
    Signal,
    SmoothTable,
    only_forms,
    scale_signal,
    signal_of,
)

MaybeDampingMatrix = Annotated[
    np.ndarray | None,
    ReadAs(of.DampingMatrix | None, np.ndarray | None, of.as_matrix_or_none),
]
Ratios = Annotated[
    np.ndarray | None,
    ReadAs(of.PerDof[of.Factor, of.Factor] | None, np.ndarray | None, of.as_six_or_none),
]
Periods = Annotated[
    np.ndarray | None,
    ReadAs(of.PerDof[of.Period, of.Period] | None, np.ndarray | None, of.as_six_or_none),
]


@schema_class
class LinearMooring(ForceElement):
    """Spring and damper at a body's centre of gravity: per DOF, or full 6 x 6 matrices; the
    stiffness may be what gives a DOF a natural period."""

    key_rules = (at_least_one("stiffness", "natural_period", nothing="no stiffness"),)

    example: ClassVar[dict[str, Any]] = {
        "type": "linear_mooring",
        "body": "barge",
        "stiffness": {"surge": "40 tonne_force/m", "sway": "40 tonne_force/m"},
        "damping_ratio": {"surge": "20 %", "sway": "20 %"},
    }

    type: Literal["linear_mooring"] = field(default="linear_mooring", kw_only=True)
    """Linear spring and damper at the centre of gravity."""
    stiffness: StiffnessMatrix = None  # type: ignore[assignment]
    """Stiffness: per degree of freedom, or a 6 x 6 matrix."""
    natural_period: Periods = field(default=None, kw_only=True)
    """Natural period that the stiffness is chosen for, per degree of freedom."""
    damping: MaybeDampingMatrix = None
    """Damping: per degree of freedom, or a 6 x 6 matrix."""
    damping_ratio: Ratios = None
    """Part of critical damping, per degree of freedom."""

    @property
    def periods(self) -> np.ndarray:
        """Natural periods (6,) [s] as given; 0 in a DOF for which there is none."""
        return np.zeros(6) if self.natural_period is None else self.natural_period

    @model_validator(mode="after")
    def _check_stiffness(self) -> Self:
        diagonal = np.diag(self.stiffness)
        twice = [dof for dof, k, t in zip(DOFS, diagonal, self.periods, strict=True) if k and t]
        if twice:
            found_text = f"both stiffness and natural_period in {', '.join(twice)}"
            raise problem(found_text, "one of them in each DOF")
        return self

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        if self.damping is not None and self.damping_ratio is not None:
            raise problem("damping and damping_ratio", "one of them, or none", "remove one")
        if self.damping_ratio is not None:
            held = (np.diag(self.stiffness) != 0.0) | (self.periods != 0.0)
            # the body's surge is the earth's sway at a heading of 90 deg
            held[:2] = held[:2].any()
            ratios = zip(DOFS, self.damping_ratio, held, strict=True)
            without = [dof for dof, ratio, is_held in ratios if ratio and not is_held]
            if without:
                raise problem(
                    f"a damping_ratio in {', '.join(without)} where stiffness is 0",
                    "stiffness there (the ratio is to critical damping on it)",
                    "give damping instead",
                )
        return self

    def can_carry_weight(self) -> bool:
        return "heave" in self.restored_dofs()

    def restored_dofs(self) -> Collection[str]:
        held = (np.diag(self.stiffness) > 0.0) | (self.periods > 0.0)
        return [dof for dof, is_held in zip(DOFS, held, strict=True) if is_held]

    def couplings(self) -> Iterator[np.ndarray]:
        yield self.stiffness
        if self.damping is not None:
            yield self.damping

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        return None


@schema_class
class Bushing(ForceElement):
    """A spring and damper in all six directions, between a body and another one or the earth."""

    key_rules = (at_least_one("stiffness", "damping", nothing="nothing that acts"),)

    example: ClassVar[dict[str, Any]] = {
        "type": "bushing",
        "body": "barge",
        "to": "topside",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "stiffness": {"surge": "40 kN/m", "heave": "60 kN/m", "pitch": "20 kN*m/rad"},
        "damping": {"surge": "2 kN*s/m", "yaw": "1 kN*m*s/rad"},
    }

    positional: ClassVar[tuple[str, ...]] = ("body", "point", "stiffness", "damping", "to")

    type: Literal["bushing"] = field(default="bushing", kw_only=True)
    """A spring and damper in six directions."""
    to: StrictStr | None = field(default=None, kw_only=True)
    """Other body. Without it the other side is the earth. Example: topside."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Place of the bushing in the body frame, with both bodies at their places at rest."""
    stiffness: StiffnessMatrix = None  # type: ignore[assignment]
    """Stiffness: per direction, or a 6 x 6 matrix, along the axes of the body at rest, which move
    with the other side."""
    damping: DampingMatrix = None  # type: ignore[assignment]
    """Damping: per direction, or a 6 x 6 matrix, along the same axes."""

    def can_carry_weight(self) -> bool:
        return bool(np.any(self.stiffness[:3, :3]))

    def restored_dofs(self) -> Collection[str]:
        if self.to is not None:
            return ()
        held = np.diag(self.stiffness) > 0.0
        return [dof for dof, is_held in zip(DOFS, held, strict=True) if is_held]

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "to", self.to

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("to",), self.to, "without to the other side is the earth"

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]

    def mirror_image(self) -> ForceElement:
        sign = np.outer(MIRROR_SIGN, MIRROR_SIGN)
        both = {"stiffness": sign * self.stiffness, "damping": sign * self.damping}
        return replace(self, point=mirrored_vector(self.point), **both)

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Linear with small angles."""
        return name if turns.exact else None


# Drives.


class OffsetTable(SchemaModel):
    """A smooth curve through the offsets at some times, which never overshoots."""

    key_rules = (value_for_each_time("offset"),)

    time: Annotated[of.Times, AfterValidator(of.require_two_entries)]
    """Times that rise, from the start of the run to its end."""
    offset: Annotated[tuple[of.Length, ...], AfterValidator(of.require_entries)]
    """Offset at each time. Equal neighbours are a rest."""


class AngleTable(SchemaModel):
    """A smooth curve through the angles at some times, which never overshoots."""

    key_rules = (value_for_each_time("angle"),)

    time: Annotated[of.Times, AfterValidator(of.require_two_entries)]
    """Times that rise, from the start of the run to its end."""
    angle: Annotated[tuple[of.Angle, ...], AfterValidator(of.require_entries)]
    """Angle at each time. Equal neighbours are a rest."""


def _form_tag(value: object) -> str:
    """Which of the forms a motion has."""
    if isinstance(value, OffsetTable | AngleTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, RecordedColumns) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic"


OffsetOverTime = Annotated[
    Annotated[OffsetTable, Tag("table")]
    | Annotated[RecordedColumns, Tag("recorded")]
    | Annotated[HarmonicEntry[of.Length], Tag("harmonic")],
    Discriminator(_form_tag),
    only_forms("offset", "m", OffsetTable, RecordedColumns, HarmonicEntry),
]
AngleOverTime = Annotated[
    Annotated[AngleTable, Tag("table")]
    | Annotated[RecordedColumns, Tag("recorded")]
    | Annotated[HarmonicEntry[of.Angle], Tag("harmonic")],
    Discriminator(_form_tag),
    only_forms("angle", "deg", AngleTable, RecordedColumns, HarmonicEntry),
]


@schema_class
class Drive(ForceElement):
    """Prescribed motion of a degree of freedom of a body, or of a motion of a joint. A scene has
    the body of the joint, and the name of its motion."""

    supplies: ClassVar[bool] = True
    key_rules = (exactly_one("offset", "angle", nothing="no motion"),)
    example: ClassVar[dict[str, Any]] = {
        "type": "drive",
        "body": "barge",
        "dof": "heave",
        "offset": {"amplitude": "0.5 m", "period": "8 s"},
    }

    type: Literal["drive"] = field(default="drive", kw_only=True)
    """A motion over time, with the force that it takes."""
    body: Annotated[str, ReadAs(StrictStr | None, str)] = None  # type: ignore[assignment]
    """Body that it moves; else give joint. Example: barge."""
    dof: StrictStr | None = field(default=None, kw_only=True)
    """Degree of freedom of the body that it moves. Example: heave."""
    joint: StrictStr | None = field(default=None, kw_only=True)
    """Joint that it moves, in place of body and dof. Example: crane."""
    motion: StrictStr | None = field(default=None, kw_only=True)
    """Motion of the joint that it moves. Without it, the only one. Example: angle."""
    offset: Annotated[Signal | None, ReadAs(OffsetOverTime | None, Signal)] = field(
        default=None, kw_only=True
    )
    """Offset from the place at rest: a table, a recorded series or a sine."""
    angle: Annotated[Signal | None, ReadAs(AngleOverTime | None, Signal)] = field(
        default=None, kw_only=True
    )
    """Angle from the place at rest: a table, a recorded series or a sine."""

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        wanted = "either body and dof, or joint"
        if (self.body is None) == (self.joint is None):
            both = "body and joint" if self.body else "neither body nor joint"
            raise problem(both, wanted)
        if (self.body is None) != (self.dof is None):
            raise problem("dof without body" if self.dof else "body without dof", wanted)
        if self.motion is not None and self.joint is None:
            raise problem("motion without joint", wanted)
        return self

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        for key, form in (("offset", self.offset), ("angle", self.angle)):
            if isinstance(form, RecordedColumns):
                yield (key,), form

    @property
    def quantity(self) -> str:
        """What is prescribed: "offset" or "angle"."""
        return "angle" if self.offset is None else "offset"

    @property
    def position(self) -> Any:
        """The offset [m] or angle [rad] from the place at rest over time."""
        return getattr(self, self.quantity)

    @property
    def coordinate(self) -> str:
        """Name of the degree of freedom, or of the motion of the joint."""
        return (self.dof if self.joint is None else self.motion) or ""

    @property
    def driven(self) -> str:
        """Name of the coordinate that it drives: "heave of barge"."""
        return f"{self.coordinate} of {self.joint or self.body}"

    def with_built_parts(self, where: BuildContext) -> Self:
        """The same with its signal, and with the body and the motion of its joint."""
        place: dict[str, Any] = {}
        if self.joint is not None:
            if self.joint not in where.joints:
                expected = f"a joint of the scene: {', '.join(where.joints) or 'there is none'}"
                raise InputError(f"{where.key}.joint: found {self.joint}; expected {expected}")
            joint = where.joints[self.joint]
            names = [motion.name for motion in joint.motions]
            motion = self.motion or (names[0] if len(names) == 1 else "")
            place = {"body": joint.body, "motion": motion}
        signal = _motion_signal(self.position, self.quantity, where)
        return self.build_from(self, **place, **{self.quantity: signal})

    def is_written(self) -> bool:
        return super().is_written() or self.body is None

    def signals(self) -> Iterator[tuple[str, Any]]:
        yield self.quantity, self.position

    def unit_names(self, name: str) -> Sequence[str]:
        return (f"{name} {self.coordinate}",)

    def restored_dofs(self) -> Collection[str]:
        return (self.coordinate,) if self.dof in ("surge", "sway", "yaw") else ()

    def can_add_energy(self) -> bool:
        return True

    def mirror_image(self) -> ForceElement:
        if self.dof in LATERAL:
            mirrored = scale_signal(self.position, -1.0)
            return self.build_from(self, **{self.quantity: mirrored})
        return self  # motions of joints out of the plane have no image themselves

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        return f"{name} moves {self.driven}"


def _motion_signal(form: Any, quantity: str, where: BuildContext) -> Signal:
    """The signal that the form of a motion in a file is."""
    if isinstance(form, OffsetTable | AngleTable):
        return SmoothTable(np.array(form.time), np.array(getattr(form, quantity)))
    if isinstance(form, Signal):
        return form
    return signal_of(
        form, f"{where.key}.{quantity}", where.path, "m" if quantity == "offset" else "rad"
    )
