"""`linear_damping` in a case file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictBool, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import as_matrix
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.damping.linear_damping import LinearDamping as Built


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

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.damping.linear_damping import LinearDamping as Built  # loads numba

        damping, ratio = self.damping, self.damping_ratio
        return Built(
            self.body,
            damping=None if damping is None else as_matrix(damping),
            damping_ratio=None if ratio is None else np.array(ratio.values()),
            relative_to_current=self.relative_to_current,
        )
