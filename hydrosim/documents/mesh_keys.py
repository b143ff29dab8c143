"""Keys of a mesh file: the transformation of its coordinates to the database's frame."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import Quantity, problem

Scale = Annotated[float, Quantity("scale", "", "0.001", above=0)]
Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
Axes = tuple[Axis, Axis, Axis]


class MeshKeys(SchemaModel):
    """The coordinates of a file times ``scale``, turned so that its ``axes`` are x forward, y to
    port and z up, plus ``offset``. The still water is then ``waterline`` above z = 0."""

    scale: Scale = 1.0
    """Factor that turns the coordinates of the file into metres."""
    axes: Axes = ("x", "y", "z")
    """The axes of the file that point forward, to port and up, such as [x, -y, -z] for z down.
    Example: [x, -y, -z]."""
    offset: of.Point = (0.0, 0.0, 0.0)
    """Vector that is added to the scaled and turned coordinates."""
    waterline: of.Length = 0.0
    """Height of the still water above z = 0, after scale, axes and offset."""

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        if round(np.linalg.det(self._turn())) != 1:
            found_text = f"axes [{', '.join(self.axes)}]"
            expected = "three different ones that turn the file, such as [x, -y, -z] for z down"
            raise problem(found_text, expected, "others make a mirror image, or no hull at all")
        return self

    def _turn(self) -> np.ndarray:
        """Matrix (3, 3) from the file's axes to the frame's."""
        return np.array(
            [
                (-1.0 if axis[0] == "-" else 1.0) * np.eye(3)["xyz".index(axis[-1])]
                for axis in self.axes
            ]
        )

    def to_database_frame(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the file in the database's frame."""
        lift = np.array([0.0, 0.0, self.waterline])
        return np.asarray(self.scale * points @ self._turn().T + np.array(self.offset) - lift)
