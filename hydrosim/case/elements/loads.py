"""Loads in a case file: `applied_force`, `current_load`, `wind_load` and `linear_mooring`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import as_matrix
from hydrosim.files.units import problem
from hydrosim.scene.signal import Forces, RecordedColumns, signal_of

if TYPE_CHECKING:
    from hydrosim import elements
    from hydrosim.elements.linear_mooring import LinearMooring as BuiltLinearMooring


class AppliedForce(Element):
    """A force and moment on a point of a body over time; lists are over the element's ``time``."""

    example: ClassVar[dict[str, Any]] = {
        "type": "applied_force",
        "body": "barge",
        "point": ["1 m", 0, 0],
        "time": ["0 s", "10 s"],
        "force": {"heave": ["0 kN", "50 kN"]},
    }

    type: Literal["applied_force"]
    """A force and moment over time on a point of a body."""
    frame: Literal["earth", "body"] = "earth"
    """Axes of the force: fixed to the earth, or turning with the body."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Point of attack in the body frame."""
    time: of.Times | None = None
    """Times of the lists in force."""
    force: Forces
    """Force or moment by degree of freedom: a number, a list over time, a table, a recorded series
    or a sine."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        forces = zip(DOFS, self.force.values(absent=None), strict=True)
        lists = {dof: values for dof, values in forces if isinstance(values, tuple)}
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

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        for dof, form in zip(DOFS, self.force.values(absent=None), strict=True):
            if isinstance(form, RecordedColumns):
                yield ("force", dof), form

    def build(self, where: BuildContext) -> elements.AppliedForce:
        from hydrosim.elements.applied_force import AppliedForce as Built
        from hydrosim.scene.signal import Table

        time = np.array(self.time or (0.0,))
        force: dict[str, elements.Signal] = {}
        for dof, form in zip(DOFS, self.force.values(absent=None), strict=True):
            if isinstance(form, tuple):
                force[dof] = Table(time, np.array(form))
            elif form is not None:
                unit = "N" if dof in DOFS[:3] else "N m"
                force[dof] = signal_of(form, f"{where.key}.force.{dof}", where.path, unit)
        fixed = self.frame == "body"
        return Built(self.body, point=self.point, force=force, body_fixed=fixed)


# `current_load` and `wind_load` in a case file.

TABLE: dict[str, Any] = {
    "headings": ["0 deg", "90 deg", "180 deg"],
    "surge": ["40 kN*s^2/m^2", 0, "-40 kN*s^2/m^2"],
    "sway": [0, "300 kN*s^2/m^2", 0],
    "yaw": [0, "2 MN*s^2/m", 0],
}


class StreamLoad(Element):
    """Load by coefficients over the heading of a stream: all round, or from 0 to 180 deg for a body
    that is its own mirror image."""

    point: of.Point = (0.0, 0.0, 0.0)
    """Point of attack in the body frame."""
    headings: of.Headings
    """Directions of the stream relative to the body, from 0 to 180 deg or all round."""
    surge: of.StreamForces | None = None
    """Surge force per squared speed at each heading."""
    sway: of.StreamForces | None = None
    """Sway force per squared speed at each heading."""
    yaw: of.StreamMoments | None = None
    """Yaw moment per squared speed at each heading."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        given = self.keys_with_value("surge", "sway", "yaw")
        if not given:
            raise problem("no coefficients", "those of one or more of surge, sway, yaw")
        for dof in given:
            if len(getattr(self, dof)) != len(self.headings):
                found_text = f"{len(getattr(self, dof))} values in {dof} and {len(self.headings)}"
                raise problem(f"{found_text} in headings", "a value for each heading")
        self._check_ends()
        return self

    def _check_ends(self) -> None:
        if not self.is_half:
            return
        for dof in self.keys_with_value("sway", "yaw"):
            first, *_, last = getattr(self, dof)
            if first or last:
                found_text = f"{first:g} at 0 and {last:g} at 180 deg in {dof}"
                expected = "0 at both, as for a body that is its own mirror image"
                raise problem(found_text, expected, "give the headings of the whole circle")

    @property
    def is_half(self) -> bool:
        """True if the headings are those of half a circle."""
        return self.headings[-1] <= np.pi * (1.0 + 1e-9)

    def all_round(self) -> tuple[np.ndarray, ...]:
        """Headings, and coefficients in surge, sway and yaw, of the whole circle."""
        headings = np.array(self.headings)
        zero = (0.0,) * headings.size
        values = [np.array(x or zero) for x in (self.surge, self.sway, self.yaw)]
        if not self.is_half:
            return headings, *values
        image = slice(-2, 0, -1)  # without 0 and 180 deg, which are their own
        mirrored = [sign * x[image] for sign, x in zip((1.0, -1.0, -1.0), values, strict=True)]
        both = [np.append(x, more) for x, more in zip(values, mirrored, strict=True)]
        return np.append(headings, 2.0 * np.pi - headings[image]), *both


