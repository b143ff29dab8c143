"""`bushing` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import as_matrix
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.bushing import Bushing as Built


class Bushing(Element):
    """A spring and damper in all six directions, between a body and another one or the earth."""

    example: ClassVar[dict[str, Any]] = {
        "type": "bushing",
        "body": "barge",
        "to": "topside",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "stiffness": {"surge": "40 kN/m", "heave": "60 kN/m", "pitch": "20 kN*m/rad"},
        "damping": {"surge": "2 kN*s/m", "yaw": "1 kN*m*s/rad"},
    }

    type: Literal["bushing"]
    """A spring and damper in six directions."""
    to: StrictStr | None = None
    """Other body. Without it the other side is the earth. Example: topside."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Place of the bushing in the body frame, with both bodies at their places at rest."""
    stiffness: of.StiffnessMatrix | None = None
    """Stiffness: per direction, or a 6 x 6 matrix, along the axes of the body at rest, which move
    with the other side."""
    damping: of.DampingMatrix | None = None
    """Damping: per direction, or a 6 x 6 matrix, along the same axes."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        if not self.keys_with_value("stiffness", "damping"):
            raise problem("nothing that acts", "stiffness, damping, or both")
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("to",), self.to, "without to the other side is the earth"

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.bushing import Bushing as Built  # loads numba

        stiffness, damping = (
            np.zeros((6, 6)) if given is None else as_matrix(given)
            for given in (self.stiffness, self.damping)
        )
        return Built(self.body, self.point, stiffness, damping, self.to)
