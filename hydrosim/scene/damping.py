"""Damping of bodies, which are their keys in a case file: `linear_damping`, `quadratic_damping` and
`viscous_roll`."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictBool, StrictStr, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ReadAs, SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import ForceElement, Turns
from hydrosim.scene.restraints import MaybeDampingMatrix, Ratios

ROLL_DOF = 3


@schema_class
class LinearDamping(ForceElement):
    """Damping in the body's axes: per DOF, a full 6 x 6 matrix, or of critical."""

    key_rules = (exactly_one("damping", "damping_ratio"),)

    example: ClassVar[dict[str, Any]] = {
        "type": "linear_damping",
        "body": "barge",
        "damping": {"roll": "2 MN*m*s/rad"},
    }

    type: Literal["linear_damping"] = field(default="linear_damping", kw_only=True)
    """Linear damping in the axes of the body."""
    damping: MaybeDampingMatrix = None
    """Damping: per degree of freedom, or a 6 x 6 matrix."""
    damping_ratio: Ratios = None
    """Part of critical damping, per degree of freedom."""
    relative_to_current: StrictBool = False
    """Whether damping is of the velocity relative to the current."""

    def can_carry_weight(self) -> bool:
        return False

    def dragging_streams(self) -> Collection[str]:
        return ("current",) if self.relative_to_current else ()

    def can_add_energy(self) -> bool:
        """A current drags the body along."""
        return self.relative_to_current

    def couplings(self) -> Iterator[np.ndarray]:
        if self.damping is not None:
            yield self.damping

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Damping changes in axes that turn, unless it is invariant about the axis of the turn."""
        dampings = turns.elements.linear_dampings
        damping = next(e["damping"] for e in dampings if e["row"] == turns.row)
        changes = turns.exact and any(_depends_on_turn(damping, angle) for angle in turns.free)
        return f"{name} turns with {self.body}" if changes else None


def _depends_on_turn(damping: np.ndarray, angle: int) -> bool:
    """True if ``damping`` (6, 6) depends on how far its body has turned about an axis."""
    from scipy.spatial.transform import Rotation  # slow to load, and few scenes need it

    R = np.kron(np.eye(2), Rotation.from_rotvec(np.eye(3)[angle - 3]).as_matrix())
    return not np.allclose(R @ damping @ R.T, damping, rtol=0.0, atol=1e-12 * np.abs(damping).max())


@schema_class
class QuadraticDamping(ForceElement):
    """Damping with the squared velocity, in the body's axes: per DOF, or a full 6 x 6 matrix."""

    example: ClassVar[dict[str, Any]] = {
        "type": "quadratic_damping",
        "body": "barge",
        "damping": {"surge": "20 kN*s^2/m^2"},
    }

    type: Literal["quadratic_damping"] = field(default="quadratic_damping", kw_only=True)
    """Damping by the squared velocity relative to the current, in the axes of the body."""
    damping: Annotated[np.ndarray, ReadAs(of.QuadraticMatrix, np.ndarray, of.as_matrix)]
    """Coefficients: per degree of freedom, or a 6 x 6 matrix."""

    def can_carry_weight(self) -> bool:
        return False

    def dragging_streams(self) -> Collection[str]:
        return ("current",)

    def can_add_energy(self) -> bool:
        """A current drags the body along."""
        return True

    def couplings(self) -> Iterator[np.ndarray]:
        yield self.damping

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()


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


@schema_class
class SharpBarge(SchemaClass):
    """A barge with sharp corners, whose eddies are estimated by Ikeda's formula."""

    length: of.LineLength
    """Length of the barge. Example: 90 m."""
    beam: of.LineLength
    """Beam of the barge. Example: 27 m."""
    draught: of.LineLength
    """Draught of the barge. Example: 4 m."""
    viscosity: of.Viscosity | None = None
    """Kinematic viscosity of the water, for friction. Without it, 1.19e-6 m^2/s, of sea water."""


@schema_class
class ViscousRoll(ForceElement):
    """Roll damping beyond radiation: p1, p2, p3 of a decay test, a recorded decay, Ikeda's formula
    for barges, or coefficients."""

    example: ClassVar[dict[str, Any]] = {
        "type": "viscous_roll",
        "body": "barge",
        "p1": "0.4 s^-1",
        "p2": "0.9 rad^-1",
        "p3": "0.5 s/rad^2",
    }

    type: Literal["viscous_roll"] = field(default="viscous_roll", kw_only=True)
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
    ikeda: SharpBarge | None = None
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

    def can_carry_weight(self) -> bool:
        return False

    def couplings(self) -> Iterator[np.ndarray]:
        """Roll damping by itself couples nothing."""
        yield from ()

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Only damping in proportion to the rate is linear, about an axis that does not turn."""
        if self.p2 or self.p3 or self.quadratic or self.cubic or self.ikeda:
            return name
        changes = turns.exact and any(angle != ROLL_DOF for angle in turns.free)
        return f"{name} turns with {self.body}" if changes else None
