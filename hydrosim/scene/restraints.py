"""Linear restraints of bodies, which are their keys in a case file: `linear_mooring`, `bushing`."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.dofs import DOFS, MIRROR_SIGN, mirrored_vector
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one
from hydrosim.files.messages import Keys
from hydrosim.files.schema_class import ReadAs, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import ForceElement, Turns
from hydrosim.scene.hydrodynamics import DampingMatrix, StiffnessMatrix

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
