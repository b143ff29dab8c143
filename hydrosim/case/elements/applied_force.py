"""`applied_force` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.records import signal_of
from hydrosim.case.signals import Forces, Recorded
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.units import problem
from hydrosim.dofs import DOFS

if TYPE_CHECKING:
    from hydrosim import forces


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

    def recorded_series(self) -> Iterator[tuple[Keys, Recorded]]:
        for dof, form in zip(DOFS, self.force.values(absent=None), strict=True):
            if isinstance(form, Recorded):
                yield ("force", dof), form

    def build(self, where: BuildContext) -> forces.AppliedForce:
        from hydrosim.forces.applied_force import AppliedForce as Built
        from hydrosim.forces.signal import Table

        time = np.array(self.time or (0.0,))
        force: dict[str, forces.Signal] = {}
        for dof, form in zip(DOFS, self.force.values(absent=None), strict=True):
            if isinstance(form, tuple):
                force[dof] = Table(time, np.array(form))
            elif form is not None:
                unit = "N" if dof in DOFS[:3] else "N m"
                force[dof] = signal_of(form, f"{where.key}.force.{dof}", where.path, unit)
        fixed = self.frame == "body"
        return Built(self.body, point=self.point, force=force, body_fixed=fixed)
