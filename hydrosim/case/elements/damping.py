"""Damping in a case file: `linear_damping`, `quadratic_damping` and `viscous_roll`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictBool, StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.files import quantities as of
from hydrosim.files.quantities import SchemaModel, as_matrix
from hydrosim.files.units import problem

if TYPE_CHECKING:
    from hydrosim.elements.damping import LinearDamping as BuiltLinearDamping
    from hydrosim.elements.damping import QuadraticDamping as BuiltQuadraticDamping
    from hydrosim.elements.viscous_roll import ViscousRoll as BuiltViscousRoll


class LinearDamping(Element):
    """Damping in the body's axes: per DOF, a full 6 x 6 matrix, or of critical."""

    example: ClassVar[dict[str, Any]] = {
        "type": "linear_damping",
        "body": "barge",
        "damping": {"roll": "2 MN*m*s/rad"},
    }

    type: Literal["linear_damping"]
    """Linear damping in the axes of the body."""
    damping: of.DampingMatrix | None = None
    """Damping: per degree of freedom, or a 6 x 6 matrix."""
    damping_ratio: of.PerDof[of.Factor, of.Factor] | None = None
    """Part of critical damping, per degree of freedom."""
    relative_to_current: StrictBool = False
    """Whether damping is of the velocity relative to the current."""

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        given = self.keys_with_value("damping", "damping_ratio")
        if len(given) != 1:
            raise problem(" and ".join(given) or "none", "either damping or damping_ratio")
        return self

    def build(self, where: BuildContext) -> BuiltLinearDamping:
        from hydrosim.elements.damping import LinearDamping as BuiltLinearDamping

        damping, ratio = self.damping, self.damping_ratio
        return BuiltLinearDamping(
            self.body,
            damping=None if damping is None else as_matrix(damping),
            damping_ratio=None if ratio is None else np.array(ratio.values()),
            relative_to_current=self.relative_to_current,
        )


# `quadratic_damping` in a case file.


class QuadraticDamping(Element):
    """Damping with the squared velocity, in the body's axes: per DOF, or a full 6 x 6 matrix."""

    example: ClassVar[dict[str, Any]] = {
        "type": "quadratic_damping",
        "body": "barge",
        "damping": {"surge": "20 kN*s^2/m^2"},
    }

    type: Literal["quadratic_damping"]
    """Damping by the squared velocity relative to the current, in the axes of the body."""
    damping: of.QuadraticMatrix
    """Coefficients: per degree of freedom, or a 6 x 6 matrix."""

    def build(self, where: BuildContext) -> BuiltQuadraticDamping:
        from hydrosim.elements.damping import QuadraticDamping as BuiltQuadraticDamping

        return BuiltQuadraticDamping(self.body, damping=as_matrix(self.damping))


# `viscous_roll` in a case file.

FITTED = ("p1", "p2", "p3")
COEFFICIENT_KEYS = ("linear", "quadratic", "cubic")


class Decay(SchemaModel):
    """A recorded decay of roll, from which p1, p2 and p3 are fitted."""

    file: StrictStr
    """Recording of the roll angle over time, relative to the case file. Example: decay.csv."""
    column: StrictStr = "roll"
    """Column of the roll angle. Example: roll."""
    unit: Literal["deg", "rad"] | None = None
    """Unit of the column, if the file does not say it."""
    start: of.Instant | None = None
    """Beginning of the part that is fitted. Without it, shortly after the release."""
    end: of.Instant | None = None
    """End of the part that is fitted. Without it, the end of the file."""


class Ikeda(SchemaModel):
    """A barge with sharp corners, whose eddies are estimated by Ikeda's formula."""

    length: of.LineLength
    """Length of the barge. Example: 90 m."""
    beam: of.LineLength
    """Beam of the barge. Example: 27 m."""
    draught: of.LineLength
    """Draught of the barge. Example: 4 m."""
    viscosity: of.Viscosity | None = None
    """Kinematic viscosity of the water, for friction. Without it, 1.19e-6 m^2/s, of sea water."""


