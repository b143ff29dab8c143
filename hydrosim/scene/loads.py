"""Loads on bodies, which are their keys in a case file: `applied_force`, `current_load` and
`wind_load`."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.dofs import DOFS, LATERAL, mirrored_vector
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one, same_length
from hydrosim.files.messages import Keys
from hydrosim.files.schema_class import ReadAs, schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.force import BuildContext, ForceElement, Turns
from hydrosim.scene.signal import Forces, RecordedColumns, Signal, Table, scale_signal, signal_of


def _has_signals(value: object) -> bool:
    return isinstance(value, Mapping) and all(isinstance(x, Signal) for x in value.values())


@schema_class
class AppliedForce(ForceElement):
    """A force and moment on a point of a body over time; lists are over the element's ``time``."""

    example: ClassVar[dict[str, Any]] = {
        "type": "applied_force",
        "body": "barge",
        "point": ["1 m", 0, 0],
        "time": ["0 s", "10 s"],
        "force": {"heave": ["0 kN", "50 kN"]},
    }
    supplies: ClassVar[bool] = True
    positional: ClassVar[tuple[str, ...]] = ("body", "point", "force")

    type: Literal["applied_force"] = field(default="applied_force", kw_only=True)
    """A force and moment over time on a point of a body."""
    frame: Literal["earth", "body"] = field(default="earth", kw_only=True)
    """Axes of the force: fixed to the earth, or turning with the body."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Point of attack in the body frame."""
    time: of.Times | None = field(default=None, kw_only=True)
    """Times of the lists in force."""
    force: Annotated[Mapping[str, Signal], ReadAs(Forces, _has_signals)] = field(kw_only=True)
    """Force or moment by degree of freedom: a number, a list over time, a table, a recorded series
    or a sine."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        lists = {dof: form for dof, form in self._forms_of_force() if isinstance(form, tuple)}
        count = len(self.time or (0.0,))
        for dof, values in lists.items():
            if len(values) != count:
                raise problem(
                    f"{len(values)} values in force.{dof} and {count} in time",
                    "a value at each time, or one value and no time",
                )
        if self.time and not lists:
            raise problem("time and no list over it", "a list of forces, or no time")
        return self

    def _forms_of_force(self) -> Iterator[tuple[str, Any]]:
        """Degrees of freedom and forms of the force of a file; none of a scene."""
        if not isinstance(self.force, Mapping):
            yield from zip(DOFS, self.force.values(absent=None), strict=True)

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        for dof, form in self._forms_of_force():
            if isinstance(form, RecordedColumns):
                yield ("force", dof), form

    def with_built_parts(self, where: BuildContext) -> AppliedForce:
        """The same with a signal for each degree of freedom that has a force."""
        force = dict(self.force) if isinstance(self.force, Mapping) else {}
        time = np.array(self.time or (0.0,))
        for dof, form in self._forms_of_force():
            if isinstance(form, tuple):
                force[dof] = Table(time, np.array(form))
            elif form is not None:
                unit = "N" if dof in DOFS[:3] else "N m"
                force[dof] = signal_of(form, f"{where.key}.force.{dof}", where.path, unit)
        return replace(self, time=None, force=force)

    def signals(self) -> Iterator[tuple[str, Signal]]:
        yield from ((f"force.{dof}", signal) for dof, signal in self.force.items())

    def mirror_image(self) -> ForceElement:
        force = {
            dof: scale_signal(signal, -1.0) if dof in LATERAL else signal
            for dof, signal in self.force.items()
        }
        return replace(self, point=mirrored_vector(self.point), force=force)

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        moves = self.frame == "body" or (turns.exact and any(self.point))
        return f"{name} turns with {self.body}" if turns.free and moves else None


TABLE: dict[str, Any] = {
    "headings": ["0 deg", "90 deg", "180 deg"],
    "surge": ["40 kN*s^2/m^2", 0, "-40 kN*s^2/m^2"],
    "sway": [0, "300 kN*s^2/m^2", 0],
    "yaw": [0, "2 MN*s^2/m", 0],
}
StreamForces = Annotated[
    np.ndarray, ReadAs(of.StreamForces | None, np.ndarray | None, of.as_array_or_none)
]
StreamMoments = Annotated[
    np.ndarray, ReadAs(of.StreamMoments | None, np.ndarray | None, of.as_array_or_none)
]


@schema_class
class StreamLoad(ForceElement):
    """Load by coefficients over the heading of a stream: all round, or from 0 to 180 deg for a body
    that is its own mirror image. A scene that is built from a file has them all round."""

    key_rules = (
        at_least_one(
            "surge",
            "sway",
            "yaw",
            nothing="no coefficients",
            expected="those of one or more of surge, sway, yaw",
        ),
        same_length("headings", "surge", "sway", "yaw", each="heading"),
    )

    supplies: ClassVar[bool] = True
    positional: ClassVar[tuple[str, ...]] = ("body", "point", "headings", "surge", "sway", "yaw")

    point: of.Point = (0.0, 0.0, 0.0)
    """Point of attack in the body frame."""
    headings: Annotated[np.ndarray, ReadAs(of.Headings, np.ndarray, np.array)] = field(kw_only=True)
    """Directions of the stream relative to the body, from 0 to 180 deg or all round."""
    surge: StreamForces = None  # type: ignore[assignment]
    """Surge force per squared speed at each heading."""
    sway: StreamForces = None  # type: ignore[assignment]
    """Sway force per squared speed at each heading."""
    yaw: StreamMoments = None  # type: ignore[assignment]
    """Yaw moment per squared speed at each heading."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        for dof in self.keys_with_value("sway", "yaw") if self.is_half else ():
            first, *_, last = getattr(self, dof)
            if first or last:
                found_text = f"{first:g} at 0 and {last:g} at 180 deg in {dof}"
                expected = "0 at both, as for a body that is its own mirror image"
                raise problem(found_text, expected, "give the headings of the whole circle")
        return self

    @property
    def is_half(self) -> bool:
        """True if the headings are those of half a circle."""
        return bool(self.headings[-1] <= np.pi * (1.0 + 1e-9))

    def is_written(self) -> bool:
        lacks = any(x is None for x in (self.surge, self.sway, self.yaw))
        return super().is_written() or lacks or self.is_half

    def with_built_parts(self, where: BuildContext) -> Self:
        """The same with headings and coefficients of the whole circle."""
        headings = self.headings
        zero = np.zeros(headings.size)
        values = [zero if x is None else x for x in (self.surge, self.sway, self.yaw)]
        if self.is_half:
            image = slice(-2, 0, -1)  # without 0 and 180 deg, which are their own
            mirrored = [sign * x[image] for sign, x in zip((1.0, -1.0, -1.0), values, strict=True)]
            values = [np.append(x, more) for x, more in zip(values, mirrored, strict=True)]
            headings = np.append(headings, 2.0 * np.pi - headings[image])
        surge, sway, yaw = values
        return replace(self, headings=headings, surge=surge, sway=sway, yaw=yaw)

    def can_carry_weight(self) -> bool:
        return False

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return [self._rotated_into_turn(self.headings)]

    def mirror_image(self) -> ForceElement:
        load = replace(self, point=mirrored_vector(self.point), sway=-self.sway, yaw=-self.yaw)
        return load._rotated_into_turn(-self.headings)

    def _rotated_into_turn(self, headings: np.ndarray) -> Self:
        """The same coefficients at these headings, which then rise from 0 within one turn."""
        headings = np.mod(headings, 2.0 * np.pi)
        order = np.argsort(headings)
        surge, sway, yaw = (x[order] for x in (self.surge, self.sway, self.yaw))
        return replace(self, headings=headings[order], surge=surge, sway=sway, yaw=yaw)


