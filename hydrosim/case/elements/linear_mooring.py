"""`linear_mooring` in a case file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import as_matrix
from hydrosim.documents.units import problem
from hydrosim.dofs import DOFS

if TYPE_CHECKING:
    from hydrosim.forces.linear_mooring import LinearMooring as Built


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

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.linear_mooring import LinearMooring as Built  # loads numba

        stiffness, damping, ratio = self.stiffness, self.damping, self.damping_ratio
        return Built(
            self.body,
            stiffness=np.zeros((6, 6)) if stiffness is None else as_matrix(stiffness),
            natural_period=self.diagonal[1],
            damping=None if damping is None else as_matrix(damping),
            damping_ratio=None if ratio is None else np.array(ratio.values()),
        )