class ViscousRoll(Element):
    """Roll damping beyond radiation: p1, p2, p3 of a decay test, a recorded decay, Ikeda's formula
    for barges, or coefficients."""

    example: ClassVar[dict[str, Any]] = {
        "type": "viscous_roll",
        "body": "barge",
        "p1": "0.4 s^-1",
        "p2": "0.9 rad^-1",
        "p3": "0.5 s/rad^2",
    }

    type: Literal["viscous_roll"]
    """Roll damping: linear, quadratic and cubic in the roll rate of the body."""
    p1: of.DecayRate | None = None
    """Linear damping of a decay test, per inertia."""
    p2: of.DecaySquare | None = None
    """Quadratic damping of a decay test, per inertia."""
    p3: of.DecayCube | None = None
    """Cubic damping of a decay test, per inertia."""
    period: of.Period | None = None
    """Natural period of the decay test, which the period of the scene is compared with."""
    includes_waves: StrictBool | None = None
    """Whether p1 includes the damping by radiated waves, which the database has already. Without
    it, true: a decay test measures both together."""
    decay: Decay | None = None
    """A recorded decay, in place of p1, p2 and p3."""
    ikeda: Ikeda | None = None
    """A barge with sharp corners, in place of p1, p2 and p3."""
    linear: of.TurnDamping | None = None
    """Moment per roll rate."""
    quadratic: of.TurnDrag | None = None
    """Moment per squared roll rate."""
    cubic: of.TurnCube | None = None
    """Moment per cubed roll rate."""

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        ways = [
            self.keys_with_value(*FITTED),
            self.keys_with_value("decay"),
            self.keys_with_value("ikeda"),
            self.keys_with_value(*COEFFICIENT_KEYS),
        ]
        used = [" ".join(keys) for keys in ways if keys]
        if len(used) != 1:
            expected = "one of: p1 p2 p3; decay; ikeda; linear quadratic cubic"
            raise problem(" and ".join(used) or "none", expected)
        measured = bool(ways[0] or ways[1])
        if self.includes_waves is not None and not measured:
            expected = "it with p1, p2, p3 or decay, because all else comes besides waves"
            raise problem(f"includes_waves with {used[0]}", expected)
        if self.period is not None and not ways[0]:
            raise problem(f"period with {used[0]}", "it with p1, p2, p3 of a decay test")
        return self

    def build(self, where: BuildContext) -> BuiltViscousRoll:
        from hydrosim.elements.viscous_roll import WATER_VISCOSITY, SharpBarge  # loads numba
        from hydrosim.elements.viscous_roll import ViscousRoll as BuiltViscousRoll

        keys = self.with_fitted_numbers(where)
        form = keys.ikeda
        barge = None
        if form is not None:
            viscosity = form.viscosity or WATER_VISCOSITY
            barge = SharpBarge(form.length, form.beam, form.draught, viscosity)
        return BuiltViscousRoll(
            self.body,
            p1=keys.p1 or 0.0,
            p2=keys.p2 or 0.0,
            p3=keys.p3 or 0.0,
            linear=keys.linear or 0.0,
            quadratic=keys.quadratic or 0.0,
            cubic=keys.cubic or 0.0,
            includes_waves=keys.includes_waves is not False,
            period=keys.period,
            barge=barge,
        )

    def with_fitted_numbers(self, where: BuildContext) -> ViscousRoll:
        """With p1, p2, p3 and the period that are fitted to the recorded decay, if there is one."""
        if self.decay is None:
            return self
        from hydrosim.elements.roll_decay import fit_files

        form = self.decay
        key = f"{where.path}: {where.key}.decay"
        fit = fit_files(
            [where.path.parent / form.file], form.column, form.unit, form.start, form.end, key
        )
        values = dict(zip(FITTED, fit.damping, strict=True))
        return self.model_copy(update={"decay": None, "period": fit.period.value, **values})