@schema_class
class CurrentLoad(StreamLoad):
    """Load of the current."""

    example: ClassVar[dict[str, Any]] = {"type": "current_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "current"

    type: Literal["current_load"] = field(default="current_load", kw_only=True)
    """Load of the current by coefficients over its heading."""
    depth: tuple[of.Length, of.Length] | None = field(default=None, kw_only=True)
    """Depths, from top to bottom, between which the mean of a current with a profile acts. Without
    it, the draught of the body or the depth of the point. Example: [0 m, 8 m]."""

    @model_validator(mode="after")
    def _check_depth(self) -> Self:
        if self.depth is not None and not 0.0 <= self.depth[0] < self.depth[1]:
            top, bottom = self.depth
            raise problem(f"depths of {top:g} and {bottom:g} m", "0 or more, top above bottom")
        return self

    def dragging_streams(self) -> Collection[str]:
        return ("current",)


@schema_class
class WindLoad(StreamLoad):
    """Load of the wind."""

    example: ClassVar[dict[str, Any]] = {"type": "wind_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "wind"

    type: Literal["wind_load"] = field(default="wind_load", kw_only=True)
    """Load of the wind by coefficients over its heading."""
    height: Annotated[float, Quantity("height", "m", "10 m", above=0)] | None = field(
        default=None, kw_only=True
    )
    """Height above the water of the wind that acts. Without it, that of the point at rest."""

    def dragging_streams(self) -> Collection[str]:
        return ("wind",)
