"""`quadratic_damping` in a case file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import as_matrix

if TYPE_CHECKING:
    from hydrosim.forces.damping.quadratic_damping import QuadraticDamping as Built


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

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.damping.quadratic_damping import (
            QuadraticDamping as Built,  # loads numba
        )

        return Built(self.body, damping=as_matrix(self.damping))