class CurrentLoad(StreamLoad):
    """Load of the current."""

    example: ClassVar[dict[str, Any]] = {"type": "current_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "current"
    type: Literal["current_load"]
    """Load of the current by coefficients over its heading."""
    depth: tuple[of.Length, of.Length] | None = None
    """Depths, from top to bottom, between which the mean of a current with a profile acts. Without
    it, the draught of the body or the depth of the point. Example: [0 m, 8 m]."""

    @model_validator(mode="after")
    def _check_depth(self) -> Self:
        if self.depth is not None and not 0.0 <= self.depth[0] < self.depth[1]:
            top, bottom = self.depth
            raise problem(f"depths of {top:g} and {bottom:g} m", "0 or more, top above bottom")
        return self

    def build(self, where: BuildContext) -> elements.CurrentLoad:
        from hydrosim.elements.stream_load import CurrentLoad as Built  # loads numba

        return Built(self.body, self.point, *self.all_round(), depth=self.depth)


class WindLoad(StreamLoad):
    """Load of the wind."""

    example: ClassVar[dict[str, Any]] = {"type": "wind_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "wind"
    type: Literal["wind_load"]
    """Load of the wind by coefficients over its heading."""
    height: Annotated[float, of.Quantity("height", "m", "10 m", above=0)] | None = None
    """Height above the water of the wind that acts. Without it, that of the point at rest."""

    def build(self, where: BuildContext) -> elements.WindLoad:
        from hydrosim.elements.stream_load import WindLoad as Built  # loads numba

        return Built(self.body, self.point, *self.all_round(), height=self.height)


# `linear_mooring` in a case file.


class LinearMooring(Element):
    """Spring and damper at a body's centre of gravity: per DOF, or full 6 x 6 matrices; the
    stiffness may be what gives a DOF a natural period."""

    example: ClassVar[dict[str, Any]] = {
        "type": "linear_mooring",
        "body": "barge",
        "stiffness": {"surge": "40 tonne_force/m", "sway": "40 tonne_force/m"},
        "damping_ratio": {"surge": "20 %", "sway": "20 %"},
    }

    type: Literal["linear_mooring"]
    """Linear spring and damper at the centre of gravity."""
    stiffness: of.StiffnessMatrix | None = None
    """Stiffness: per degree of freedom, or a 6 x 6 matrix."""
    natural_period: of.PerDof[of.Period, of.Period] | None = None
    """Natural period that the stiffness is chosen for, per degree of freedom."""
    damping: of.DampingMatrix | None = None
    """Damping: per degree of freedom, or a 6 x 6 matrix."""
    damping_ratio: of.PerDof[of.Factor, of.Factor] | None = None
    """Part of critical damping, per degree of freedom."""

    @property
    def diagonal(self) -> tuple[np.ndarray, np.ndarray]:
        """Diagonal of the stiffness (6,) [N/m, N m/rad] and the natural periods (6,) [s] as the
        case gives them per DOF; 0 in a DOF for which the case gives none."""
        stiffness = np.zeros(6) if self.stiffness is None else np.diag(as_matrix(self.stiffness))
        period = np.zeros(6) if self.natural_period is None else self.natural_period.values()
        return stiffness, np.array(period)

    @model_validator(mode="after")
    def _check_stiffness(self) -> Self:
        if self.stiffness is None and self.natural_period is None:
            raise problem("no stiffness", "stiffness, natural_period, or both")
        twice = [dof for dof, k, t in zip(DOFS, *self.diagonal, strict=True) if k and t]
        if twice:
            found_text = f"both stiffness and natural_period in {', '.join(twice)}"
            raise problem(found_text, "one of them in each DOF")
        return self

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        if self.damping is not None and self.damping_ratio is not None:
            raise problem("damping and damping_ratio", "one of them, or none", "remove one")
        if self.damping_ratio is not None:
            held = np.any(self.diagonal, axis=0)
            # the body's surge is the earth's sway at a heading of 90 deg
            held[:2] = held[:2].any()
            ratios = zip(DOFS, self.damping_ratio.values(), held, strict=True)
            without = [dof for dof, ratio, is_held in ratios if ratio and not is_held]
            if without:
                raise problem(
                    f"a damping_ratio in {', '.join(without)} where stiffness is 0",
                    "stiffness there (the ratio is to critical damping on it)",
                    "give damping instead",
                )
        return self

    def build(self, where: BuildContext) -> BuiltLinearMooring:
        from hydrosim.elements.linear_mooring import LinearMooring as BuiltLinearMooring

        stiffness, damping, ratio = self.stiffness, self.damping, self.damping_ratio
        return BuiltLinearMooring(
            self.body,
            stiffness=np.zeros((6, 6)) if stiffness is None else as_matrix(stiffness),
            natural_period=self.diagonal[1],
            damping=None if damping is None else as_matrix(damping),
            damping_ratio=None if ratio is None else np.array(ratio.values()),
        )
